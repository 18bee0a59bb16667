"""What a camera's detector collects: stars, a target, smear and noise, as numbers of a 12-bit converter.

A pinhole with a Gaussian point spread. Light is in photo-electrons: a star of magnitude m gives
`zero_point * 10**(-0.4 m)` a second. Everything that moves over the field while the shutter is open is deposited along
its way. Shot noise is Gaussian: with the background's electrons in every pixel, that is what Poisson's comes to.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sim.sky import Floats, Sky

FULL_SCALE = 4095
"""The converter's largest number."""
STEPS_A_SAMPLE = 4
STILL_PX = 0.1
"""Less motion than this over an exposure is none."""
_PATCH = 5
"""Half the width of what a point's light is spread over, in standard deviations; the rest is 1e-6 of it."""


@dataclass(frozen=True, slots=True)
class Optics:
    """A square detector behind a lens. Frame: rows go down, columns to the right, the middle is the boresight."""

    pixels: int
    field_rad: float
    spread_px: float
    zero_point_e_s: float
    background_e_s: float
    read_noise_e: float
    gain_e: float

    @property
    def focal_px(self) -> float:
        """Pixels a unit of the tangent."""
        return 0.5 * self.pixels / math.tan(0.5 * self.field_rad)

    @property
    def corner_rad(self) -> float:
        """From the boresight to the farthest corner."""
        return math.atan(math.sqrt(2.0) * math.tan(0.5 * self.field_rad))

    def electrons(self, magnitude: Floats | float, seconds: float) -> Any:
        """What a star of a magnitude gives in an exposure."""
        return self.zero_point_e_s * seconds * 10.0 ** (-0.4 * magnitude)

    def project(self, directions: Floats, axes: Floats) -> Floats:
        """Column and row (n, 2) of unit vectors (n, 3); NaN behind the camera. `axes`: rows right, up, backward."""
        right, up, backward = (directions @ axes.T).T
        with np.errstate(divide="ignore", invalid="ignore"):
            ahead = np.where(backward < 0.0, -backward, np.nan)
            return 0.5 * (self.pixels - 1) + self.focal_px * np.stack([right / ahead, -up / ahead], axis=-1)

    def direction(self, place: Floats, axes: Floats) -> Floats:
        """Unit vector of a column and row, in the frame of `axes`."""
        x, y = (place - 0.5 * (self.pixels - 1)) / self.focal_px
        direction = x * axes[0] - y * axes[1] - axes[2]
        return np.asarray(direction / np.linalg.norm(direction))


MICAS = Optics(512, math.radians(0.7), 0.8, 1.0e6, 2.0, 20.0, 15.0)
"""The science camera: 0.7 degrees on 512 pixels of 24 microradians. Assumptions of a class, none published."""
STAR_TRACKER = Optics(512, math.radians(15.0), 0.9, 2.5e6, 40.0, 30.0, 15.0)
"""A star tracker: 15 degrees on 512 pixels, exposed for a tenth of a second. Assumptions of a class."""


@dataclass(frozen=True, slots=True)
class Body:
    """A target in a frame: its direction and the Sun's (unit vectors), apparent diameter, magnitude when it is a point.

    A resolved one is a grey sphere lit by the Sun (Lambert), each pixel of it as bright as a star of that magnitude.
    """

    direction: Floats
    sun: Floats
    diameter_rad: float
    magnitude: float


def expose(
    optics: Optics,
    sky: Sky,
    ways: Sequence[Floats],
    seconds: float,
    body: Body | None,
    generator: Generator | None,
) -> NDArray[np.uint16]:
    """One frame (pixels, pixels). `ways`: the camera's axes at even moments from opening to closing of the shutter.

    Without a generator the frame has no noise.
    """
    light = np.full((optics.pixels, optics.pixels), optics.background_e_s * seconds)
    moments = _moments(optics, ways)
    swept = max(float(np.arccos(np.clip(axes[2] @ ways[0][2], -1.0, 1.0))) for axes in ways)
    seen = sky.near(-ways[0][2], 1.05 * optics.corner_rad + swept)
    for axes, share in moments:
        _add_stars(light, optics, sky, seen, axes, seconds * share)
        if body is not None:
            _add_body(light, optics, body, axes, seconds * share)
    if generator is not None:
        spread = np.sqrt(light + optics.read_noise_e**2)
        light += spread * generator.standard_normal(light.shape)
    return np.clip(np.rint(light / optics.gain_e), 0, FULL_SCALE).astype(np.uint16)


