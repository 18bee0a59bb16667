"""Functions of time that change in steps."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from planner.errors import ModelError


@dataclass(frozen=True, slots=True)
class Steps:
    """A piecewise constant function: `values[k]` from tick `starts[k]` on, and `values[0]` before `starts[0]` too."""

    starts: tuple[float, ...]
    values: tuple[float, ...]

    @staticmethod
    def constant(value: float) -> Steps:
        """The same value at all times."""
        return Steps((-math.inf,), (value,))

    @staticmethod
    def parse(value: Any, where: str) -> Steps:
        """A number, or a sequence of (tick, value) pairs in increasing order of ticks; ModelError for anything else."""
        if _is_number(value):
            return Steps.constant(float(value))
        expected = f"{where}: expected a number, or (tick, value) pairs in increasing order of ticks, found {value!r}"
        if isinstance(value, str) or not isinstance(value, Sequence) or not value:
            raise ModelError(expected)
        for pair in value:
            if (
                isinstance(pair, str)
                or not isinstance(pair, Sequence)
                or len(pair) != 2
                or not all(map(_is_number, pair))
            ):
                raise ModelError(expected)
        starts = tuple(float(tick) for tick, _ in value)
        if any(a >= b for a, b in pairwise(starts)) or not all(t.is_integer() for t in starts):
            raise ModelError(expected)
        return Steps((-math.inf, *starts[1:]), tuple(float(v) for _, v in value))

    def at(self, tick: float) -> float:
        """The value at a tick."""
        return self.values[max(bisect_right(self.starts, tick) - 1, 0)]

    def minus(self, other: Steps) -> Steps:
        """The difference of two functions."""
        starts = tuple(sorted({*self.starts, *other.starts}))
        return Steps(starts, tuple(self.at(t) - other.at(t) for t in starts))

    def negated(self) -> Steps:
        """The function with the other sign."""
        return Steps(self.starts, tuple(-v for v in self.values))

    def stretch(self, tick: float, holds: Callable[[float], bool]) -> tuple[float, float]:
        """The longest stretch [from, to) of time around a tick on which a test of the value holds; it does there."""
        first = last = max(bisect_right(self.starts, tick) - 1, 0)
        while first > 0 and holds(self.values[first - 1]):
            first -= 1
        while last + 1 < len(self.starts) and holds(self.values[last + 1]):
            last += 1
        return self.starts[first], self.starts[last + 1] if last + 1 < len(self.starts) else math.inf


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and not math.isnan(value)
