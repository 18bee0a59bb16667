"""Where things are, and how the spacecraft has to stand to look at them.

Directions are unit vectors in an inertial frame. They are constants of the configuration: over a few days of cruise at
0.6 AU and more they move by less than the planner's margins. Every function takes the time all the same.

Which body axis goes to the target follows from its kind. The free turn about that axis is used for power: the wings'
axis (+Y) is put across the Sun line, so that turning the wings brings their cells to normal incidence. Of the two such
attitudes a camera or thrust target takes the one with the Sun on the antenna side (+X), an Earth target the one with
the Sun behind the camera (towards -Z), so that the camera never looks near the Sun by choice of the turn.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

from sim.config import SpacecraftConfig, Target
from sim.errors import ConfigurationError
from sim.quaternion import Quaternion, Vector, angle_between, cross, dot, from_axes, rotate_inverse, unit

CAMERA_BORESIGHT_B: Vector = (0.0, 0.0, 1.0)
THRUST_AXIS_B: Vector = (0.0, 0.0, 1.0)
ANTENNA_AXIS_B: Vector = (1.0, 0.0, 0.0)
WING_AXIS_B: Vector = (0.0, 1.0, 0.0)

POINTING_AXIS_B: Mapping[str, Vector] = MappingProxyType(
    {"earth": ANTENNA_AXIS_B, "thrust": THRUST_AXIS_B, "asteroid": CAMERA_BORESIGHT_B}
)


class Environment:
    """The sky of one configuration: the Sun, the targets, and the attitude that each target asks for."""

    def __init__(self, config: SpacecraftConfig) -> None:
        self._sun_I = unit(config.sun_direction_I)
        self.sun_distance_au = config.sun_distance_au
        self.targets: Mapping[str, Target] = MappingProxyType({target.name: target for target in config.targets})
        self.earth = next(target.name for target in config.targets if target.kind == "earth")
        self._directions = {target.name: unit(target.direction_I) for target in config.targets}
        self._attitudes = {
            name: _attitude(target.kind, self._directions[name], self._sun_I) for name, target in self.targets.items()
        }

    def __repr__(self) -> str:
        return f"Environment({', '.join(self.targets)})"

    def sun_direction_I(self, time_s: float) -> Vector:
        """Unit vector to the Sun at `time_s`."""
        del time_s
        return self._sun_I

    def direction_I(self, target: str, time_s: float) -> Vector:
        """Unit vector to `target` at `time_s`; `ConfigurationError` for a name that the sky does not have."""
        del time_s
        self._check(target)
        return self._directions[target]

    def target_attitude_IB(self, target: str, time_s: float) -> Quaternion:
        """Attitude that points the right axis to `target` with the wings' axis across the Sun line."""
        del time_s
        self._check(target)
        return self._attitudes[target]

    def slew_angle(self, from_target: str, to_target: str, time_s: float) -> float:
        """Angle (rad) of the single rotation from pointing at one target to pointing at the other."""
        return angle_between(self.target_attitude_IB(from_target, time_s), self.target_attitude_IB(to_target, time_s))

    def pointing_error_rad(self, attitude_IB: Quaternion, target: str, time_s: float) -> float:
        """Angle (rad) between the axis that belongs at `target` and its direction; the turn about it is free."""
        axis_B = POINTING_AXIS_B[self.targets[target].kind]
        seen_B = rotate_inverse(attitude_IB, self.direction_I(target, time_s))
        offset = cross(axis_B, seen_B)
        return math.atan2(math.sqrt(dot(offset, offset)), dot(axis_B, seen_B))

    def _check(self, target: str) -> None:
        if target not in self.targets:
            raise ConfigurationError(f"target: expected one of {', '.join(self.targets)}, found {target!r}")


def wing_angle_rad(sun_B: Vector) -> float:
    """Angle about +Y that turns the cells' normal (+X at angle 0) as near to the Sun as it can come."""
    return math.atan2(-sun_B[2], sun_B[0])


def _across(direction: Vector, sun: Vector) -> Vector:
    """Unit vector across `direction` towards the Sun; any fixed one when the Sun is on that line."""
    along = dot(direction, sun)
    across = (sun[0] - along * direction[0], sun[1] - along * direction[1], sun[2] - along * direction[2])
    if dot(across, across) > 1e-12:
        return unit(across)
    spare = (0.0, 0.0, 1.0) if abs(direction[2]) < 0.9 else (1.0, 0.0, 0.0)
    return unit(cross(direction, spare))


def _attitude(kind: str, direction_I: Vector, sun_I: Vector) -> Quaternion:
    sunward_I = _across(direction_I, sun_I)
    if POINTING_AXIS_B[kind] == ANTENNA_AXIS_B:
        x_I, z_I = direction_I, (-sunward_I[0], -sunward_I[1], -sunward_I[2])
    else:
        x_I, z_I = sunward_I, direction_I
    return from_axes(x_I, cross(z_I, x_I), z_I)
