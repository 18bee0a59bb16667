"""Sums and products: addEq, eqSum, mulEq, divEq, eqProduct, neg, absVal, diffSquare, distances.

Each argument is narrowed to the bounds that the others leave it (hull consistency, projection by projection: F.
Benhamou and W. Older, "Applying interval arithmetic to real, integer and Boolean constraints", 1997). Sums reach bounds
consistency; products the bounds consistency of their real relaxation, rounded to whole numbers on integers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from planner.constraints.numeric import (
    EVERYTHING,
    INF,
    Bounds,
    Intervals,
    add,
    bounds,
    divide,
    lowered,
    meet,
    multiply,
    negate,
    numeric,
    raised,
    subtract,
)
from planner.constraints.procedure import Narrowed
from planner.domains import REAL_RESOLUTION, Domain, Interval, Number

_Combine = Callable[[Bounds, Bounds], Bounds]
_Undo = Callable[[Bounds, Bounds], Bounds | None]


def add_eq(domains: Sequence[Domain]) -> Narrowed:
    """x + y = z, arguments (x, y, z)."""
    x, y, z = domains
    if isinstance(x, Interval) and isinstance(y, Interval) and isinstance(z, Interval):
        xl, xu, yl, yu, zl, zu = x.lower, x.upper, y.lower, y.upper, z.lower, z.upper
        if xl + yl <= zl and zu <= xu + yu and zl - yu <= xl and xu <= zu - yl and zl - xu <= yl and yu <= zu - xl:
            return domains
        if x.integer and y.integer and z.integer:
            return _add_integers(x, y, z)
    return _add_eq(domains)


def _add_integers(x: Interval, y: Interval, z: Interval) -> Narrowed:
    """x + y = z without rounding; a sum of opposite infinities is NaN, which compares as no news."""
    xl, xu, yl, yu = x.lower, x.upper, y.lower, y.upper
    zl, zu = _tighter(z.lower, z.upper, xl + yl, xu + yu)
    xl, xu = _tighter(xl, xu, zl - yu, zu - yl)
    yl, yu = _tighter(yl, yu, zl - xu, zu - xl)
    if xl > xu or yl > yu or zl > zu:
        return None
    return (
        x if xl == x.lower and xu == x.upper else Interval(xl, xu),
        y if yl == y.lower and yu == y.upper else Interval(yl, yu),
        z if zl == z.lower and zu == z.upper else Interval(zl, zu),
    )


def _tighter(lower: Number, upper: Number, low: Number, high: Number) -> Bounds:
    return low if low > lower else lower, high if high < upper else upper


def _add_intervals(domains: Intervals) -> Intervals | None:
    """x + y = z."""
    x, y, z = domains
    total = meet(z, *add(bounds(x), bounds(y)))
    if total is None:
        return None
    first = meet(x, *subtract(bounds(total), bounds(y)))
    if first is None:
        return None
    second = meet(y, *subtract(bounds(total), bounds(first)))
    return None if second is None else (first, second, total)


_add_eq = numeric(_add_intervals)


@numeric
def eq_sum(domains: Intervals) -> Intervals | None:
    """r = x1 + ... + xn, arguments (r, x1, ..., xn)."""
    return _fold(domains, (0, 0), add, subtract)


def _fold(domains: Intervals, neutral: Bounds, combine: _Combine, undo: _Undo) -> Intervals | None:
    """Narrow r = x1 * ... * xn for an associative operation: each x by what those before and after it leave."""
    terms = domains[1:]
    before, after = [neutral], [neutral]
    for term in terms:
        before.append(combine(before[-1], bounds(term)))
    for term in reversed(terms):
        after.append(combine(after[-1], bounds(term)))
    result = meet(domains[0], *before[-1])
    if result is None:
        return None
    narrowed = [result]
    for i, term in enumerate(terms):
        left = undo(bounds(result), combine(before[i], after[len(terms) - 1 - i]))
        kept = None if left is None else meet(term, *left)
        if kept is None:
            return None
        narrowed.append(kept)
    return narrowed


def _nonzero(domain: Interval) -> Interval | None:
    """The interval without zero, as far as its ends can tell."""
    if domain.lower <= 0 <= domain.upper:
        left = domain.without(0)
        return None if left.is_empty else left
    return domain


def _multiply_intervals(domains: Intervals) -> Intervals | None:
    x, y, z = domains
    product = meet(z, *multiply(bounds(x), bounds(y)))
    if product is None:
        return None
    if product.lower > REAL_RESOLUTION or product.upper < -REAL_RESOLUTION:
        left, right = _nonzero(x), _nonzero(y)
        if left is None or right is None:
            return None
        x, y = left, right
    quotient = divide(bounds(product), bounds(y))
    first = None if quotient is None else meet(x, *quotient)
    if first is None:
        return None
    quotient = divide(bounds(product), bounds(first))
    second = None if quotient is None else meet(y, *quotient)
    return None if second is None else (first, second, product)


@numeric
def mul_eq(domains: Intervals) -> Intervals | None:
    """x * y = z, arguments (x, y, z)."""
    return _multiply_intervals(domains)


@numeric
def div_eq(domains: Intervals) -> Intervals | None:
    """x / y = z and y != 0, arguments (x, y, z); exact on integers (7 / 2 is no integer)."""
    x, y, z = domains
    divisor = _nonzero(y)
    if divisor is None:
        return None
    narrowed = _multiply_intervals((z, divisor, x))
    return None if narrowed is None else (narrowed[2], narrowed[1], narrowed[0])


@numeric
def eq_product(domains: Intervals) -> Intervals | None:
    """r = x1 * ... * xn, arguments (r, x1, ..., xn)."""
    return _fold(domains, (1, 1), multiply, divide)


@numeric
def neg(domains: Intervals) -> Intervals | None:
    """x = -y, arguments (x, y)."""
    x, y = domains
    first = meet(x, *negate(bounds(y)))
    if first is None:
        return None
    second = meet(y, *negate(bounds(first)))
    return None if second is None else (first, second)


def magnitude(a: Bounds) -> Bounds:
    """All absolute values."""
    low, high = a
    if low >= 0:
        return a
    return (-high, -low) if high <= 0 else (0, max(-low, high))


def unsigned(domain: Interval, low: Number, high: Number) -> Interval | None:
    """The values v of the interval with low <= |v| <= high; the middle of an interval stays."""
    kept = meet(domain, -high, high)
    if kept is None or low <= 0:
        return kept
    positive, negative = meet(kept, low, high), meet(kept, -high, -low)
    if positive is None or negative is None:
        return positive or negative
    return kept.bounded(negative.lower, positive.upper)


@numeric
def abs_val(domains: Intervals) -> Intervals | None:
    """x = |y|, arguments (x, y)."""
    x, y = domains
    first = meet(x, *magnitude(bounds(y)))
    if first is None:
        return None
    second = unsigned(y, first.lower, first.upper)
    return None if second is None else (first, second)


def square(a: Bounds) -> Bounds:
    """All squares."""
    low, high = magnitude(a)
    return multiply((low, low), (low, low))[0], multiply((high, high), (high, high))[1]


def root(a: Bounds) -> Bounds:
    """All square roots of the part that is not negative."""
    return max(0.0, lowered(_sqrt(a[0]), 0)), raised(_sqrt(a[1]), 0)


def _sqrt(value: Number) -> float:
    if value <= 0:
        return 0.0
    try:
        return math.sqrt(value)
    except OverflowError:
        return INF


def add_squares(terms: Sequence[Bounds]) -> Bounds:
    """All sums of squares."""
    total: Bounds = (0, 0)
    for term in terms:
        total = add(total, square(term))
    return total


@numeric
def diff_square(domains: Intervals) -> Intervals | None:
    """a = (x - y)^2, arguments (x, y, a)."""
    x, y, a = domains
    area = meet(a, *square(subtract(bounds(x), bounds(y))))
    if area is None:
        return None
    sides = _apart(x, y, root(bounds(area)))
    return None if sides is None else (*sides, area)


def _apart(x: Interval, y: Interval, distance: Bounds) -> tuple[Interval, Interval] | None:
    """x and y with |x - y| within the bounds."""
    low, high = distance
    first = _beside(x, bounds(y), low, high)
    if first is None:
        return None
    second = _beside(y, bounds(first), low, high)
    return None if second is None else (first, second)


def _beside(x: Interval, centre: Bounds, low: Number, high: Number) -> Interval | None:
    """The values of x that are low to high away from some point of the centre, on either side."""
    right = meet(x, *add(centre, (low, high)))
    left = meet(x, *add(centre, (-high, -low)))
    if right is None or left is None:
        return right or left
    if left is x or right is x:
        return x
    return x.bounded(min(left.lower, right.lower), max(left.upper, right.upper))


@numeric
def distance_squares(domains: Intervals) -> Intervals | None:
    """a = sqrt(x + y), arguments (x, y, a)."""
    x, y, a = domains
    side = meet(a, *root(add(bounds(x), bounds(y))))
    if side is None or bounds(side)[1] < 0:
        return None
    total = square((max(0, side.lower), side.upper))
    first = meet(x, *subtract(total, bounds(y)))
    if first is None:
        return None
    second = meet(y, *subtract(total, bounds(first)))
    return None if second is None else (first, second, side)


@numeric
def calc_distance(domains: Intervals) -> Intervals | None:
    """d = sqrt((x1 - x2)^2 + (y1 - y2)^2), arguments (d, x1, y1, x2, y2)."""
    d, *ends = domains
    spans = [magnitude(subtract(bounds(ends[i]), bounds(ends[i + 2]))) for i in (0, 1)]
    side = meet(d, *root(add_squares(spans)))
    if side is None:
        return None
    area = square((max(0, side.lower), side.upper))
    narrowed = list(ends)
    for i in (0, 1):
        low, high = subtract(area, square(spans[1 - i]))
        pair = _apart(ends[i], ends[i + 2], root((max(0, low), high)) if (low, high) != EVERYTHING else (0, INF))
        if pair is None:
            return None
        narrowed[i], narrowed[i + 2] = pair
    return (side, *narrowed)
