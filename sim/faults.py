"""What can break: one row a fault, and the schedule that starts and ends them.

A row names the component and the failure mode that the component's `set_fault` knows, and the parameters with their
defaults. A new fault is a new row and, where the mode is new, a branch in that component's `set_fault`.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

from sim.errors import ConfigurationError


class FaultHook(Protocol):
    """A component that can fail."""

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """Begin or end a failure mode; `ConfigurationError` for one that the component does not have."""
        ...


@dataclass(frozen=True, slots=True)
class FaultParameter:
    """A number that shapes a fault: default and the range it may have (ends included)."""

    name: str
    default: float
    minimum: float
    maximum: float
    meaning: str


@dataclass(frozen=True, slots=True)
class Fault:
    """A row of the table."""

    name: str
    component: str
    mode: str
    meaning: str
    parameters: tuple[FaultParameter, ...] = ()


_TABLE = (
    Fault("micas-stuck-on", "micas", "stuck_on", "the camera's power switch no longer goes off; off is acknowledged"),
    Fault(
        "camera-warmup-slow",
        "micas",
        "slow_warmup",
        "the camera takes longer to warm up",
        (FaultParameter("factor", 3.0, 1.0, 100.0, "times the healthy duration"),),
    ),
    Fault("ips-start-fails", "ips", "start_blocked", "the ion engine's start never reaches ready"),
    Fault("ips-terminal-hung", "terminal.ips", "hung", "commands to the ion engine get no answer and do nothing"),
    Fault("micas-terminal-hung", "terminal.micas", "hung", "commands to the camera get no answer and do nothing"),
    Fault(
        "slow-slew",
        "acs",
        "slow_slew",
        "slews run at a fraction of their rate",
        (FaultParameter("factor", 0.25, 0.01, 1.0, "fraction of the rate limit"),),
    ),
    Fault(
        "array-degraded",
        "power",
        "array_loss",
        "the solar array gives a fraction of its power",
        (FaultParameter("factor", 0.8, 0.0, 1.0, "fraction of the healthy power"),),
    ),
)
FAULTS: Mapping[str, Fault] = MappingProxyType({fault.name: fault for fault in _TABLE})


class FaultSchedule:
    """Faults that wait for their time to begin or end. The same fault injected twice: the later begin or end counts."""

    def __init__(self, components: Mapping[str, FaultHook]) -> None:
        self._components = components
        self._queue: list[tuple[float, int, Fault, bool, Mapping[str, float]]] = []
        self._count = 0
        self.active: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"FaultSchedule(active: {', '.join(self.active) or 'none'}; {len(self._queue)} to come)"

    def add(self, name: str, at_s: float, end_s: float | None, parameters: Mapping[str, float]) -> None:
        """Schedule a fault from `at_s` to `end_s` (None: for good); `ConfigurationError` for what the table forbids."""
        if name not in FAULTS:
            raise ConfigurationError(f"fault: expected one of {', '.join(FAULTS)}, found {name!r}")
        fault = FAULTS[name]
        if not (math.isfinite(at_s) and at_s >= 0.0):
            raise ConfigurationError(f"fault {name}: expected a start at 0 s or later, found {at_s}")
        if end_s is not None and not (math.isfinite(end_s) and end_s > at_s):
            raise ConfigurationError(f"fault {name}: expected an end after its start at {at_s} s, found {end_s}")
        complete = _complete(fault, parameters)
        self._push(at_s, fault, True, complete)
        if end_s is not None:
            self._push(end_s, fault, False, complete)

    def update(self, time_s: float) -> None:
        """Begin and end what is due at `time_s` or before, in order of time, then of injection."""
        while self._queue and self._queue[0][0] <= time_s:
            _, _, fault, active, parameters = heapq.heappop(self._queue)
            self._components[fault.component].set_fault(fault.mode, active, parameters)
            others = tuple(name for name in self.active if name != fault.name)
            self.active = (*others, fault.name) if active else others

    def _push(self, time_s: float, fault: Fault, active: bool, parameters: Mapping[str, float]) -> None:
        self._count += 1
        heapq.heappush(self._queue, (time_s, self._count, fault, active, parameters))


def _complete(fault: Fault, given: Mapping[str, float]) -> Mapping[str, float]:
    known = {parameter.name: parameter for parameter in fault.parameters}
    for name, value in given.items():
        if name not in known:
            expected = ", ".join(known) or "none"
            raise ConfigurationError(f"fault {fault.name}: expected parameters {expected}, found {name!r}")
        low, high = known[name].minimum, known[name].maximum
        if not low <= value <= high:
            raise ConfigurationError(f"fault {fault.name}, {name}: expected {low:g} to {high:g}, found {value}")
    return MappingProxyType({name: given.get(name, parameter.default) for name, parameter in known.items()})
