"""The target hardware: a spacecraft after Deep Space 1 as physics, behind telecommands and telemetry.

`Spacecraft(config, seed)` is the whole of it. The package knows nothing of plans or executives.
"""

from sim.components.terminal import Acknowledgement
from sim.config import SpacecraftConfig, Target
from sim.errors import ConfigurationError, RenderingUnavailable, SimulationError, SimulatorError
from sim.fault_rates import FaultRate, draw_faults
from sim.faults import FAULTS, random_faults
from sim.recorded_state import RecordedState
from sim.spacecraft import Spacecraft

__all__ = [
    "FAULTS",
    "Acknowledgement",
    "ConfigurationError",
    "FaultRate",
    "RecordedState",
    "RenderingUnavailable",
    "SimulationError",
    "SimulatorError",
    "Spacecraft",
    "SpacecraftConfig",
    "Target",
    "draw_faults",
    "random_faults",
]
