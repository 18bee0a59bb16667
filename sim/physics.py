"""The rigid bodies in motion: the only holder of MuJoCo's state.

Integration is RK4, which keeps angular momentum to about 1e-10 of its size over an hour at the default step; MuJoCo's
Euler and implicit integrators lose it within the hour. MuJoCo's habit of resetting an unstable state in silence is off
in the model, and its warning counters are read after every advance: a broken state is a `SimulationError`.

What Python does between two steps costs as much as the steps, so the flight loop reads and writes MuJoCo's own arrays
(`drive_views`) in compiled code; everybody else gets copies.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NoReturn

import mujoco

from sim.assembly import (
    JOINTS,
    QPOS_ATTITUDE,
    QPOS_WINGS,
    QVEL_RATE,
    QVEL_WHEELS,
    QVEL_WINGS,
    WHEELS,
    WINGS,
    Assembly,
)
from sim.errors import SimulationError
from sim.kernels import Memory
from sim.quaternion import Quaternion, Vector

_WARNINGS = (
    "inertia matrix near singular",
    "contact buffer full",
    "constraint buffer full",
    "bad position",
    "bad velocity",
    "bad acceleration",
    "bad control",
)
_NO_WARNINGS = [0] * len(_WARNINGS)
_BAD_ACCELERATION, _BAD_CONTROL = 5, 6
# The bus has six degrees of freedom, every other joint one.
_DOF_OWNER = ("bus",) * 6 + JOINTS[1:]
# The spherical xenon tank sits at the centre of mass; its radius gives the inertia that leaves with the xenon.
XENON_TANK_RADIUS_M = 0.3


class Physics:
    """Integrates the spacecraft. `qpos` (13) and `qvel` (12) come as plain lists."""

    def __init__(self, assembly: Assembly, attitude_IB: Quaternion, wheel_speeds_rad_s: Sequence[float]) -> None:
        self._assembly = assembly
        self._model = assembly.model
        self._data = mujoco.MjData(assembly.model)
        self._bus_mass_kg = float(assembly.model.body_mass[assembly.bus_body])
        self._bus_inertia_kg_m2 = assembly.model.body_inertia[assembly.bus_body].copy()
        self._data.qpos[QPOS_ATTITUDE] = attitude_IB
        self._data.qvel[QVEL_WHEELS] = wheel_speeds_rad_s
        self.qpos_view, self.qvel_view, self._ctrl_view = self._data.qpos, self._data.qvel, self._data.ctrl
        self._warnings_view = self._data.warning.number
        self._force_view = self._data.qfrc_applied[0:6]
        self._qpos_before, self._qvel_before = self.qpos_view.copy(), self.qvel_view.copy()
        self._time_before = 0.0
        self._step_s = float(assembly.model.opt.timestep)
        self.steps = 0
        self.drive_views = (self.qpos_view, self.qvel_view, self._ctrl_view, self._force_view)

    def __repr__(self) -> str:
        return f"Physics(time_s={self._data.time})"

    @property
    def qpos(self) -> list[float]:
        """Positions as of the last step (13)."""
        values: list[float] = self.qpos_view.tolist()
        return values

    @property
    def qvel(self) -> list[float]:
        """Speeds as of the last step (12)."""
        values: list[float] = self.qvel_view.tolist()
        return values

    @property
    def time_s(self) -> float:
        """Seconds since the start."""
        return float(self._data.time)

    @property
    def attitude_IB(self) -> Quaternion:
        """Attitude of the bus, body to inertial."""
        w, x, y, z = self.qpos[QPOS_ATTITUDE]
        return (w, x, y, z)

    @property
    def rate_B(self) -> Vector:
        """Angular rate of the bus against inertial space in body axes, rad/s."""
        x, y, z = self.qvel[QVEL_RATE]
        return (x, y, z)

    @property
    def wheel_speeds_rad_s(self) -> list[float]:
        """Speeds of the four wheels against the bus."""
        return self.qvel[QVEL_WHEELS]

    @property
    def wing_angles_rad(self) -> list[float]:
        """Angles of the two wings about +Y."""
        return self.qpos[QPOS_WINGS]

    @property
    def position_I(self) -> Vector:
        """Metres from where ballistic flight would have taken it."""
        return (self.qpos[0], self.qpos[1], self.qpos[2])

    @property
    def velocity_I(self) -> Vector:
        """Metres per second gained over ballistic flight."""
        return (self.qvel[0], self.qvel[1], self.qvel[2])

    def remember_in(self, qpos: Memory, qvel: Memory) -> None:
        """Let whoever calls `step` keep the state before it in these arrays (13 and 12)."""
        self._qpos_before, self._qvel_before = qpos, qvel

    def place_wings(self, angle_rad: float) -> None:
        """Set both wings at rest at an angle: for the start of a run only, motion has to come from the drives."""
        self.qpos_view[QPOS_WINGS] = angle_rad
        self.qvel_view[QVEL_WINGS] = 0.0

    def set_rate(self, rate_B: Vector) -> None:
        """Set the bus's angular rate (rad/s, body axes): for the start of a run only."""
        self.qvel_view[QVEL_RATE] = rate_B

    def set_xenon_used(self, used_kg: float) -> None:
        """Take `used_kg` of propellant out of the tank at the centre of mass: mass and inertia of the bus fall."""
        body = self._assembly.bus_body
        self._model.body_mass[body] = self._bus_mass_kg - used_kg
        self._model.body_subtreemass[body] = self._assembly.total_mass_kg - used_kg
        self._model.body_subtreemass[0] = self._assembly.total_mass_kg - used_kg
        self._model.body_inertia[body] = self._bus_inertia_kg_m2 - 0.4 * used_kg * XENON_TANK_RADIUS_M**2

    def advance(self, steps: int, controls: list[float], force_I: Vector) -> None:
        """Take `steps` steps under constant wheel torques (4, N m), wing angles (2, rad), force at the mass centre (N).

        Raises `SimulationError` with the component and the time when the state is not finite or MuJoCo warns.
        """
        self._ctrl_view[:] = controls
        self._force_view[:3] = force_I
        if not math.isfinite(sum(controls) + sum(force_I)):
            self._refuse(controls)
        self._qpos_before[:] = self.qpos_view
        self._qvel_before[:] = self.qvel_view
        self.step(steps, self._step_s)
        if not math.isfinite(sum(self.qvel)):
            self.explain()

    def step(self, steps: int, step_s: float) -> None:
        """Take `steps` steps of `step_s` under the controls and forces that lie in `drive_views`.

        Raises `SimulationError` when MuJoCo warns; whether the state is finite the caller has to see, and to `explain`.
        """
        if step_s != self._step_s:
            self._step_s = self._model.opt.timestep = step_s
        self._time_before = self._data.time
        self.steps += steps
        mujoco.mj_step(self._model, self._data, nstep=steps)
        if self._warnings_view.tolist() != _NO_WARNINGS:
            self.explain()

    def angular_momentum_I(self) -> Vector:
        """Angular momentum of spacecraft and wheels about the centre of mass, inertial axes, N m s."""
        copy = self.scratch()
        mujoco.mj_forward(self._model, copy)
        mujoco.mj_subtreeVel(self._model, copy)
        x, y, z = copy.subtree_angmom[self._assembly.bus_body].tolist()
        return (x, y, z)

    def scratch(self) -> mujoco.MjData:
        """A copy of pose and rates for pictures and sums, moved to the origin; the flight does not see it."""
        copy = mujoco.MjData(self._model)
        copy.qpos[:] = self.qpos
        copy.qpos[0:3] = 0.0
        copy.qvel[:] = self.qvel
        return copy

    def _refuse(self, controls: list[float]) -> None:
        for owner, value in zip((*WHEELS, *WINGS), controls, strict=True):
            if not math.isfinite(value):
                raise SimulationError(owner, float(self._data.time), f"expected a finite command, found {value}")
        raise SimulationError("ips", float(self._data.time), "expected a finite thrust")

    def explain(self) -> NoReturn:
        """Raise what broke: step again, one at a time, from the sound state; the first that warns knows the cause."""
        again = mujoco.MjData(self._model)
        again.qpos[:], again.qvel[:], again.time = self._qpos_before, self._qvel_before, self._time_before
        again.ctrl[:], again.qfrc_applied[0:6] = self._ctrl_view, self._force_view
        while not again.warning.number.any() and again.time < self._data.time:
            mujoco.mj_step(self._model, again)
        numbers = again.warning.number.tolist()
        for warning in sorted(range(len(numbers)), key=lambda k: (k != _BAD_ACCELERATION, -k)):
            if numbers[warning]:
                place = int(again.warning[warning].lastinfo)
                owners = (*WHEELS, *WINGS) if warning == _BAD_CONTROL else _DOF_OWNER
                owner = owners[place] if 0 <= place < len(owners) else "bus"
                raise SimulationError(owner, float(again.time), f"expected a stable step, found: {_WARNINGS[warning]}")
        for owner, value in zip(_DOF_OWNER, self.qvel, strict=True):
            if not math.isfinite(value):
                raise SimulationError(owner, float(again.time), f"expected a finite speed, found {value}")
        raise SimulationError(
            "bus", float(again.time), "expected a stable step, found a warning that did not come again"
        )
