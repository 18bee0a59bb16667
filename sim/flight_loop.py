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

from sim import control_law, filter_law, flight_law
from sim.components import gimbals, ion_engine, power, radio, thermal, thrusters, wheels, wings
from sim.config import SpacecraftConfig
from sim.control import AttitudeControl
from sim.dictionary import counts_per_unit
from sim.environment import Environment
from sim.errors import SimulationError
from sim.estimator import Estimator, Sensors
from sim.flight_law import (
    ACTUATORS,
    BEAM_COS,
    EARTH_COS,
    EARTH_I,
    QUIET,
    SIZE,
    STATION_HEARS,
    SUN_B,
    SUN_I,
    SUNLIGHT_N,
    THRUST_N,
    actuate,
    apply_forces,
    is_quiet,
    is_usual,
    know,
    look_to_earth,
    see_sun,
    sun_in_body,
)
from sim.kernels import Memory, compiled
from sim.physics import Physics

# What the compiled functions answer, and the component that it accuses.
_FINE, _PHYSICS = 0, 9
_BROKEN = {1: "acs", 2: "ips", 3: "rcs", 4: "wings", 5: "power", 6: "wheels", 7: "sensors", 8: "estimator"}


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
        gimbals.SIZE,
        thermal.SIZE,
        SIZE,
    )
    return tuple(itertools.accumulate(sizes, initial=0))


_C, _W, _R, _G, _P, _S, _F, _N, _D, _H, _T, _E, _END = _places()


def _build(stamp: str) -> tuple[Callable[..., int], Callable[..., int]]:
    """The two halves. numba's cache looks at this file alone: `stamp` makes it notice a change of the others."""

    @compiled
    def before(block: Memory, qpos: Memory, qvel: Memory, ctrl: Memory, applied: Memory, dt_s: float) -> int:
        assert stamp
        c, w, r, g = block[_C:_W], block[_W:_R], block[_R:_G], block[_G:_P]
        p, h, e = block[_P:_S], block[_H:_T], block[_E:_END]
        m = wheels.MOMENTUM
        tx, ty, tz = control_law.step(c, dt_s, w[m], w[m + 1], w[m + 2])
        if not math.isfinite(tx + ty + tz):
            return 1
        if not math.isfinite(e[THRUST_N]):
            return 2
        actuate(e, r, w, h, dt_s, tx, ty, tz)
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
        apply_forces(e, r, h, qpos, applied)
        power.step(p, dt_s)
        if not math.isfinite(p[power.SOC]):
            return 5
        ion_engine.burn(block[_N:_D], dt_s)
        thermal.step(block[_T:_E], dt_s)
        if e[EARTH_COS] >= e[BEAM_COS] and e[STATION_HEARS] != 0.0:
            radio.play(block[_D:_H], dt_s)
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
        know(c, s, f, e, qpos, qvel)
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
    modules: tuple[ModuleType, ...] = (
        control_law,
        filter_law,
        flight_law,
        gimbals,
        ion_engine,
        power,
        radio,
        thermal,
        thrusters,
        wheels,
        wings,
    )
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
    gimbals: gimbals.Gimbals
    thermal: thermal.Thermal


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
        starts = (_C, _W, _R, _G, _P, _S, _F, _N, _D, _H, _T)
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
                (units.gimbals, _H),
                (units.thermal, _T),
            )
            for channel, place in unit.READINGS.items()
        ]
        self.channels = tuple(channel for channel, _ in readings)
        states = (_C + control_law.SETTLED, _S + filter_law.TRACKER_VALID, _C + control_law.CONES_KEPT, _E + ACTUATORS)
        self._places = np.array([*(float(place) for _, place in readings), *map(float, states)])
        counts = [counts_per_unit(channel) for channel in self.channels]
        self._counts_per_unit = np.array([*counts, *(1.0 for _ in states)])
        self._out = np.zeros(len(self._places))

    def __repr__(self) -> str:
        return f"FlightLoop({self._physics!r})"

    def readings(self) -> list[float]:
        """The analogue values of `channels`, rounded, then settled, tracker valid, cones kept, actuators."""
        read_rounded(self._block, self._places, self._counts_per_unit, self._out)
        values: list[float] = self._out.tolist()
        return values

    def look_around(self, environment: Environment, time_s: float) -> None:
        """Take the directions of Sun and Earth at `time_s`, and how strong the sunlight is."""
        e = self.surroundings
        e[SUN_I : SUN_I + 3] = environment.sun_direction_I(time_s)
        e[EARTH_I : EARTH_I + 3] = environment.direction_I(environment.earth, time_s)
        e[STATION_HEARS] = environment.station(time_s) != "none"
        weakened = 1.0 / environment.sun_distance_au(time_s) ** 2
        e[SUNLIGHT_N] = self._sunlight_1au_N * weakened
        self._block[_P + power.NORMAL_W] = self._array_1au_W * weakened
        self.feel_light()

    def feel_light(self) -> None:
        """What of the light reaches body and wings, and what the loads leave of it."""
        e, qpos = self.surroundings, self._physics.qpos_view
        sun_in_body(e, qpos)
        look_to_earth(e, qpos)
        see_sun(self._block[_C:_W], self._block[_S:_F], e[SUN_I : SUN_I + 3])
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
