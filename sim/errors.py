"""What the simulator raises.

SimulatorError
    ConfigurationError    a configuration, injection or call that cannot be (unknown target, negative capacity, ...)
    SimulationError       the physics broke down: not a number or instability; names the component and the time
    RenderingUnavailable  no offscreen OpenGL on this machine, names the packages that bring it; or its context was lost

A wrong telecommand is none of these: it is refused in its acknowledgement, as on the spacecraft.
"""

from __future__ import annotations


class SimulatorError(Exception):
    """Anything the simulator raises on purpose."""


class ConfigurationError(SimulatorError):
    """What was asked for cannot be; says what, where, what was expected and what was found."""


class SimulationError(SimulatorError):
    """The physics broke down at `time_s` in `component`."""

    def __init__(self, component: str, time_s: float, what: str) -> None:
        super().__init__(f"simulation broke down in {component} at {time_s:.3f} s: {what}")
        self.component = component
        self.time_s = time_s


class RenderingUnavailable(SimulatorError):  # noqa: N818 - says a fact of the machine, not a mistake
    """Views from outside need offscreen OpenGL and this machine has none that works; the message names the packages."""
