"""Where things are, and how the spacecraft has to stand to look at them.

Spacecraft and bodies move about the Sun on two-body orbits. What thrust adds to the spacecraft's velocity is told by
`gain`, now and then: the orbit goes on from the state with the gain (drift and kick: J. Wisdom, M. Holman, "Symplectic
maps for the n-body problem", Astronomical Journal 102, 1991). Directions are unit vectors in an inertial frame.

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
from sim.ground import STATIONS
from sim.orbits import AU_M, LIGHT_M_S, Orbit
from sim.quaternion import Quaternion, Vector, angle_between, cross, dot, from_axes, rotate_inverse, unit

CAMERA_BORESIGHT_B: Vector = (0.0, 0.0, 1.0)
THRUST_AXIS_B: Vector = (0.0, 0.0, 1.0)
ANTENNA_AXIS_B: Vector = (1.0, 0.0, 0.0)
WING_AXIS_B: Vector = (0.0, 1.0, 0.0)

POINTING_AXIS_B: Mapping[str, Vector] = MappingProxyType(
    {"earth": ANTENNA_AXIS_B, "thrust": THRUST_AXIS_B, "asteroid": CAMERA_BORESIGHT_B}
)


class Environment:
    """The sky of one configuration: the Sun, the targets, and the attitude that each target asks for.

    Every function takes the simulation time (s). `ConfigurationError` for a target that the sky does not have.
    """

    def __init__(self, config: SpacecraftConfig) -> None:
        self.targets: Mapping[str, Target] = MappingProxyType({target.name: target for target in config.targets})
        self.earth = next(target.name for target in config.targets if target.kind == "earth")
        self._stations = tuple(STATIONS[name] for name in config.ground_stations.split())
        self._least_elevation_rad, self._sidereal_rad = config.station_elevation_rad, config.sidereal_angle_rad
        self._orbit = config.orbit.orbit() if config.orbit else Orbit.circular(_away(config))
        self._since_s, self._gained_m_s = 0.0, (0.0, 0.0, 0.0)
        self._last: tuple[float, Vector] = (0.0, self._orbit.position_m)
        self._bodies = {t.name: orbit for t in config.targets if (orbit := self._orbit_of(t)) is not None}
        self._fixed = {t.name: unit(t.direction_I) for t in config.targets if t.name not in self._bodies}
        self._seen: dict[str, tuple[float, Vector]] = {}
        self._first_m = {name: self.distance_m(name, 0.0) for name in self._bodies}
        for name, distance_m in self._first_m.items():
            if distance_m == 0.0:
                raise ConfigurationError(f"targets, {name!r}: expected a place of its own, found the spacecraft's")

    def __repr__(self) -> str:
        return f"Environment({', '.join(self.targets)})"

    def gain(self, time_s: float, velocity_I_m_s: Vector) -> None:
        """All that has been gained over ballistic flight by `time_s`; between two calls at an even rate."""
        x, y, z = self._gained_m_s
        kick = (velocity_I_m_s[0] - x, velocity_I_m_s[1] - y, velocity_I_m_s[2] - z)
        if kick == (0.0, 0.0, 0.0):
            return
        half_s = 0.5 * (time_s - self._since_s)
        position_m, velocity_m_s = self._orbit.at(time_s - self._since_s)
        shift = (half_s * kick[0], half_s * kick[1], half_s * kick[2])
        self._orbit = Orbit(_plus(position_m, shift), _plus(velocity_m_s, kick))
        self._since_s, self._gained_m_s = time_s, velocity_I_m_s
        self._last = (math.nan, position_m)

    def position_I_m(self, time_s: float) -> Vector:
        """Of the spacecraft from the Sun, if nothing thrusts from now on."""
        if self._last[0] != time_s:
            self._last = time_s, self._orbit.at(time_s - self._since_s)[0]
        return self._last[1]

    def sun_direction_I(self, time_s: float) -> Vector:
        """Unit vector to the Sun."""
        x, y, z = unit(self.position_I_m(time_s))
        return (-x, -y, -z)

    def sun_distance_au(self, time_s: float) -> float:
        """Distance of the Sun."""
        return math.hypot(*self.position_I_m(time_s)) / AU_M

    def direction_I(self, target: str, time_s: float) -> Vector:
        """Unit vector to `target`."""
        self._check(target)
        return self._fixed.get(target) or unit(self._offset_m(target, time_s))

    def distance_m(self, target: str, time_s: float) -> float:
        """Distance of `target`, infinite for one that only has a direction."""
        self._check(target)
        return math.hypot(*self._offset_m(target, time_s)) if target in self._bodies else math.inf

    def light_time_s(self, time_s: float) -> float:
        """What a signal takes to the Earth; 0 for an Earth without a distance."""
        return self.distance_m(self.earth, time_s) / LIGHT_M_S if self.earth in self._bodies else 0.0

    def station(self, time_s: float) -> str:
        """A ground station that hears what is sent now, when it arrives; the one that sees it highest, or `none`."""
        x, y, z = self.direction_I(self.earth, time_s)
        arrival_s = time_s + self.light_time_s(time_s)
        heights = [(s.elevation_rad((-x, -y, -z), arrival_s, self._sidereal_rad), s.name) for s in self._stations]
        best = max(heights, default=(-math.inf, ""))
        return best[1] if best[0] >= self._least_elevation_rad else "none"

    def downlink_windows(self, start_s: float, end_s: float) -> tuple[tuple[float, float], ...]:
        """Stretches of sending time (s) in which some station hears, to the minute, within the two times."""
        windows: list[tuple[float, float]] = []
        opened: float | None = None
        for k in range(math.ceil((end_s - start_s) / 60.0) + 1):
            time_s = min(end_s, start_s + 60.0 * k)
            heard = self.station(time_s) != "none"
            if heard and opened is None:
                opened = time_s
            elif not heard and opened is not None:
                windows.append((opened, time_s - 60.0))
                opened = None
        return (*windows, (opened, end_s)) if opened is not None else tuple(windows)

    def telemetry(self, time_s: float) -> dict[str, float | str]:
        """What the ephemeris on board says of Sun, Earth and stations."""
        return {
            "sun.distance_au": self.sun_distance_au(time_s),
            "earth.light_time_s": self.light_time_s(time_s),
            "earth.station": self.station(time_s),
        }

    def angular_diameter_rad(self, target: str, time_s: float) -> float:
        """What the camera sees of `target`: the configured diameter in proportion to how near it has come."""
        at_first = self.targets[target].angular_diameter_rad
        if target not in self._bodies or at_first == 0.0:
            return at_first
        return at_first * self._first_m[target] / self.distance_m(target, time_s)

    def target_attitude_IB(self, target: str, time_s: float) -> Quaternion:
        """Attitude that points the right axis to `target` with the wings' axis across the Sun line."""
        direction_I = self.direction_I(target, time_s)
        return _attitude(self.targets[target].kind, direction_I, self.sun_direction_I(time_s))

    def slew_angle(self, from_target: str, to_target: str, time_s: float) -> float:
        """Angle (rad) of the single rotation from pointing at one target to pointing at the other."""
        return angle_between(self.target_attitude_IB(from_target, time_s), self.target_attitude_IB(to_target, time_s))

    def pointing_error_rad(self, attitude_IB: Quaternion, target: str, time_s: float) -> float:
        """Angle (rad) between the axis that belongs at `target` and its direction; the turn about it is free."""
        axis_B = POINTING_AXIS_B[self.targets[target].kind]
        seen_B = rotate_inverse(attitude_IB, self.direction_I(target, time_s))
        offset = cross(axis_B, seen_B)
        return math.atan2(math.sqrt(dot(offset, offset)), dot(axis_B, seen_B))

    def _orbit_of(self, target: Target) -> Orbit | None:
        if target.orbit is not None:
            return target.orbit.orbit()
        if target.distance_au == 0.0:
            return None
        x, y, z = unit(target.direction_I)
        away_m = target.distance_au * AU_M
        return Orbit.circular(_plus(self._orbit.position_m, (away_m * x, away_m * y, away_m * z)))

    def _offset_m(self, target: str, time_s: float) -> Vector:
        x, y, z = self.position_I_m(time_s)
        if self._seen.get(target, (math.nan,))[0] != time_s:
            self._seen[target] = time_s, self._bodies[target].at(time_s)[0]
        return _plus(self._seen[target][1], (-x, -y, -z))

    def _check(self, target: str) -> None:
        if target not in self.targets:
            raise ConfigurationError(f"target: expected one of {', '.join(self.targets)}, found {target!r}")


def _plus(a: Vector, b: Vector) -> Vector:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _away(config: SpacecraftConfig) -> Vector:
    """Position (m) from the Sun of a spacecraft that sees it in its configured direction and distance."""
    x, y, z = unit(config.sun_direction_I)
    distance_m = -config.sun_distance_au * AU_M
    return (distance_m * x, distance_m * y, distance_m * z)


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
