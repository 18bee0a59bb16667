"""What one run of a campaign has of its own: a seed, faults, hardware that differs within its tolerances.

Everything is drawn from (campaign seed, run number) alone, so that a run can be flown again by itself, in any order, on
any machine.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.random import Generator, default_rng

from scenarios.config import FaultSection, Scenario
from scenarios.faults import own_faults
from sim import FAULTS
from sim.faults import random_faults

Faults = Literal["scenario", "all", "random", "none"]
NO_FAULT = "none"
FAULT_WINDOW = (0.05, 0.9)
"""Where in the horizon a fault begins, as shares of it."""
LASTING_SHARE = 0.7
"""Of the faults of `all`, those that stay; the others end by themselves."""
SPELL_S = (60, 3600)
"""How long those last that end by themselves."""
CHARGE = (0.75, 1.0)
NOISE = (0.5, 2.0)
"""Of the attitude sensors, times what the scenario says."""
_NOISY = ("gyro_angle_walk_rad_rs", "gyro_rate_noise_rad_s", "sun_sensor_noise_rad")


@dataclass(frozen=True, slots=True)
class Variation:
    """Run `number` of a campaign. `seed`: of the spacecraft, its durations among them. `spacecraft`: overrides."""

    number: int
    seed: int
    faults: tuple[FaultSection, ...]
    spacecraft: dict[str, Any]

    @property
    def label(self) -> str:
        """The names of its faults, by which runs are grouped."""
        return "+".join(sorted({fault.name for fault in self.faults})) or NO_FAULT


def variation(scenario: Scenario, campaign_seed: int, faults: Faults, number: int) -> Variation:
    """Run `number`: `all` takes each fault in turn, and none after the last; `random` draws one a run on average."""
    seed = int(np.random.SeedSequence([campaign_seed, number]).generate_state(1)[0])
    rng = default_rng([campaign_seed, number, 1])
    return Variation(number, seed, _faults(scenario, faults, number, seed, rng), _spacecraft(scenario, rng))


def varied(scenario: Scenario, own: Variation) -> Scenario:
    """The scenario as this run has it."""
    return scenario.model_copy(update={"spacecraft": {**scenario.spacecraft, **own.spacecraft}})


def _faults(scenario: Scenario, faults: Faults, number: int, seed: int, rng: Generator) -> tuple[FaultSection, ...]:
    if faults == "scenario":
        return own_faults(scenario, seed)
    if faults == "random":
        rate = 86_400.0 / scenario.horizon / len(FAULTS)
        drawn = random_faults(rng, dict.fromkeys(FAULTS, rate), scenario.horizon)
        return tuple(FaultSection(name=name, at=int(at)) for name, at in drawn)
    names = (*FAULTS, NO_FAULT)
    name = names[number % len(names)]
    if faults == "none" or name == NO_FAULT:
        return ()
    at = int(scenario.horizon * rng.uniform(*FAULT_WINDOW))
    lasts = rng.random() < LASTING_SHARE
    return (FaultSection(name=name, at=at, until=None if lasts else at + int(rng.integers(*SPELL_S))),)


def _spacecraft(scenario: Scenario, rng: Generator) -> dict[str, Any]:
    """Initial charge and wheel speeds, and the noise of the attitude sensors."""
    hardware = scenario.spacecraft_config()
    noise = float(rng.uniform(*NOISE))
    overrides: dict[str, Any] = {name: getattr(hardware, name) * noise for name in _NOISY}
    overrides["tracker_noise_rad"] = [noise * value for value in hardware.tracker_noise_rad]
    overrides["battery_initial_soc"] = float(rng.uniform(*CHARGE))
    overrides["wheel_initial_speed_rad_s"] = hardware.wheel_initial_speed_rad_s * float(rng.uniform(0.0, 2.0))
    return overrides
