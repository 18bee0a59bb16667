"""One second of flight: control, actuators and battery before the physics, sensors and filter after them.

Everything continuous that happens every second is here, as two compiled functions around one call of MuJoCo; what
happens at moments only (commands, warm-ups, faults) is in `sim.spacecraft` and the components.
"""

from __future__ import annotations

import hashlib
import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from sim import control_law, filter_law
from sim.components import power, thrusters, wheels, wings
from sim.control import AttitudeControl
from sim.environment import Environment
from sim.errors import SimulationError
from sim.estimator import Estimator, Sensors
from sim.kernels import Memory, compiled
from sim.physics import Physics

# Places in the surroundings' memory: what acts on the spacecraft and what it sees.
SUN_I, SUN_B, THRUST_N, SUNLIGHT_N, PRESSURE_CENTRE = 0, 3, 6, 7, 8
ACTUATORS, USE_TRUTH, UNLOAD_NM, UNLOADED_NMS, THRUST_I = 11, 12, 13, 14, 15
SIZE = 18
WITH_WHEELS, UNLOADING, WITH_THRUSTERS = 0.0, 1.0, 2.0

# What the compiled functions answer, and the component that it accuses.
_FINE, _PHYSICS = 0, 9
_BROKEN = {1: "acs", 2: "ips", 3: "rcs", 4: "wings", 5: "power", 6: "wheels", 7: "sensors", 8: "estimator"}


@compiled
def sun_in_body(e: Memory, qpos: Memory) -> None:
    """Turn the Sun's direction into body axes."""
    w, x, y, z = qpos[3], -qpos[4], -qpos[5], -qpos[6]
    sx, sy, sz = e[SUN_I], e[SUN_I + 1], e[SUN_I + 2]
    tx, ty, tz = 2.0 * (y * sz - z * sy), 2.0 * (z * sx - x * sz), 2.0 * (x * sy - y * sx)
    e[SUN_B] = sx + w * tx + y * tz - z * ty
    e[SUN_B + 1] = sy + w * ty + z * tx - x * tz
    e[SUN_B + 2] = sz + w * tz + x * ty - y * tx


@compiled
def unload(e: Memory, r: Memory, w: Memory, dt_s: float) -> None:
    """Thruster torque against the wheels' momentum; ends with little left."""
    hx, hy, hz = w[wheels.MOMENTUM], w[wheels.MOMENTUM + 1], w[wheels.MOMENTUM + 2]
    size = math.sqrt(hx * hx + hy * hy + hz * hz)
    if size <= e[UNLOADED_NMS]:
        e[ACTUATORS] = WITH_WHEELS
        thrusters.close(r)
        return
    gain = -min(e[UNLOAD_NM], 0.05 * size) / size
    thrusters.fire(r, dt_s, gain * hx, gain * hy, gain * hz)


@compiled
def apply_forces(e: Memory, r: Memory, qpos: Memory, applied: Memory) -> None:
    """Engine, thrusters and sunlight as force (inertial axes) and torque (body axes) on the bus."""
    light = -e[SUNLIGHT_N]
    lx, ly, lz = light * e[SUN_B], light * e[SUN_B + 1], light * e[SUN_B + 2]
    cx, cy, cz = e[PRESSURE_CENTRE], e[PRESSURE_CENTRE + 1], e[PRESSURE_CENTRE + 2]
    applied[3] = r[thrusters.TORQUE] + cy * lz - cz * ly
    applied[4] = r[thrusters.TORQUE + 1] + cz * lx - cx * lz
    applied[5] = r[thrusters.TORQUE + 2] + cx * ly - cy * lx
    fx, fz = r[thrusters.FORCE], r[thrusters.FORCE + 2]
    w, x, y, z = qpos[3], qpos[4], qpos[5], qpos[6]
    # The axes +X and +Z of the body are the first and the third column of its rotation matrix.
    xx, xy, xz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
    zx, zy, zz = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
    e[THRUST_I], e[THRUST_I + 1], e[THRUST_I + 2] = e[THRUST_N] * zx, e[THRUST_N] * zy, e[THRUST_N] * zz
    applied[0] = e[THRUST_I] + fx * xx + fz * zx + light * e[SUN_I]
    applied[1] = e[THRUST_I + 1] + fx * xy + fz * zy + light * e[SUN_I + 1]
    applied[2] = e[THRUST_I + 2] + fx * xz + fz * zz + light * e[SUN_I + 2]


