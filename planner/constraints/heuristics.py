"""Heuristics of the constraint network (paper, section 4): which variable to assign next, and which value first.

They read the network and change nothing, so that an engine may ask at any time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain
from random import Random
from types import MappingProxyType
from typing import Any

from planner.constraints.consistency import constraints_on, only, with_value
from planner.constraints.network import Variable
from planner.domains import Interval

VariableHeuristic = Callable[[Iterable[Variable]], Variable | None]
"""The variable to assign next among some, the first of equals; None when all have one value, or endless ones."""
ValueHeuristic = Callable[[Variable], Iterable[Any]]
"""The values of a variable with finitely many, in the order in which to try them."""
Scalar = str | int | float | bool
"""A value as a file says it."""
MANY = 1000
"""Of more values than this, none is looked at before it is tried."""


def _least(variables: Iterable[Variable], key: Callable[[Variable], float]) -> Variable | None:
    open_ = (v for v in variables if not v.domain.is_singleton and v.domain.size < math.inf)
    return min(open_, key=key, default=None)


def first_stated(variables: Iterable[Variable]) -> Variable | None:
    """In the order given."""
    return _least(variables, lambda variable: 0)


def fewest_values(variables: Iterable[Variable]) -> Variable | None:
    """The one with the fewest values left (Haralick and Elliott 1980), or with none, a dead end."""
    best, fewest = None, math.inf
    for variable in variables:
        size = variable.domain.size
        if size < fewest and size != 1:
            best, fewest = variable, size
            if size <= 2:
                break
    return best


def fewest_values_per_constraint(variables: Iterable[Variable]) -> Variable | None:
    """The one with the fewest values for the constraints on it (Bessiere and Regin 1996)."""
    return _least(variables, lambda variable: variable.domain.size / (1 + sum(1 for _ in constraints_on(variable))))


def in_order(variable: Variable) -> Iterable[Any]:
    """In the order in which the domain lists them."""
    values: Iterable[Any] = variable.domain.values()
    return values


def smallest_first(variable: Variable) -> Sequence[Any]:
    """Numbers by size, other values as they were declared."""
    domain = variable.domain
    if isinstance(domain, Interval):
        return range(int(domain.lower), int(domain.upper) + 1)
    return sorted(domain.values()) if domain.is_numeric else list(domain.values())


def largest_first(variable: Variable) -> Iterable[Any]:
    """The reverse of the smallest first."""
    return smallest_first(variable)[::-1]


def least_constraining(variable: Variable) -> Iterable[Any]:
    """Those first that leave most to other variables, as far as each constraint tells by itself: by the product of the
    sizes of their domains (Geelen 1992). A value that a constraint refuses comes last."""
    if variable.domain.size > MANY:
        return in_order(variable)
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


def shuffled(variable: Variable, seed: int) -> Iterator[Any]:
    """A random order, a function of the seed and the variable's name alone, drawn as far as somebody asks.

    Fisher and Yates' shuffle, with only what moved written down.
    """
    values = smallest_first(variable)
    random = Random(f"{seed} {variable.name}")
    moved: dict[int, int] = {}
    for last in range(len(values) - 1, -1, -1):
        place = random.randrange(last + 1)
        drawn = moved.get(place, place)
        moved[place] = moved.get(last, last)
        yield values[drawn]


def listed_first(variable: Variable, order: Sequence[Scalar]) -> Iterator[Any]:
    """What is listed, where it is a value, then the others, the smallest first."""
    values = smallest_first(variable)
    if isinstance(values, range):
        listed = [int(v) for v in order if not isinstance(v, bool | str) and v in values]
    else:
        listed = [value for wanted in order for value in values if _is_meant(wanted, value)]
    first = dict.fromkeys(listed)
    return chain(first, (value for value in values if value not in first))


def _is_meant(wanted: Scalar, value: Any) -> bool:
    if isinstance(wanted, bool) or isinstance(value, bool):
        return wanted is value
    return bool(wanted == value) or wanted == str(value)


VARIABLE_HEURISTICS: Mapping[str, VariableHeuristic] = MappingProxyType(
    {
        "first-stated": first_stated,
        "fewest-values": fewest_values,
        "fewest-values-per-constraint": fewest_values_per_constraint,
    }
)
VALUE_HEURISTICS: Mapping[str, ValueHeuristic] = MappingProxyType(
    {"in-order": in_order, "min": smallest_first, "max": largest_first, "least-constraining": least_constraining}
)
