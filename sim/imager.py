"""The science camera's light path in flight: collects where it looked while the shutter was open, makes the frame."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from sim.environment import Environment
from sim.navigation import AXES_B, Frame, take
from sim.optics import Body
from sim.quaternion import Quaternion
from sim.sky import Floats, to_angles
from sim.star_tracker import axes_I


class Imager:
    """One exposure at a time: `look` every second of it, then `develop`. `frame`: the last one developed."""

    def __init__(self, environment: Environment, generator: Generator) -> None:
        self._environment = environment
        self._generator = generator
        self._ways: list[Floats] = []
        self._believed: Floats = AXES_B
        self.frame: Frame | None = None

    def look(self, attitude_IB: Quaternion, believed_IB: Quaternion) -> None:
        """A second of the exposure: the true attitude and the one that the filter has."""
        self._ways.append(axes_I(attitude_IB, AXES_B))
        self._believed = axes_I(believed_IB, AXES_B)

    def develop(self, target: str, seconds: float, time_s: float) -> bool:
        """The frame of what was looked at for `seconds` up to about `time_s`; whether it holds a measurement."""
        body = body_of(self._environment, target, time_s)
        self.frame = take(target, body, self._ways, seconds, self._believed, self._generator)
        self._ways = []
        return self.frame.good

    def telemetry(self) -> dict[str, float | str]:
        """What the last frame says: its status, and the target's longitude and latitude in the inertial frame."""
        if self.frame is None:
            return {"optnav.status": "none", "optnav.longitude_rad": 0.0, "optnav.latitude_rad": 0.0}
        longitude, latitude = 0.0, 0.0
        if self.frame.direction_I is not None:
            longitude, latitude = (float(angle) for angle in to_angles(self.frame.direction_I))
        values: dict[str, float | str] = {"optnav.status": self.frame.status}
        return values | {"optnav.longitude_rad": longitude, "optnav.latitude_rad": latitude}


def body_of(environment: Environment, target: str, time_s: float) -> Body:
    """A target as a camera of the spacecraft sees it."""
    return Body(
        np.array(environment.direction_I(target, time_s)),
        np.array(environment.sun_direction_I(time_s)),
        environment.angular_diameter_rad(target, time_s),
        environment.targets[target].magnitude,
    )
