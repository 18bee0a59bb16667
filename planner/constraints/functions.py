"""Functions of expressions, result first: eqMaximum, eqMinimum, sqrt, pow, mod, floor, ceil, sin, rand.

Extrema, roots and roundings are narrowed both ways to the hull of each projection; pow, mod and sin as their docstrings
say. All of them decide assigned arguments; where a function is undefined (sqrt of a negative number) there is no
solution.
"""

from __future__ import annotations

import math

from planner.constraints.arithmetic import root, square, unsigned
from planner.constraints.numeric import (
    EVERYTHING,
    INF,
    Bounds,
    Intervals,
    add,
    bounds,
    ceil_whole,
    floor_whole,
    less,
    lowered,
    meet,
    multiply,
    negate,
    numeric,
    raised,
    same,
)
from planner.domains import REAL_RESOLUTION, Interval, Number

# Whole powers are computed exactly up to this many bits, in floating point beyond.
EXACT_POWER_BITS = 4096
RANDOM_LIMIT = 32767


@numeric
def eq_maximum(domains: Intervals) -> Intervals | None:
    """r = max(x1, ..., xn), arguments (r, x1, ..., xn)."""
    terms = domains[1:]
    result = meet(domains[0], max(t.lower for t in terms), max(t.upper for t in terms))
    if result is None:
        return None
    candidates = [i for i, t in enumerate(terms) if not less(t.upper, result.lower)]
    if not candidates:
        return None
    narrowed = [result]
    for i, term in enumerate(terms):
        # The only one that can reach the result has to.
        kept = meet(term, result.lower if candidates == [i] else -INF, result.upper)
        if kept is None:
            return None
        narrowed.append(kept)
    return narrowed


@numeric
def eq_minimum(domains: Intervals) -> Intervals | None:
    """r = min(x1, ..., xn), arguments (r, x1, ..., xn)."""
    terms = domains[1:]
    result = meet(domains[0], min(t.lower for t in terms), min(t.upper for t in terms))
    if result is None:
        return None
    candidates = [i for i, t in enumerate(terms) if not less(result.upper, t.lower)]
    if not candidates:
        return None
    narrowed = [result]
    for i, term in enumerate(terms):
        kept = meet(term, result.lower, result.upper if candidates == [i] else INF)
        if kept is None:
            return None
        narrowed.append(kept)
    return narrowed


@numeric
def sqrt(domains: Intervals) -> Intervals | None:
    """r = sqrt(x), the root that is not negative, arguments (r, x)."""
    r, x = domains
    source = meet(x, 0, INF)
    result = None if source is None else meet(r, *root(bounds(source)))
    if source is None or result is None:
        return None
    source = meet(source, *square((max(0, result.lower), result.upper)))
    return None if source is None else (result, source)


def _power(base: Number, exponent: Number) -> Number | None:
    """The real power; None where there is none, infinity where it is too large for a float."""
    if isinstance(base, int) and isinstance(exponent, int) and exponent >= 0:
        if base.bit_length() * exponent <= EXACT_POWER_BITS:
            return int(base**exponent)
    elif base == 0 and exponent < 0:
        return None
    try:
        return math.pow(base, exponent)
    except OverflowError:
        return -INF if base < 0 and exponent % 2 == 1 else INF
    except ValueError:
        return None


@numeric
def power(domains: Intervals) -> Intervals | None:
    """r = b ^ e, arguments (r, b, e); 0 ^ 0 = 1.

    Narrowed forward for positive bases and for a fixed whole exponent, backward (to b) for a fixed positive whole
    exponent; decided once b and e are assigned.
    """
    r, b, e = domains
    exponent = _whole(e)
    if b.lower == b.upper and e.lower == e.upper:
        # A power of a negative number needs a whole exponent: one that is whole to the resolution counts.
        near = round(e.value) if b.value < 0 and math.isfinite(e.value) else e.value
        value = _power(b.value, near if same(near, e.value) else e.value)
        result = None if value is None else meet(r, lowered(value, abs(value)), raised(value, abs(value)))
        return None if result is None else (result, b, e)
    if exponent is not None and exponent > 0:
        return _fixed_power(r, b, e, exponent)
    if b.lower > 0:
        corners = [_limit_power(p, q) for p in bounds(b) for q in bounds(e)]
        result = meet(r, lowered(min(corners), abs(min(corners))), raised(max(corners), abs(max(corners))))
        return None if result is None else (result, b, e)
    return domains


def _whole(e: Interval) -> int | None:
    """The exponent when it is one whole number."""
    if e.lower != e.upper or math.isinf(e.lower):
        return None
    near = round(e.lower)
    return near if near == e.lower else None


def _limit_power(base: Number, exponent: Number) -> Number:
    """base ^ exponent for base > 0 at the corner of a box, infinite ends by their limit; 1 where there is none."""
    value = _power(base, exponent)
    return 1 if value is None or math.isnan(value) else value


def _fixed_power(r: Interval, b: Interval, e: Interval, exponent: int) -> Intervals | None:
    even = exponent % 2 == 0
    ends = [_power(p, exponent) if math.isfinite(p) else p ** (2 if even else 1) for p in bounds(b)]
    low, high = min(_given(ends)), max(_given(ends))
    if even and b.lower <= 0 <= b.upper:
        low = 0
    result = meet(r, lowered(low, abs(low)), raised(high, abs(high)))
    if result is None:
        return None
    if even:
        if result.upper < 0:
            return None if not same(result.upper, 0) else (result, b, e)
        base = unsigned(b, _root_of(max(0, result.lower), exponent)[0], _root_of(result.upper, exponent)[1])
    else:
        base = meet(b, _root_of(result.lower, exponent)[0], _root_of(result.upper, exponent)[1])
    return None if base is None else (result, base, e)


