"""One second of flight: control, actuators and battery before the physics, sensors and filter after them.

Everything continuous that happens every second is here, as two compiled functions around one call of MuJoCo; what
happens at moments only (commands, warm-ups, faults) is in `sim.spacecraft` and the components.
"""

from __future__ import annotations

import hashlib
import inspect
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from types import ModuleType

import numpy as np

from sim import control_law, filter_law
from sim.components import ion_engine, power, radio, thrusters, wheels, wings
from sim.config import SpacecraftConfig
from sim.control import AttitudeControl
from sim.dictionary import counts_per_unit
from sim.environment import Environment
from sim.errors import SimulationError
from sim.estimator import Estimator, Sensors
from sim.kernels import Memory, compiled
from sim.physics import Physics

# Places in the surroundings' memory: what acts on the spacecraft and what it sees.
SUN_I, SUN_B, THRUST_N, SUNLIGHT_N, PRESSURE_CENTRE = 0, 3, 6, 7, 8
ACTUATORS, USE_TRUTH, UNLOAD_NM, UNLOADED_NMS, THRUST_I = 11, 12, 13, 14, 15
EARTH_I, EARTH_COS, BEAM_COS, QUIET, PROPELLANT_TAKEN_KG = 18, 21, 22, 23, 24
SIZE = 25
_WINGS_REST_RAD_S = 1.0e-4
# The mass in the physics follows the propellant in grains of this size, half a minute of thrust: 2e-7 of the mass.
PROPELLANT_GRAIN_KG = 1.0e-4
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
def look_to_earth(e: Memory, qpos: Memory) -> None:
    """Cosine between the antenna, +X of the body, and the direction to the Earth."""
    w, x, y, z = qpos[3], qpos[4], qpos[5], qpos[6]
    ex, ey, ez = e[EARTH_I], e[EARTH_I + 1], e[EARTH_I + 2]
    e[EARTH_COS] = (1.0 - 2.0 * (y * y + z * z)) * ex + 2.0 * (x * y + w * z) * ey + 2.0 * (x * z - w * y) * ez


@compiled
def is_quiet(c: Memory, e: Memory, qvel: Memory) -> float:
    """1.0 when nothing turns: settled, wheels in charge, wings at rest."""
    turning = abs(qvel[10]) + abs(qvel[11]) > _WINGS_REST_RAD_S
    return 0.0 if turning or c[control_law.SETTLED] == 0.0 or e[ACTUATORS] != WITH_WHEELS else 1.0


@compiled
def is_usual(p: Memory, n: Memory, r: Memory, e: Memory) -> bool:
    """False when somebody should look: bus in undervoltage, engine out of xenon, a grain of propellant gone."""
    gone_kg = n[ion_engine.USED_KG] + r[thrusters.USED_KG] - e[PROPELLANT_TAKEN_KG]
    dry = n[ion_engine.BURNING] != 0.0 and n[ion_engine.LEFT_KG] <= 0.0
    return bool(p[power.UNDERVOLTAGE] == 0.0 and gone_kg < PROPELLANT_GRAIN_KG and not dry)


@compiled
def actuate(e: Memory, r: Memory, w: Memory, dt_s: float, tx: float, ty: float, tz: float) -> None:
    """Give the wanted torque to wheels, thrusters, or both while unloading."""
    if e[ACTUATORS] == WITH_THRUSTERS:
        # The drives still compensate their bearings' friction, so that the wheels keep their speed.
        thrusters.fire(r, dt_s, tx, ty, tz)
        wheels.allocate(w, dt_s, 0.0, 0.0, 0.0)
        return
    if e[ACTUATORS] == UNLOADING:
        unload(e, r, w, dt_s)
        t = thrusters.TORQUE
        tx, ty, tz = tx - r[t], ty - r[t + 1], tz - r[t + 2]
    wheels.allocate(w, dt_s, tx, ty, tz)


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


