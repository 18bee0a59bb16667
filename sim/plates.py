"""Frames reduced as a mission would: centroids, the plate solved against the catalogue, the target's direction.

Extraction and solving are tetra3rs's. A narrow field is solved from where the spacecraft believes that it looks, a wide
one without knowing anything. Angles for the solver are longitude and latitude of the inertial frame.
"""

from __future__ import annotations

import math
import struct
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import tetra3rs
from numpy.typing import NDArray

from sim.optics import FULL_SCALE, STAR_TRACKER, Optics
from sim.sky import CATALOGUE_ROW, Floats, Sky, load_sky, to_angles

HINTS_RAD = (5.0e-4, 4.0e-3)
"""How far off the spacecraft's belief is at the most as a rule, and ever. The farther, the easier is one star taken for
another: with the larger alone, frames full of stars stay unsolved now and then."""
CONE = 1.6
"""How much more of the sky than the frame shows is searched, as a factor of its half diagonal."""
MOST_CENTROIDS = 100
"""The brightest in a frame; what is fainter adds more noise than knowledge."""
WIDE_FAINTEST = 7.5
"""The star tracker's catalogue; fainter ones it does not see."""


@dataclass(frozen=True, eq=False)
class Plate:
    """A solved frame. `axes_I`: the camera's right, up and backward. `stars`, `others`: centroids (n, 2), column and
    row, of stars that were recognised and of what else is there, brightest first. `rms_rad`: residual of the stars."""

    axes_I: Floats
    stars: Floats
    others: Floats
    rms_rad: float


class UnsolvedError(Exception):
    """No attitude can be had from a frame; the text says why."""


def solve_narrow(frame: NDArray[np.uint16], optics: Optics, believed_I: Floats) -> Plate:
    """Solve a frame taken at about the believed axes (right, up, backward); `UnsolvedError` when that cannot be."""
    sky = load_sky()
    near = sky.near(-believed_I[2], CONE * optics.corner_rad + HINTS_RAD[-1])
    if len(near) < 3:
        raise UnsolvedError(f"{len(near)} stars of the catalogue near, expected at least 3")
    database = _database(sky, near, max_fov_deg=15.0, verification_stars_per_fov=4000, patterns_per_lattice_field=1)
    hint = np.array([believed_I[0], -believed_I[1], -believed_I[2]])
    found = _extract(frame, optics)
    for uncertainty in HINTS_RAD:
        how = {"attitude_hint": hint, "hint_uncertainty_rad": uncertainty, "strict_hint": True}
        try:
            return _solve(found, optics, database, **how)
        except UnsolvedError as reason:
            last = reason
    raise last


def solve_wide(frame: NDArray[np.uint16], optics: Optics = STAR_TRACKER) -> Plate:
    """Solve a frame of the star tracker, lost in space; `UnsolvedError` when that cannot be."""
    return _solve(_extract(frame, optics), optics, _wide_database(), fov_max_error_rad=0.02 * optics.field_rad)


def centroids(frame: NDArray[np.uint16], optics: Optics) -> Floats:
    """Column and row (n, 2) of what shines like a point or a small disc, brightest first."""
    found = _extract(frame, optics)
    middle = 0.5 * (optics.pixels - 1)
    return np.array([(middle + c.x, middle + c.y) for c in found]).reshape(-1, 2)


def _extract(frame: NDArray[np.uint16], optics: Optics) -> list[tetra3rs.Centroid]:
    return tetra3rs.extract_centroids(
        frame,
        max_centroids=MOST_CENTROIDS,
        matched_filter_sigma=optics.spread_px,
        max_sharpness=None,
        saturation_level=float(FULL_SCALE),
        threads=1,
    ).centroids


def _solve(found: list[tetra3rs.Centroid], optics: Optics, database: tetra3rs.SolverDatabase, **how: Any) -> Plate:
    result = database.solve_from_centroids(
        found,
        fov_estimate_rad=optics.field_rad,
        image_shape=(optics.pixels, optics.pixels),
        solve_timeout_ms=None,
        **how,
    )
    if not isinstance(result, tetra3rs.SolveResult):
        raise UnsolvedError(f"{len(found)} centroids, {result.status.replace('_', ' ')}")
    right, down, forward = np.asarray(result.rotation_matrix_icrs_to_camera, float)
    middle = 0.5 * (optics.pixels - 1)
    places = np.array([(middle + c.x, middle + c.y) for c in found]).reshape(-1, 2)
    known = np.zeros(len(places), bool)
    known[np.asarray(result.matched_centroids, int)] = True
    rms = math.radians(result.rmse_arcsec / 3600.0)
    return Plate(np.array([right, -down, -forward]), places[known], places[~known], rms)


@cache
def _wide_database() -> tetra3rs.SolverDatabase:
    """Patterns for the star tracker's field: half a second, once a process."""
    sky = load_sky()
    bright = np.arange(int(np.searchsorted(sky.magnitudes, WIDE_FAINTEST)))
    field = math.degrees(STAR_TRACKER.field_rad)
    return _database(
        sky,
        bright,
        max_fov_deg=1.05 * field,
        min_fov_deg=0.95 * field,
        lattice_field_oversampling=20,
        patterns_per_lattice_field=20,
    )


def _database(sky: Sky, chosen: NDArray[np.intp], **how: Any) -> tetra3rs.SolverDatabase:
    """A solver's database of some stars, by way of a file in the catalogue's own form."""
    rows = np.zeros(len(chosen), CATALOGUE_ROW)
    longitude, latitude = to_angles(sky.directions_I[chosen])
    rows["id"], rows["magnitude"] = chosen + 1, sky.magnitudes[chosen]
    rows["ra_deg"], rows["dec_deg"] = np.degrees(longitude), np.degrees(latitude)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "stars.bin")
        path.write_bytes(b"GDR3" + struct.pack("<IQ", 1, len(rows)) + rows.tobytes())
        defaults: dict[str, Any] = {"lattice_field_oversampling": 1, "epoch_proper_motion_year": None}
        return tetra3rs.SolverDatabase.generate_from_gaia(str(path), **(defaults | how))
