"""Standby: safe without a plan, and proven to be so by telemetry."""

from __future__ import annotations

from dataclasses import replace

from executive.bindings import Bindings
from executive.commands import CommandLink, Transmission
from executive.conclusions import Conclusions
from executive.conditions import Telemetry, Watch
from executive.journal import Journal
from executive.monitor import Violation


class StandbyKeeper:
    """Brings the hardware to standby and says whether it is there; a keeper serves one stay.

    What is concluded of a device decides which of standby's conditions it has to meet.
    """

    def __init__(self, bindings: Bindings, link: CommandLink, conclusions: Conclusions, journal: Journal) -> None:
        self._standby = bindings.standby
        self._conclusions = conclusions
        self._link = link
        self._journal = journal
        self._transmission: Transmission | None = None
        self._holds = Watch((), 0, {})
        self._waived: frozenset[str] = frozenset()

    def enter(self, reason: str, telemetry: Telemetry, now: int) -> None:
        """Send the commands."""
        self._journal.write(now, "standby.entered", {"reason": reason})
        self._send(telemetry, now)

    def _send(self, telemetry: Telemetry, now: int) -> None:
        self._waived = self._conclusions.waived
        wanted = self._standby.confirmation
        kept = tuple(c for c in wanted.conditions if self._waived.isdisjoint(c.channels()))
        self._transmission = Transmission(
            self._link, self._standby.commands, replace(wanted, conditions=kept), {}, "standby"
        )
        self._holds = Watch(kept, 0, telemetry)
        self._transmission.send(telemetry, now)

    def observe(self, telemetry: Telemetry, now: int) -> Violation | None:
        """One observation. A failure to reach standby is a violation, and the commands go out once more."""
        if self._transmission is None:
            return None
        if self._waived != self._conclusions.waived:
            self._transmission.close()
            self._send(telemetry, now)
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