def _places() -> tuple[int, ...]:
    """Where each memory begins in the block that holds them all."""
    sizes = (
        control_law.SIZE,
        wheels.SIZE,
        thrusters.SIZE,
        wings.SIZE,
        power.SIZE,
        filter_law.SENSORS_SIZE,
        filter_law.FILTER_SIZE,
        ion_engine.SIZE,
        radio.SIZE,
        SIZE,
    )
    return tuple(itertools.accumulate(sizes, initial=0))


_C, _W, _R, _G, _P, _S, _F, _N, _D, _E, _END = _places()


def _build(stamp: str) -> tuple[Callable[..., int], Callable[..., int]]:
    """The two halves. numba's cache looks at this file alone: `stamp` makes it notice a change of the others."""

    @compiled
    def before(block: Memory, qpos: Memory, qvel: Memory, ctrl: Memory, applied: Memory, dt_s: float) -> int:
        assert stamp
        c, w, r, g = block[_C:_W], block[_W:_R], block[_R:_G], block[_G:_P]
        p, e = block[_P:_S], block[_E:_END]
        m = wheels.MOMENTUM
        tx, ty, tz = control_law.step(c, dt_s, w[m], w[m + 1], w[m + 2])
        if not math.isfinite(tx + ty + tz):
            return 1
        if not math.isfinite(e[THRUST_N]):
            return 2
        actuate(e, r, w, dt_s, tx, ty, tz)
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
        if not math.isfinite(p[power.SOC]):
            return 5
        ion_engine.burn(block[_N:_D], dt_s)
        if e[EARTH_COS] >= e[BEAM_COS]:
            radio.play(block[_D:_E], dt_s)
        e[QUIET] = is_quiet(c, e, qvel)
        for k in range(13):
            block[_END + k] = qpos[k]
        for k in range(12):
            block[_END + 13 + k] = qvel[k]
        return 0

    @compiled
    def after(block: Memory, qpos: Memory, qvel: Memory, noise: Memory, row: int, dt_s: float) -> int:
        assert stamp
        c, w, p = block[_C:_W], block[_W:_R], block[_P:_S]
        s, f, e = block[_S:_F], block[_F:_N], block[_E:_END]
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
        filter_law.correct(f, s, sun_I)
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
        look_to_earth(e, qpos)
        power.observe(p, wings.incidence(qpos[11], qpos[12], e[SUN_B], e[SUN_B + 2]))
        return 0 if is_usual(p, block[_N:_D], block[_R:_G], e) else -1

    return before, after


@compiled
def read_rounded(block: Memory, places: Memory, counts_per_unit: Memory, out: Memory) -> None:
    """The values at `places` (whole numbers) to the nearest count; there is no negative zero."""
    for k in range(len(places)):
        counts = counts_per_unit[k]
        out[k] = math.floor(block[int(places[k])] * counts + 0.5) / counts


def _stamp() -> str:
    modules: tuple[ModuleType, ...] = (control_law, filter_law, ion_engine, power, radio, thrusters, wheels, wings)
    return hashlib.sha256("".join(map(inspect.getsource, modules)).encode()).hexdigest()


_BEFORE, _AFTER = _build(_stamp())


@dataclass(frozen=True, slots=True)
class Units:
    """The continuous units that one second of flight takes through the loop, in the order of the block."""

    control: AttitudeControl
    wheels: wheels.Wheels
    thrusters: thrusters.Thrusters
    wings: wings.Wings
    power: power.Power
    sensors: Sensors
    estimator: Estimator
    engine: ion_engine.IonEngine
    recorder: radio.Recorder


