"""Two-body motion about the Sun: elements, states, and where an orbit is at any time.

Ellipses only. Metres, seconds, inertial axes with the ecliptic as X-Y plane. The propagation is by the difference of
the eccentric anomaly and Lagrange's f and g: R. H. Battin, "An Introduction to the Mathematics and Methods of
Astrodynamics" (AIAA 1999), section 4.5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from sim.errors import ConfigurationError
from sim.quaternion import Vector, cross, dot, unit

SUN_MU_M3_S2 = 1.32712440018e20
AU_M = 1.495978707e11
LIGHT_M_S = 299_792_458.0
_DIGITS = 1e-14
_ITERATIONS = 50


@dataclass(frozen=True, slots=True)
class Elements:
    """Kepler's six of a heliocentric ellipse at simulation time 0, angles in degrees.

    `ConfigurationError` for no ellipse: a semimajor axis not above 0, an eccentricity outside 0 to under 1.
    """

    semimajor_axis_au: float
    eccentricity: float = 0.0
    inclination_deg: float = 0.0
    node_deg: float = 0.0
    periapsis_deg: float = 0.0
    mean_anomaly_deg: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            if not math.isfinite(getattr(self, field.name)):
                raise ConfigurationError(f"{field.name}: expected a finite number, found {getattr(self, field.name)}")
        if self.semimajor_axis_au <= 0.0:
            raise ConfigurationError(f"semimajor_axis_au: expected more than 0, found {self.semimajor_axis_au}")
        if not 0.0 <= self.eccentricity < 1.0:
            raise ConfigurationError(f"eccentricity: expected 0 to under 1, found {self.eccentricity}")

    def orbit(self) -> Orbit:
        """The orbit with these elements."""
        a, e = self.semimajor_axis_au * AU_M, self.eccentricity
        anomaly = _eccentric_anomaly(math.radians(self.mean_anomaly_deg), e)
        c, s = math.cos(anomaly), math.sin(anomaly)
        flat = math.sqrt(1.0 - e * e)
        speed = math.sqrt(SUN_MU_M3_S2 / a) / (1.0 - e * c)
        p, q = self._axes()
        return Orbit(_sum(a * (c - e), p, a * flat * s, q), _sum(-speed * s, p, speed * flat * c, q))

    def _axes(self) -> tuple[Vector, Vector]:
        """Unit vectors to the periapsis and a quarter turn ahead of it."""
        cn, sn = _cos_sin(self.node_deg)
        ci, si = _cos_sin(self.inclination_deg)
        cw, sw = _cos_sin(self.periapsis_deg)
        return (
            (cn * cw - sn * sw * ci, sn * cw + cn * sw * ci, sw * si),
            (-cn * sw - sn * cw * ci, -sn * sw + cn * cw * ci, cw * si),
        )


@dataclass(frozen=True, slots=True)
class Orbit:
    """A state at time 0 that moves about the Sun: position (m) and velocity (m/s), inertial axes.

    `ConfigurationError` for a state at the Sun's centre or one that leaves it for good.
    """

    position_m: Vector
    velocity_m_s: Vector

    def __post_init__(self) -> None:
        distance = math.sqrt(dot(self.position_m, self.position_m))
        speed_squared = dot(self.velocity_m_s, self.velocity_m_s)
        if not distance > 0.0 or not speed_squared < 2.0 * SUN_MU_M3_S2 / distance:
            raise ConfigurationError(
                f"orbit: expected an ellipse about the Sun, found position {self.position_m} m, "
                f"velocity {self.velocity_m_s} m/s"
            )

    @classmethod
    def circular(cls, position_m: Vector) -> Orbit:
        """The circular orbit through a position, prograde and as near to the ecliptic as it can be."""
        distance = math.sqrt(dot(position_m, position_m))
        ahead = cross((0.0, 0.0, 1.0), position_m)
        if dot(ahead, ahead) < 1e-12 * distance * distance:
            ahead = (0.0, 1.0, 0.0)
        speed = math.sqrt(SUN_MU_M3_S2 / distance)
        x, y, z = unit(ahead)
        return cls(position_m, (speed * x, speed * y, speed * z))

    def at(self, time_s: float) -> tuple[Vector, Vector]:
        """Position (m) and velocity (m/s) at `time_s`."""
        r0, v0 = self.position_m, self.velocity_m_s
        distance0 = math.sqrt(dot(r0, r0))
        a = 1.0 / (2.0 / distance0 - dot(v0, v0) / SUN_MU_M3_S2)
        root = math.sqrt(SUN_MU_M3_S2 * a)
        sigma, share = dot(r0, v0) / root, 1.0 - distance0 / a
        turned = _anomaly_difference(root / (a * a) * time_s, share, sigma)
        c, s = math.cos(turned), math.sin(turned)
        distance = a * (1.0 - share * c + sigma * s)
        f = 1.0 - a / distance0 * (1.0 - c)
        g = (a * sigma * (1.0 - c) + distance0 * s) * a / root
        df, dg = -root / (distance * distance0) * s, 1.0 - a / distance * (1.0 - c)
        return _sum(f, r0, g, v0), _sum(df, r0, dg, v0)


def _sum(p: float, a: Vector, q: float, b: Vector) -> Vector:
    return (p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2])


def _cos_sin(angle_deg: float) -> tuple[float, float]:
    return math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))


def _eccentric_anomaly(mean_rad: float, eccentricity: float) -> float:
    """E of M = E - e sin E: the difference from periapsis, where share = e and sigma = 0."""
    return _anomaly_difference(mean_rad, eccentricity, 0.0)


def _anomaly_difference(mean_rad: float, share: float, sigma: float) -> float:
    """x of M = x - share sin x + sigma (1 - cos x); rising in x, so Newton's steps are kept within their bracket."""
    size = math.hypot(share, sigma)
    low, high = mean_rad - 2.0 * size - 1e-9, mean_rad + 2.0 * size + 1e-9
    x = mean_rad
    for _ in range(_ITERATIONS):
        residual = x - share * math.sin(x) + sigma * (1.0 - math.cos(x)) - mean_rad
        low, high = (low, x) if residual > 0.0 else (x, high)
        step = residual / (1.0 - share * math.cos(x) + sigma * math.sin(x))
        following = x - step
        if not low <= following <= high:
            following = 0.5 * (low + high)
        if abs(following - x) <= _DIGITS * max(1.0, abs(x)):
            return following
        x = following
    return x
