"""Observation against expectation: violations as values, and fault protection over telemetry as data.

Monitor, conclusion and response are kept apart: whatever else can explain telemetry may draw the same conclusions.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from executive.bindings import Conclusion, Monitor, Response
from executive.commands import CommandLink
from executive.conditions import Telemetry, Watch
from executive.journal import Journal

ViolationKind = Literal[
    "early", "late", "unconfirmed", "refused", "lock", "incompatible", "fault", "dispatch", "standby", "stalled"
]

REPLAN = "replan"
"""The response that is left when no other helped: a plan that knows of the conclusion."""


@dataclass(frozen=True, slots=True)
class Violation:
    """Something that the plan in execution does not allow. `token`: the one that failed, if it was one."""

    kind: ViolationKind
    detail: str
    token: str | None = None
    conclusion: Conclusion | None = None

    @property
    def words(self) -> str:
        """For people: what was concluded, and from what; without a conclusion what was seen."""
        if self.conclusion is None:
            return f"{self.kind}: {self.detail}"
        return f"{self.conclusion.text} ({self.kind}: {self.detail.removesuffix(f': {self.conclusion.text}')})"


@dataclass(frozen=True, slots=True)
class FaultRecord:
    """One fault: who saw it, when (seconds), what was concluded (None so far), and the responses tried."""

    monitor: str
    detected: int
    diagnosis: str | None = None
    responses: tuple[str, ...] = ()


class Conclusions:
    """What has been concluded about devices in this run, in order, each once; and the record of faults."""

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        self._drawn: dict[str, Conclusion] = {}
        self._faults: list[FaultRecord] = []

    @property
    def names(self) -> frozenset[str]:
        """The names of all conclusions."""
        return frozenset(self._drawn)

    @property
    def faults(self) -> tuple[FaultRecord, ...]:
        """The faults detected so far, in order."""
        return tuple(self._faults)

    def detected(self, monitor: str, now: int, *, tell: bool) -> int:
        """Record a symptom, `tell`ing of it before anything is concluded; returns its place in the record."""
        if tell:
            self._journal.write(now, "fault.detected", {"monitor": monitor, "diagnosis": None})
        self._faults.append(FaultRecord(monitor, now))
        return len(self._faults) - 1

    def draw(self, conclusion: Conclusion, monitor: str, now: int, place: int | None = None) -> None:
        """Take it as true from now on; the fault at `place` gets its diagnosis, or a new fault is recorded."""
        if conclusion.name in self._drawn:
            return
        self._drawn[conclusion.name] = conclusion
        self._journal.write(
            now, "fault.detected", {"monitor": monitor, "diagnosis": conclusion.name, "text": conclusion.text}
        )
        if place is None:
            place = self.detected(monitor, now, tell=False)
        fault = self._faults[place]
        self._faults[place] = FaultRecord(fault.monitor, fault.detected, conclusion.name, fault.responses)

    def responded(self, place: int, response: str, now: int) -> None:
        """Record that a response to the fault at `place` was started."""
        fault = self._faults[place]
        self._journal.write(now, "fault.response", {"monitor": fault.monitor, "response": response})
        self._faults[place] = FaultRecord(fault.monitor, fault.detected, fault.diagnosis, (*fault.responses, response))

    def replanned(self, conclusion: Conclusion, now: int) -> None:
        """Record that the response to what was concluded is another plan, once."""
        for place, fault in enumerate(self._faults):
            if fault.diagnosis == conclusion.name and REPLAN not in fault.responses:
                self.responded(place, REPLAN, now)


class _Vigil:
    """One monitor at work: watching, responding, or silent."""

    def __init__(self, monitor: Monitor) -> None:
        self.monitor = monitor
        self.silent = False
        self._watch = Watch(monitor.conditions, monitor.persistence, {})
        self._place: int | None = None
        self._left: list[Response] = []
        self._respond_until: int | None = None

    def update(self, telemetry: Telemetry, now: int, link: CommandLink, conclusions: Conclusions) -> Violation | None:
        """One observation: what it means, with responses started as needed."""
        present = self._watch.update(telemetry, now)
        if self._place is None:
            if not present:
                return None
            self._place = conclusions.detected(self.monitor.name, now, tell=bool(self.monitor.responses))
            self._left = [r for r in self.monitor.responses for _ in range(r.attempts)]
        elif not present and self._watch.due(now) is None:
            self._place, self._respond_until = None, None  # the symptom is gone
            return None
        elif self._respond_until is not None and now < self._respond_until:
            return None
        if self._left:
            response = self._left.pop(0)
            conclusions.responded(self._place, response.name, now)
            link.forget(link.send(response.commands, {}, f"monitor {self.monitor.name}", now))
            self._respond_until = now + response.within
            return None
        self.silent = True
        conclusions.draw(self.monitor.conclusion, self.monitor.name, now, self._place)
        if not self.monitor.replan:
            return None
        conclusion = self.monitor.conclusion
        return Violation("fault", f"{self.monitor.name}: {conclusion.text}", None, conclusion)

    def due(self, now: int) -> int | None:
        """The next second at which waiting alone changes something."""
        if self.silent:
            return None
        return self._watch.due(now) if self._respond_until is None else self._respond_until


class FaultProtection:
    """All monitors of a domain, asked at every observation in the order in which they are given."""

    def __init__(self, monitors: Iterable[Monitor], link: CommandLink, conclusions: Conclusions) -> None:
        self._vigils = tuple(_Vigil(monitor) for monitor in monitors)
        self._link = link
        self._conclusions = conclusions

    def update(self, telemetry: Telemetry, now: int) -> list[Violation]:
        """What the monitors say of this observation; conclusions are drawn and responses sent on the way."""
        found = []
        for vigil in self._vigils:
            if not vigil.silent:
                violation = vigil.update(telemetry, now, self._link, self._conclusions)
                if violation is not None:
                    found.append(violation)
        return found

    def dues(self, now: int) -> Iterable[int]:
        """The seconds at which waiting alone changes something."""
        return (due for vigil in self._vigils if (due := vigil.due(now)) is not None)