class FlightLoop:
    """Takes units and physics through time. The units' memories become parts of one block, quick to hand over."""

    def __init__(self, config: SpacecraftConfig, physics: Physics, units: Units, surroundings: Memory) -> None:
        period = float(config.control_period_s)
        self._steps = (round(period / config.time_step_s), config.time_step_s)
        self._quiet_steps = (round(period / config.quiet_time_step_s), config.quiet_time_step_s)
        self._sunlight_1au_N = config.solar_pressure_1au_Pa * config.sunlit_area_m2
        self._array_1au_W = config.array_power_1au_W
        self._physics = physics
        self._sensors = units.sensors
        self._block: Memory = np.zeros(_END + 25)
        starts = (_C, _W, _R, _G, _P, _S, _F, _N, _D)
        owners = (getattr(units, field.name) for field in fields(units))
        for owner, start in zip(owners, starts, strict=True):
            part = self._block[start : start + len(owner.memory)]
            part[:] = owner.memory
            owner.memory = part
        self.surroundings: Memory = self._block[_E:_END]
        self.surroundings[:] = surroundings
        physics.remember_in(self._block[_END : _END + 13], self._block[_END + 13 : _END + 25])
        readings = [
            (channel, start + place)
            for unit, start in (
                (units.control, _C),
                (units.wheels, _W),
                (units.thrusters, _R),
                (units.power, _P),
                (units.sensors, _S),
                (units.estimator, _F),
                (units.engine, _N),
                (units.recorder, _D),
            )
            for channel, place in unit.READINGS.items()
        ]
        self.channels = tuple(channel for channel, _ in readings)
        states = (_C + control_law.SETTLED, _S + filter_law.TRACKER_VALID, _E + ACTUATORS)
        self._places = np.array([*(float(place) for _, place in readings), *map(float, states)])
        counts = [counts_per_unit(channel) for channel in self.channels]
        self._counts_per_unit = np.array([*counts, *(1.0 for _ in states)])
        self._out = np.zeros(len(self._places))

    def __repr__(self) -> str:
        return f"FlightLoop({self._physics!r})"

    def readings(self) -> list[float]:
        """The analogue values of `channels`, rounded to their resolution, then settled, tracker valid, actuators."""
        read_rounded(self._block, self._places, self._counts_per_unit, self._out)
        values: list[float] = self._out.tolist()
        return values

    def look_around(self, environment: Environment, time_s: float) -> None:
        """Take the directions of Sun and Earth at `time_s`, and how strong the sunlight is."""
        e = self.surroundings
        e[SUN_I : SUN_I + 3] = environment.sun_direction_I(time_s)
        e[EARTH_I : EARTH_I + 3] = environment.direction_I(environment.earth, time_s)
        weakened = 1.0 / environment.sun_distance_au(time_s) ** 2
        e[SUNLIGHT_N] = self._sunlight_1au_N * weakened
        self._block[_P + power.NORMAL_W] = self._array_1au_W * weakened
        self.feel_light()

    def feel_light(self) -> None:
        """What of the light reaches body and wings, and what the loads leave of it."""
        e, qpos = self.surroundings, self._physics.qpos_view
        sun_in_body(e, qpos)
        look_to_earth(e, qpos)
        light = wings.incidence(float(qpos[11]), float(qpos[12]), float(e[SUN_B]), float(e[SUN_B + 2]))
        power.observe(self._block[_P:_S], light)

    def before(self, dt_s: float) -> None:
        """Control, actuators and battery for the next `dt_s`; `SimulationError` when a component gives no number."""
        qpos, qvel, ctrl, applied = self._physics.drive_views
        status = _BEFORE(self._block, qpos, qvel, ctrl, applied, dt_s)
        if status != _FINE:
            self._accuse(status)

    def after(self, dt_s: float) -> bool:
        """The physics for `dt_s`, then sensors, filter, control; True when somebody should look."""
        physics = self._physics
        if self.surroundings[QUIET]:
            physics.step(*self._quiet_steps)
        else:
            physics.step(*self._steps)
        noise, row = self._sensors.noise()
        status = _AFTER(self._block, physics.qpos_view, physics.qvel_view, noise, row, dt_s)
        if status == _PHYSICS:
            physics.explain()
        elif status > _FINE:
            self._accuse(status)
        return bool(status < _FINE)

    def _accuse(self, status: int) -> None:
        raise SimulationError(_BROKEN[status], self._physics.time_s, "expected finite numbers, found one that is not")


def surroundings() -> Memory:
    """A memory for what acts on the spacecraft, all zero: wheels in charge, the filter believed."""
    return np.zeros(SIZE)
