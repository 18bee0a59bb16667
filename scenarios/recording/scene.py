"""The spacecraft in its sky, as the 3D view draws it: values in, drawing out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import rerun as rr

from scenarios.recording.stream import Stream
from scenarios.recording.style import entity

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

WORLD = "/world"
CRAFT = "/world/spacecraft"
CAMERA = "/world/spacecraft/camera"
IMAGE_PX = 512
"""A side of the science camera's frames."""
CAMERA_IMAGE = "/world/spacecraft/camera/image"
THRUST = "/world/spacecraft/thrust"
SHAPES = ("box", "cylinder", "sphere")
_STARS, _STAR_DISTANCE = 1500, 400.0
_ARROW_COLOURS = {"sun": (255, 206, 84), "earth": (88, 170, 255)}
_TARGET_COLOURS = ((126, 231, 135), (214, 140, 255), (255, 150, 200), (120, 220, 230))


@dataclass(frozen=True, slots=True)
class Geom:
    """A body-fixed shape.

    `size` metres as MuJoCo has it: box half-edges; cylinder radius and half-length; sphere radius. `position` metres
    and `quaternion` (wxyz) place it in the body frame B; `rgba` 0 to 1.
    """

    name: str
    shape: str
    size: tuple[float, ...]
    position: Vector
    quaternion: Quaternion
    rgba: tuple[float, float, float, float]

    def __post_init__(self) -> None:
        needed = {"box": 3, "cylinder": 2, "sphere": 1}.get(self.shape)
        if needed is None:
            raise ValueError(f"geom {self.name!r}: expected shape one of {', '.join(SHAPES)}, found {self.shape!r}")
        if len(self.size) < needed or min(self.size[:needed]) <= 0:
            raise ValueError(
                f"geom {self.name!r}: expected {needed} positive sizes for a {self.shape}, found {self.size!r}"
            )


@dataclass(frozen=True, slots=True)
class Camera:
    """Where the camera sits (metres, body frame B) and where it looks (a direction in B)."""

    position: Vector
    boresight: Vector


@dataclass(frozen=True, slots=True)
class Scene:
    """What stays the same over a run.

    `directions`: unit vectors in the inertial frame N by name (`Sun`, `Earth`, targets). `thrust_axis`: direction of
    the force on the craft in the body frame B, None when there is no engine.
    """

    geoms: tuple[Geom, ...] = ()
    directions: Mapping[str, Vector] = field(default_factory=dict)
    thrust_axis: Vector | None = None
    camera: Camera | None = None

    def extent(self) -> float:
        """Metres from the body's origin to its farthest shape, at least 1."""
        reach = [float(np.linalg.norm(g.position)) + max(g.size) for g in self.geoms]
        return max([1.0, *reach])


def draw_static(stream: Stream, scene: Scene) -> None:
    """Write the body's shapes, the stars and the directions."""
    for i, geom in enumerate(scene.geoms):
        stream.static(f"{CRAFT}/body/{i:02d}_{entity(geom.name)}", _shape(geom))
    _draw_stars(stream)
    reach = scene.extent()
    others = 0
    for name, direction in scene.directions.items():
        colour = _ARROW_COLOURS.get(name.lower())
        if colour is None:
            colour = _TARGET_COLOURS[others % len(_TARGET_COLOURS)]
            others += 1
        vector = _unit(direction)
        arrow = rr.Arrows3D(
            origins=[vector * reach * 0.3],
            vectors=[vector * reach * 0.75],
            colors=[colour],
            radii=[reach * 0.012],
            labels=[name],
        )
        stream.static(f"{WORLD}/directions/{entity(name)}", arrow)
    if scene.thrust_axis is not None:
        plume = -_unit(scene.thrust_axis)
        look = rr.Arrows3D.from_fields(
            origins=[plume * reach * 0.25], colors=[(255, 90, 60)], radii=[reach * 0.03], labels=["engine plume"]
        )
        stream.static(THRUST, look)
    if scene.camera is not None:
        _draw_camera(stream, scene.camera, reach)


def plume_vectors(scene: Scene, shares: np.ndarray[Any, np.dtype[np.float64]]) -> list[list[list[float]]]:
    """For each thrust share (0 to 1) the arrows to draw: one against the force, or none when the engine is off."""
    if scene.thrust_axis is None:
        return [[] for _ in shares]
    plume = -_unit(scene.thrust_axis) * scene.extent()
    return [[(plume * (0.25 + 0.5 * float(share))).tolist()] if share > 0 else [] for share in shares]


def _shape(geom: Geom) -> Any:
    w, x, y, z = geom.quaternion
    rotation = [rr.Quaternion(xyzw=[x, y, z, w])]
    colour = [tuple(round(255 * min(1.0, max(0.0, c))) for c in geom.rgba)]
    fill = rr.components.FillMode.Solid
    if geom.shape == "box":
        return rr.Boxes3D(
            half_sizes=[geom.size[:3]], centers=[geom.position], quaternions=rotation, colors=colour, fill_mode=fill
        )
    if geom.shape == "cylinder":
        return rr.Cylinders3D(
            lengths=[2 * geom.size[1]],
            radii=[geom.size[0]],
            centers=[geom.position],
            quaternions=rotation,
            colors=colour,
            fill_mode=fill,
        )
    return rr.Ellipsoids3D(radii=[geom.size[0]], centers=[geom.position], colors=colour, fill_mode=fill)


def _draw_stars(stream: Stream) -> None:
    """Points of screen size all round: they carry no data, they make turns of the view visible."""
    generator = np.random.default_rng(0)
    directions = generator.normal(size=(_STARS, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    sizes = 0.5 + 1.1 * generator.random(_STARS) ** 4
    stars = rr.Points3D(directions * _STAR_DISTANCE, radii=rr.Radius.ui_points(sizes), colors=[[200, 208, 235]])
    stream.static(f"{WORLD}/stars", stars)


def _draw_camera(stream: Stream, camera: Camera, reach: float) -> None:
    """A frustum along the boresight, wider than the true field of view so that it can be seen."""
    forward = _unit(camera.boresight)
    helper = np.array([0.0, 0.0, 1.0]) if abs(forward[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    right = _unit(np.cross(forward, helper))
    down = np.cross(forward, right)
    axes = np.column_stack([right, down, forward])
    stream.static(CAMERA, rr.Transform3D(translation=camera.position, mat3x3=axes))
    pinhole = rr.Pinhole(resolution=[IMAGE_PX, IMAGE_PX], focal_length=1.2 * IMAGE_PX, image_plane_distance=reach * 0.5)
    stream.static(CAMERA_IMAGE, pinhole)


def _unit(vector: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    array = np.asarray(vector, np.float64)
    length = float(np.linalg.norm(array))
    if array.shape != (3,) or length == 0.0 or not np.isfinite(length):
        raise ValueError(f"scene direction: expected a vector of three finite numbers, not all 0, found {vector!r}")
    return array / length
