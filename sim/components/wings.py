"""The two solar wings: their drive turns them about +Y after the Sun."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sim.components.hooks import refuse_fault
from sim.environment import wing_angle_rad
from sim.kernels import Memory, compiled
from sim.quaternion import Vector

# With the Sun nearly along the wings' axis every angle is as good: the drive waits rather than race round.
_AXIS_CONE_SQUARED = 0.01

SETPOINT, RATE_LIMIT, WORKS = 0, 1, 2
SIZE = 3


@compiled
def step(m: Memory, dt_s: float, sun_x: float, sun_z: float) -> float:
    """Move the set point after the Sun (its components across +Y) for `dt_s`; the new one."""
    if m[WORKS] != 0.0 and sun_x * sun_x + sun_z * sun_z > _AXIS_CONE_SQUARED:
        way = math.atan2(-sun_z, sun_x) - m[SETPOINT]
        way -= 2.0 * math.pi * math.floor(way / (2.0 * math.pi) + 0.5)
        reach = m[RATE_LIMIT] * dt_s
        m[SETPOINT] += max(-reach, min(reach, way))
    return float(m[SETPOINT])


@compiled
def incidence(plus_rad: float, minus_rad: float, sun_x: float, sun_z: float) -> float:
    """Mean over the wings of the cosine between their cells' normal and the Sun, not below 0."""
    one = sun_x * math.cos(plus_rad) - sun_z * math.sin(plus_rad)
    two = sun_x * math.cos(minus_rad) - sun_z * math.sin(minus_rad)
    return 0.5 * (max(0.0, one) + max(0.0, two))


class Wings:
    """One angle for both. The set point runs at the drive's rate limit; the physics follow it with their inertia."""

    def __init__(self, rate_limit_rad_s: float, sun_B: Vector) -> None:
        self.memory: Memory = np.array([wing_angle_rad(sun_B), rate_limit_rad_s, 1.0])

    def __repr__(self) -> str:
        return f"Wings({math.degrees(self.setpoint_rad):.1f} deg)"

    @property
    def setpoint_rad(self) -> float:
        """Angle (rad, turns counted) that the drives hold."""
        return float(self.memory[SETPOINT])

    def step(self, dt_s: float, sun_B: Vector) -> float:
        """Angle (rad, turns counted) that the drives should hold for the next `dt_s`."""
        return step(self.memory, dt_s, sun_B[0], sun_B[2])

    def incidence_cosine(self, angles_rad: list[float], sun_B: Vector) -> float:
        """Mean over the wings of the cosine between their cells' normal and the Sun, not below 0."""
        return incidence(angles_rad[0], angles_rad[1], sun_B[0], sun_B[2])

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`stuck`: the drives hold the angle that they have."""
        del parameters
        if mode != "stuck":
            refuse_fault(self, mode)
        self.memory[WORKS] = 0.0 if active else 1.0
