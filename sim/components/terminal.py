"""A remote terminal of the data bus: takes a telecommand to its unit and acknowledges it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from sim.components.hooks import refuse_fault


@dataclass(frozen=True, slots=True)
class Acknowledgement:
    """A terminal's answer: taken, or not and why. Taken says nothing of whether the unit did it."""

    accepted: bool
    reason: str = ""


class BusTerminal:
    """Answers for one unit. A hung one is back after a reset, a dead one never; a mute one executes all the same."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.powered = True
        self._faults: set[str] = set()

    def __repr__(self) -> str:
        return f"BusTerminal({', '.join([self.name, *sorted(self._faults)])})"

    def deliver(self, execute: Callable[[], str | None]) -> Acknowledgement | None:
        """Pass a command to the unit, which gives the reason of a refusal or None; None when nobody answers."""
        if not self.powered or "hung" in self._faults or "dead" in self._faults:
            return None
        reason = execute()
        return None if "mute" in self._faults else Acknowledgement(reason is None, reason or "")

    def reset(self) -> str | None:
        """Start its electronics anew, by the bus controller's own line: ends a hang."""
        self._faults.discard("hung")
        return None

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`hung`: commands vanish until a reset. `dead`: for good. `mute`: executed, but the answer is lost."""
        del parameters
        if mode not in ("hung", "dead", "mute"):
            refuse_fault(self, mode)
        if active:
            self._faults.add(mode)
        else:
            self._faults.discard(mode)
