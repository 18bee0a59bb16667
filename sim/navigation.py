"""Optical navigation: the science camera's frame, reduced to the direction of the target among the stars.

A frame counts when the target is found in it. A turn that missed, or motion while the shutter was open, gives a frame
in which it is not, or is no point any more: the picture says so itself, and the goal that needed it is lost.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sim.optics import FULL_SCALE, MICAS, Body, add_sphere, expose
from sim.plates import Plate, UnsolvedError, centroids, solve_narrow
from sim.sky import Floats, load_sky

AXES_B = np.array([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]])
"""Right, up and backward of the science camera in the body frame: it looks along +Z."""
SEARCH_RAD = 5.0e-4
"""How far from where the ephemeris and the plate put it the target may be found (beside its own radius)."""
FEWEST_STARS = 3
"""So many that the catalogue has well inside the field are a plate; less, and the attitude has to do."""
BY_ATTITUDE_RAD = 4.0e-3
"""The same where too few stars are in the field, and the spacecraft's own attitude has to serve as the plate."""


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame and what was found in it. `pixels`: converter numbers (n, n). Places are column and row.

    `status`: `stars` (measured against them), `attitude` (against the spacecraft's attitude, where stars are too few),
    or why there is no measurement. `direction_I`: unit vector to the target, None without measurement.
    """

    pixels: NDArray[np.uint16]
    target: str
    status: str
    stars: Floats
    place: tuple[float, float] | None = None
    direction_I: Floats | None = None

    @property
    def good(self) -> bool:
        """It holds a measurement."""
        return self.direction_I is not None


def take(
    target: str, body: Body, ways: Sequence[Floats], seconds: float, believed: Floats, generator: Generator
) -> Frame:
    """Expose and reduce. `ways`: the camera's true axes while the shutter was open; `believed`: as the filter has them.

    `body`: the target as it is (the frame) and as the ephemeris has it (the reduction).
    """
    sky = load_sky()
    pixels = expose(MICAS, sky, ways, seconds, body, generator)
    try:
        plate, status, search = solve_narrow(pixels, MICAS, believed), "stars", SEARCH_RAD
    except UnsolvedError as reason:
        expected_stars = len(sky.near(-believed[2], 0.45 * MICAS.field_rad))
        if expected_stars >= FEWEST_STARS:
            return Frame(pixels, target, f"no plate: {reason}, {expected_stars} stars expected", np.empty((0, 2)))
        plate = Plate(believed, np.empty((0, 2)), centroids(pixels, MICAS), 0.0)
        status, search = "attitude", BY_ATTITUDE_RAD
    [expected] = MICAS.project(body.direction[None, :], plate.axes_I)
    reach_px = search * MICAS.focal_px + 0.5 * body.diameter_rad * MICAS.focal_px
    near = [p for p in plate.others if np.hypot(*(p - expected)) <= reach_px]
    if not near:
        return Frame(pixels, target, f"target not found: {len(plate.stars)} stars", plate.stars)
    found = near[0] - _light_centre_offset(body, plate.axes_I, seconds)
    column, row = found.tolist()
    return Frame(pixels, target, status, plate.stars, (column, row), MICAS.direction(found, plate.axes_I))


def _light_centre_offset(body: Body, axes: Floats, seconds: float) -> Floats:
    """From a body's centre to the middle of its light (columns, rows): nothing for a point, the phase for a sphere."""
    radius = 0.5 * body.diameter_rad * MICAS.focal_px
    if radius < 1.0:
        return np.zeros(2)
    size = 2 * math.ceil(radius) + 1
    light, middle = np.zeros((size, size)), np.full(2, 0.5 * (size - 1))
    add_sphere(light, middle, radius, axes @ body.sun, MICAS.electrons(body.magnitude, seconds))
    weight = np.minimum(light / MICAS.gain_e, FULL_SCALE)
    total = weight.sum()
    if total == 0.0:
        return np.zeros(2)
    places = np.arange(size) - middle[0]
    return np.asarray(np.array([weight.sum(axis=0) @ places, weight.sum(axis=1) @ places]) / total)
