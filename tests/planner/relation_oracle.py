"""The temporal relations on whole times, each written out as a formula: what the planner's table is tested against.

A relation takes (start, end) of the token and of the target, and one (minimum, maximum) for each of its distances.
"""

from __future__ import annotations

import math
from collections.abc import Callable

Bounds = tuple[float, float]
FREE: Bounds = (0, math.inf)


def _in(value: float, bounds: Bounds) -> bool:
    return bounds[0] <= value <= bounds[1]


# The paper's twelve (Jonsson et al. 2000, section 2): bounds on every distance.
QUANTITATIVE: dict[str, tuple[int, Callable[..., bool]]] = {
    "before": (1, lambda s, e, ts, te, b: _in(ts - e, b)),
    "after": (1, lambda s, e, ts, te, b: _in(s - te, b)),
    "startsBefore": (1, lambda s, e, ts, te, b: _in(ts - s, b)),
    "startsAfter": (1, lambda s, e, ts, te, b: _in(s - ts, b)),
    "endsBefore": (1, lambda s, e, ts, te, b: _in(te - e, b)),
    "endsAfter": (1, lambda s, e, ts, te, b: _in(e - te, b)),
    "startsBeforeEnd": (1, lambda s, e, ts, te, b: _in(te - s, b)),
    "endsAfterStart": (1, lambda s, e, ts, te, b: _in(e - ts, b)),
    "contains": (2, lambda s, e, ts, te, b, c: _in(ts - s, b) and _in(e - te, c)),
    "containedBy": (2, lambda s, e, ts, te, b, c: _in(s - ts, b) and _in(te - e, c)),
    "parallels": (2, lambda s, e, ts, te, b, c: _in(ts - s, b) and _in(te - e, c)),
    "paralleledBy": (2, lambda s, e, ts, te, b, c: _in(s - ts, b) and _in(e - te, c)),
    "contained_by": (2, lambda s, e, ts, te, b, c: _in(s - ts, b) and _in(te - e, c)),
    "paralleled_by": (2, lambda s, e, ts, te, b, c: _in(s - ts, b) and _in(e - te, c)),
}

# NDDL's relations as the language defines them.
QUALITATIVE: dict[str, Callable[[int, int, int, int], bool]] = {
    "any": lambda s, e, ts, te: True,
    "meets": lambda s, e, ts, te: e == ts,
    "met_by": lambda s, e, ts, te: te == s,
    "before": lambda s, e, ts, te: e <= ts,
    "after": lambda s, e, ts, te: te <= s,
    "contains": lambda s, e, ts, te: s <= ts and te <= e,
    "contained_by": lambda s, e, ts, te: ts <= s and e <= te,
    "equals": lambda s, e, ts, te: s == ts and e == te,
    "equal": lambda s, e, ts, te: s == ts and e == te,
    "starts": lambda s, e, ts, te: s == ts,
    "ends": lambda s, e, ts, te: e == te,
    "parallels": lambda s, e, ts, te: s <= ts and e <= te,
    "paralleled_by": lambda s, e, ts, te: ts <= s and te <= e,
    "starts_before": lambda s, e, ts, te: s < ts,
    "starts_after": lambda s, e, ts, te: ts < s,
    "ends_before": lambda s, e, ts, te: e < te,
    "ends_after": lambda s, e, ts, te: te < e,
    "ends_after_start": lambda s, e, ts, te: ts < e,
    "starts_before_end": lambda s, e, ts, te: s < te,
    "starts_during": lambda s, e, ts, te: ts <= s < te,
    "ends_during": lambda s, e, ts, te: ts < e <= te,
    "contains_start": lambda s, e, ts, te: s <= ts < e,
    "contains_end": lambda s, e, ts, te: s < te <= e,
}


def holds(relation: str, times: tuple[int, int, int, int], bounds: tuple[Bounds, ...] = ()) -> bool:
    """Whether the relation holds between [times[0] times[1]] and [times[2] times[3]]."""
    if bounds or relation not in QUALITATIVE:
        count, formula = QUANTITATIVE[relation]
        return formula(*times, *bounds, *[FREE] * (count - len(bounds)))
    return QUALITATIVE[relation](*times)
