"""The radio's transmitter and the recorder that it empties."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sim.components.hooks import refuse_fault
from sim.config import SpacecraftConfig
from sim.kernels import Memory, compiled

STORED_MBIT, DOWNLINKED_MBIT, RATE_MBIT_S = 0, 1, 2
SIZE = 3


@compiled
def play(m: Memory, dt_s: float) -> None:
    """Send to the ground for `dt_s` at the rate in the memory, and drop here what was sent."""
    sent = min(m[RATE_MBIT_S] * dt_s, m[STORED_MBIT])
    m[STORED_MBIT] -= sent
    m[DOWNLINKED_MBIT] += sent


class Recorder:
    """Megabits in, megabits out, at the radio's rate."""

    READINGS: ClassVar[Mapping[str, int]] = {
        "recorder.stored_Mbit": STORED_MBIT,
        "recorder.downlinked_Mbit": DOWNLINKED_MBIT,
    }

    def __init__(self, capacity_Mbit: float) -> None:
        self._capacity_Mbit = capacity_Mbit
        self._stuck = False
        self.memory: Memory = np.zeros(SIZE)

    def __repr__(self) -> str:
        return f"Recorder({self.stored_Mbit:.1f} of {self._capacity_Mbit:.0f} Mbit)"

    @property
    def stored_Mbit(self) -> float:
        """What waits for a downlink."""
        return float(self.memory[STORED_MBIT])

    @property
    def downlinked_Mbit(self) -> float:
        """What has gone down."""
        return float(self.memory[DOWNLINKED_MBIT])

    def store(self, size_Mbit: float) -> bool:
        """Take a frame; False when it does not fit, and it is lost."""
        if self._stuck or self.stored_Mbit + size_Mbit > self._capacity_Mbit:
            return False
        self.memory[STORED_MBIT] += size_Mbit
        return True

    def play(self, dt_s: float, rate_Mbit_s: float) -> None:
        """Send to the ground for `dt_s`."""
        self.memory[RATE_MBIT_S] = rate_Mbit_s
        play(self.memory, dt_s)

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`stuck`: it takes no more frames."""
        del parameters
        if mode != "stuck":
            refuse_fault(self, mode)
        self._stuck = active


class Radio:
    """States off, on, downlinking. It transmits wherever it points; only an antenna on the Earth gets data down."""

    def __init__(self, config: SpacecraftConfig) -> None:
        self._rate_Mbit_s = config.downlink_Mbit_s
        self._power_W = {"off": 0.0, "on": config.radio_on_W, "downlinking": config.radio_downlinking_W}
        self._silent = False
        self._factor = 1.0
        self.state = "off"

    def __repr__(self) -> str:
        return f"Radio({self.state})"

    @property
    def power_W(self) -> float:
        """Power drawn from the bus."""
        return self._power_W[self.state]

    def power(self, on: bool) -> str | None:
        """Transmitter on or off; off ends a downlink."""
        if not on:
            self.state = "off"
        elif self.state == "off" and not self._silent:
            self.state = "on"
        return None

    def downlink(self, on: bool) -> str | None:
        """Start or end playing the recorder to the ground."""
        if self.state == "off":
            return "radio.downlink needs the radio on, found state off"
        self.state = "downlinking" if on else "on"
        return None

    def trip(self) -> None:
        """The bus gave way."""
        self.state = "off"

    @property
    def rate_Mbit_s(self) -> float:
        """What it sends while playing the recorder."""
        return self._factor * self._rate_Mbit_s if self.state == "downlinking" else 0.0

    def telemetry(self) -> dict[str, str]:
        """The state."""
        return {"radio.state": self.state}

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`silent`: the transmitter is off and stays so. `slow`: the downlink runs at `factor` of its rate."""
        if mode == "silent":
            self._silent = active
            if active:
                self.state = "off"
        elif mode == "slow":
            self._factor = parameters["factor"] if active else 1.0
        else:
            refuse_fault(self, mode)