def _build(stamp: str) -> tuple[Callable[..., int], Callable[..., int]]:
    """The two halves. numba's cache looks at this file alone: `stamp` makes it notice a change of the others."""

    @compiled
    def before(
        c: Memory,
        w: Memory,
        r: Memory,
        g: Memory,
        p: Memory,
        e: Memory,
        state: tuple[Memory, Memory, Memory, Memory, Memory, Memory],
        dt_s: float,
    ) -> int:
        qpos, qvel, ctrl, applied, qpos_before, qvel_before = state
        assert stamp
        for k in range(13):
            qpos_before[k] = qpos[k]
        for k in range(12):
            qvel_before[k] = qvel[k]
        m = wheels.MOMENTUM
        tx, ty, tz = control_law.step(c, dt_s, w[m], w[m + 1], w[m + 2])
        if not math.isfinite(tx + ty + tz):
            return 1
        if not math.isfinite(e[THRUST_N]):
            return 2
        if e[ACTUATORS] == WITH_THRUSTERS:
            # Wheels that keep their speed leave the bus with its own momentum only, and no torque from them.
            thrusters.fire(r, dt_s, tx, ty, tz)
            wheels.allocate(w, dt_s, 0.0, 0.0, 0.0)
        else:
            if e[ACTUATORS] == UNLOADING:
                unload(e, r, w, dt_s)
                t = thrusters.TORQUE
                tx, ty, tz = tx - r[t], ty - r[t + 1], tz - r[t + 2]
            wheels.allocate(w, dt_s, tx, ty, tz)
        t = thrusters.TORQUE
        if not math.isfinite(r[t] + r[t + 1] + r[t + 2] + r[thrusters.USED_KG]):
            return 3
        for k in range(4):
            ctrl[k] = w[wheels.MOTORS + k] + wheels.uncompensated_friction(w, k)
            if not math.isfinite(ctrl[k]):
                return 6
        wing = wings.step(g, dt_s, e[SUN_B], e[SUN_B + 2])
        if not math.isfinite(wing):
            return 4
        ctrl[4] = ctrl[5] = wing
        apply_forces(e, r, qpos, applied)
        power.step(p, dt_s)
        return 0 if math.isfinite(p[power.SOC]) else 5

    @compiled
    def after(
        c: Memory,
        w: Memory,
        p: Memory,
        e: Memory,
        s: Memory,
        f: Memory,
        state: tuple[Memory, Memory, Memory],
        noise: Memory,
        row: int,
        dt_s: float,
    ) -> int:
        qpos, qvel, scratch = state
        assert stamp
        total = 0.0
        for k in range(12):
            total += qvel[k]
        if not math.isfinite(total):
            return 9
        for k in range(4):
            w[wheels.SPEEDS + k] = qvel[6 + k]
        wheels.observe(w)
        sun_I = e[SUN_I : SUN_I + 3]
        filter_law.sense(s, qpos[3:7], qvel[3:6], sun_I, noise[row], dt_s)
        if not math.isfinite(s[filter_law.GYRO_TURN] + s[filter_law.TRACKER] + s[filter_law.SUN_READING]):
            return 7
        filter_law.propagate(f, s, dt_s)
        filter_law.correct(f, s, sun_I, scratch)
        if not math.isfinite(f[filter_law.ESTIMATE] + f[filter_law.BIAS] + f[filter_law.COVARIANCE]):
            return 8
        truth = e[USE_TRUTH] != 0.0
        for k in range(4):
            c[control_law.ATTITUDE + k] = qpos[3 + k] if truth else f[filter_law.ESTIMATE + k]
        for k in range(3):
            reading = s[filter_law.GYRO_RATE + k] - f[filter_law.BIAS + k]
            c[control_law.RATE + k] = qvel[3 + k] if truth else reading
        control_law.observe(c, dt_s)
        sun_in_body(e, qpos)
        power.observe(p, wings.incidence(qpos[11], qpos[12], e[SUN_B], e[SUN_B + 2]))
        return 0

    return before, after


def _stamp() -> str:
    modules: tuple[ModuleType, ...] = (control_law, filter_law, power, thrusters, wheels, wings)
    return hashlib.sha256("".join(map(inspect.getsource, modules)).encode()).hexdigest()


_BEFORE, _AFTER = _build(_stamp())


@dataclass(frozen=True, eq=False)
class FlightLoop:
    """The continuous units and the physics that one second of flight takes through the loop."""

    physics: Physics
    control: AttitudeControl
    wheels: wheels.Wheels
    thrusters: thrusters.Thrusters
    wings: wings.Wings
    power: power.Power
    sensors: Sensors
    estimator: Estimator
    surroundings: Memory

    def __repr__(self) -> str:
        return f"FlightLoop({self.physics!r})"

    def look_around(self, environment: Environment, time_s: float) -> None:
        """Take the Sun's direction and light at `time_s`, and what of them reaches body and wings."""
        e = self.surroundings
        e[SUN_I : SUN_I + 3] = environment.sun_direction_I(time_s)
        sun_in_body(e, self.physics.qpos_view)
        plus, minus = self.physics.wing_angles_rad
        power.observe(self.power.memory, wings.incidence(plus, minus, float(e[SUN_B]), float(e[SUN_B + 2])))

    def before(self, dt_s: float) -> None:
        """Control, actuators and battery for the next `dt_s`; `SimulationError` when a component gives no number."""
        status = _BEFORE(
            self.control.memory,
            self.wheels.memory,
            self.thrusters.memory,
            self.wings.memory,
            self.power.memory,
            self.surroundings,
            self.physics.drive_views,
            dt_s,
        )
        if status != _FINE:
            self._accuse(status)

    def after(self, steps: int, dt_s: float) -> None:
        """The physics for `dt_s`, in `steps`, then sensors, filter and what control makes of them."""
        self.physics.step(steps)
        noise, row = self.sensors.noise()
        status = _AFTER(
            self.control.memory,
            self.wheels.memory,
            self.power.memory,
            self.surroundings,
            self.sensors.memory,
            self.estimator.memory,
            (self.physics.qpos_view, self.physics.qvel_view, self.estimator.scratch),
            noise,
            row,
            dt_s,
        )
        if status == _PHYSICS:
            self.physics.explain()
        elif status != _FINE:
            self._accuse(status)

    def _accuse(self, status: int) -> None:
        raise SimulationError(_BROKEN[status], self.physics.time_s, "expected finite numbers, found one that is not")


def surroundings() -> Memory:
    """A memory for what acts on the spacecraft, all zero: wheels in charge, the filter believed."""
    return np.zeros(SIZE)
