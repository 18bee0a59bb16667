"""What all tokens of a predicate have in common, looked up in the model once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from planner.domains import Domain, Interval, Values
from planner.model.classes import Kind, Predicate
from planner.model.manager import ModelManager

TokenKind = Kind | Literal["constraint"]
"""What a value token's attribute says of it, or that it is a constraint token."""


@dataclass(frozen=True, slots=True)
class Form:
    """A predicate, its attribute's kind, and the domains that the variables of its tokens begin with."""

    predicate: Predicate
    kind: TokenKind
    objects: Values
    duration: Interval
    parameters: tuple[tuple[str, Domain], ...]
    label: str

    @property
    def is_settled(self) -> bool:
        """Whether it stays so: an open domain may still grow."""
        return not any(domain.is_open for domain in (self.objects, *(domain for _, domain in self.parameters)))


def form_of(model: ModelManager, cls: str, name: str) -> Form:
    """The form of the tokens of a class's predicate."""
    predicate = model.predicate(cls, name)
    parameters = tuple((p.name, model.domain_of(p.type)) for p in predicate.parameters)
    kind, objects, label = model.kind_of(predicate), model.objects_of(cls), f"predicate {predicate.full_name}"
    return Form(predicate, kind, objects, Interval(*predicate.duration), parameters, label)
