"""What the experts of the Deep Space 1 model know: the constraint procedures that `domain.nddl` names."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from planner.constraints.procedure import ConstraintProcedure
from planner.domains import Domain, Interval, Values


def turn_duration(turns: Mapping[tuple[str, str], tuple[int, int]]) -> ConstraintProcedure:
    """The attitude expert: how long a turn takes from one target to another."""

    def narrow(domains: Sequence[Domain]) -> Sequence[Domain] | None:
        """Duration is within the bounds of the turn from origin to target."""
        origin, target, duration = domains
        assert isinstance(origin, Values)
        assert isinstance(target, Values)
        left = [
            (a, b)
            for a in origin.values()
            for b in target.values()
            if (a, b) in turns and turns[a, b][0] <= duration.upper and turns[a, b][1] >= duration.lower
        ]
        if not left:
            return None
        lower, upper = min(turns[p][0] for p in left), max(turns[p][1] for p in left)
        return origin.keep(a for a, _ in left), target.keep(b for _, b in left), duration.bounded(lower, upper)

    return ConstraintProcedure("turnDuration", narrow, 3, 3)


def throttle_power(throttle: Mapping[int, float]) -> ConstraintProcedure:
    """The engine expert: how much power a throttle level draws."""

    def narrow(domains: Sequence[Domain]) -> Sequence[Domain] | None:
        """Power is what the level draws."""
        level, power = domains
        assert isinstance(level, Values)
        left = [v for v in level.values() if throttle.get(v, math.nan) in power]
        if not left:
            return None
        drawn = [throttle[v] for v in left]
        return level.keep(left), power.intersect(Interval(min(drawn), max(drawn), integer=False))

    return ConstraintProcedure("throttlePower", narrow, 2, 2)


def missing_power(planned: float, spare: float) -> ConstraintProcedure:
    """The power expert: what is missing when the arrays give less than `planned`, at most all there is to spare."""

    def narrow(domains: Sequence[Domain]) -> Sequence[Domain] | None:
        """Power is what was planned for less what is given. All in watts."""
        given, power = domains
        least, most = (min(max(planned - watts, 0.0), spare) for watts in (given.upper, given.lower))
        return given, power.intersect(Interval(least, most, integer=False))

    return ConstraintProcedure("missingPower", narrow, 2, 2)
