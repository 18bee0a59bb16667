"""Speed of the simulator against the same physics without Python: `python -m tests.benchmarks.bench_sim`.

The flight has everything on: attitude control, sensors, power, engine, camera and radio, a slew in every slice, and
second by second what an executive asks for, one `advance` and one `telemetry`. The limit is MuJoCo stepping the same
model, from the same state and with the same step, in one C call a slice. Both are timed in turns, slice by slice, and the
best of some repeats of each slice counts, so that what else the machine does stays out of the figure.

A second row lets the flight run free: one `advance` a slice, telemetry at its end.
"""

from __future__ import annotations

import gc
import json
import sys
import time
from collections.abc import Callable

import mujoco

from sim import Spacecraft, SpacecraftConfig
from sim.assembly import load_assembly

SLICE_S = 300
SLICES = 12
REPEATS = 3
_TOUR = ("asteroid_a", "thrust_a", "asteroid_c", "earth")


def busy_spacecraft(seed: int = 1) -> Spacecraft:
    """A spacecraft with engine, camera and radio on."""
    craft = Spacecraft(SpacecraftConfig(sun_distance_au=0.9), seed)
    for name, arguments in (("ips.start", {}), ("micas.power", {"on": True}), ("radio.power", {"on": True})):
        craft.send(name, arguments)
    craft.advance(1300)
    craft.send("ips.thrust", {"level": 48})
    craft.send("radio.downlink", {"on": True})
    return craft


def _fly(craft: Spacecraft, every_second: bool) -> None:
    until = craft.time + SLICE_S
    if every_second:
        for second in range(craft.time + 1, until + 1):
            craft.advance(second)
            craft.telemetry()
    else:
        craft.advance(until)
        craft.telemetry()


def _timed(run: Callable[[], None]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


def measure(*, every_second: bool = True, slices: int = SLICES, repeats: int = REPEATS) -> dict[str, float]:
    """Simulated seconds a second of flight and of bare physics, and their ratio."""
    flight = [float("inf")] * slices
    bare = [float("inf")] * slices
    gc.collect()
    gc.disable()
    try:
        for repeat in range(repeats):
            craft = busy_spacecraft()
            for k in range(slices):
                if k % 3 == 0:
                    craft.send("acs.point", {"target": _TOUR[(k // 3) % len(_TOUR)]})
                data, model, steps = _bare(craft)
                bare[k] = min(bare[k], _timed(lambda d=data, m=model, n=steps: mujoco.mj_step(m, d, nstep=n)))  # type: ignore[misc]
                flight[k] = min(flight[k], _timed(lambda c=craft: _fly(c, every_second)))  # type: ignore[misc]
            del repeat
    finally:
        gc.enable()
    seconds = float(slices * SLICE_S)
    return {
        "sim_seconds_per_second": seconds / sum(flight),
        "limit_seconds_per_second": seconds / sum(bare),
        "ratio_to_limit": sum(bare) / sum(flight),
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


def rows() -> list[dict[str, float | str]]:
    """One row a way of flying."""
    return [
        {"flight": "telemetry every second", **measure()},
        {"flight": f"telemetry every {SLICE_S} s", **measure(every_second=False)},
    ]


def main() -> None:
    """Print the table, or with `--json` one object."""
    table = rows()
    if "--json" in sys.argv[1:]:
        print(json.dumps({**measure(), "rows": table}))
        return
    print(f"{'flight':26} {'sim s / s':>10} {'limit':>10} {'ratio':>6}")
    for row in table:
        print(
            f"{row['flight']:26} {row['sim_seconds_per_second']:10.0f} {row['limit_seconds_per_second']:10.0f}"
            f" {row['ratio_to_limit']:6.2f}"
        )


if __name__ == "__main__":
    main()
