"""Observation against expectation: violations and findings as values, and the monitors that find.

A finding says for which conclusion telemetry speaks now. Who finds it does not matter to what is done about it:
monitors here, a model-based diagnosis by the same protocol.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, Protocol

from executive.conditions import Condition, Telemetry, Watch
from executive.protection import Monitor
from executive.sends import Conclusion

ViolationKind = Literal[
    "early",
    "late",
    "short",
    "unconfirmed",
    "refused",
    "lock",
    "incompatible",
    "fault",
    "dispatch",
    "standby",
    "stalled",
]


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
class Finding:
    """What speaks for a conclusion now, by the name of who found it."""

    source: str
    conclusion: Conclusion


class Diagnoser(Protocol):
    """Whoever explains telemetry. Asked at every observation; a finding lasts as long as it is given again."""

    def update(self, telemetry: Telemetry, now: int) -> Iterable[Finding]:
        """What telemetry speaks for at this observation, in an order that depends on nothing else."""
        ...

    def dues(self, now: int) -> Iterable[int]:
        """The seconds at which waiting alone changes that."""
        ...


class Monitors:
    """A domain's monitors, asked in the order in which they are given."""

    def __init__(self, monitors: Iterable[Monitor]) -> None:
        self._watched = tuple((monitor, Watch((), monitor.persistence, {})) for monitor in monitors)
        self._lasting: set[str] = set()

    def update(self, telemetry: Telemetry, now: int) -> Iterable[Finding]:
        """The monitors whose symptom has lasted."""
        found = []
        for monitor, watch in self._watched:
            if monitor.name in self._lasting and not _all(monitor.until, telemetry):
                found.append(Finding(monitor.name, monitor.conclusion))
                continue
            self._lasting.discard(monitor.name)
            if watch.hold(is_present(monitor, telemetry), now):
                found.append(Finding(monitor.name, monitor.conclusion))
                if monitor.until:
                    self._lasting.add(monitor.name)
        return found

    def dues(self, now: int) -> Iterable[int]:
        """When a symptom that is there now will have lasted."""
        return (due for _, watch in self._watched if (due := watch.due(now)) is not None)


def is_present(monitor: Monitor, telemetry: Telemetry) -> bool:
    """Whether the evidence is there at this instant: all conditions, and enough of the votes."""
    votes = sum(vote.holds(telemetry) for vote in monitor.votes)
    return votes >= monitor.needed and _all(monitor.conditions, telemetry)


def _all(conditions: Iterable[Condition], telemetry: Telemetry) -> bool:
    return all(condition.holds(telemetry) for condition in conditions)
