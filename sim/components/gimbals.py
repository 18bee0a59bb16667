"""The two gimbals of the ion engine: they turn the thrust, and with it the spacecraft about X and Y.

The engine sits on the -Z side; with the gimbals at angles (x, y) about the body's X and Y the thrust points along
(sin y, -sin x cos y, cos x cos y). At 20 to 92 mN some millinewton metres come of it: enough to hold an attitude, not
to slew. Angles run at a limited rate to limited angles; nobody steering, they go back to the middle.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sim.components.hooks import refuse_fault
from sim.config import SpacecraftConfig
from sim.kernels import Memory, compiled

ANGLE_X, ANGLE_Y, WORKS_X, WORKS_Y = 0, 1, 2, 3
RATE_LIMIT, ANGLE_LIMIT, ARM_M = 4, 5, 6
TORQUE, DIRECTION = 7, 9
SIZE = 12


@compiled
def steer(m: Memory, dt_s: float, thrust_N: float, tx: float, ty: float) -> None:
    """Turn the thrust for this torque (N m about X and Y) in the next `dt_s`, as far as it goes."""
    lever_Nm = thrust_N * m[ARM_M]
    reach = m[RATE_LIMIT] * dt_s
    for k in range(2):
        wanted = 0.0
        if lever_Nm > 0.0:
            sine = -(tx if k == 0 else ty) / lever_Nm
            wanted = math.asin(max(-1.0, min(1.0, sine)))
        wanted = max(-m[ANGLE_LIMIT], min(m[ANGLE_LIMIT], wanted))
        if m[WORKS_X + k] != 0.0:
            m[ANGLE_X + k] += max(-reach, min(reach, wanted - m[ANGLE_X + k]))
    sx, sy, cy = math.sin(m[ANGLE_X]), math.sin(m[ANGLE_Y]), math.cos(m[ANGLE_Y])
    m[DIRECTION], m[DIRECTION + 1], m[DIRECTION + 2] = sy, -sx * cy, math.cos(m[ANGLE_X]) * cy
    m[TORQUE], m[TORQUE + 1] = -lever_Nm * sx * cy, -lever_Nm * sy


class Gimbals:
    """Angles (rad) and what the thrust at them does: direction and torque over the control period, body axes."""

    READINGS: ClassVar[Mapping[str, int]] = {"ips.gimbal_x_rad": ANGLE_X, "ips.gimbal_y_rad": ANGLE_Y}

    def __init__(self, config: SpacecraftConfig) -> None:
        self.memory: Memory = np.zeros(SIZE)
        m = self.memory
        m[WORKS_X] = m[WORKS_Y] = m[DIRECTION + 2] = 1.0
        m[RATE_LIMIT], m[ANGLE_LIMIT] = config.gimbal_rate_limit_rad_s, config.gimbal_limit_rad
        m[ARM_M] = config.gimbal_arm_m

    def __repr__(self) -> str:
        return f"Gimbals({math.degrees(self.memory[ANGLE_X]):.2f}, {math.degrees(self.memory[ANGLE_Y]):.2f} deg)"

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`stuck_x`, `stuck_y`: that gimbal stays where it is."""
        del parameters
        if mode not in ("stuck_x", "stuck_y"):
            refuse_fault(self, mode)
        self.memory[WORKS_X if mode == "stuck_x" else WORKS_Y] = 0.0 if active else 1.0
