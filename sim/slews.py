"""How long turns between targets take over a span of time, for whoever plans them."""

from __future__ import annotations

import math
from itertools import pairwise

from sim.config import SpacecraftConfig
from sim.control import SlewBounds, slew_bounds
from sim.environment import Environment

SAMPLE_S = 21_600.0
"""The sky moves by a degree a day: every six hours is often enough, and what it moves in between is added."""


def slew_bounds_between(
    sky: Environment, config: SpacecraftConfig, here: str, there: str, start_s: float, end_s: float
) -> SlewBounds:
    """Bounds (s) of a healthy turn from pointing at one target to settled on another, begun between the two times."""
    count = max(1, math.ceil((end_s - start_s) / SAMPLE_S))
    times = [start_s + k * (end_s - start_s) / count for k in range(count + 1)]
    angles = [sky.slew_angle(here, there, time_s) for time_s in times]
    moved_rad = max(abs(after - before) for before, after in pairwise(angles))
    return SlewBounds(
        slew_bounds(max(0.0, min(angles) - moved_rad), config).lower_s,
        slew_bounds(min(math.pi, max(angles) + moved_rad), config).upper_s,
    )
