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

from numpy.random import Generator

from sim.components.thrusters import NAMES
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
    """A row of the table. `lasts`: without an end it stays; otherwise it happens and is over, and may happen again."""

    name: str
    component: str
    mode: str
    meaning: str
    parameters: tuple[FaultParameter, ...] = ()
    lasts: bool = True


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
    Fault(
        "ips-recycle",
        "ips",
        "recycle",
        "the ion engine breaks off thrusting by itself and stays ready, or goes on by itself after a time",
        (FaultParameter("seconds", 0.0, 0.0, 3600.0, "until it goes on by itself; 0: it does not"),),
        lasts=False,
    ),
    Fault("gimbal-x-stuck", "gimbals", "stuck_x", "the ion engine's gimbal about X stays where it is"),
    Fault("gimbal-y-stuck", "gimbals", "stuck_y", "the ion engine's gimbal about Y stays where it is"),
    Fault("ips-terminal-hung", "terminal.ips", "hung", "commands to the ion engine get no answer and do nothing"),
    Fault("ips-confirmation-lost", "terminal.ips", "mute", "the ion engine executes commands, but no answer comes"),
    Fault("micas-terminal-hung", "terminal.micas", "hung", "commands to the camera get no answer and do nothing"),
    Fault("radio-terminal-hung", "terminal.radio", "hung", "commands to the radio get no answer and do nothing"),
    Fault("lpe-terminal-hung", "terminal.lpe", "hung", "the LPE's terminal does not answer until it is reset"),
    Fault("lpe-terminal-dead", "terminal.lpe", "dead", "the LPE's terminal does not answer, and a reset does not help"),
    Fault("neb1-status-false", "switchboard", "false_off_neb1", "NEB1's status sensor says off; the bus has power"),
    Fault("neb1-off", "switchboard", "open_neb1", "NEB1's relay is open: the star tracker has no power"),
    Fault("neb1s-off", "switchboard", "open_neb1s", "NEB1-S's relay is open: the thrusters' drive has no power"),
    Fault("neb2-off", "switchboard", "open_neb2", "NEB2's relay is open: no power for camera, PASM and ion engine"),
    Fault("pasm-status-false", "switchboard", "false_off_pasm", "PASM's status says off whatever it is"),
    *(
        Fault(f"thruster-{name}-closed", "rcs", f"closed_{name}", f"the valve of thruster {name.upper()} stays closed")
        for name in NAMES
    ),
    Fault("star-tracker-fails", "sensors", "tracker_fails", "the star tracker gives no more attitude"),
    Fault("sun-sensors-fail", "sensors", "sun_fails", "the Sun sensors see no Sun"),
    Fault(
        "gyro-bias-jumps",
        "sensors",
        "bias_jump",
        "the gyro's bias steps about every axis",
        (FaultParameter("size", 5.0, -100.0, 100.0, "degrees an hour"),),
    ),
    *(
        Fault(f"wheel-{n}-fails", "wheels", f"motor_{n}", f"the motor of wheel {n} gives no torque")
        for n in (1, 2, 3, 4)
    ),
    Fault(
        "wheel-friction",
        "wheels",
        "friction",
        "friction of all wheels grows",
        (FaultParameter("factor", 5.0, 1.0, 50.0, "times the healthy friction"),),
    ),
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
    Fault("wing-drives-stuck", "wings", "stuck", "the solar wings stay at the angle that they have"),
    Fault("radio-transmitter-fails", "radio", "silent", "the transmitter goes off and does not come on"),
    Fault(
        "radio-degraded",
        "radio",
        "slow",
        "the downlink runs at a fraction of its rate",
        (FaultParameter("factor", 0.5, 0.01, 1.0, "fraction of the healthy rate"),),
    ),
    Fault("acs-terminal-hung", "terminal.acs", "hung", "commands to the attitude control get no answer, do nothing"),
    Fault("pdu-terminal-hung", "terminal.pdu", "hung", "commands to the power unit get no answer and do nothing"),
    *(
        Fault(f"thruster-{name}-open", "rcs", f"open_{name}", f"the valve of thruster {name.upper()} does not close")
        for name in NAMES
    ),
    Fault("battery-heater-fails", "thermal", "battery_unheated", "the battery cools until it takes no more charge"),
    Fault("tank-heater-fails", "thermal", "tank_unheated", "the hydrazine tank cools until nothing flows"),
    Fault("recorder-stuck", "recorder", "stuck", "the recorder takes no more frames: images are lost"),
    Fault(
        "battery-degraded",
        "power",
        "battery_loss",
        "the battery holds a fraction of its charge",
        (FaultParameter("factor", 0.5, 0.01, 1.0, "fraction of the healthy capacity"),),
    ),
)
FAULTS: Mapping[str, Fault] = MappingProxyType({fault.name: fault for fault in _TABLE})


def random_faults(
    generator: Generator, rates_per_day: Mapping[str, float], horizon_s: float
) -> tuple[tuple[str, float], ...]:
    """Faults (name, begin in seconds) that come by chance: each by itself, at exponential intervals of its rate.

    In order of time. The same generator state, rates and horizon give the same faults, whatever the rates' order.
    """
    found: list[tuple[str, float]] = []
    for name in sorted(rates_per_day):
        rate = rates_per_day[name]
        if name not in FAULTS:
            raise ConfigurationError(f"fault rates: expected one of {', '.join(FAULTS)}, found {name!r}")
        if not (math.isfinite(rate) and rate >= 0.0):
            raise ConfigurationError(f"fault rates, {name}: expected a number a day of at least 0, found {rate}")
        at_s = 0.0
        while rate > 0.0 and (at_s := at_s + float(generator.exponential(86_400.0 / rate))) < horizon_s:
            found.append((name, at_s))
    return tuple(sorted(found, key=lambda fault: (fault[1], fault[0])))


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

    def update(self, time_s: float) -> bool:
        """Begin and end what is due at `time_s` or before, in order of time, then of injection; whether any was."""
        if not self._queue or self._queue[0][0] > time_s:
            return False
        while self._queue and self._queue[0][0] <= time_s:
            _, _, fault, active, parameters = heapq.heappop(self._queue)
            self._components[fault.component].set_fault(fault.mode, active, parameters)
            others = tuple(name for name in self.active if name != fault.name)
            self.active = (*others, fault.name) if active else others
        return True

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
