"""A made-up sky of point stars and how a camera spreads them over its pixels.

The stars are not a catalogue: 480,000 directions drawn evenly over the sphere from one fixed seed, about 5.7 in a field
of 0.7 x 0.7 degrees as in the real sky down to magnitude 10, with magnitudes that grow in number as the real ones do
(by a factor of ten every 2.2 magnitudes). Every run sees the same sky.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_SEED = 19981024
_COUNT = 480_000
_FAINTEST = 10.0
_MAGNITUDES_PER_DECADE = 2.2


@dataclass(frozen=True, eq=False)
class Sky:
    """Directions (n, 3) in the inertial frame and magnitudes (n,), brightest first."""

    directions_I: NDArray[np.float64]
    magnitudes: NDArray[np.float64]

    def __repr__(self) -> str:
        return f"Sky({len(self.magnitudes)} stars)"


def make_sky() -> Sky:
    """The sky, the same at every call; 12 MB and some 30 ms, so make it where pictures are made."""
    generator = np.random.default_rng(_SEED)
    directions = generator.standard_normal((_COUNT, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    ranks = np.arange(1, _COUNT + 1)
    magnitudes = _FAINTEST + _MAGNITUDES_PER_DECADE * np.log10(ranks / _COUNT)
    return Sky(directions, magnitudes)


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
