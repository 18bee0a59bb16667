"""Pictures: MuJoCo draws what has a shape, `sim.sky` the stars behind it.

`micas`: through the science camera, 0.7 degrees high. Targets with an angular diameter near its boresight are drawn as
an ellipsoid lit from the Sun; the stars are the real ones (see `sim.sky`).
`chase`: the spacecraft from outside, the plume shown while thrusting.
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

CAMERAS = ("micas", "chase")
LARGEST_FRAME = 1024
_FAINTEST = {"micas": 10.0, "chase": 5.5}
_TARGET_DISTANCE_M = 2000.0
_LOOK_RAD = math.radians(2.0)


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
        return f"Renderer({', '.join(CAMERAS)})"

    def close(self) -> None:
        """Free the OpenGL context."""
        if self._context is not None:
            self._context.make_current()
            self._mjr.free()
            self._context.free()
            self._context = None

    def render(
        self, data: mujoco.MjData, camera: str, width: int, height: int, *, time_s: float, thrusting: bool
    ) -> NDArray[np.uint8]:
        """Frame (height, width, 3) of the pose in `data`, whose position is the origin."""
        if camera not in CAMERAS:
            raise ConfigurationError(f"camera: expected one of {', '.join(CAMERAS)}, found {camera!r}")
        if not (1 <= width <= LARGEST_FRAME and 1 <= height <= LARGEST_FRAME):
            raise ConfigurationError(f"frame: expected 1 to {LARGEST_FRAME} pixels a side, found {width} x {height}")
        number = self._model.camera(camera).id
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_camlight(self._model, data)
        self._set_scene(data, number, time_s, thrusting)
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_camlight(self._model, data)
        try:
            shape = self._draw(data, number, width, height)
        except Exception as error:  # each OpenGL binding has errors of its own
            raise RenderingUnavailable(f"the OpenGL context was lost at {time_s:.0f} s: {error}") from error
        axes_I = data.cam_xmat[number].reshape(3, 3).T
        field_rad = math.radians(float(self._model.cam_fovy[number]))
        stars = star_image(self._sky, axes_I, field_rad, width, height, faintest=_FAINTEST[camera])
        light = (255.0 * np.minimum(stars, 1.0)).astype(np.uint8)
        behind = shape.max(axis=2) == 0
        shape[behind] = light[behind][:, None]
        return shape

    def _set_scene(self, data: mujoco.MjData, number: int, time_s: float, thrusting: bool) -> None:
        """Put the target into the field, or behind the camera, turn the Sun's light and show or hide the plume."""
        sun_I = np.array(self._environment.sun_direction_I(time_s))
        self._model.light_dir[0] = -sun_I
        self._model.mat_rgba[self._model.material("plume").id][3] = 0.45 if thrusting else 0.0
        body = self._model.geom("target_body").id
        position = data.cam_xpos[number].copy()
        forward = -data.cam_xmat[number].reshape(3, 3)[:, 2]
        data.mocap_pos[0] = -_TARGET_DISTANCE_M * forward
        for target in self._environment.targets.values():
            direction = np.array(self._environment.direction_I(target.name, time_s))
            diameter_rad = self._environment.angular_diameter_rad(target.name, time_s)
            if diameter_rad > 0.0 and direction @ forward > math.cos(_LOOK_RAD):
                radius = _TARGET_DISTANCE_M * math.tan(0.5 * diameter_rad)
                self._model.geom_size[body] = radius * np.array([1.0, 0.82, 0.7])
                self._model.geom_rbound[body] = radius
                data.mocap_pos[0] = position + _TARGET_DISTANCE_M * direction
                return

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
