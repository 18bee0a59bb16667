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
    """Answers for one unit. A hung terminal neither executes nor answers."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._hung = False

    def __repr__(self) -> str:
        return f"BusTerminal({self.name}{', hung' if self._hung else ''})"

    def deliver(self, execute: Callable[[], str | None]) -> Acknowledgement | None:
        """Pass a command to the unit, which gives the reason of a refusal or None; None when nobody answers."""
        if self._hung:
            return None
        reason = execute()
        return Acknowledgement(reason is None, reason or "")

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`hung`: commands vanish without an answer."""
        del parameters
        if mode != "hung":
            refuse_fault(self, mode)
        self._hung = active
