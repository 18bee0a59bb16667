"""What the planner raises.

PlannerError
    ModelError          the domain model says something that cannot be (unknown name, wrong arity, ...)
    ProblemError        the problem does (a goal on an unknown predicate, a horizon that ends before it starts, ...)
    PlanFormatError     a plan file that is not one; says the field
    NetworkFormatError  a temporal network file that is not one; says the field
    HintsError          a file of solver hints that is not one; says the key

`planner.constraints.network.Inconsistency` is not among them: it is search's own signal, never reaches a user, and
formats nothing unless asked.

Every message says what went wrong, where, what was expected and what was found.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class PlannerError(Exception):
    """Anything a user of the planner did that cannot work."""


class ModelError(PlannerError):
    """The domain model is wrong."""


class ProblemError(PlannerError):
    """The problem statement is wrong."""


class PlanFormatError(PlannerError):
    """A plan file is malformed; the message names the field."""


class NetworkFormatError(PlannerError):
    """A temporal network file is malformed; the message names the field."""


class HintsError(PlannerError):
    """A file of solver hints is malformed, or is not for this model; the message names the file and the key."""


def nearest(name: str, known: Iterable[str]) -> str:
    """A hint to end a message with: the known names most like this one, or nothing."""
    near = difflib.get_close_matches(name, list(known), n=3)
    return f"; did you mean {', '.join(near)}?" if near else ""
