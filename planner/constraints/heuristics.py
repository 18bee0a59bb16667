"""Heuristics of the constraint network (paper, section 4): which variable to assign next, and which value first.

They read the network and change nothing, so that an engine may ask at any time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any

from planner.constraints.consistency import constraints_on, only, with_value
from planner.constraints.network import Variable

VariableHeuristic = Callable[[Iterable[Variable]], Variable | None]
"""The variable to assign next among some, the first of equals; None when all have one value, or endless ones."""
ValueHeuristic = Callable[[Variable], list[Any]]
"""The values of a variable with finitely many, in the order in which to try them."""


def _least(variables: Iterable[Variable], key: Callable[[Variable], float]) -> Variable | None:
    open_ = (v for v in variables if not v.domain.is_singleton and v.domain.size < math.inf)
    return min(open_, key=key, default=None)


def first_stated(variables: Iterable[Variable]) -> Variable | None:
    """In the order given."""
    return _least(variables, lambda variable: 0)


def fewest_values(variables: Iterable[Variable]) -> Variable | None:
    """The one with the fewest values left (Haralick and Elliott 1980)."""
    return _least(variables, lambda variable: variable.domain.size)


def fewest_values_per_constraint(variables: Iterable[Variable]) -> Variable | None:
    """The one with the fewest values for the constraints on it (Bessiere and Regin 1996)."""
    return _least(variables, lambda variable: variable.domain.size / (1 + sum(1 for _ in constraints_on(variable))))


def in_order(variable: Variable) -> list[Any]:
    """In the order in which the domain lists them."""
    return list(variable.domain.values())


def least_constraining(variable: Variable) -> list[Any]:
    """Those first that leave most to other variables, as far as each constraint tells by itself: by the product of the
    sizes of their domains (Geelen 1992). A value that a constraint refuses comes last."""
    return sorted(variable.domain.values(), key=lambda value: -_left(variable, value))


def _left(variable: Variable, value: Any) -> float:
    """The logarithm of how many assignments to the other variables of its constraints a value leaves."""
    one = only(variable.domain, value)
    total = 0.0
    for constraint in constraints_on(variable):
        narrowed = constraint.procedure.narrow(with_value(constraint, variable, one))
        if narrowed is None or any(domain.is_empty for domain in narrowed):
            return -math.inf
        for other, domain in zip(constraint.scope, narrowed, strict=True):
            if other is not variable and domain.size < math.inf:
                total += math.log(domain.size)
    return total


VARIABLE_HEURISTICS: Mapping[str, VariableHeuristic] = MappingProxyType(
    {
        "first-stated": first_stated,
        "fewest-values": fewest_values,
        "fewest-values-per-constraint": fewest_values_per_constraint,
    }
)
VALUE_HEURISTICS: Mapping[str, ValueHeuristic] = MappingProxyType(
    {"in-order": in_order, "least-constraining": least_constraining}
)
