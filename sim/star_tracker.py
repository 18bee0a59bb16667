"""The star tracker as the chain that it is: a picture of the sky, centroids, the attitude solved lost in space.

It looks along -X of the body. The noise model of `sim.estimator` is calibrated against this chain (`calibrate`), and
stands for it where every second counts.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.random import Generator

from sim.optics import STAR_TRACKER, expose
from sim.plates import UnsolvedError, solve_wide
from sim.quaternion import Quaternion, rotate
from sim.sky import Floats, load_sky

TRACKER_AXES_B = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
"""Right, up and backward in the body frame."""
EXPOSURE_S = 0.3


def axes_I(attitude_IB: Quaternion, axes_B: Floats) -> Floats:
    """The rows of `axes_B` in the inertial frame."""
    return np.array([rotate(attitude_IB, (row[0], row[1], row[2])) for row in axes_B.tolist()])


class StarTracker:
    """Measures attitudes by pictures; its noise comes from one generator."""

    def __init__(self, generator: Generator) -> None:
        self._generator = generator

    def error_B(self, attitude_IB: Quaternion) -> Floats | None:
        """What one measurement at rest gets wrong: a small rotation in body axes (3,), rad; None: no fix."""
        true_I = axes_I(attitude_IB, TRACKER_AXES_B)
        frame = expose(STAR_TRACKER, load_sky(), (true_I,), EXPOSURE_S, None, self._generator)
        try:
            solved_I = solve_wide(frame).axes_I
        except UnsolvedError:
            return None
        # Rows of both are the camera's axes: solved = true turned by the error, which is small in camera axes.
        turn = solved_I @ true_I.T
        in_camera = 0.5 * np.array([turn[1, 2] - turn[2, 1], turn[2, 0] - turn[0, 2], turn[0, 1] - turn[1, 0]])
        return np.asarray(in_camera @ TRACKER_AXES_B)


def calibrate(generator: Generator, count: int) -> tuple[Floats, float]:
    """Standard deviations about the body axes (3,) of the chain over attitudes drawn evenly, and the share without fix.

    A fix farther off than a hundredth of a radian is a wrong one; it counts as none.
    """
    tracker, errors = StarTracker(generator), []
    for _ in range(count):
        drawn = generator.standard_normal(4)
        w, x, y, z = (drawn / np.linalg.norm(drawn)).tolist()
        error = tracker.error_B((w, x, y, z))
        if error is not None and math.hypot(*error.tolist()) < 0.01:
            errors.append(error)
    return np.sqrt(np.mean(np.square(errors), axis=0)), 1.0 - len(errors) / count
