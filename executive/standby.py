"""Standby: safe without a plan, and proven to be so by telemetry."""

from __future__ import annotations

from executive.bindings import Bindings
from executive.commands import CommandLink, Transmission
from executive.conditions import Telemetry, Watch
from executive.journal import Journal
from executive.monitor import Violation


class StandbyKeeper:
    """Brings the hardware to standby and says whether it is there; a keeper serves one stay."""

    def __init__(self, bindings: Bindings, link: CommandLink, journal: Journal) -> None:
        self._standby = bindings.standby
        self._link = link
        self._journal = journal
        self._transmission: Transmission | None = None
        self._holds = Watch((), 0, {})

    def enter(self, reason: str, telemetry: Telemetry, now: int) -> None:
        """Send the commands."""
        self._journal.write(now, "standby.entered", {"reason": reason})
        self._send(telemetry, now)

    def _send(self, telemetry: Telemetry, now: int) -> None:
        self._transmission = Transmission(self._link, self._standby.commands, self._standby.confirmation, {}, "standby")
        self._holds = Watch(self._standby.confirmation.conditions, 0, telemetry)
        self._transmission.send(telemetry, now)

    def observe(self, telemetry: Telemetry, now: int) -> Violation | None:
        """One observation. A failure to reach standby is a violation, and the commands go out once more."""
        if self._transmission is None:
            return None
        progress = self._transmission.follow(telemetry, now)
        if progress == "pending":
            return None
        detail = self._transmission.complaint(progress, telemetry)
        self._transmission.close()
        if progress == "confirmed":
            self._transmission = None
            return None
        self._send(telemetry, now)
        return Violation("standby", detail, None, self._standby.confirmation.conclusion)

    def is_reached(self, telemetry: Telemetry, now: int) -> bool:
        """Telemetry confirmed standby since the commands went out, and it still holds."""
        return self._transmission is None and self._holds.update(telemetry, now)

    def resume(self, telemetry: Telemetry, now: int) -> None:
        """Standby was reached and lost again: the commands go out once more."""
        if self._transmission is None and not self._holds.update(telemetry, now):
            self._send(telemetry, now)

    def dues(self, now: int) -> list[int]:
        """The seconds at which waiting alone changes something."""
        return [] if self._transmission is None else [self._transmission.due(now)]

    def leave(self, now: int) -> None:
        """A plan takes over."""
        self._journal.write(now, "standby.left")
