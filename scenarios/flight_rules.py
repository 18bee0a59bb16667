"""Flight rules: what must never be seen in telemetry, whatever planner and executive believe."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from executive.port import TelemetryValue

Telemetry = Mapping[str, TelemetryValue]


@dataclass(frozen=True, slots=True)
class FlightRule:
    """A rule: a name, what it says, and whether telemetry breaks it."""

    name: str
    text: str
    broken: Callable[[Telemetry], bool]


def _over_speed(telemetry: Telemetry) -> bool:
    return any(abs(float(telemetry[f"wheels.speed_{n}_rad_s"])) > 620.0 for n in (1, 2, 3, 4))


FLIGHT_RULES = (
    FlightRule(
        "no-thrust-while-exposing",
        "the engine does not thrust while the camera exposes",
        lambda t: t["micas.state"] == "exposing" and t["ips.state"] == "thrusting",
    ),
    FlightRule(
        "no-turn-while-exposing",
        "the spacecraft does not turn while the camera exposes",
        lambda t: t["micas.state"] == "exposing" and t["acs.state"] == "slewing",
    ),
    FlightRule("bus-voltage", "the bus is never under its voltage", lambda t: t["power.bus"] == "undervoltage"),
    FlightRule("battery-floor", "the battery keeps at least 40 % charge", lambda t: float(t["battery.soc"]) < 0.4),
    FlightRule("wheel-speed", "no wheel comes near its speed limit", _over_speed),
)


@dataclass(frozen=True, slots=True)
class RuleViolation:
    """A rule broken from `start` on (seconds), up to and including `end`."""

    rule: str
    start: int
    end: int


class RuleWatch:
    """Looks at telemetry second by second, and keeps each unbroken stretch of violation as one."""

    def __init__(self) -> None:
        self._open: dict[str, tuple[int, int]] = {}
        self._closed: list[RuleViolation] = []

    def look(self, time: int, telemetry: Telemetry) -> None:
        """One observation."""
        for rule in FLIGHT_RULES:
            if rule.broken(telemetry):
                start, _ = self._open.get(rule.name, (time, time))
                self._open[rule.name] = (start, time)
            elif rule.name in self._open:
                self._closed.append(RuleViolation(rule.name, *self._open.pop(rule.name)))

    def violations(self) -> tuple[RuleViolation, ...]:
        """All so far, those that still last included, in order of their start."""
        lasting = (RuleViolation(name, *span) for name, span in self._open.items())
        return tuple(sorted((*self._closed, *lasting), key=lambda v: (v.start, v.rule)))
