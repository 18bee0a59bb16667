"""Attitude control through the reaction wheels: eigenaxis slews under a rate and an acceleration limit, then holding.

A new target first waits for any rate left from a broken-off slew to be braked. Then the whole way is one rotation
about the eigenaxis; a reference attitude runs along it (accelerate, cruise, brake) and quaternion feedback keeps the
spacecraft on the reference. The law is feedback on the vector part of the error quaternion with gyroscopic
decoupling and the reference's acceleration fed forward: B. Wie, H. Weiss, A. Arapostathis, "Quaternion feedback
regulator for spacecraft eigenaxis rotations", J. Guidance, Control, and Dynamics 12(3), 1989; for this law with
gains in proportion to the inertia the rotation stays on the eigenaxis.

The state is settled once error and rate stay under their thresholds for the whole hold time, and until one of them
exceeds twice its threshold.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from sim.components.hooks import refuse_fault
from sim.config import SpacecraftConfig
from sim.quaternion import Quaternion, Vector, about, axis_angle, conjugate, multiply

BRAKED_RATE_RAD_S = 1.0e-4
_BRAKE_GAIN_PER_S = 0.18
# Over 210 slews (10 to 180 degrees, wheels up to 440 rad/s) feedback and the wings coming to rest added 0 to 38 s to
# the ideal profile and the hold time.
_EARLIEST_S = -10.0
_LATEST_S = 60.0


@dataclass(frozen=True, slots=True)
class SlewBounds:
    """Seconds from the pointing command to settled: never less than `lower`, never more than `upper`."""

    lower_s: int
    upper_s: int


def profile_duration_s(angle_rad: float, config: SpacecraftConfig) -> float:
    """Duration of the ideal profile: trapezoid in rate, or triangle where the angle is too small to reach the limit."""
    rate, acceleration = config.slew_rate_limit_rad_s, config.slew_acceleration_limit_rad_s2
    if angle_rad >= rate * rate / acceleration:
        return angle_rad / rate + rate / acceleration
    return 2.0 * math.sqrt(angle_rad / acceleration)


def slew_bounds(angle_rad: float, config: SpacecraftConfig) -> SlewBounds:
    """Bounds of a healthy slew from rest, as long as no wheel comes to its speed limit.

    The lower one lets the spacecraft be within the error threshold when it starts and when it ends.
    """
    way_rad = max(0.0, angle_rad - 2.0 * config.settle_error_rad)
    lower = config.settle_hold_s + max(0.0, profile_duration_s(way_rad, config) + _EARLIEST_S)
    upper = config.settle_hold_s + profile_duration_s(angle_rad, config) + _LATEST_S
    return SlewBounds(math.floor(lower), math.ceil(upper))


def _small_angle(target_IB: Quaternion, attitude_IB: Quaternion) -> float:
    """Angle (rad) between two attitudes; by the vector part too, as the scalar one has no digits for small angles."""
    tw, tx, ty, tz = target_IB
    w, x, y, z = attitude_IB
    ex = tw * x - tx * w - ty * z + tz * y
    ey = tw * y + tx * z - ty * w - tz * x
    ez = tw * z - tx * y + ty * x - tz * w
    return 2.0 * math.atan2(math.sqrt(ex * ex + ey * ey + ez * ez), abs(tw * w + tx * x + ty * y + tz * z))


class AttitudeControl:
    """The controller's memory: target, reference along the slew, settling clock. One `step` a control period."""

    def __init__(self, config: SpacecraftConfig, inertia_kg_m2: Vector, attitude_IB: Quaternion, target: str) -> None:
        self._config = config
        self._inertia = inertia_kg_m2
        self._stiffness = config.control_bandwidth_rad_s**2
        self._damping = 2.0 * config.control_damping * config.control_bandwidth_rad_s
        self._start_IB = attitude_IB
        self._axis: Vector = (1.0, 0.0, 0.0)
        self._way_rad = 0.0
        self._way_done_rad = 0.0
        self._way_rate_rad_s = 0.0
        self._braking = False
        self._reference_IB = attitude_IB
        self._target_IB = attitude_IB
        self._attitude_IB = attitude_IB
        self._rate_B: Vector = (0.0, 0.0, 0.0)
        self._quiet_s = float(config.settle_hold_s)
        self._rate_factor = 1.0
        self.mode = "standby"
        self.target = target
        self.settled = True
        self.error_rad = 0.0
        self.rate_rad_s = 0.0

    def __repr__(self) -> str:
        return f"AttitudeControl({self.mode}, {self.target}, {self.state})"

    @property
    def state(self) -> str:
        """`settled` or `slewing`."""
        return "settled" if self.settled else "slewing"

    def point(self, mode: str, target: str, target_IB: Quaternion) -> None:
        """Go to `target_IB` and hold it. The target and mode already held stay as they are, settled if they were."""
        same = target == self.target and target_IB == self._target_IB
        self.mode = mode
        if same:
            return
        self.target = target
        self._target_IB = target_IB
        self.settled = False
        self._quiet_s = 0.0
        self._braking = True
        self.error_rad = _small_angle(target_IB, self._attitude_IB)

    def observe(self, dt_s: float, attitude_IB: Quaternion, rate_B: Vector) -> None:
        """See where the spacecraft is after `dt_s` more, and judge whether it is settled."""
        wx, wy, wz = rate_B
        self._attitude_IB = attitude_IB
        self._rate_B = rate_B
        self.rate_rad_s = math.sqrt(wx * wx + wy * wy + wz * wz)
        self.error_rad = _small_angle(self._target_IB, attitude_IB)
        config = self._config
        slack = 2.0 if self.settled else 1.0
        if self.error_rad > slack * config.settle_error_rad or self.rate_rad_s > slack * config.settle_rate_rad_s:
            self._quiet_s = 0.0
            self.settled = False
        elif not self.settled:
            self._quiet_s += dt_s
            self.settled = self._quiet_s >= config.settle_hold_s

    def step(self, dt_s: float, wheel_momentum_B: Vector) -> Vector:
        """Torque (N m, body axes) that the wheels should put on the bus for the next `dt_s`."""
        attitude_IB, rate_B = self._attitude_IB, self._rate_B
        wx, wy, wz = rate_B
        if self._braking and self.rate_rad_s <= BRAKED_RATE_RAD_S:
            self._plan(attitude_IB)
        ax, ay, az = self._brake(rate_B) if self._braking else self._follow(dt_s, attitude_IB, rate_B)
        jx, jy, jz = self._inertia
        hx = jx * wx + wheel_momentum_B[0]
        hy = jy * wy + wheel_momentum_B[1]
        hz = jz * wz + wheel_momentum_B[2]
        return (
            jx * ax + wy * hz - wz * hy,
            jy * ay + wz * hx - wx * hz,
            jz * az + wx * hy - wy * hx,
        )

    def _plan(self, attitude_IB: Quaternion) -> None:
        self._braking = False
        self._start_IB = attitude_IB
        self._axis, self._way_rad = axis_angle(multiply(conjugate(attitude_IB), self._target_IB))
        self._way_done_rad = 0.0
        self._way_rate_rad_s = 0.0
        self._reference_IB = attitude_IB

    def _brake(self, rate_B: Vector) -> Vector:
        wanted = _BRAKE_GAIN_PER_S * self.rate_rad_s
        gain = _BRAKE_GAIN_PER_S * min(1.0, self._config.slew_acceleration_limit_rad_s2 / max(wanted, 1e-12))
        return (-gain * rate_B[0], -gain * rate_B[1], -gain * rate_B[2])

    def _follow(self, dt_s: float, attitude_IB: Quaternion, rate_B: Vector) -> Vector:
        rate, acceleration = self._way_rate_rad_s, 0.0
        rw, rx, ry, rz = self._reference_IB
        w, x, y, z = attitude_IB
        scalar = rw * w + rx * x + ry * y + rz * z
        sign = 2.0 if scalar >= 0.0 else -2.0
        ex = sign * (rw * x - rx * w - ry * z + rz * y)
        ey = sign * (rw * y + rx * z - ry * w - rz * x)
        ez = sign * (rw * z - rx * y + ry * x - rz * w)
        if self._way_done_rad < self._way_rad:
            acceleration = self._advance_reference(dt_s)
        nx, ny, nz = self._axis
        k, d = self._stiffness, self._damping
        return (
            acceleration * nx - k * ex - d * (rate_B[0] - rate * nx),
            acceleration * ny - k * ey - d * (rate_B[1] - rate * ny),
            acceleration * nz - k * ez - d * (rate_B[2] - rate * nz),
        )

    def _advance_reference(self, dt_s: float) -> float:
        """Move the reference on by `dt_s`; the acceleration it takes (rad/s2), constant over the step."""
        limit = self._config.slew_acceleration_limit_rad_s2
        left = self._way_rad - self._way_done_rad
        rate = self._way_rate_rad_s
        # The fastest new rate v that can still be braked in whole steps: v^2/2a of ideal braking, and v dt for this
        # step's own share and for the last step that is not a whole one, have to fit into what is left.
        room = left - 0.5 * rate * dt_s
        stoppable = limit * (math.sqrt(dt_s * dt_s + 2.0 * max(room, 0.0) / limit) - dt_s)
        wanted = min(self._config.slew_rate_limit_rad_s * self._rate_factor, rate + limit * dt_s, stoppable)
        new = max(wanted, rate - limit * dt_s, 0.0)
        done = self._way_done_rad + 0.5 * (rate + new) * dt_s
        if self._way_rad - done < 1e-9 or (new < 1e-9 and rate < 1e-9):
            done, new = self._way_rad, 0.0
        self._way_done_rad = done
        self._way_rate_rad_s = new
        self._reference_IB = multiply(self._start_IB, about(self._axis, done))
        return (new - rate) / dt_s

    def telemetry(self) -> dict[str, float | str]:
        """Mode, target, state, error and rate as the last step saw them."""
        return {
            "acs.mode": self.mode,
            "acs.target": self.target,
            "acs.state": self.state,
            "acs.error_rad": self.error_rad,
            "acs.rate_rad_s": self.rate_rad_s,
        }

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`slow_slew`: the reference runs at `factor` of the rate limit."""
        if mode != "slow_slew":
            refuse_fault(self, mode)
        self._rate_factor = parameters["factor"] if active else 1.0
