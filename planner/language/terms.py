"""Terms of the Python builder: expressions over names, which arithmetic and comparison make larger."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from planner.model.rules import Apply, Constant, Expression


@dataclass(frozen=True, slots=True, eq=False)
class Term:
    """An expression in a rule; arithmetic and comparison make larger ones."""

    expression: Expression

    def __add__(self, other: Operand) -> Term:
        return Term(Apply("addEq", (self.expression, expression_of(other))))

    __radd__ = __add__

    def __mul__(self, other: Operand) -> Term:
        return Term(Apply("mulEq", (self.expression, expression_of(other))))

    __rmul__ = __mul__

    def __eq__(self, other: object) -> Test:  # type: ignore[override]
        return Test("eq", (self.expression, expression_of(other)))

    def __ne__(self, other: object) -> Test:  # type: ignore[override]
        return Test("neq", (self.expression, expression_of(other)))

    def __le__(self, other: Operand) -> Test:
        return Test("leq", (self.expression, expression_of(other)))

    def __lt__(self, other: Operand) -> Test:
        return Test("lt", (self.expression, expression_of(other)))

    def __ge__(self, other: Operand) -> Test:
        return Test("leq", (expression_of(other), self.expression))

    def __gt__(self, other: Operand) -> Test:
        return Test("lt", (expression_of(other), self.expression))

    def __hash__(self) -> int:
        return hash(self.expression)


@dataclass(frozen=True, slots=True)
class Test:
    """A relation between terms: required, or the test of a guard."""

    procedure: str
    arguments: tuple[Expression, ...]


Operand = Any
"""A Term, a model object, or a plain value."""


def expression_of(operand: object) -> Expression:
    """The expression of a term, or of a value as a constant."""
    return operand.expression if isinstance(operand, Term) else Constant(operand)
