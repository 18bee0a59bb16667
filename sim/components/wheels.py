"""Four reaction wheels: from a torque wanted on the bus to motor torques within the limits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from sim.components.hooks import refuse_fault
from sim.quaternion import Vector


class Wheels:
    """Allocation by the pseudo-inverse, which for axes (+-1, +-1, 1)/sqrt(3) is 3/4 of the transpose.

    A wheel at its speed limit may only slow down. When one motor would need more than its limit, all four torques
    shrink together, so that the direction of the torque on the bus stays right.
    """

    def __init__(
        self,
        axes_B: tuple[Vector, Vector, Vector, Vector],
        inertia_kg_m2: float,
        torque_limit_Nm: float,
        speed_limit_rad_s: float,
        speeds_rad_s: Sequence[float],
    ) -> None:
        self._axes = axes_B
        self._inertia = inertia_kg_m2
        self._torque_limit = torque_limit_Nm
        self._speed_limit = speed_limit_rad_s
        self._speeds = list(speeds_rad_s)
        self.momentum_B: Vector = (0.0, 0.0, 0.0)
        self.observe(self._speeds)

    def __repr__(self) -> str:
        return f"Wheels({', '.join(f'{speed:.1f}' for speed in self._speeds)} rad/s)"

    def observe(self, speeds_rad_s: list[float]) -> None:
        """Take the wheels' speeds (4, rad/s) as the physics left them."""
        self._speeds = speeds_rad_s
        a, b, c, d = self._axes
        i = self._inertia
        p, q, r, s = i * speeds_rad_s[0], i * speeds_rad_s[1], i * speeds_rad_s[2], i * speeds_rad_s[3]
        self.momentum_B = (
            a[0] * p + b[0] * q + c[0] * r + d[0] * s,
            a[1] * p + b[1] * q + c[1] * r + d[1] * s,
            a[2] * p + b[2] * q + c[2] * r + d[2] * s,
        )

    def step(self, dt_s: float, torque_on_bus_B: Vector) -> list[float]:
        """Motor torques (4, N m on the wheels) that put `torque_on_bus_B` (N m) on the bus, as far as the limits go."""
        tx, ty, tz = torque_on_bus_B
        a, b, c, d = self._axes
        motors = [
            -0.75 * (a[0] * tx + a[1] * ty + a[2] * tz),
            -0.75 * (b[0] * tx + b[1] * ty + b[2] * tz),
            -0.75 * (c[0] * tx + c[1] * ty + c[2] * tz),
            -0.75 * (d[0] * tx + d[1] * ty + d[2] * tz),
        ]
        return self.limited(dt_s, motors)

    def limited(self, dt_s: float, motors: list[float]) -> list[float]:
        """Motor torques (4, N m) like `motors` that keep torque and speed limits for the next `dt_s`."""
        largest = max(*motors, -min(motors))
        if largest > self._torque_limit:
            scale = self._torque_limit / largest
            motors = [scale * motor for motor in motors]
        else:
            motors = list(motors)
        if max(*self._speeds, -min(self._speeds)) > self._speed_limit - self._torque_limit * dt_s / self._inertia:
            self._respect_speed_limit(dt_s, motors)
        return motors

    def telemetry(self) -> dict[str, float]:
        """Speeds and the size of the momentum they store."""
        x, y, z = self.momentum_B
        one, two, three, four = self._speeds
        return {
            "wheels.speed_1_rad_s": one,
            "wheels.speed_2_rad_s": two,
            "wheels.speed_3_rad_s": three,
            "wheels.speed_4_rad_s": four,
            "wheels.momentum_Nms": math.sqrt(x * x + y * y + z * z),
        }

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """No failure modes yet."""
        del active, parameters
        refuse_fault(self, mode)

    def _respect_speed_limit(self, dt_s: float, motors: list[float]) -> None:
        for k, speed in enumerate(self._speeds):
            change = motors[k] * dt_s / self._inertia
            if abs(speed + change) > self._speed_limit and speed * change > 0.0:
                room = max(0.0, self._speed_limit - abs(speed))
                motors[k] = math.copysign(room * self._inertia / dt_s, change)
