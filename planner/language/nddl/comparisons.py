"""Comparisons that say how far two timepoints are apart: `a.end + 5 <= b.start` and the like."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from planner.language.nddl.syntax import Binary, Expression, Name
from planner.model.rules import Ref

Bounds = tuple[float, float]
Timepoint = Callable[[Name], Ref | None]
Number = Callable[[Expression], Bounds | None]


@dataclass(frozen=True, slots=True)
class Difference:
    """`lower <= to - from_ <= upper`."""

    from_: Ref
    to: Ref
    lower: float
    upper: float


@dataclass(frozen=True, slots=True)
class _Sum:
    """Timepoints that are added, timepoints that are taken away, and bounds on the rest."""

    plus: tuple[Ref, ...]
    minus: tuple[Ref, ...]
    rest: Bounds


def difference(node: Binary, timepoint: Timepoint, number: Number) -> Difference | None:
    """The distance that a comparison of sums states; None unless just two timepoints take part, with opposite signs."""
    left, right = _sum(node.left, timepoint, number), _sum(node.right, timepoint, number)
    if left is None or right is None:
        return None
    # left - right  op  0, with everything on one side
    plus, minus = left.plus + right.minus, left.minus + right.plus
    if len(plus) != 1 or len(minus) != 1:
        return None
    low, high = left.rest[0] - right.rest[1], left.rest[1] - right.rest[0]
    if math.isnan(low) or math.isnan(high):
        return None
    bounds = _bounds(node.operator, low, high)
    return None if bounds is None else Difference(minus[0], plus[0], *bounds)


def _bounds(operator: str, low: float, high: float) -> Bounds | None:
    """Bounds on d from `d + rest op 0` with some rest in [low, high]; times are whole numbers."""
    if operator == "==":
        return -high, -low
    if operator == "<=":
        return -math.inf, -low
    if operator == "<":
        return -math.inf, -low - 1
    if operator == ">=":
        return -high, math.inf
    return (-high + 1, math.inf) if operator == ">" else None


def _sum(node: Expression, timepoint: Timepoint, number: Number) -> _Sum | None:
    if isinstance(node, Name):
        ref = timepoint(node)
        if ref is not None:
            return _Sum((ref,), (), (0, 0))
    bounds = number(node)
    if bounds is not None:
        return _Sum((), (), bounds)
    if not isinstance(node, Binary) or node.operator not in ("+", "-"):
        return None
    left, right = _sum(node.left, timepoint, number), _sum(node.right, timepoint, number)
    if left is None or right is None:
        return None
    if node.operator == "+":
        rest = (left.rest[0] + right.rest[0], left.rest[1] + right.rest[1])
        return _Sum(left.plus + right.plus, left.minus + right.minus, rest)
    rest = (left.rest[0] - right.rest[1], left.rest[1] - right.rest[0])
    return _Sum(left.plus + right.minus, left.minus + right.plus, rest)
