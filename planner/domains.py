"""Immutable variable domains: numeric intervals, and finite sets of values over a universe.

A domain never changes; narrowing gives a new one, or the same object when nothing was removed, so `is` tells whether
anything happened. Unbounded ends are `math.inf`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

Number = int | float

# Two reals this close (relative) are one value: rounding of a few operations stays well below it.
REAL_RESOLUTION = 1e-9


class Interval:
    """All numbers from `lower` to `upper`, whole ones only when `integer`. Empty when `lower > upper`."""

    __slots__ = ("integer", "lower", "upper")

    def __init__(self, lower: Number, upper: Number, integer: bool = True) -> None:
        if integer:
            lower = lower if lower in (-math.inf, math.inf) else math.ceil(lower)
            upper = upper if upper in (-math.inf, math.inf) else math.floor(upper)
        self.lower = lower
        self.upper = upper
        self.integer = integer

    is_numeric = True
    is_open = False

    @property
    def is_empty(self) -> bool:
        """No value is left."""
        return self.lower > self.upper

    @property
    def is_singleton(self) -> bool:
        """One value is left (for reals: to within REAL_RESOLUTION)."""
        if self.integer:
            return self.lower == self.upper
        width = self.upper - self.lower
        return width == 0 or (0 < width < math.inf and width <= REAL_RESOLUTION * max(1.0, abs(self.lower)))

    @property
    def value(self) -> Number:
        """The value of a singleton."""
        return self.lower if self.lower == self.upper else (self.lower + self.upper) / 2

    @property
    def size(self) -> Number:
        """How many values there are; infinite for reals that are not decided."""
        if self.lower > self.upper:
            return 0
        if self.integer:
            return self.upper - self.lower + 1
        return 1 if self.is_singleton else math.inf

    def __contains__(self, value: object) -> bool:
        if not isinstance(value, int | float):
            return False
        if self.integer:
            return self.lower <= value <= self.upper and (math.isinf(value) or value == int(value))
        slack = REAL_RESOLUTION * max(1.0, abs(value))
        return self.lower - slack <= value <= self.upper + slack

    def values(self) -> Iterator[Number]:
        """The values in increasing order; ValueError unless there are finitely many."""
        if not self.integer and not self.is_singleton:
            raise ValueError(f"{self!r} cannot be enumerated")
        if self.is_singleton:
            return iter((self.value,))
        if math.isinf(self.lower) or math.isinf(self.upper):
            raise ValueError(f"{self!r} cannot be enumerated")
        return iter(range(int(self.lower), int(self.upper) + 1))

    def bounded(self, lower: Number, upper: Number) -> Interval:
        """The values within [lower, upper]."""
        if lower <= self.lower and upper >= self.upper:
            return self
        return Interval(max(lower, self.lower), min(upper, self.upper), self.integer)

    def without(self, value: Any) -> Interval:
        """All values but one; only an end can leave an interval."""
        if self.lower == self.upper == value:
            return Interval(1, 0, self.integer)
        if not self.integer:
            return self
        if value == self.lower and value != -math.inf:
            return Interval(self.lower + 1, self.upper)
        if value == self.upper and value != math.inf:
            return Interval(self.lower, self.upper - 1)
        return self

    def intersect(self, other: Domain) -> Interval:
        """The values that both have, as far as an interval can say."""
        if isinstance(other, Interval):
            if other.integer and not self.integer:
                return Interval(max(self.lower, other.lower), min(self.upper, other.upper), True)
            return self.bounded(other.lower, other.upper)
        inside = [v for v in other.values() if v in self]
        if not inside:
            return Interval(1, 0, self.integer)
        return self.bounded(min(inside), max(inside))

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Interval)
            and (self.lower, self.upper, self.integer) == (other.lower, other.upper, other.integer)
        ) or (isinstance(other, Interval) and self.is_empty and other.is_empty)

    def __hash__(self) -> int:
        return hash((self.lower, self.upper)) if self.lower <= self.upper else 0

    def __repr__(self) -> str:
        return f"[{self.lower} {self.upper}]"


class Universe:
    """The values that a finite domain draws from, in a fixed order; new ones may be added until it is closed."""

    __slots__ = ("index", "is_numeric", "is_open", "name", "values")

    def __init__(self, name: str, values: Iterable[Any], is_open: bool = False) -> None:
        self.name = name
        self.values: list[Any] = []
        self.index: dict[Any, int] = {}
        self.is_open = is_open
        self.is_numeric = False
        for value in values:
            self.add(value)

    def add(self, value: Any) -> int:
        """Add a value (nothing happens when it is there); returns its position."""
        if value not in self.index:
            number = isinstance(value, int | float) and not isinstance(value, bool)
            self.is_numeric = number and (self.is_numeric or not self.values)
            self.index[value] = len(self.values)
            self.values.append(value)
        return self.index[value]

    def domain(self, values: Iterable[Any] | None = None) -> Values:
        """The domain of those values (all of them when None); KeyError for a stranger."""
        if values is None:
            return Values(self, (1 << len(self.values)) - 1)
        bits = 0
        for value in values:
            bits |= 1 << self.index[value]
        return Values(self, bits)

    def __repr__(self) -> str:
        return f"Universe({self.name}, {len(self.values)} values)"


class Values:
    """A set of values of a universe, as a bit set. `is_open`: the universe may still grow, so nothing is decided."""

    __slots__ = ("bits", "universe")

    def __init__(self, universe: Universe, bits: int) -> None:
        self.universe = universe
        self.bits = bits

    @property
    def is_numeric(self) -> bool:
        """All values are numbers."""
        return self.universe.is_numeric

    @property
    def is_open(self) -> bool:
        """Values may still be added to the universe."""
        return self.universe.is_open

    @property
    def is_empty(self) -> bool:
        """No value is left."""
        return not self.bits

    @property
    def is_singleton(self) -> bool:
        """One value is left."""
        bits = self.bits
        return bits != 0 and bits & (bits - 1) == 0

    @property
    def value(self) -> Any:
        """The value of a singleton."""
        return self.universe.values[self.bits.bit_length() - 1]

    @property
    def size(self) -> int:
        """How many values there are."""
        return self.bits.bit_count()

    @property
    def lower(self) -> Number:
        """The smallest value of a numeric domain."""
        return min(self.values(), default=math.inf)

    @property
    def upper(self) -> Number:
        """The largest value of a numeric domain."""
        return max(self.values(), default=-math.inf)

    def __contains__(self, value: object) -> bool:
        position = self.universe.index.get(value)
        return position is not None and bool(self.bits >> position & 1)

    def values(self) -> Iterator[Any]:
        """The values in the universe's order."""
        bits, values = self.bits, self.universe.values
        while bits:
            low = bits & -bits
            yield values[low.bit_length() - 1]
            bits ^= low

    def bounded(self, lower: Number, upper: Number) -> Values:
        """The values within [lower, upper] of a numeric domain."""
        return self.keep(v for v in self.values() if lower <= v <= upper)

    def without(self, value: Any) -> Values:
        """All values but one."""
        position = self.universe.index.get(value)
        if position is None or not self.bits >> position & 1:
            return self
        return Values(self.universe, self.bits & ~(1 << position))

    def keep(self, values: Iterable[Any]) -> Values:
        """Only those values; this very object when all stay."""
        bits, index = 0, self.universe.index
        for value in values:
            position = index.get(value)
            if position is not None:
                bits |= 1 << position
        bits &= self.bits
        return self if bits == self.bits else Values(self.universe, bits)

    def intersect(self, other: Domain) -> Values:
        """The values that both have."""
        if isinstance(other, Values) and other.universe is self.universe:
            bits = self.bits & other.bits
            return self if bits == self.bits else Values(self.universe, bits)
        return self.keep(v for v in self.values() if v in other)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Values) and (
            (self.universe is other.universe and self.bits == other.bits)
            or (self.universe is not other.universe and set(self.values()) == set(other.values()))
        )

    def __hash__(self) -> int:
        return hash(frozenset(self.values()))  # equal sets of two universes hash alike

    def __repr__(self) -> str:
        return "{" + ", ".join(str(v) for v in self.values()) + "}"


Domain = Interval | Values

BOOLEAN = Universe("bool", (False, True))
TRUE = BOOLEAN.domain((True,))
FALSE = BOOLEAN.domain((False,))


def singleton(value: Any) -> Domain:
    """The domain of that one value, over a universe of its own unless it is a number or a boolean."""
    if isinstance(value, bool):
        return TRUE if value else FALSE
    if isinstance(value, int | float):
        return Interval(value, value, isinstance(value, int))
    return Universe(str(value), (value,)).domain()
