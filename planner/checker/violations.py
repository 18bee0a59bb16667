"""What a plan can have wrong, as values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal[
    "structure",  # tokens, slots, timelines, objects and predicates do not fit together
    "codesignation",  # tokens of one slot differ
    "parameter",  # a parameter is undecided, outside its domain, or against a parameter constraint
    "inconsistent",  # no schedule satisfies the temporal network
    "bounds",  # a written bound is not what the network implies
    "duration",  # a duration beyond what its predicate declares
    "contingent",  # nature's choice is narrowed, widened, or given to the wrong token
    "order",  # tokens of one timeline may overlap
    "configuration",  # a configuration constraint is not satisfied
    "constraint",  # a value that a constraint token does not allow, or a constraint token of the problem is missing
    "exogenous",  # a value that no plan brings about, and that the problem does not state
    "resource",  # a level, rate or sum beyond its limits in some schedule
    "horizon",  # the plan's horizon is not the problem's
    "state",  # the problem's state and facts are not what the plan starts from
    "goal",  # a goal is missing, or not as the problem asks for it
]


@dataclass(frozen=True, slots=True)
class Violation:
    """One requirement that a plan breaks: its kind, the tokens and objects concerned, and a sentence."""

    kind: Kind
    explanation: str
    tokens: tuple[str, ...] = ()
    objects: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.kind}: {self.explanation}"
