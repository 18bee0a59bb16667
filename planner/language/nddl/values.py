"""Domains of literals and types: what can be said without a plan."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeGuard

from planner.domains import Domain, Interval, Universe, Values
from planner.errors import ModelError, nearest
from planner.language.nddl.errors import Complaint
from planner.language.nddl.symbols import Symbols
from planner.language.nddl.syntax import Binary, Choice, Expression, Name, Number, Range, Text, Truth, Unary
from planner.model.manager import ModelManager

Value = object
"""A number, a boolean, a text (also: a value of an enumeration) or a model object."""


class Literals:
    """The values of expressions that need no plan: literals, values of enumerations, objects."""

    def __init__(self, symbols: Symbols, model: ModelManager) -> None:
        self.symbols = symbols
        self.model = model

    def domain_of_type(self, type_: str) -> Domain:
        """The domain of a type by its name."""
        try:
            return self.model.domain_of(type_)
        except ModelError:
            base = self.symbols.base(type_)
            return self.model.domain_of(base)

    def is_real(self, type_: str) -> bool:
        """Whether values of the type are real numbers."""
        return self.symbols.base(type_) == "float"

    def value(self, expression: Expression) -> Value | None:
        """The value of a literal, a value of an enumeration, an object or arithmetic over numbers; None for others."""
        if isinstance(expression, Number | Text | Truth):
            return expression.value
        if isinstance(expression, Name):
            return self._named(expression)
        if isinstance(expression, Unary) and expression.operator == "-":
            operand = self.value(expression.operand)
            return -operand if is_number(operand) else None
        if isinstance(expression, Binary) and expression.operator in "+-*/":
            left, right = self.value(expression.left), self.value(expression.right)
            if is_number(left) and is_number(right):
                return arithmetic(expression, left, right)
        return None

    def _named(self, name: Name) -> Value | None:
        enumerations = self.symbols.enumerations_of
        if len(name.path) == 1 and name.path[0] in self.model.objects:
            return self.model.objects[name.path[0]]
        if len(name.path) == 1 and name.path[0] in enumerations and name.path[0] not in self.symbols.variables:
            return name.path[0]
        if len(name.path) == 2 and name.path[0] in enumerations.get(name.path[1], ()):
            return name.path[1]
        return self.symbols.constants.get(name.path[0]) if len(name.path) == 1 else None

    def interval(self, node: Range, real: bool) -> Interval:
        """The interval of `[lower upper]`; a complaint for bounds that are no numbers or are the wrong way round."""
        lower, upper = self._bound(node.lower), self._bound(node.upper)
        if lower > upper:
            raise Complaint(node.at, f"the interval [{lower} {upper}] is empty: expected lower <= upper")
        whole = not (real or _is_real(node.lower) or _is_real(node.upper))
        return Interval(lower, upper, whole)

    def _bound(self, node: Expression) -> float:
        value = self.value(node)
        if not is_number(value):
            raise Complaint(node.at, f"expected a number as the bound of an interval, found {node!s}")
        return value

    def choice(self, node: Choice, type_: str | None = None) -> Values:
        """The set of `{a, b}`, over the universe of the type where that has one."""
        values: list[Value] = []
        for one in node.values:
            value = self.value(one)
            if value is None:
                text = str(one) if isinstance(one, Name) else "an expression"
                hint = nearest(text, [*self.symbols.enumerations_of, *self.model.objects])
                raise Complaint(one.at, f"expected a value or an object in this set, found {text!r}{hint}")
            values.append(value)
        universe = self._universe(type_)
        if universe is not None:
            return self._within(node, values, universe)
        if any(v in self.model.objects.values() for v in values):
            return self.model.objects_of("Object").keep(values)
        return Universe("set", values).domain()

    def _universe(self, type_: str | None) -> Universe | None:
        base = None if type_ is None else self.symbols.base(type_)
        if base is None or base not in (*self.symbols.enumerations, "bool"):
            return None
        domain = self.model.domain_of(base)
        return domain.universe if isinstance(domain, Values) else None

    def _within(self, node: Choice, values: Sequence[Value], universe: Universe) -> Values:
        for one, value in zip(node.values, values, strict=True):
            if value not in universe.index:
                hint = nearest(str(value), map(str, universe.values))
                raise Complaint(one.at, f"{value!r} is not a value of {universe.name}{hint}")
        return universe.domain(values)

    def enumerated(self, value: str, enumeration: str) -> Values:
        """The domain of one value of an enumeration."""
        return self.model.enumerations[enumeration].domain((value,))


def is_number(value: object) -> TypeGuard[float]:
    """Whether a value is a number (a truth value is none)."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_real(node: Expression) -> bool:
    return isinstance(node, Number) and node.real and not math.isinf(node.value)


def arithmetic(node: Binary, left: float, right: float) -> float | None:
    """The value of an operation on numbers; None where it has none, a complaint for a division by zero."""
    if node.operator == "/":
        if right == 0:
            raise Complaint(node.at, "division by zero")
        return left / right
    found = left + right if node.operator == "+" else left - right if node.operator == "-" else left * right
    return None if math.isnan(found) else found