def _moments(optics: Optics, ways: Sequence[Floats]) -> list[tuple[Floats, float]]:
    """Axes and share of the exposure: one moment when nothing moves, else some between every two samples."""
    first, last = ways[0], ways[-1]
    motion = max(float(np.abs(axes - first).max()) for axes in ways) * optics.focal_px
    if motion < STILL_PX:
        return [(last, 1.0)]
    parts = [(i + 0.5) / STEPS_A_SAMPLE for i in range(STEPS_A_SAMPLE)]
    steps = [a + part * (b - a) for a, b in pairwise(ways) for part in parts]
    return [(axes, 1.0 / len(steps)) for axes in steps]


def _add_stars(light: Floats, optics: Optics, sky: Sky, seen: NDArray[np.intp], axes: Floats, seconds: float) -> None:
    electrons = optics.electrons(sky.magnitudes[seen], seconds)
    for place, amount in zip(optics.project(sky.directions_I[seen], axes), electrons, strict=True):
        _add_point(light, optics.spread_px, place, float(amount))


def _add_point(light: Floats, spread_px: float, place: Floats, electrons: float) -> None:
    """A Gaussian of unit sum, times the electrons."""
    column, row = place
    if not math.isfinite(column):
        return
    reach = math.ceil(_PATCH * spread_px)
    left, top = max(0, round(column) - reach), max(0, round(row) - reach)
    right, bottom = min(light.shape[1], round(column) + reach + 1), min(light.shape[0], round(row) + reach + 1)
    if left < right and top < bottom:
        x = np.exp(-0.5 * ((np.arange(left, right) - column) / spread_px) ** 2)
        y = np.exp(-0.5 * ((np.arange(top, bottom) - row) / spread_px) ** 2)
        light[top:bottom, left:right] += electrons / (2.0 * math.pi * spread_px**2) * np.outer(y, x)


def _add_body(light: Floats, optics: Optics, body: Body, axes: Floats, seconds: float) -> None:
    [place] = optics.project(body.direction[None, :], axes)
    electrons = float(optics.electrons(body.magnitude, seconds))
    radius = 0.5 * body.diameter_rad * optics.focal_px
    if radius < 1.0:
        _add_point(light, optics.spread_px, place, electrons)
    elif math.isfinite(place[0]):
        add_sphere(light, place, radius, axes @ body.sun, electrons)


def add_sphere(light: Floats, place: Floats, radius: float, sun: Floats, electrons: float) -> None:
    """`electrons` in each pixel whose surface faces the Sun; `sun`: its direction along right, up and backward."""
    column, row = place
    left, top = max(0, math.floor(column - radius)), max(0, math.floor(row - radius))
    right, bottom = (
        min(light.shape[1], math.ceil(column + radius) + 1),
        min(light.shape[0], math.ceil(row + radius) + 1),
    )
    if left >= right or top >= bottom:
        return
    x = (np.arange(left, right) - column)[None, :] / radius
    y = -(np.arange(top, bottom) - row)[:, None] / radius
    inside = x**2 + y**2
    toward = np.sqrt(np.maximum(0.0, 1.0 - inside))
    lit = np.maximum(0.0, x * sun[0] + y * sun[1] + toward * sun[2])
    light[top:bottom, left:right] += np.where(inside <= 1.0, electrons * lit, 0.0)


def as_grey(frame: NDArray[np.uint16]) -> NDArray[np.uint8]:
    """A frame for people, 0 to 255: the square root of what is over the sky, so that faint stars are seen too."""
    light = frame.astype(np.float64)
    sky, bright = np.median(light), max(float(np.percentile(light, 99.95)), 1.0)
    level = np.sqrt(np.clip((light - sky) / max(bright - sky, 1.0), 0.0, 1.0))
    return np.asarray(np.rint(255.0 * level), dtype=np.uint8)
