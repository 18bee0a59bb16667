"""Interval arithmetic that never loses a solution: what the numeric procedures share.

Whole numbers are exact. Reals are rounded outward, by two units in the last place of the larger operand, so the error
of the operands themselves is covered too (R. E. Moore, Interval Analysis, 1966, chapter 2). Reals closer than
`REAL_RESOLUTION` are one value everywhere: equal, neither less than the other. No operation on infinite ends gives NaN.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any

from planner.constraints.procedure import Narrowed, Narrowing
from planner.domains import REAL_RESOLUTION, Domain, Interval, Number, Values

INF = math.inf
Bounds = tuple[Number, Number]
Intervals = Sequence[Interval]
IntervalNarrowing = Callable[[Intervals], Intervals | None]

# What an open domain says: nothing.
UNKNOWN = Interval(-INF, INF, integer=False)
EVERYTHING: Bounds = (-INF, INF)

# Outward rounding, relative to the larger operand: two units in the last place.
ROUNDING = 2.0**-51
# A real bound moves only by more than this (relative), so that a chain of constraints settles in few steps.
REAL_STEP = REAL_RESOLUTION * 1e-3
# Combinations of enumerated values that one call looks at; beyond, only bounds are reasoned about.
ENUMERATION_LIMIT = 1024


def same(a: Any, b: Any) -> bool:
    """Whether a and b are one value: equal, or reals within the resolution."""
    if a == b:
        return True
    if not (isinstance(a, float | int) and isinstance(b, float | int)):
        return False
    if not (isinstance(a, float) or isinstance(b, float)) or math.isinf(a) or math.isinf(b):
        return False
    return abs(a - b) <= REAL_RESOLUTION * max(1.0, min(abs(a), abs(b)))


def less(a: Number, b: Number) -> bool:
    """Whether a < b and the two are not one value."""
    return a < b and not same(a, b)


def ceil_whole(value: Number) -> Number:
    """The smallest whole number that is not less than the value; infinity stays."""
    if not isinstance(value, float) or math.isinf(value):
        return value
    near = round(value)
    return near if same(value, near) else math.ceil(value)


def floor_whole(value: Number) -> Number:
    """The largest whole number that is not greater than the value; infinity stays."""
    return -ceil_whole(-value)


def meet(domain: Interval, lower: Number, upper: Number) -> Interval | None:
    """The values of the interval within [lower, upper]: the same object when all are, None when none is."""
    if lower <= domain.lower and domain.upper <= upper:
        return domain
    if domain.integer:
        lower, upper = max(domain.lower, ceil_whole(lower)), min(domain.upper, floor_whole(upper))
        if lower > upper:
            return None
        return domain if lower == domain.lower and upper == domain.upper else Interval(lower, upper)
    return _meet_real(domain, lower, upper)


def _meet_real(domain: Interval, lower: Number, upper: Number) -> Interval | None:
    low, high = max(domain.lower, lower), min(domain.upper, upper)
    if low > high:
        if not same(low, high):
            return None
        # Apart by rounding only: what is left is the end that faces the bounds.
        point = domain.upper if lower > domain.upper else domain.lower if upper < domain.lower else low
        low = high = point
    step = REAL_STEP * max(1.0, min(abs(low), abs(high)))
    moved = (low > domain.lower and low - domain.lower > step) or (high < domain.upper and domain.upper - high > step)
    if not moved:
        return domain
    return Interval(low, high, integer=False)


def clip(domain: Domain, lower: Number, upper: Number) -> Domain | None:
    """`meet` for every kind of numeric domain."""
    if isinstance(domain, Interval):
        return meet(domain, lower, upper)
    kept = domain.keep(v for v in domain.values() if not (less(v, lower) or less(upper, v)))
    return kept if kept.bits else None


def below(domain: Domain, limit: Number) -> Domain | None:
    """The values less than the limit; the limit itself may stay as the closed end of a real interval."""
    if isinstance(domain, Values):
        kept = domain.keep(v for v in domain.values() if less(v, limit))
        return kept if kept.bits else None
    if not less(domain.lower, limit):
        return None
    return meet(domain, -INF, ceil_whole(limit) - 1 if domain.integer else limit)


def above(domain: Domain, limit: Number) -> Domain | None:
    """The values greater than the limit; the limit itself may stay as the closed end of a real interval."""
    if isinstance(domain, Values):
        kept = domain.keep(v for v in domain.values() if less(limit, v))
        return kept if kept.bits else None
    if not less(limit, domain.upper):
        return None
    return meet(domain, floor_whole(limit) + 1 if domain.integer else limit, INF)


def lowered(value: Number, magnitude: Number) -> Number:
    """A lower bound on what rounded to that value, the operands being up to that magnitude."""
    if isinstance(value, int) or math.isinf(value):
        return value
    return math.nextafter(value - ROUNDING * magnitude if magnitude < INF else value, -INF)


def raised(value: Number, magnitude: Number) -> Number:
    """An upper bound on what rounded to that value, the operands being up to that magnitude."""
    return -lowered(-value, magnitude)


def add(a: Bounds, b: Bounds) -> Bounds:
    """All sums."""
    low, high = a[0] + b[0], a[1] + b[1]
    if isinstance(low, float):
        low = -INF if math.isnan(low) else lowered(low, max(abs(a[0]), abs(b[0])))
    if isinstance(high, float):
        high = INF if math.isnan(high) else raised(high, max(abs(a[1]), abs(b[1])))
    return low, high


def negate(a: Bounds) -> Bounds:
    """All negatives."""
    return -a[1], -a[0]


def subtract(a: Bounds, b: Bounds) -> Bounds:
    """All differences."""
    return add(a, (-b[1], -b[0]))


def _times(a: Number, b: Number) -> Number:
    if not a or not b:
        return 0
    try:
        return a * b
    except OverflowError:  # a whole number too large for a float
        return INF if (a > 0) == (b > 0) else -INF


def multiply(a: Bounds, b: Bounds) -> Bounds:
    """All products; zero times an infinite end is zero."""
    corners = [_times(p, q) for p in a for q in b]
    low, high = min(corners), max(corners)
    return lowered(low, abs(low)), raised(high, abs(high))


def has_zero(a: Bounds) -> bool:
    """Whether zero is within the bounds, to the resolution."""
    return a[0] <= REAL_RESOLUTION and a[1] >= -REAL_RESOLUTION


def divide(a: Bounds, b: Bounds) -> Bounds | None:
    """All q with q * divisor = dividend; None when there is none (the divisor is zero and the dividend is not)."""
    if b[0] <= 0 <= b[1]:
        if has_zero(a) or b[0] < 0 < b[1]:
            return EVERYTHING
        if b[0] == b[1]:
            return None
        # One side of zero: the quotient is unbounded on the side of the matching sign.
        if (b[0] == 0) == (a[0] > 0):
            nearest = _over(a[0] if a[0] > 0 else a[1], b[1] if b[0] == 0 else b[0])
            return lowered(min(nearest), abs(min(nearest))), INF
        nearest = _over(a[0] if a[0] > 0 else a[1], b[1] if b[0] == 0 else b[0])
        return -INF, raised(max(nearest), abs(max(nearest)))
    corners = [q for p in a for d in b for q in _over(p, d)]
    low, high = min(corners), max(corners)
    return lowered(low, abs(low)), raised(high, abs(high))


def _over(a: Number, b: Number) -> tuple[Number, ...]:
    """The quotient of two ends, b not zero; both limits when both are infinite."""
    if math.isinf(b):
        return (0.0, INF if (a > 0) == (b > 0) else -INF) if math.isinf(a) else (0.0,)
    try:
        return (a / b,)
    except OverflowError:
        return (0.0, INF if (a > 0) == (b > 0) else -INF)


def bounds(domain: Interval) -> Bounds:
    """The ends of the interval."""
    return domain.lower, domain.upper


def numeric(core: IntervalNarrowing) -> Narrowing:
    """The narrowing over all numeric domains that a narrowing over intervals gives.

    Enumerated domains: bounds first, then each combination of their values by itself, so that a value stays only when
    the interval narrowing finds no contradiction with it (generalised arc consistency where that narrowing decides
    a relation with one open argument). An open domain counts as unknown and stays as it is.
    """

    @functools.wraps(core)
    def narrow(domains: Sequence[Domain]) -> Narrowed:
        intervals = [d for d in domains if isinstance(d, Interval)]
        try:
            return core(intervals) if len(intervals) == len(domains) else _narrow_mixed(core, domains)
        except OverflowError:
            # Whole numbers beyond the range of reals, mixed with reals: nothing is concluded.
            return domains

    return narrow


def _hull(domain: Domain) -> Interval:
    if isinstance(domain, Interval):
        return domain
    if domain.is_open:
        return UNKNOWN
    return Interval(domain.lower, domain.upper, all(isinstance(v, int) for v in domain.values()))


def _narrow_mixed(core: IntervalNarrowing, domains: Sequence[Domain]) -> Narrowed:
    hulls = core([_hull(d) for d in domains])
    if hulls is None:
        return None
    result: list[Domain] = []
    for domain, hull in zip(domains, hulls, strict=True):
        kept = hull if isinstance(domain, Interval) else domain if domain.is_open else clip(domain, *bounds(hull))
        if kept is None:
            return None
        result.append(kept)
    places = [i for i, d in enumerate(result) if isinstance(d, Values) and not d.is_open]
    return _enumerate(core, result, places) if places else result


def _enumerate(core: IntervalNarrowing, domains: list[Domain], places: list[int]) -> Narrowed:
    """Every combination of the enumerated values by itself; the widest domain joins as its hull when there are many."""
    places = sorted(places, key=lambda i: domains[i].size)
    count = math.prod(domains[i].size for i in places)
    if count > ENUMERATION_LIMIT:
        count //= domains[places.pop()].size
    if count > ENUMERATION_LIMIT:
        return domains
    trial = [_hull(d) for d in domains]
    lows: list[Number] = [INF] * len(domains)
    highs: list[Number] = [-INF] * len(domains)
    supported: list[set[Any]] = [set() for _ in domains]
    choices = [[(v, Interval(v, v, isinstance(v, int))) for v in domains[i].values()] for i in places]
    for combination in itertools.product(*choices):
        for place, (_, point) in zip(places, combination, strict=True):
            trial[place] = point
        found = core(trial)
        if found is None or not _fits(domains, found):
            continue
        for place, (value, _) in zip(places, combination, strict=True):
            supported[place].add(value)
        for i, hull in enumerate(found):
            lows[i], highs[i] = min(lows[i], hull.lower), max(highs[i], hull.upper)
    result: list[Domain] = []
    for i, domain in enumerate(domains):
        kept: Domain | None = domain
        if i in places:
            kept = domain.keep(supported[i]) if isinstance(domain, Values) else domain
        elif not domain.is_open:
            kept = clip(domain, lows[i], highs[i])
        if kept is None or kept.is_empty:
            return None
        result.append(kept)
    return result


def _fits(domains: Sequence[Domain], found: Intervals) -> bool:
    """Whether each enumerated domain has a value within the bounds found for it."""
    return all(
        isinstance(d, Interval) or d.is_open or clip(d, hull.lower, hull.upper) is not None
        for d, hull in zip(domains, found, strict=True)
    )
