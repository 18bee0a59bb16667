"""The two solar wings: their drive turns them about +Y after the Sun."""

from __future__ import annotations

import math

from sim.environment import wing_angle_rad
from sim.quaternion import Vector

# With the Sun nearly along the wings' axis every angle is as good: the drive waits rather than race round.
_AXIS_CONE_SQUARED = 0.01


class Wings:
    """One angle for both. The set point runs at the drive's rate limit; the physics follow it with their inertia."""

    def __init__(self, rate_limit_rad_s: float, sun_B: Vector) -> None:
        self._rate_limit = rate_limit_rad_s
        self.setpoint_rad = wing_angle_rad(sun_B)

    def __repr__(self) -> str:
        return f"Wings({math.degrees(self.setpoint_rad):.1f} deg)"

    def step(self, dt_s: float, sun_B: Vector) -> float:
        """Angle (rad, turns counted) that the drives should hold for the next `dt_s`."""
        if sun_B[0] * sun_B[0] + sun_B[2] * sun_B[2] > _AXIS_CONE_SQUARED:
            way = math.remainder(wing_angle_rad(sun_B) - self.setpoint_rad, math.tau)
            reach = self._rate_limit * dt_s
            self.setpoint_rad += max(-reach, min(reach, way))
        return self.setpoint_rad

    def incidence_cosine(self, angles_rad: list[float], sun_B: Vector) -> float:
        """Mean over the wings of the cosine between their cells' normal and the Sun, not below 0."""
        x, _, z = sun_B
        plus, minus = angles_rad
        one = x * math.cos(plus) - z * math.sin(plus)
        two = x * math.cos(minus) - z * math.sin(minus)
        return 0.5 * (max(0.0, one) + max(0.0, two))
