"""What `survey.nddl` knows of the way: a constraint procedure, found by its name.

A procedure narrows the domains of its arguments: it gives them back without the values that no solution has, and
None where there is none.
"""

from __future__ import annotations

from collections.abc import Sequence

from planner.domains import Domain, Interval, Values

_WAYS = {("Home", "Near"): (12, 18), ("Near", "Far"): (20, 31), ("Home", "Far"): (30, 47)}
_BOUNDS = _WAYS | {(b, a): bounds for (a, b), bounds in _WAYS.items()}


def travelTime(origin: Values, target: Values, duration: Interval) -> Sequence[Domain] | None:
    """Duration is within what the way from origin to target takes."""
    ways = [
        (a, b)
        for a, b in _BOUNDS
        if a in origin and b in target and _BOUNDS[a, b][0] <= duration.upper and duration.lower <= _BOUNDS[a, b][1]
    ]
    if not ways:
        return None
    shortest, longest = min(_BOUNDS[way][0] for way in ways), max(_BOUNDS[way][1] for way in ways)
    return origin.keep(a for a, _ in ways), target.keep(b for _, b in ways), duration.bounded(shortest, longest)
