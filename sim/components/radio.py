"""The radio's transmitter and the recorder that it empties."""

from __future__ import annotations

from collections.abc import Mapping

from sim.components.hooks import refuse_fault
from sim.config import SpacecraftConfig


class Recorder:
    """Megabits in, megabits out."""

    def __init__(self, capacity_Mbit: float) -> None:
        self._capacity_Mbit = capacity_Mbit
        self.stored_Mbit = 0.0
        self.downlinked_Mbit = 0.0

    def __repr__(self) -> str:
        return f"Recorder({self.stored_Mbit:.1f} of {self._capacity_Mbit:.0f} Mbit)"

    def store(self, size_Mbit: float) -> bool:
        """Take a frame; False when it does not fit, and it is lost."""
        if self.stored_Mbit + size_Mbit > self._capacity_Mbit:
            return False
        self.stored_Mbit += size_Mbit
        return True

    def play(self, size_Mbit: float) -> None:
        """Send up to `size_Mbit` to the ground and drop it here."""
        sent = min(size_Mbit, self.stored_Mbit)
        self.stored_Mbit -= sent
        self.downlinked_Mbit += sent

    def telemetry(self) -> dict[str, float]:
        """What it holds and what has gone down."""
        return {"recorder.stored_Mbit": self.stored_Mbit, "recorder.downlinked_Mbit": self.downlinked_Mbit}

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """No failure modes yet."""
        del active, parameters
        refuse_fault(self, mode)


class Radio:
    """States off, on, downlinking. It transmits wherever it points; only an antenna on the Earth gets data down."""

    def __init__(self, config: SpacecraftConfig) -> None:
        self._rate_Mbit_s = config.downlink_Mbit_s
        self._power_W = {"off": 0.0, "on": config.radio_on_W, "downlinking": config.radio_downlinking_W}
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
        elif self.state == "off":
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

    def step(self, dt_s: float, earth_in_beam: bool) -> float:
        """Megabits that `dt_s` brings to the ground."""
        return self._rate_Mbit_s * dt_s if self.state == "downlinking" and earth_in_beam else 0.0

    def telemetry(self) -> dict[str, str]:
        """The state."""
        return {"radio.state": self.state}

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """No failure modes yet."""
        del active, parameters
        refuse_fault(self, mode)
