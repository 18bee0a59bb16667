"""What the planner may count on, read off the hardware's configuration so that the two cannot drift apart."""

from __future__ import annotations

from math import ceil, floor

from scenarios.ds1.domain import Capability
from sim import SpacecraftConfig
from sim.components.ion_engine import THROTTLE_TABLE
from sim.environment import Environment
from sim.slews import slew_bounds_between

EXPOSURE_S = 30.0
"""Commanded exposure of a navigation image."""
OBSERVED_LATE_S = 2
"""The hardware acts on whole seconds and telemetry shows it a second later."""
CREEP_S = 120
"""With thrusters alone, one of them closed: so much longer a slew takes to its end (measured: up to 90 s).

Thrusters that are all well keep the bounds of wheels, also after wheels that were lost, and a plan made then needs no
others. Wheels lost and a valve closed are two faults: then a turn may outlast its bound, and is seen to.
"""
SAMPLE_S = 21_600
"""How often the Sun's distance is looked at over a horizon."""
POWER_RESERVE_W = 20.0
"""Kept back from what the arrays give, for pointing that is never perfect."""


def capability_of(config: SpacecraftConfig, horizon_s: int = 0, deliberation_s: int = 1) -> Capability:
    """What a spacecraft of this configuration can do at any time up to the horizon, as the sky moves around it.

    `deliberation_s`: the longest that planning the next horizon takes.
    """
    sky = Environment(config)
    late_s = OBSERVED_LATE_S + (CREEP_S if config.initial_actuators == "thrusters" else 0)
    turns = {
        (a, b): (bounds.lower_s, bounds.upper_s + late_s)
        for a in sky.targets
        for b in sky.targets
        for bounds in [slew_bounds_between(sky, config, a, b, 0.0, horizon_s)]
    }
    farthest_au = max(sky.sun_distance_au(time_s) for time_s in range(0, horizon_s + 1, SAMPLE_S))
    array_W = config.array_power_1au_W / max(farthest_au, sky.sun_distance_au(horizon_s)) ** 2
    read_out = config.camera_readout_s
    return Capability(
        targets=tuple(sky.targets),
        turns=turns,
        throttle={level: THROTTLE_TABLE[level].power_W for level in sorted(THROTTLE_TABLE, reverse=True)},
        power=array_W - config.base_load_W - POWER_RESERVE_W,
        engine_start=_observed(config.engine_start_s),
        engine_stop=_observed(config.engine_stop_s),
        engine_start_power=config.engine_starting_W,
        camera_warmup=_observed(config.camera_warmup_s),
        camera_power=max(config.camera_warming_W, config.camera_on_W),
        exposure=_observed((EXPOSURE_S + read_out[0], EXPOSURE_S + read_out[1])),
        downlink_power=config.radio_downlinking_W,
        planning=(1, deliberation_s + OBSERVED_LATE_S),
        arrays=array_W,
    )


def _observed(span: tuple[float, float]) -> tuple[int, int]:
    return floor(span[0]), ceil(span[1]) + OBSERVED_LATE_S
