"""How long turns between targets take over a span of time, for whoever plans them."""

from __future__ import annotations

import math
from itertools import pairwise

from sim.cones import Cones, legs_rad
from sim.config import SpacecraftConfig
from sim.control import SlewBounds, profile_duration_s, slew_bounds
from sim.environment import Environment

SAMPLE_S = 21_600.0
"""The sky moves by a degree a day: every six hours is often enough, and what it moves in between is added."""
_CORNER_S = 20.0
"""What the stop between the two rotations of a way round a cone may add."""


def slew_bounds_between(
    sky: Environment, config: SpacecraftConfig, here: str, there: str, start_s: float, end_s: float
) -> SlewBounds:
    """Bounds (s) of a healthy turn from pointing at one target to settled on another, begun between the two times.

    Turns go round the cones as the control makes them go; one that it would refuse counts as the straight one.
    """
    count = max(1, math.ceil((end_s - start_s) / SAMPLE_S))
    times = [start_s + k * (end_s - start_s) / count for k in range(count + 1)]
    ways = [_legs_rad(sky, config, here, there, time_s) for time_s in times]
    durations = [sum(profile_duration_s(leg, config) for leg in legs) for legs in ways]
    moved_s = max(abs(after - before) for before, after in pairwise(durations))
    stops = max(len(legs) for legs in ways) - 1
    at_once = slew_bounds(0.0, config)
    lower = max(0.0, min(durations) - moved_s + _least(config))
    return SlewBounds(
        math.floor(config.settle_hold_s + lower),
        math.ceil(at_once.upper_s + max(durations) + moved_s + stops * _CORNER_S),
    )


def _least(config: SpacecraftConfig) -> float:
    """How much earlier than its profile a turn may end, as `slew_bounds` has it for half a turn."""
    return slew_bounds(math.pi, config).lower_s - config.settle_hold_s - profile_duration_s(math.pi, config)


def _legs_rad(sky: Environment, config: SpacecraftConfig, here: str, there: str, time_s: float) -> tuple[float, ...]:
    here_IB, goal_IB = sky.target_attitude_IB(here, time_s), sky.target_attitude_IB(there, time_s)
    way = Cones.of(config).way(here_IB, goal_IB, sky.sun_direction_I(time_s))
    return legs_rad(here_IB, way or (goal_IB,))
