"""Members of resources as functions of time that change in steps, as the checker reads them."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from planner.errors import ModelError
from planner.model.classes import ModelObject
from planner.model.manager import ModelManager


@dataclass(frozen=True, slots=True)
class Steps:
    """`values[k]` from tick `starts[k]` on; the first start is minus infinity."""

    starts: tuple[float, ...]
    values: tuple[float, ...]

    def at(self, tick: float) -> float:
        """The value at a tick."""
        return self.values[bisect_right(self.starts, tick) - 1]

    def minus(self, other: Steps) -> Steps:
        """The difference of two functions, where only the other may be without bound."""
        starts = tuple(sorted({*self.starts, *other.starts}))
        return Steps(starts, tuple(self.at(tick) - other.at(tick) for tick in starts))

    def stretches(self) -> Iterator[tuple[float, float, float]]:
        """The first and the last tick of each constant stretch, and its value."""
        ends = [start - 1 for start in self.starts[1:]] + [math.inf]
        yield from zip(self.starts, ends, self.values, strict=True)


def constant(value: float) -> Steps:
    """The same value at all times."""
    return Steps((-math.inf,), (value,))


def steps_of(model: ModelManager, thing: ModelObject, name: str, default: float | None = None) -> Steps:
    """A member of an object: a number, or (tick, value) pairs whose first value holds before its tick too.

    ModelError when it has no value and there is no default, or when it is of no such form.
    """
    value = thing.members.get(name)
    if value is None and name in (types := model.members_of(thing.cls)):
        declared = model.domain_of(types[name])
        value = declared.value if declared.is_singleton else None
    if value is None:
        if default is None:
            raise ModelError(f"object {thing}: a resource needs a value for its member {name!r}")
        return constant(default)
    if isinstance(value, int | float) and not isinstance(value, bool):
        return constant(float(value))
    try:
        pairs = [(float(tick), float(level)) for tick, level in value]
    except (TypeError, ValueError):
        pairs = []
    if not pairs or any(a[0] >= b[0] for a, b in pairwise(pairs)):
        expected = "expected a number, or (tick, value) pairs in increasing order of ticks"
        raise ModelError(f"object {thing}, member {name!r}: {expected}, found {value!r}")
    return Steps((-math.inf, *(tick for tick, _ in pairs[1:])), tuple(level for _, level in pairs))
