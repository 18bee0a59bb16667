"""Speed of the simulator against the same physics without Python.

The flight has everything on: attitude control, sensors, filter, power, engine, camera and radio. It is flown slewing
all the time or holding one attitude, and either as an executive flies it, with one `advance` and one `telemetry` a
second, or undisturbed. The limit is MuJoCo stepping the same model from the same state in one C call a slice, at the
default step of 0.5 s throughout; the flight takes its longer quiet step where it holds. Both are timed in turns, slice
by slice, and the best of some repeats of each slice counts, so that what else the machine does stays out of the figure.
Beside it: one slew of the bare bus, flown by Basilisk too where that is installed.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import mujoco

from scenarios.benchmarks import basilisk
from sim import Spacecraft, SpacecraftConfig
from sim.assembly import load_assembly

SLICE_S = 300
SLICES = 12
REPEATS = 5
_TOUR = ("asteroid_a", "thrust_a", "asteroid_c", "earth")


@dataclass(frozen=True, slots=True)
class Flight:
    """A way of flying. `every`: seconds between calls of `advance` and `telemetry`; `slewing`: all the time."""

    name: str
    every: int
    slewing: bool


FLIGHTS = (
    Flight("slewing, telemetry at 1 Hz", 1, True),
    Flight("slewing, undisturbed", SLICE_S, True),
    Flight("holding, telemetry at 1 Hz", 1, False),
    Flight("holding, undisturbed", SLICE_S, False),
)


def busy_spacecraft(seed: int = 1) -> Spacecraft:
    """A spacecraft with engine, camera and radio on."""
    craft = Spacecraft(SpacecraftConfig(sun_distance_au=0.9), seed)
    for name, arguments in (("ips.start", {}), ("micas.power", {"on": True}), ("radio.power", {"on": True})):
        craft.send(name, arguments)
    craft.advance(1300)
    craft.send("ips.thrust", {"level": 48})
    craft.send("radio.downlink", {"on": True})
    return craft


def _fly(craft: Spacecraft, every: int) -> None:
    begin = craft.time
    for second in range(begin + every, begin + SLICE_S + 1, every):
        craft.advance(second)
        craft.telemetry()


def _timed(run: Callable[[], None]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


def fly(flight: Flight = FLIGHTS[0], *, slices: int = SLICES, repeats: int = REPEATS) -> dict[str, float]:
    """Simulated seconds a second of flight and of bare physics, and their ratio."""
    flown = [float("inf")] * slices
    bare = [float("inf")] * slices
    gc.collect()
    gc.disable()
    try:
        for _ in range(repeats):
            craft = busy_spacecraft()
            for k in range(slices):
                if flight.slewing and k % 3 == 0:
                    craft.send("acs.point", {"target": _TOUR[(k // 3) % len(_TOUR)]})
                data, model, steps = _bare(craft)
                bare[k] = min(bare[k], _timed(partial(mujoco.mj_step, model, data, nstep=steps)))
                flown[k] = min(flown[k], _timed(partial(_fly, craft, flight.every)))
    finally:
        gc.enable()
    seconds = float(slices * SLICE_S)
    return {
        "sim_seconds_per_second": seconds / sum(flown),
        "limit_seconds_per_second": seconds / sum(bare),
        "ratio_to_limit": sum(bare) / sum(flown),
    }


def _bare(craft: Spacecraft) -> tuple[mujoco.MjData, mujoco.MjModel, int]:
    """The same model and state on their own, wheels without torque, and the steps of a slice."""
    model = load_assembly(craft.config.time_step_s).model
    state = craft.state_for_recording()
    data = mujoco.MjData(model)
    data.qpos[3:7] = state.attitude_IB
    data.qvel[3:6] = state.rate_B_rad_s
    data.qvel[6:10] = state.wheel_speeds_rad_s
    data.qpos[11:13] = state.wing_angles_rad
    data.ctrl[4:6] = state.wing_angles_rad
    data.qfrc_applied[0:3] = state.thrust_I_N
    return data, model, round(SLICE_S / craft.config.time_step_s)


def rows(repeats: int = REPEATS) -> list[dict[str, float | str]]:
    """One row a way of flying."""
    return [{"flight": flight.name, **fly(flight, repeats=repeats)} for flight in FLIGHTS]


def measure() -> dict[str, object]:
    """All figures of this benchmark: those of the first way of flying, a row for each, and a slew beside Basilisk's."""
    table = rows()
    return {**table[0], "rows": table, "slew_beside_basilisk": basilisk.figures()}
