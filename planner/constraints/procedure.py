"""The constraint procedure and its registry (paper, section 5).

A procedure narrows: it maps the domains of its scope to subsets of them, and never eliminates an allowed assignment.
On singletons it thereby decides: the same domains back, or None for "no solution".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from planner.domains import Domain
from planner.errors import ModelError, nearest

# The narrowed domains in scope order (the same object where nothing changed), or None when no solution exists.
Narrowed = Sequence[Domain] | None
Narrowing = Callable[[Sequence[Domain]], Narrowed]


@dataclass(frozen=True, slots=True)
class ConstraintProcedure:
    """A named relation over a scope of `minimum` to `maximum` variables (None: any number), given by its narrowing.

    `narrow` is a pure function of the domains: no state, no order of calls. It need not reach its own fixpoint in one
    call; the network calls again as long as a domain of the scope changes. `kinds` names what each argument must be
    (`numeric`, `boolean`, `any`); the last one covers the rest.
    """

    name: str
    narrow: Narrowing
    minimum: int
    maximum: int | None
    kinds: tuple[str, ...] = ("any",)

    @property
    def formula(self) -> str:
        """What the relation says, in one line."""
        return (self.narrow.__doc__ or self.name).strip().splitlines()[0]

    def check_scope(self, count: int) -> None:
        """ModelError unless the relation takes that many variables."""
        if count < self.minimum or (self.maximum is not None and count > self.maximum):
            expected = (
                str(self.minimum) if self.minimum == self.maximum else f"{self.minimum} to {self.maximum or 'any'}"
            )
            raise ModelError(f"constraint {self.name}: expected {expected} arguments, found {count}")


class ProcedureRegistry:
    """Procedures by name. Immutable: `with_procedures` gives a larger one."""

    def __init__(self, procedures: Mapping[str, ConstraintProcedure]) -> None:
        self._procedures = dict(procedures)

    def __contains__(self, name: str) -> bool:
        return name in self._procedures

    def names(self) -> tuple[str, ...]:
        """All names, sorted."""
        return tuple(sorted(self._procedures))

    def get(self, name: str) -> ConstraintProcedure:
        """The procedure of that name; ModelError with the nearest names otherwise."""
        try:
            return self._procedures[name]
        except KeyError:
            hint = nearest(name, self._procedures)
            raise ModelError(f"there is no constraint procedure named {name!r}{hint}") from None

    def with_procedures(self, *procedures: ConstraintProcedure) -> ProcedureRegistry:
        """This registry and those procedures; a name given twice means the new one."""
        return ProcedureRegistry(self._procedures | {p.name: p for p in procedures})
