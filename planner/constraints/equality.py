"""Equality and order: eq, neq, leq, lt, withinBounds.

Equal means the same value, whatever the kinds of the two domains (numbers by number). These run most often, so the
plain cases come first. Strength: generalised arc consistency on enumerated domains, bounds consistency on intervals.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from planner.constraints.numeric import INF, above, below, ceil_whole, clip, floor_whole, meet, same
from planner.constraints.procedure import Narrowed
from planner.domains import Domain, Interval, Number, Values


def eq(domains: Sequence[Domain]) -> Narrowed:
    """x1 = x2 = ... = xn."""
    if len(domains) == 2:
        x, y = domains
        if isinstance(x, Values):
            if isinstance(y, Values) and x.universe is y.universe:
                bits = x.bits & y.bits
                if (bits == x.bits and bits == y.bits) or x.universe.is_open:
                    return domains
                if not bits:
                    return None
                return (
                    (x if bits == x.bits else y, y if bits == y.bits else x)
                    if bits in (x.bits, y.bits)
                    else (
                        Values(x.universe, bits),
                        Values(x.universe, bits),
                    )
                )
        elif isinstance(y, Interval) and x.integer and y.integer:
            if x.lower == y.lower and x.upper == y.upper:
                return domains
            lower, upper = max(x.lower, y.lower), min(x.upper, y.upper)
            if lower > upper:
                return None
            return x.bounded(lower, upper), y.bounded(lower, upper)
    return _eq_all(domains)


def _eq_all(domains: Sequence[Domain]) -> Narrowed:
    intervals = [d for d in domains if isinstance(d, Interval)]
    sets = [d for d in domains if isinstance(d, Values) and not d.is_open]
    if len(intervals) + len(sets) < 2:
        return domains
    common = common_range(intervals)
    if common is None:
        return None
    lower, upper, integer = common
    if not sets:
        return _each(domains, lower, upper, ())
    smallest = min(sets, key=lambda d: d.size)
    values = [
        v
        for v in smallest.values()
        if all(v in other for other in sets) and (not intervals or _in_range(v, lower, upper, integer))
    ]
    if not values:
        return None
    if intervals:
        lower, upper = min(values), max(values)
    return _each(domains, lower, upper, values)


def common_range(intervals: Iterable[Interval]) -> tuple[Number, Number, bool] | None:
    """The range that all the intervals have in common, and whether only its whole numbers; None when empty."""
    lower, upper, integer = -INF, INF, False
    for interval in intervals:
        lower, upper = max(lower, interval.lower), min(upper, interval.upper)
        integer = integer or interval.integer
    if integer:
        lower, upper = ceil_whole(lower), floor_whole(upper)
    if lower > upper:
        # Reals apart by rounding only are one value.
        return (upper, lower, integer) if same(lower, upper) else None
    return lower, upper, integer


def _in_range(value: Any, lower: Number, upper: Number, integer: bool) -> bool:
    if not isinstance(value, int | float):
        return False
    if not (lower <= value <= upper or same(value, lower) or same(value, upper)):
        return False
    return not integer or not isinstance(value, float) or (math.isfinite(value) and same(value, round(value)))


def _each(domains: Sequence[Domain], lower: Number, upper: Number, values: Sequence[Any]) -> Narrowed:
    result: list[Domain] = []
    for domain in domains:
        if isinstance(domain, Interval):
            kept = meet(domain, lower, upper)
            if kept is None:
                return None
            result.append(kept)
        else:
            result.append(domain if domain.is_open else domain.keep(values))
    return result


def neq(domains: Sequence[Domain]) -> Narrowed:
    """x != y."""
    x, y = domains
    if x.is_singleton and not x.is_open:
        kept = without(y, x.value)
        return domains if kept is y else None if kept is None else (x, kept)
    if y.is_singleton and not y.is_open:
        kept = without(x, y.value)
        return domains if kept is x else None if kept is None else (kept, y)
    return domains


def without(domain: Domain, value: Any) -> Domain | None:
    """The domain less that value, None when nothing is left; an open domain stays as it is."""
    if isinstance(domain, Values):
        if domain.is_open:
            return domain
        kept = domain.without(value)
        return kept if kept.bits else None
    if not isinstance(value, int | float):
        return domain
    if domain.integer:
        whole = round(value) if isinstance(value, float) and math.isfinite(value) else value
        left = domain.without(whole) if same(value, whole) else domain
        return None if left.is_empty else left
    return None if domain.is_singleton and same(domain.value, value) else domain


def leq(domains: Sequence[Domain]) -> Narrowed:
    """x <= y."""
    x, y = domains
    if isinstance(x, Interval) and isinstance(y, Interval):
        if x.upper <= y.upper and x.lower <= y.lower:
            return domains
        if x.integer and y.integer:
            return (x.bounded(-INF, y.upper), y.bounded(x.lower, INF)) if x.lower <= y.upper else None
    elif x.is_open or y.is_open:
        return domains
    first = clip(x, -INF, y.upper)
    if first is None:
        return None
    second = clip(y, first.lower, INF)
    return None if second is None else (first, second)


def lt(domains: Sequence[Domain]) -> Narrowed:
    """x < y."""
    x, y = domains
    if isinstance(x, Interval) and isinstance(y, Interval):
        if x.integer and y.integer:
            if x.upper < y.upper and x.lower < y.lower:
                return domains
            return (x.bounded(-INF, y.upper - 1), y.bounded(x.lower + 1, INF)) if x.lower < y.upper else None
    elif x.is_open or y.is_open:
        return domains
    first = below(x, y.upper)
    if first is None:
        return None
    second = above(y, first.lower)
    return None if second is None else (first, second)


def within_bounds(domains: Sequence[Domain]) -> Narrowed:
    """y <= x <= z, arguments (x, y, z)."""
    x, y, z = domains
    for _ in range(2):
        pair = leq((y, x))
        if pair is None:
            return None
        y, x = pair
        pair = leq((x, z))
        if pair is None:
            return None
        x, z = pair
    if not (y.is_open or z.is_open) and x.is_open:
        # An unknown x still needs room between the two.
        pair = leq((y, z))
        if pair is None:
            return None
        y, z = pair
    return x, y, z
