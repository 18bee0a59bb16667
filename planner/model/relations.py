"""The temporal relations as one table.

`o` is the token that a configuration constraint belongs to, `t` the target. A relation is one or two distances, each
read as `minimum <= t_to - t_from <= maximum`. The paper's twelve relations (section 2) carry quantitative bounds on
every distance they constrain, [0, inf] when not written, in the order of this table; the further ones are NDDL's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from planner.errors import ModelError, nearest

OS, OE, TS, TE = "o.start", "o.end", "t.start", "t.end"
UNBOUNDED = (0.0, math.inf)


@dataclass(frozen=True, slots=True)
class Distance:
    """`minimum <= to - from_ <= maximum` between a timepoint of the token and one of the target."""

    from_: str
    to: str
    minimum: float = 0
    maximum: float = math.inf


def _strictly(from_: str, to: str) -> Distance:
    return Distance(from_, to, 1)


def _same(a: str, b: str) -> Distance:
    return Distance(a, b, 0, 0)


# name: (distances, may quantitative bounds be written)
RELATIONS: dict[str, tuple[tuple[Distance, ...], bool]] = {
    # The paper's twelve, in pairs of inverses.
    "before": ((Distance(OE, TS),), True),
    "after": ((Distance(TE, OS),), True),
    "startsBefore": ((Distance(OS, TS),), True),
    "startsAfter": ((Distance(TS, OS),), True),
    "endsBefore": ((Distance(OE, TE),), True),
    "endsAfter": ((Distance(TE, OE),), True),
    "startsBeforeEnd": ((Distance(OS, TE),), True),
    "endsAfterStart": ((Distance(TS, OE),), True),
    "contains": ((Distance(OS, TS), Distance(TE, OE)), True),
    "containedBy": ((Distance(TS, OS), Distance(OE, TE)), True),
    "parallels": ((Distance(OS, TS), Distance(OE, TE)), True),
    "paralleledBy": ((Distance(TS, OS), Distance(TE, OE)), True),
    # NDDL's names.
    "any": ((), False),
    "meets": ((_same(OE, TS),), False),
    "met_by": ((_same(TE, OS),), False),
    "equals": ((_same(OS, TS), _same(OE, TE)), False),
    "equal": ((_same(OS, TS), _same(OE, TE)), False),
    "starts": ((_same(OS, TS),), False),
    "ends": ((_same(OE, TE),), False),
    "contained_by": ((Distance(TS, OS), Distance(OE, TE)), True),
    "paralleled_by": ((Distance(TS, OS), Distance(TE, OE)), True),
    "starts_before": ((_strictly(OS, TS),), False),
    "starts_after": ((_strictly(TS, OS),), False),
    "ends_before": ((_strictly(OE, TE),), False),
    "ends_after": ((_strictly(TE, OE),), False),
    "ends_after_start": ((_strictly(TS, OE),), False),
    "starts_before_end": ((_strictly(OS, TE),), False),
    "starts_during": ((Distance(TS, OS), _strictly(OS, TE)), False),
    "ends_during": ((_strictly(TS, OE), Distance(OE, TE)), False),
    "contains_start": ((Distance(OS, TS), _strictly(TS, OE)), False),
    "contains_end": ((_strictly(OS, TE), Distance(TE, OE)), False),
}


def distances(relation: str, bounds: Sequence[tuple[float, float]] = ()) -> tuple[Distance, ...]:
    """The distances of a relation under written bounds; ModelError for an unknown relation or bounds too many."""
    if relation not in RELATIONS:
        raise ModelError(f"there is no temporal relation named {relation!r}{nearest(relation, RELATIONS)}")
    table, quantitative = RELATIONS[relation]
    if not bounds:
        return table
    if not quantitative or len(bounds) > len(table):
        most = len(table) if quantitative else 0
        raise ModelError(f"relation {relation}: expected at most {most} bounds, found {len(bounds)}")
    for lower, upper in bounds:
        if lower > upper:
            raise ModelError(f"relation {relation}: the bounds [{lower} {upper}] are empty")
    filled = [*bounds, *[UNBOUNDED] * (len(table) - len(bounds))]
    return tuple(Distance(d.from_, d.to, lo, hi) for d, (lo, hi) in zip(table, filled, strict=True))
