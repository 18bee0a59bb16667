"""Attitude control: eigenaxis slews under a rate and an acceleration limit, then holding.

A new target first waits for any rate left from a broken-off slew to be braked. Then the whole way is one rotation
about the eigenaxis; a reference attitude runs along it (accelerate, cruise, brake) and quaternion feedback keeps the
spacecraft on the reference. The law is feedback on the vector part of the error quaternion with gyroscopic
decoupling and the reference's acceleration fed forward: B. Wie, H. Weiss, A. Arapostathis, "Quaternion feedback
regulator for spacecraft eigenaxis rotations", J. Guidance, Control, and Dynamics 12(3), 1989; for this law with
gains in proportion to the inertia the rotation stays on the eigenaxis.

The state is settled once error and rate stay under their thresholds for the whole hold time, and until one of them
exceeds twice its threshold. The law itself is in `sim.control_law`; here are its memory and its commands.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sim import control_law as law
from sim.components.hooks import refuse_fault
from sim.cones import SLACK_RAD
from sim.config import SpacecraftConfig
from sim.kernels import Memory
from sim.quaternion import Quaternion, Vector, about, multiply, unit

SUN = "sun"
"""What Sun standby calls its target."""
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


class AttitudeControl:
    """The target, and the law's memory: reference along the slew, settling clock."""

    READINGS: ClassVar[Mapping[str, int]] = {
        "acs.error_rad": law.ERROR,
        "acs.rate_rad_s": law.RATE_SIZE,
        "acs.sun_from_camera_rad": law.FROM_CAMERA,
        "acs.sun_from_sensor_rad": law.FROM_SENSOR,
    }

    def __init__(self, config: SpacecraftConfig, inertia_kg_m2: Vector, attitude_IB: Quaternion, target: str) -> None:
        self.memory: Memory = np.zeros(law.SIZE)
        m = self.memory
        m[law.STIFFNESS] = config.control_bandwidth_rad_s**2
        m[law.DAMPING] = 2.0 * config.control_damping * config.control_bandwidth_rad_s
        m[law.RATE_LIMIT] = config.slew_rate_limit_rad_s
        m[law.ACCELERATION_LIMIT] = config.slew_acceleration_limit_rad_s2
        m[law.SETTLE_ERROR] = config.settle_error_rad
        m[law.SETTLE_RATE] = config.settle_rate_rad_s
        m[law.SETTLE_HOLD] = m[law.QUIET_S] = config.settle_hold_s
        m[law.SPIN], m[law.SUN_ERROR] = config.sun_standby_spin_rad_s, config.sun_standby_error_rad
        m[law.SUN_RATE] = config.sun_standby_rate_rad_s
        m[law.SUN_B] = m[law.CONES_KEPT] = 1.0
        m[law.CAMERA_LEAST] = config.camera_sun_exclusion_rad - SLACK_RAD
        m[law.SENSOR_MOST] = config.sun_sensor_half_field_rad + SLACK_RAD
        m[law.INERTIA : law.INERTIA + 3] = inertia_kg_m2
        for place in (law.ATTITUDE, law.START, law.REFERENCE, law.TARGET):
            m[place : place + 4] = attitude_IB
        m[law.AXIS] = m[law.RATE_FACTOR] = m[law.SETTLED] = 1.0
        self.target = target

    def __repr__(self) -> str:
        return f"AttitudeControl({self.target}, {self.state})"

    @property
    def settled(self) -> bool:
        """Error and rate have been small for the hold time."""
        return bool(self.memory[law.SETTLED])

    @property
    def state(self) -> str:
        """`settled` or `slewing`."""
        return "settled" if self.memory[law.SETTLED] else "slewing"

    @property
    def error_rad(self) -> float:
        """Angle to the target's attitude, as last observed."""
        return float(self.memory[law.ERROR])

    @property
    def rate_rad_s(self) -> float:
        """Size of the angular rate, as last observed."""
        return float(self.memory[law.RATE_SIZE])

    @property
    def attitude_IB(self) -> Quaternion:
        """The attitude as last observed."""
        w, x, y, z = self.memory[law.ATTITUDE : law.ATTITUDE + 4].tolist()
        return (w, x, y, z)

    @property
    def rest_IB(self) -> Quaternion:
        """Where it comes to rest if it brakes from now on: turned on by half the rate over the limit, and a little."""
        rate_B = self.memory[law.RATE : law.RATE + 3].tolist()
        size = math.sqrt(sum(part * part for part in rate_B))
        if size <= law.BRAKED_RATE_RAD_S:
            return self.attitude_IB
        turned = 0.5 * size * size / self.memory[law.ACCELERATION_LIMIT] + law.BRAKE_TAIL_RAD
        return multiply(self.attitude_IB, about(unit((rate_B[0], rate_B[1], rate_B[2])), turned))

    def point(self, target: str, way: tuple[Quaternion, ...]) -> None:
        """Turn along one or two attitudes to the last of them, the target's, and hold it. One already held stays."""
        if target == self.target:
            return
        self.target = target
        m = self.memory
        m[law.SUN_MODE] = 0.0
        m[law.HAS_VIA] = float(len(way) > 1)
        m[law.VIA : law.VIA + 4] = way[0]
        m[law.TARGET : law.TARGET + 4] = way[-1]
        m[law.SETTLED] = m[law.QUIET_S] = 0.0
        m[law.BRAKING] = 1.0
        m[law.ERROR] = law.small_angle(m, law.TARGET)

    def seek_sun(self) -> None:
        """Turn +X to the Sun by the Sun sensors and spin about it, whatever the attitude."""
        if self.target == SUN:
            return
        self.target = SUN
        m = self.memory
        m[law.SUN_MODE] = 1.0
        m[law.BRAKING] = m[law.HAS_VIA] = m[law.SETTLED] = m[law.QUIET_S] = 0.0

    def track(self, target_IB: Quaternion) -> None:
        """Where the target asks to look by now; a slew under way ends first where it was to end."""
        m = self.memory
        if m[law.BRAKING] == 0.0 and m[law.HAS_VIA] == 0.0 and m[law.DONE] >= m[law.WAY]:
            m[law.TARGET : law.TARGET + 4] = m[law.REFERENCE : law.REFERENCE + 4] = target_IB

    def observe(self, dt_s: float, attitude_IB: Quaternion, rate_B: Vector) -> None:
        """See where the spacecraft is after `dt_s` more, and judge whether it is settled."""
        self.memory[law.ATTITUDE : law.ATTITUDE + 4] = attitude_IB
        self.memory[law.RATE : law.RATE + 3] = rate_B
        law.observe(self.memory, dt_s)

    def step(self, dt_s: float, wheel_momentum_B: Vector) -> Vector:
        """Torque (N m, body axes) that the actuators should put on the bus for the next `dt_s`."""
        x, y, z = law.step(self.memory, dt_s, *wheel_momentum_B)
        return (x, y, z)

    def telemetry(self) -> dict[str, str]:
        """Target and state; errors and rate are among the readings."""
        return {"acs.target": self.target, "acs.state": self.state}

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`slow_slew`: the reference runs at `factor` of the rate limit."""
        if mode != "slow_slew":
            refuse_fault(self, mode)
        self.memory[law.RATE_FACTOR] = parameters["factor"] if active else 1.0
