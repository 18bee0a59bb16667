"""Attitude sensors and the filter that makes one attitude of them.

Gyro: angle turned over the last period (angle random walk) and rate, both with a bias that walks. Star tracker: the
attitude with a noise of its own about each body axis; blind when slewing faster than its limit, with the Sun in its
exclusion cone, and without power. Sun sensors: the Sun's direction, all round. All noises are white and Gaussian at the
control rate, drawn in blocks from one generator, so that how time is cut makes no difference.

The filter's attitude and its bias-free gyro rate are what control and telemetry see; `attitude_source = "truth"` of the
configuration bypasses them. Numbers are assumptions of the class of instrument.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.random import Generator

from sim import filter_law as law
from sim.components.hooks import refuse_fault
from sim.config import SpacecraftConfig
from sim.kernels import Memory
from sim.quaternion import Quaternion
from sim.star_tracker import StarTracker

TRACKER_AXIS_B = (-1.0, 0.0, 0.0)
_BLOCK = 256


class Sensors:
    """Gyro, star tracker and Sun sensors."""

    READINGS: ClassVar[Mapping[str, int]] = {
        f"sun_sensor.{axis}": law.SUN_READING + place for place, axis in enumerate("xyz")
    }

    def __init__(
        self,
        config: SpacecraftConfig,
        generator: Generator,
        attitude_IB: Quaternion,
        star_tracker: StarTracker | None = None,
    ) -> None:
        self._generator = generator
        self._star_tracker = star_tracker
        self._tracker_works = True
        self.memory: Memory = np.zeros(law.SENSORS_SIZE)
        s = self.memory
        s[law.ANGLE_NOISE] = config.gyro_angle_walk_rad_rs
        s[law.RATE_NOISE] = config.gyro_rate_noise_rad_s
        s[law.BIAS_WALK] = config.gyro_bias_walk_rad_s_rs
        s[law.TRACKER_NOISE : law.TRACKER_NOISE + 3] = config.tracker_noise_rad
        s[law.SUN_NOISE] = config.sun_sensor_noise_rad
        s[law.TRACKER_RATE_LIMIT] = config.tracker_rate_limit_rad_s
        s[law.TRACKER_AXIS : law.TRACKER_AXIS + 3] = TRACKER_AXIS_B
        s[law.SUN_EXCLUSION_COS] = math.cos(config.tracker_sun_exclusion_rad)
        s[law.TRACKER_POWERED] = s[law.TRACKER_WORKS] = s[law.SUN_WORKS] = 1.0
        s[law.LAST_TRUTH : law.LAST_TRUTH + 4] = attitude_IB
        s[law.GYRO_BIAS : law.GYRO_BIAS + 3] = config.gyro_bias_rad_s * generator.standard_normal(3)
        s[law.TRACKER_VALID] = s[law.SUN_SEEN] = 1.0
        self._block = np.empty((_BLOCK, law.NOISE_COLUMNS))
        self._next = _BLOCK

    def __repr__(self) -> str:
        return f"Sensors(tracker {self.tracker_state})"

    @property
    def tracker_state(self) -> str:
        """`tracking`, `blind` (too fast, or the Sun too near), `failed` or `off`."""
        s = self.memory
        if s[law.TRACKER_POWERED] == 0.0:
            return "off"
        if s[law.TRACKER_WORKS] == 0.0:
            return "failed"
        return "tracking" if s[law.TRACKER_VALID] else "blind"

    def noise(self) -> tuple[Memory, int]:
        """A block of standard normal numbers and the row in it for the next reading."""
        if self._next == _BLOCK:
            self._generator.standard_normal(out=self._block)
            self._next = 0
        self._next += 1
        if self._star_tracker is not None:
            self._measure(self._star_tracker, self._block[self._next - 1])
        return self._block, self._next - 1

    def _measure(self, star_tracker: StarTracker, noise: Memory) -> None:
        """What a picture of the sky gets wrong takes the place of the tracker's noise; without a fix there is none."""
        s = self.memory
        w, x, y, z = s[law.LAST_TRUTH : law.LAST_TRUTH + 4].tolist()
        error_B = star_tracker.error_B((w, x, y, z))
        s[law.TRACKER_WORKS] = self._tracker_works and error_B is not None
        if error_B is not None:
            noise[law.TRACKER_COLUMNS] = error_B / s[law.TRACKER_NOISE : law.TRACKER_NOISE + 3]

    def telemetry(self) -> dict[str, str]:
        """State of the star tracker."""
        return {"tracker.state": self.tracker_state}

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`tracker_fails`, `sun_fails`: no readings. `bias_jump`: the gyro's bias steps by `size` deg/h an axis."""
        s = self.memory
        if mode == "tracker_fails":
            self._tracker_works = not active
            s[law.TRACKER_WORKS] = self._tracker_works
        elif mode == "sun_fails":
            s[law.SUN_WORKS] = 0.0 if active else 1.0
        elif mode == "bias_jump":
            size = parameters["size"] * math.radians(1.0) / 3600.0
            s[law.GYRO_BIAS : law.GYRO_BIAS + 3] += size if active else -size
        else:
            refuse_fault(self, mode)


class Estimator:
    """The filter: starts converged, with errors drawn from the covariance that it starts with."""

    READINGS: ClassVar[Mapping[str, int]] = {"acs.estimate_sigma_rad": law.SIGMA}

    def __init__(
        self, config: SpacecraftConfig, generator: Generator, attitude_IB: Quaternion, gyro_bias_rad_s: Memory
    ) -> None:
        self.memory: Memory = np.zeros(law.FILTER_SIZE)
        f = self.memory
        sigma = np.repeat((config.initial_attitude_error_rad, config.initial_bias_error_rad_s), 3)
        drawn = sigma * generator.standard_normal(6)
        f[law.ESTIMATE : law.ESTIMATE + 4] = attitude_IB
        law.turn_estimate(f, float(drawn[0]), float(drawn[1]), float(drawn[2]))
        f[law.BIAS : law.BIAS + 3] = gyro_bias_rad_s + drawn[3:]
        f[law.COVARIANCE : law.COVARIANCE + 36] = np.diag(sigma**2).ravel()
        f[law.SIGMA] = float(np.linalg.norm(sigma[:3]))

    def __repr__(self) -> str:
        return f"Estimator(within {self.sigma_rad:.2g} rad)"

    @property
    def attitude_IB(self) -> Quaternion:
        """Estimated attitude, body to inertial."""
        w, x, y, z = self.memory[law.ESTIMATE : law.ESTIMATE + 4].tolist()
        return (w, x, y, z)

    @property
    def sigma_rad(self) -> float:
        """Standard deviation that the filter gives its attitude: root of the sum over the axes."""
        return float(self.memory[law.SIGMA])
