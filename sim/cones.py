"""Where the Sun may stand in the body, and turns that keep it there.

Keep-out: the Sun stays away from the camera's boresight. Keep-in: it stays in the field of the fine Sun sensor. A turn
is one rotation about its eigenaxis where that keeps both. Otherwise it takes two: one that carries the Sun in the body
along the great circle to where the goal has it, and one about the Sun line; the first stays in the sensor's field,
which is convex, the second moves the Sun nowhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from sim.config import SpacecraftConfig
from sim.quaternion import (
    Quaternion,
    Vector,
    about,
    axis_angle,
    conjugate,
    cross,
    dot,
    multiply,
    rotate_inverse,
    unit,
)

CAMERA_BORESIGHT_B: Vector = (0.0, 0.0, 1.0)
SUN_SENSOR_AXIS_B: Vector = (math.sqrt(0.5), 0.0, -math.sqrt(0.5))
_SAMPLE_RAD = math.radians(1.5)
SLACK_RAD = 2.0e-3
"""Under a cone's edge by this much is still on it: what the filter does not know, and the Sun moves in a turn."""


@dataclass(frozen=True, slots=True)
class Cones:
    """The two cones (rad) of one spacecraft."""

    camera_rad: float
    sensor_rad: float

    @classmethod
    def of(cls, config: SpacecraftConfig) -> Cones:
        """Those of a configuration."""
        return cls(config.camera_sun_exclusion_rad, config.sun_sensor_half_field_rad)

    def margin_rad(self, sun_B: Vector) -> float:
        """How far inside both cones the Sun (unit vector, body axes) is; negative: outside of one."""
        return min(
            _angle(CAMERA_BORESIGHT_B, sun_B) - self.camera_rad, self.sensor_rad - _angle(SUN_SENSOR_AXIS_B, sun_B)
        )

    def complaint(self, sun_B: Vector) -> str | None:
        """What is wrong with the Sun there, or None."""
        camera, sensor = _angle(CAMERA_BORESIGHT_B, sun_B), _angle(SUN_SENSOR_AXIS_B, sun_B)
        if camera < self.camera_rad - SLACK_RAD:
            return (
                f"the Sun {_degrees(camera)} from the camera's boresight, expected at least {_degrees(self.camera_rad)}"
            )
        if sensor > self.sensor_rad + SLACK_RAD:
            return (
                f"the Sun {_degrees(sensor)} from the Sun sensor's axis, expected at most {_degrees(self.sensor_rad)}"
            )
        return None

    def way(self, here_IB: Quaternion, goal_IB: Quaternion, sun_I: Vector) -> tuple[Quaternion, ...] | None:
        """Attitudes to turn to one after the other, the goal last; None when no way keeps the cones.

        From outside of a cone the way is straight: there is nothing left to keep.
        """
        straight = (goal_IB,)
        if self.margin_rad(rotate_inverse(here_IB, sun_I)) < -SLACK_RAD or self._keeps(here_IB, goal_IB, sun_I):
            return straight
        via_IB = _with_sun_as_at(here_IB, goal_IB, sun_I)
        return (
            (via_IB, goal_IB) if self._keeps(here_IB, via_IB, sun_I) and self._keeps(via_IB, goal_IB, sun_I) else None
        )

    def _keeps(self, here_IB: Quaternion, there_IB: Quaternion, sun_I: Vector) -> bool:
        axis, angle = axis_angle(multiply(conjugate(here_IB), there_IB))
        count = max(1, math.ceil(angle / _SAMPLE_RAD))
        for k in range(count + 1):
            between_IB = multiply(here_IB, about(axis, angle * k / count))
            if self.margin_rad(rotate_inverse(between_IB, sun_I)) < -SLACK_RAD:
                return False
        return True


def legs_rad(here_IB: Quaternion, way: tuple[Quaternion, ...]) -> tuple[float, ...]:
    """The angle of each rotation of a way."""
    ends = (here_IB, *way)
    return tuple(axis_angle(multiply(conjugate(a), b))[1] for a, b in pairwise(ends))


def _with_sun_as_at(here_IB: Quaternion, goal_IB: Quaternion, sun_I: Vector) -> Quaternion:
    """The attitude nearest to `here_IB` that has the Sun where the goal has it in the body."""
    now_B, then_B = rotate_inverse(here_IB, sun_I), rotate_inverse(goal_IB, sun_I)
    axis = cross(then_B, now_B)
    size = math.sqrt(dot(axis, axis))
    if size < 1e-9:
        return here_IB
    return multiply(here_IB, about(unit(axis), math.atan2(size, dot(now_B, then_B))))


def _angle(a: Vector, b: Vector) -> float:
    across = cross(a, b)
    return math.atan2(math.sqrt(dot(across, across)), dot(a, b))


def _degrees(angle_rad: float) -> str:
    return f"{math.degrees(angle_rad):.1f} deg"
