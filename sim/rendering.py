"""The spacecraft from outside: MuJoCo draws what has a shape, `sim.sky` the stars behind it.

The camera hangs beside the bus (`chase` in the model) and turns with nothing; the plume is shown while thrusting. What
the science camera sees is not drawn here: its picture is `sim.optics`'.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from sim.environment import Environment
from sim.errors import ConfigurationError, RenderingUnavailable
from sim.offscreen import make_context
from sim.sky import load_sky, star_image

LARGEST_FRAME = 1024
_CAMERA = "chase"
_FAINTEST = 5.5


class Renderer:
    """Draws poses of one model; the OpenGL context is made at the first frame of a size and kept."""

    def __init__(self, model: mujoco.MjModel, environment: Environment) -> None:
        self._model = model
        self._environment = environment
        self._sky = load_sky()
        self._context: Any = make_context(LARGEST_FRAME, LARGEST_FRAME)
        self._context.make_current()
        self._mjr = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._mjr)
        self._scene = mujoco.MjvScene(model=model, maxgeom=100)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = False
        self._option = mujoco.MjvOption()

    def __repr__(self) -> str:
        return f"Renderer({_CAMERA})"

    def close(self) -> None:
        """Free the OpenGL context."""
        if self._context is not None:
            self._context.make_current()
            self._mjr.free()
            self._context.free()
            self._context = None

    def render(
        self, data: mujoco.MjData, width: int, height: int, *, time_s: float, thrusting: bool
    ) -> NDArray[np.uint8]:
        """Frame (height, width, 3) of the pose in `data`, whose position is the origin."""
        check_size(width, height)
        number = self._model.camera(_CAMERA).id
        self._model.light_dir[0] = -np.array(self._environment.sun_direction_I(time_s))
        self._model.mat_rgba[self._model.material("plume").id][3] = 0.45 if thrusting else 0.0
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_camlight(self._model, data)
        try:
            shape = self._draw(data, number, width, height)
        except Exception as error:  # each OpenGL binding has errors of its own
            raise RenderingUnavailable(f"the OpenGL context was lost at {time_s:.0f} s: {error}") from error
        axes_I = data.cam_xmat[number].reshape(3, 3).T
        field_rad = math.radians(float(self._model.cam_fovy[number]))
        stars = star_image(self._sky, axes_I, field_rad, width, height, faintest=_FAINTEST)
        light = (255.0 * np.minimum(stars, 1.0)).astype(np.uint8)
        behind = shape.max(axis=2) == 0
        shape[behind] = light[behind][:, None]
        return shape

    def _draw(self, data: mujoco.MjData, number: int, width: int, height: int) -> NDArray[np.uint8]:
        camera = mujoco.MjvCamera()
        camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        camera.fixedcamid = number
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(self._model, data, self._option, None, camera, everything, self._scene)
        frame = np.empty((height, width, 3), dtype=np.uint8)
        rectangle = mujoco.MjrRect(0, 0, width, height)
        self._context.make_current()
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._mjr)
        mujoco.mjr_render(rectangle, self._scene, self._mjr)
        mujoco.mjr_readPixels(frame, None, rectangle, self._mjr)
        return np.flipud(frame).copy()


def check_size(width: int, height: int) -> None:
    """Refuse frames that nobody draws: ConfigurationError."""
    if not (1 <= width <= LARGEST_FRAME and 1 <= height <= LARGEST_FRAME):
        raise ConfigurationError(f"frame: expected 1 to {LARGEST_FRAME} pixels a side, found {width} x {height}")
