"""The Rerun recording of a run: plan against execution, attitude, power, images, the plan's network and the events.

`RunRecorder` is all that a runner needs; `Scene` and `Channel` are the values it is told of the spacecraft.
"""

from scenarios.recording.marks import Mark
from scenarios.recording.recorder import RunRecorder
from scenarios.recording.scene import Camera, Geom, Scene
from scenarios.recording.telemetry import Channel

__all__ = ["Camera", "Channel", "Geom", "Mark", "RunRecorder", "Scene"]
