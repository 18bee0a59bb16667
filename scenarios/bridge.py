"""The spacecraft as an executive's plant, and as a scene for the recording."""

from __future__ import annotations

from collections.abc import Mapping

from executive.port import Acknowledgement, Command, Observation, TelemetryValue
from scenarios.flight_rules import BusCommand
from scenarios.recording import Camera, Geom, Scene
from sim import Spacecraft, SpacecraftConfig
from sim.assembly import load_assembly
from sim.dictionary import TELECOMMANDS
from sim.environment import CAMERA_BORESIGHT_B, THRUST_AXIS_B, Environment
from sim.shapes import outside


class SpacecraftPlant:
    """The port's other side: commands to the bus, telemetry of the subscribed channels back, changes only.

    A terminal that left a command without an answer is left alone for the rest of that second; what else is meant for
    it goes out at the next one. `telemetry`: all channels as last seen. `on_bus`: the commands of the second so far.
    """

    def __init__(self, spacecraft: Spacecraft, channels: frozenset[str]) -> None:
        self._spacecraft = spacecraft
        self._channels = tuple(sorted(channels))
        self._last: dict[str, TelemetryValue] = {}
        self._acknowledgements: list[Acknowledgement] = []
        self._silent: set[str] = set()
        self._waiting: list[Command] = []
        self.telemetry: Mapping[str, TelemetryValue] = spacecraft.telemetry()
        self.on_bus: list[BusCommand] = []

    def send(self, command: Command) -> None:
        """Put a command on the bus; what the terminal says of it arrives with the next observation."""
        known = TELECOMMANDS.get(command.name)
        terminal = "" if known is None else known.terminal
        if terminal in self._silent:
            self._waiting.append(command)
            return
        answer = self._spacecraft.send(command.name, command.arguments)
        self.on_bus.append(BusCommand(command.name, terminal, answer is not None))
        if answer is None:
            self._silent.add(terminal)
        if answer is not None:
            self._acknowledgements.append(Acknowledgement(command.id, answer.accepted, answer.reason))

    def advance(self, until: int) -> Observation:
        """Fly on to that second and look at the subscribed channels."""
        self._spacecraft.advance(until)
        self.on_bus.clear()
        if self._silent:
            self._silent.clear()
            waiting, self._waiting = self._waiting, []
            for command in waiting:
                self.send(command)
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
