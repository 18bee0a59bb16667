"""The spacecraft's outside as plain values, for whoever draws it without MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from sim.assembly import Assembly
from sim.quaternion import Quaternion, Vector

_NAMES = {
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
}


@dataclass(frozen=True, slots=True)
class Shape:
    """A shape fixed to the bus, wings at angle 0.

    `size` (m): half-edges of a box; radius and half-length of a cylinder; radius of a sphere. `position_B_m` and
    `attitude_BG` (w, x, y, z; shape to body) place it in the body frame.
    """

    name: str
    kind: str
    size_m: tuple[float, ...]
    position_B_m: Vector
    attitude_BG: Quaternion
    rgba: tuple[float, float, float, float]


def outside(assembly: Assembly) -> tuple[Shape, ...]:
    """The boxes, cylinders and spheres of the bus and what hangs on it, in the model's order; wheels are inside."""
    model = assembly.model
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    bus = assembly.bus_body
    to_body = np.zeros(4)
    mujoco.mju_negQuat(to_body, data.xquat[bus])
    shapes = []
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        kind = _NAMES.get(int(model.geom_type[geom]))
        rgba = model.mat_rgba[model.geom_matid[geom]] if model.geom_matid[geom] >= 0 else model.geom_rgba[geom]
        hidden = rgba[3] == 0 or model.body(body).name.startswith("wheel")
        if kind is None or hidden or int(model.body_rootid[body]) != int(model.body_rootid[bus]):
            continue
        position, attitude_IG, attitude_BG = np.zeros(3), np.zeros(4), np.zeros(4)
        mujoco.mju_rotVecQuat(position, data.geom_xpos[geom] - data.xpos[bus], to_body)
        mujoco.mju_mat2Quat(attitude_IG, data.geom_xmat[geom])
        mujoco.mju_mulQuat(attitude_BG, to_body, attitude_IG)
        x, y, z = position.tolist()
        qw, qx, qy, qz = attitude_BG.tolist()
        r, g, b, a = rgba.tolist()
        name = model.geom(geom).name or f"{model.body(body).name}_{geom}"
        size = tuple(model.geom_size[geom].tolist())
        shapes.append(Shape(name, kind, size, (x, y, z), (qw, qx, qy, qz), (r, g, b, a)))
    return tuple(shapes)
