"""Four reaction wheels: from a torque wanted on the bus to motor torques within the limits.

Allocation is the pseudo-inverse, which for axes (+-1, +-1, 1)/sqrt(3) is 3/4 of the transpose. A wheel at its speed
limit may only slow down. When one motor would need more than its limit, all four torques shrink together, so that the
direction of the torque on the bus stays right. Bearings have viscous and dry friction, of which the drives compensate a
share from the measured speed; the rest turns wheel and bus against each other as the motor does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sim.components.hooks import refuse_fault
from sim.kernels import Memory, compiled
from sim.quaternion import Vector

AXES, INERTIA, TORQUE_LIMIT, SPEED_LIMIT = 0, 12, 13, 14
SPEEDS, MOMENTUM, MOTORS, WORKS = 15, 19, 22, 26
VISCOUS, DRY, UNCOMPENSATED, MOMENTUM_SIZE = 30, 31, 32, 33
SIZE = 34
# Speed under which dry friction fades to nothing at rest.
_DRY_FADES_RAD_S = 0.5


@compiled
def observe(m: Memory) -> None:
    """Momentum in body axes from the speeds in the memory."""
    for axis in range(3):
        total = 0.0
        for k in range(4):
            total += m[AXES + 3 * k + axis] * m[SPEEDS + k]
        m[MOMENTUM + axis] = m[INERTIA] * total
    x, y, z = m[MOMENTUM], m[MOMENTUM + 1], m[MOMENTUM + 2]
    m[MOMENTUM_SIZE] = math.sqrt(x * x + y * y + z * z)


@compiled
def limit(m: Memory, dt_s: float) -> None:
    """Cut the motor torques in the memory to what torque and speed limits allow for `dt_s`."""
    largest = 0.0
    for k in range(4):
        largest = max(largest, abs(m[MOTORS + k]))
    scale = m[TORQUE_LIMIT] / largest if largest > m[TORQUE_LIMIT] else 1.0
    for k in range(4):
        motor = scale * m[MOTORS + k] * m[WORKS + k]
        speed, change = m[SPEEDS + k], motor * dt_s / m[INERTIA]
        if abs(speed + change) > m[SPEED_LIMIT] and speed * change > 0.0:
            room = max(0.0, m[SPEED_LIMIT] - abs(speed))
            motor = math.copysign(room * m[INERTIA] / dt_s, change)
        m[MOTORS + k] = motor


@compiled
def allocate(m: Memory, dt_s: float, tx: float, ty: float, tz: float) -> None:
    """Motor torques that put this torque on the bus, as far as the limits go."""
    for k in range(4):
        a = AXES + 3 * k
        m[MOTORS + k] = -0.75 * (m[a] * tx + m[a + 1] * ty + m[a + 2] * tz)
    limit(m, dt_s)


@compiled
def uncompensated_friction(m: Memory, k: int) -> float:
    """Torque (N m) on wheel `k` that its drive does not compensate; a drive that failed compensates nothing."""
    speed = m[SPEEDS + k]
    dry = m[DRY] * max(-1.0, min(1.0, speed / _DRY_FADES_RAD_S))
    share = m[UNCOMPENSATED] if m[WORKS + k] != 0.0 else 1.0
    return float(-share * (m[VISCOUS] * speed + dry))


class Wheels:
    """The wheels' memory, their faults and telemetry. Without `friction` (viscous, dry, share left) there is none."""

    READINGS: ClassVar[Mapping[str, int]] = {
        "wheels.speed_1_rad_s": SPEEDS,
        "wheels.speed_2_rad_s": SPEEDS + 1,
        "wheels.speed_3_rad_s": SPEEDS + 2,
        "wheels.speed_4_rad_s": SPEEDS + 3,
        "wheels.momentum_Nms": MOMENTUM_SIZE,
    }

    def __init__(
        self,
        axes_B: tuple[Vector, Vector, Vector, Vector],
        inertia_kg_m2: float,
        torque_limit_Nm: float,
        speed_limit_rad_s: float,
        speeds_rad_s: Sequence[float],
        friction: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        self.memory: Memory = np.zeros(SIZE)
        m = self.memory
        m[AXES : AXES + 12] = np.ravel(axes_B)
        m[INERTIA], m[TORQUE_LIMIT], m[SPEED_LIMIT] = inertia_kg_m2, torque_limit_Nm, speed_limit_rad_s
        m[WORKS : WORKS + 4] = 1.0
        m[VISCOUS], m[DRY], m[UNCOMPENSATED] = friction
        self.observe(speeds_rad_s)

    def __repr__(self) -> str:
        return f"Wheels({', '.join(f'{speed:.1f}' for speed in self.memory[SPEEDS : SPEEDS + 4])} rad/s)"

    def observe(self, speeds_rad_s: Sequence[float]) -> None:
        """Take the wheels' speeds (4, rad/s) as the physics left them."""
        self.memory[SPEEDS : SPEEDS + 4] = speeds_rad_s
        observe(self.memory)

    def step(self, dt_s: float, torque_on_bus_B: Vector) -> list[float]:
        """Motor torques (4, N m on the wheels) that put `torque_on_bus_B` (N m) on the bus, as far as the limits go."""
        allocate(self.memory, dt_s, *torque_on_bus_B)
        motors: list[float] = self.memory[MOTORS : MOTORS + 4].tolist()
        return motors

    def limited(self, dt_s: float, motors: Sequence[float]) -> list[float]:
        """Motor torques (4, N m) like `motors` that keep torque and speed limits for the next `dt_s`."""
        self.memory[MOTORS : MOTORS + 4] = motors
        limit(self.memory, dt_s)
        cut: list[float] = self.memory[MOTORS : MOTORS + 4].tolist()
        return cut

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`motor_1` to `motor_4`: that wheel's drive gives no torque, friction slows it. `friction`: `factor` times."""
        if mode == "friction":
            factor = parameters["factor"] if active else 1.0 / parameters["factor"]
            self.memory[VISCOUS] *= factor
            self.memory[DRY] *= factor
        elif mode in ("motor_1", "motor_2", "motor_3", "motor_4"):
            self.memory[WORKS + int(mode[-1]) - 1] = 0.0 if active else 1.0
        else:
            refuse_fault(self, mode)
