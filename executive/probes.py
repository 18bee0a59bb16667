"""Probes at work: commands that only a living unit answers, and what their answers say as telemetry."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Literal

from executive.commands import CommandLink
from executive.conditions import Telemetry
from executive.protection import Probe, probe_channel

State = Literal["unknown", "answers", "silent"]


class Prober:
    """Sends all probes of a domain when it is time."""

    def __init__(self, probes: Iterable[Probe], link: CommandLink) -> None:
        self._asked = tuple(_Question(probe, link) for probe in probes)

    def update(self, telemetry: Telemetry, now: int) -> Mapping[str, State]:
        """One observation: answers are taken in, and what is due is asked. By channel, how each probe stands."""
        return {probe_channel(q.probe.name): q.update(telemetry, now) for q in self._asked}

    def dues(self, now: int) -> Iterable[int]:
        """The seconds at which something is asked, or taken as not answered."""
        return (due for question in self._asked if (due := question.due()) is not None and due > now)


class _Question:
    """One probe: when it was last sent, and what came of it."""

    def __init__(self, probe: Probe, link: CommandLink) -> None:
        self.probe = probe
        self._link = link
        self._numbers: tuple[int, ...] = ()
        self._state: State = "unknown"
        self._due: int | None = None

    def update(self, telemetry: Telemetry, now: int) -> State:
        """Take in what was said, and ask if it is time."""
        wanted = all(condition.holds(telemetry) for condition in self.probe.while_)
        if not wanted or self._link.is_forbidden(self.probe.command.name):
            self._stop()
            return self._state
        if self._numbers:
            self._listen(now)
        if not self._numbers and (self._due is None or now >= self._due):
            self._numbers = self._link.send((self.probe.command,), {}, f"probe {self.probe.name}", now)
            self._due = now + self.probe.within
        return self._state

    def _listen(self, now: int) -> None:
        assert self._due is not None
        if self._link.answer(self._numbers[0]) is not None:
            self._state, self._due = "answers", self._due - self.probe.within + self.probe.every
        elif now >= self._due:
            self._state = "silent"
            self._link.timed_out(self._numbers, now)
        else:
            return
        self._link.forget(self._numbers)
        self._numbers = ()

    def _stop(self) -> None:
        self._link.forget(self._numbers)
        self._numbers, self._state, self._due = (), "unknown", None

    def due(self) -> int | None:
        """When it is asked next, or given up."""
        return self._due
