"""What has been concluded about devices, what follows from it, and the record of faults. The journal tells of each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from executive.bindings import Bindings
from executive.conditions import Telemetry
from executive.journal import Journal
from executive.port import TelemetryValue
from executive.protection import Response, concluded_channel
from executive.sends import Conclusion
from planner.problem import TokenPattern

REPLAN = "replan"
"""The response that is left when no other helped: a plan that knows of the conclusion."""


@dataclass(frozen=True, slots=True)
class FaultRecord:
    """One fault: who saw it, when (seconds), what was concluded, the responses tried, and when one of them worked."""

    monitor: str
    detected: int
    diagnosis: str | None = None
    responses: tuple[str, ...] = ()
    recovered: int | None = None


class Conclusions:
    """The conclusions that stand, each at most once, and every fault so far in order."""

    def __init__(self, bindings: Bindings, journal: Journal) -> None:
        self._bindings = bindings
        self._journal = journal
        self._standing: dict[str, Conclusion] = {}
        self._under_way: set[str] = set()
        self._worked_around: set[str] = set()
        self._faults: list[FaultRecord] = []
        known = {conclusion.name: concluded_channel(conclusion) for conclusion in bindings.conclusions()}
        self._channels = tuple((channel, name) for name, channel in known.items())
        self._vetoes: dict[str, TelemetryValue | None] = {}

    @property
    def names(self) -> frozenset[str]:
        """The names of all conclusions that stand."""
        return frozenset(self._standing)

    @property
    def planned_for(self) -> frozenset[str]:
        """The names of those that a plan depends on: not what is being recovered from or is worked around."""
        return frozenset(
            name
            for name, conclusion in self._standing.items()
            if name not in self._under_way
            and name not in self._worked_around
            and ((response := self._bindings.response(conclusion)) is None or response.replan != "never")
        )

    def channels(self) -> Mapping[str, bool]:
        """What monitors and recoveries may ask of conclusions: whether each stands, by channel."""
        return {channel: name in self._standing for channel, name in self._channels}

    @property
    def faults(self) -> tuple[FaultRecord, ...]:
        """The faults detected so far, in order."""
        return tuple(self._faults)

    @property
    def facts(self) -> tuple[TokenPattern, ...]:
        """What has to be in every planning problem from now on."""
        return tuple(fact for response in self._responses() for fact in response.facts)

    @property
    def waived(self) -> frozenset[str]:
        """The channels that standby does not depend on."""
        return frozenset(name for response in self._responses() for name in response.waives)

    def response(self, conclusion: Conclusion) -> Response | None:
        """What is done about a conclusion."""
        return self._bindings.response(conclusion)

    def stands(self, conclusion: Conclusion) -> bool:
        """Whether it is taken as true."""
        return conclusion.name in self._standing

    def following(self, conclusion: Conclusion | None) -> Conclusion | None:
        """What speaks for `conclusion` now says: `otherwise` if it stands already and there is no recovery from it."""
        response = None if conclusion is None else self._bindings.response(conclusion)
        if conclusion is None or response is None or response.recoveries or not self.stands(conclusion):
            return conclusion
        return response.otherwise or conclusion

    def forbids(self, command: str) -> str | None:
        """The conclusion because of which a command is not to be sent; None when it may be."""
        for name, conclusion in self._standing.items():
            response = self._bindings.response(conclusion)
            if response is not None and command.startswith(response.forbids):
                return name
        return None

    def believed(self, seen: Telemetry) -> Mapping[str, TelemetryValue]:
        """Telemetry as it is believed: what vetoed sensors say is replaced."""
        if not self._vetoes:
            return seen
        values = {name: value for name, value in seen.items() if name not in self._vetoes}
        return values | {name: value for name, value in self._vetoes.items() if value is not None}

    def draw(
        self, conclusion: Conclusion, monitor: str, now: int, place: int | None = None, *, under_way: bool = False
    ) -> int | None:
        """Take it as true from now on; returns the fault's place in the record, None if it stood already.

        `place`: of a fault that gets another diagnosis by it. `under_way`: a recovery from it is being tried.
        """
        if conclusion.name in self._standing:
            return None
        self._standing[conclusion.name] = conclusion
        if under_way:
            self._under_way.add(conclusion.name)
        entry = {"monitor": monitor, "diagnosis": conclusion.name, "text": conclusion.text}
        self._journal.write(now, "fault.detected", entry)
        if place is None:
            self._faults.append(FaultRecord(monitor, now, conclusion.name))
            place = len(self._faults) - 1
        else:
            self._faults[place] = replace(self._faults[place], diagnosis=conclusion.name)
        self._revise()
        if (response := self._bindings.response(conclusion)) is not None:
            for words in _standing_measures(response):
                self.responded(place, words, now)
        return place

    def settle(self, conclusion: Conclusion, *, stands: bool, worked_around: bool = False) -> None:
        """Nothing is tried about it any more: it stands for good, if only worked around, or is not true any more."""
        self._under_way.discard(conclusion.name)
        if worked_around:
            self._worked_around.add(conclusion.name)
        if not stands:
            self._standing.pop(conclusion.name, None)
        self._revise()

    def responded(self, place: int, response: str, now: int) -> None:
        """Record that a response to the fault at `place` was started."""
        fault = self._faults[place]
        self._journal.write(now, "fault.response", {"monitor": fault.monitor, "response": response})
        self._faults[place] = replace(fault, responses=(*fault.responses, response))

    def recovered(self, place: int, now: int, *, cured: bool) -> None:
        """Record that the fault at `place` is cured, or, if not, worked around."""
        fault = self._faults[place]
        entry = {"monitor": fault.monitor, "diagnosis": fault.diagnosis, "cured": cured}
        self._journal.write(now, "fault.recovered", entry)
        self._faults[place] = replace(fault, recovered=now)

    def replanned(self, conclusion: Conclusion, now: int) -> None:
        """Record that the response to what was concluded is another plan, once."""
        for place, fault in enumerate(self._faults):
            if fault.diagnosis == conclusion.name and REPLAN not in fault.responses:
                self.responded(place, REPLAN, now)

    def _responses(self) -> Iterator[Response]:
        """What is done about the conclusions that stand."""
        for conclusion in self._standing.values():
            if (response := self._bindings.response(conclusion)) is not None:
                yield response

    def _revise(self) -> None:
        self._vetoes = {name: value for response in self._responses() for name, value in response.vetoes.items()}


def _standing_measures(response: Response) -> Iterator[str]:
    """What takes effect at once with a conclusion, in words."""
    for channel, value in response.vetoes.items():
        yield f"veto {channel}" + ("" if value is None else f", believe {value}")
    for prefix in response.forbids:
        yield f"no more commands {prefix}*"