def _given(values: list[Number | None]) -> list[Number]:
    return [v for v in values if v is not None]


def _root_of(value: Number, degree: int) -> Bounds:
    """Bounds on the root of that degree, odd for negative values; wide by the resolution around the computed one."""
    if math.isinf(value):
        return value, value
    try:
        near = math.copysign(math.pow(abs(value), 1 / degree), value)
    except OverflowError:
        return EVERYTHING
    # Near zero the root magnifies what is one value in the power, hence the root of the resolution.
    slack = REAL_RESOLUTION * abs(near) if abs(value) > 1 else REAL_RESOLUTION ** (1 / degree)
    return near - slack, near + slack


@numeric
def mod(domains: Intervals) -> Intervals | None:
    """r = x - y * trunc(x / y) and y != 0: the remainder with the sign of x, arguments (r, x, y).

    Narrowed by sign and size; both ways while the quotient is one number.
    """
    r, x, y = domains
    if y.is_singleton and same(y.value, 0):
        return None
    size = max(-y.lower, y.upper)
    limit = size - 1 if x.integer and y.integer else size
    low = 0 if x.lower >= 0 else -min(limit, -x.lower)
    high = 0 if x.upper <= 0 else min(limit, x.upper)
    result = meet(r, low, high)
    if result is None:
        return None
    source = x
    if less(0, result.lower) or less(result.upper, 0):
        # A remainder of one sign comes from a number of that sign, at least as large.
        kept = meet(x, result.lower, INF) if result.lower > 0 else meet(x, -INF, result.upper)
        if kept is None:
            return None
        source = kept
    if not y.is_singleton or math.isinf(source.lower) or math.isinf(source.upper):
        return result, source, y
    return _mod_fixed(result, source, y)


def _mod_fixed(r: Interval, x: Interval, y: Interval) -> Intervals | None:
    """The remainder by a known divisor: exact while every x has the same quotient."""
    divisor = abs(y.value)
    first, last = _quotient(x.lower, divisor), _quotient(x.upper, divisor)
    if first != last:
        return r, x, y
    offset = multiply((first, first), (divisor, divisor))
    result = meet(r, *add(bounds(x), negate(offset)))
    if result is None:
        return None
    source = meet(x, *add(bounds(result), offset))
    return None if source is None else (result, source, y)


def _quotient(x: Number, divisor: Number) -> int:
    """trunc(x / divisor); a quotient that is whole to the resolution is that number."""
    if isinstance(x, int) and isinstance(divisor, int):
        return x // divisor if x >= 0 else -(-x // divisor)
    quotient = x / divisor
    near = round(quotient)
    return near if same(float(quotient), near) else math.trunc(quotient)


@numeric
def floor(domains: Intervals) -> Intervals | None:
    """r = the largest whole number <= x, arguments (r, x); x within the resolution of a whole number counts as it."""
    r, x = domains
    result = meet(r, max(floor_whole(x.lower), ceil_whole(r.lower)), min(floor_whole(x.upper), floor_whole(r.upper)))
    if result is None:
        return None
    source = meet(x, result.lower, result.upper if x.integer else result.upper + 1)
    if source is None or not less(source.lower, result.upper + 1):
        return None
    return result, source


@numeric
def ceil(domains: Intervals) -> Intervals | None:
    """r = the smallest whole number >= x, arguments (r, x); x within the resolution of a whole number counts as it."""
    r, x = domains
    result = meet(r, max(ceil_whole(x.lower), ceil_whole(r.lower)), min(ceil_whole(x.upper), floor_whole(r.upper)))
    if result is None:
        return None
    source = meet(x, result.lower if x.integer else result.lower - 1, result.upper)
    if source is None or not less(result.lower - 1, source.upper):
        return None
    return result, source


@numeric
def sin(domains: Intervals) -> Intervals | None:
    """r = sin(x), x in degrees and within [-90, 90], arguments (r, x)."""
    r, x = domains
    source = meet(x, -90, 90)
    if source is None:
        return None
    low, high = (math.sin(math.radians(v)) for v in bounds(source))
    result = meet(r, lowered(low, 1), raised(high, 1))
    if result is None:
        return None
    source = meet(source, _angle(result.lower)[0], _angle(result.upper)[1])
    return None if source is None else (result, source)


def _angle(value: Number) -> Bounds:
    """Bounds in degrees on the angles whose sine is that value to the resolution; the sine is flat at +-90."""
    low, high = (math.degrees(math.asin(max(-1.0, min(1.0, value + s)))) for s in (-REAL_RESOLUTION, REAL_RESOLUTION))
    return lowered(low, 90), raised(high, 90)


@numeric
def rand(domains: Intervals) -> Intervals | None:
    """x is a whole number in [0, 32767].

    Which one is no matter of the constraint, so that plans are reproducible: whoever assigns x draws it.
    """
    (x,) = domains
    kept = meet(x, max(0, ceil_whole(x.lower)), min(RANDOM_LIMIT, floor_whole(x.upper)))
    return None if kept is None else (kept,)
