"""The spacecraft as an executive's plant, and as a scene and pose for the recording."""

from __future__ import annotations

from collections.abc import Mapping

from executive.port import Acknowledgement, Command, Observation, TelemetryValue
from scenarios.recording import Camera, Geom, Scene
from sim import Spacecraft, SpacecraftConfig
from sim.assembly import load_assembly
from sim.environment import CAMERA_BORESIGHT_B, THRUST_AXIS_B, Environment
from sim.shapes import outside


class SpacecraftPlant:
    """The port's other side: commands to the bus, telemetry of the subscribed channels back, changes only."""

    def __init__(self, spacecraft: Spacecraft, channels: frozenset[str]) -> None:
        self._spacecraft = spacecraft
        self._channels = tuple(sorted(channels))
        self._last: dict[str, TelemetryValue] = {}
        self._acknowledgements: list[Acknowledgement] = []
        self.telemetry: Mapping[str, TelemetryValue] = spacecraft.telemetry()

    def send(self, command: Command) -> None:
        """Put a command on the bus; what the terminal says of it arrives with the next observation."""
        answer = self._spacecraft.send(command.name, command.arguments)
        if answer is not None:
            self._acknowledgements.append(Acknowledgement(command.id, answer.accepted, answer.reason))

    def advance(self, until: int) -> Observation:
        """Fly on to that second and look at the subscribed channels. All channels stay in `telemetry`."""
        self._spacecraft.advance(until)
        self.telemetry = values = self._spacecraft.telemetry()
        last = self._last
        changes = {name: values[name] for name in self._channels if name not in last or last[name] != values[name]}
        last.update(changes)
        acknowledgements, self._acknowledgements = tuple(self._acknowledgements), []
        return Observation(until, changes, acknowledgements)


def scene_of(config: SpacecraftConfig) -> Scene:
    """What the 3D view draws of a spacecraft of this configuration in its sky."""
    sky = Environment(config)
    shapes = outside(load_assembly(config.time_step_s))
    aperture = next(shape for shape in shapes if shape.name == "micas_aperture")
    directions = {"sun": sky.sun_direction_I(0.0)} | {name: sky.direction_I(name, 0.0) for name in sky.targets}
    return Scene(
        geoms=tuple(Geom(s.name, s.kind, s.size_m, s.position_B_m, s.attitude_BG, s.rgba) for s in shapes),
        directions=directions,
        thrust_axis=THRUST_AXIS_B,
        camera=Camera(aperture.position_B_m, CAMERA_BORESIGHT_B),
    )
