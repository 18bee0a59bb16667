"""What the cameras of a flight see at a moment, as pictures for people: the flight never sees them.

`micas`: through the science camera, the picture of `sim.optics` that its frames are made by, without noise.
`chase`: the spacecraft from outside, drawn with OpenGL.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from sim.environment import Environment
from sim.errors import ConfigurationError
from sim.imager import body_of
from sim.navigation import AXES_B
from sim.optics import MICAS, as_grey, expose
from sim.physics import Physics
from sim.quaternion import Quaternion
from sim.rendering import Renderer, check_size
from sim.sky import load_sky
from sim.star_tracker import axes_I

CAMERAS = ("micas", "chase")
GLANCE_S = 30.0
"""How long the science camera is exposed for a view."""


class Views:
    """The views of one flight. OpenGL is asked for at the first view from outside."""

    def __init__(self, model: mujoco.MjModel, environment: Environment, physics: Physics) -> None:
        self._model = model
        self._environment = environment
        self._physics = physics
        self._renderer: Renderer | None = None

    def render(self, camera: str, width: int, height: int, *, time_s: float, thrusting: bool) -> NDArray[np.uint8]:
        """Rows, columns and RGB of 0 to 255. ConfigurationError, and for `chase` RenderingUnavailable."""
        check_size(width, height)
        if camera == "micas":
            return framed(through_science_camera(self._environment, self._physics.attitude_IB, time_s), width, height)
        if camera != "chase":
            raise ConfigurationError(f"camera: expected one of {', '.join(CAMERAS)}, found {camera!r}")
        if self._renderer is None:
            self._renderer = Renderer(self._model, self._environment)
        return self._renderer.render(self._physics.scratch(), width, height, time_s=time_s, thrusting=thrusting)

    def close(self) -> None:
        """Give back the OpenGL context; the next view makes another."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


def through_science_camera(environment: Environment, attitude_IB: Quaternion, time_s: float) -> NDArray[np.uint16]:
    """A frame (n, n) without noise or motion; the target nearest to the boresight is in it if it is in the field."""
    axes = axes_I(attitude_IB, AXES_B)
    bodies = [body_of(environment, t.name, time_s) for t in environment.targets.values() if t.kind == "asteroid"]
    nearest = max(bodies, key=lambda body: float(-axes[2] @ body.direction), default=None)
    return expose(MICAS, load_sky(), (axes,), GLANCE_S, nearest, None)


def framed(frame: NDArray[np.uint16], width: int, height: int) -> NDArray[np.uint8]:
    """A square frame as a picture (height, width, 3), on black where the picture is no square.

    A pixel of a smaller picture shows the brightest of what falls on it: no star is lost.
    """
    side = min(width, height)
    first = np.arange(side) * len(frame) // side
    square = np.maximum.reduceat(np.maximum.reduceat(as_grey(frame), first, axis=0), first, axis=1)
    picture = np.zeros((height, width, 3), dtype=np.uint8)
    top, left = (height - side) // 2, (width - side) // 2
    picture[top : top + side, left : left + side] = square[:, :, None]
    return picture
