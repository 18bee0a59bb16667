"""Flight rules: what must never be seen, whatever planner and executive believe.

Judged second by second from telemetry and from the commands on the bus alone; a rule that has a grace time is broken
once what it forbids has lasted longer. Limits are the hardware's, stated here a second time on purpose.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from executive.port import TelemetryValue

Telemetry = Mapping[str, TelemetryValue]

CAMERA_SUN_DEG = 40.0
"""The Sun stays this far from the camera's boresight, +Z."""
SUN_SENSOR_DEG = 64.0
"""The Sun stays this near to the axis of the fine Sun sensor, half-way between +X and -Z (assumption)."""
BATTERY_FLOOR = 0.4
WHEEL_LIMIT_RAD_S = 620.0
ANTENNA_RAD = math.radians(0.5)
PROPELLANT_RESERVE_KG = 1.0
ATTITUDE_KNOWN_RAD = 1.0e-3


@dataclass(frozen=True, slots=True)
class BusCommand:
    """A command as it was on the bus: the terminal that it went to, and whether that answered at once."""

    name: str
    terminal: str
    answered: bool


Commands = Sequence[BusCommand]


@dataclass(frozen=True, slots=True)
class FlightRule:
    """A rule: a name, what it says, whether what is seen breaks it, and the seconds for which that is let pass.

    `broken` is given the telemetry and the commands of one second, in their order on the bus.
    """

    name: str
    text: str
    broken: Callable[[Telemetry, Commands], bool]
    grace_s: int = 0


def _both(one: tuple[str, str], other: tuple[str, str]) -> Callable[[Telemetry, Commands], bool]:
    """Broken while two channels say these words."""
    (channel, word), (second_channel, second_word) = one, other
    return lambda t, _: t[channel] == word and t[second_channel] == second_word


def _over_speed(t: Telemetry, _: Commands) -> bool:
    return max(abs(float(t[wheel])) for wheel in _WHEELS) > WHEEL_LIMIT_RAD_S


def _sun_towards(t: Telemetry, x: float, z: float) -> float | None:
    """Cosine between a direction of the body's XZ plane and the Sun as its sensors see it; None: they see nothing."""
    sun_x, sun_y, sun_z = float(t["sun_sensor.x"]), float(t["sun_sensor.y"]), float(t["sun_sensor.z"])
    square = sun_x * sun_x + sun_y * sun_y + sun_z * sun_z
    return None if square < 0.25 else (x * sun_x + z * sun_z) / math.sqrt(square)


def _sun_in_camera(t: Telemetry, _: Commands) -> bool:
    cosine = _sun_towards(t, 0.0, 1.0)
    return cosine is not None and cosine > _CAMERA_COS


def _sun_lost(t: Telemetry, _: Commands) -> bool:
    cosine = _sun_towards(t, _HALF, -_HALF)
    return cosine is not None and cosine < _SENSOR_COS


def _talked_over(t: Telemetry, commands: Commands) -> bool:
    """Two commands to one terminal in a second, the earlier one without an answer."""
    del t
    silent: set[str] = set()
    for command in commands:
        if command.terminal in silent:
            return True
        if not command.answered:
            silent.add(command.terminal)
    return False


def _over_drawn(t: Telemetry, _: Commands) -> bool:
    return float(t["power.margin_W"]) < 0.0 and t["acs.state"] == "settled"


def _off_earth(t: Telemetry, _: Commands) -> bool:
    at_earth = t["acs.target"] == "earth" and float(t["acs.error_rad"]) <= ANTENNA_RAD
    return t["radio.state"] == "downlinking" and not at_earth


def _blind_work(t: Telemetry, _: Commands) -> bool:
    known = float(t["acs.estimate_sigma_rad"]) <= ATTITUDE_KNOWN_RAD
    return not known and (t["micas.state"] == "exposing" or t["ips.state"] == "thrusting")


_WHEELS = tuple(f"wheels.speed_{n}_rad_s" for n in (1, 2, 3, 4))
_HALF = math.sqrt(0.5)
_CAMERA_COS, _SENSOR_COS = math.cos(math.radians(CAMERA_SUN_DEG)), math.cos(math.radians(SUN_SENSOR_DEG))
_EXPOSING, _THRUSTING, _TURNING = ("micas.state", "exposing"), ("ips.state", "thrusting"), ("acs.state", "slewing")

FLIGHT_RULES = (
    FlightRule(
        "no-thrust-while-exposing",
        "the engine does not thrust while the camera exposes",
        _both(_EXPOSING, _THRUSTING),
    ),
    FlightRule(
        "no-turn-while-exposing",
        "the spacecraft does not turn while the camera exposes, but for half a minute after it lost its target",
        _both(_EXPOSING, _TURNING),
        grace_s=30,
    ),
    FlightRule(
        "no-thrust-while-turning",
        "the engine thrusts along a heading that is held, but for half a minute after it was lost",
        _both(_THRUSTING, _TURNING),
        grace_s=30,
    ),
    FlightRule("sun-out-of-camera", f"the Sun is never within {CAMERA_SUN_DEG:g} deg of the boresight", _sun_in_camera),
    FlightRule("sun-on-sensor", f"the Sun is always within {SUN_SENSOR_DEG:g} deg of the Sun sensor's axis", _sun_lost),
    FlightRule("bus-voltage", "the bus is never under its voltage", lambda t, _: t["power.bus"] == "undervoltage"),
    FlightRule(
        "battery-floor",
        f"the battery keeps at least {BATTERY_FLOOR:.0%} charge",
        lambda t, _: float(t["battery.soc"]) < BATTERY_FLOOR,
    ),
    FlightRule(
        "power-within-supply",
        "in a settled attitude the arrays carry all loads, once the wings have had ten minutes to follow",
        _over_drawn,
        grace_s=600,
    ),
    FlightRule("wheel-speed", f"no wheel turns faster than {WHEEL_LIMIT_RAD_S:g} rad/s", _over_speed),
    FlightRule(
        "one-command-at-a-time", "a terminal gets no command while one before it waits for its answer", _talked_over
    ),
    FlightRule(
        "downlink-to-earth",
        "the radio plays to the Earth, within its beam, but for half a minute after it was lost",
        _off_earth,
        grace_s=30,
    ),
    FlightRule(
        "attitude-known", "nothing exposes or thrusts with an attitude that is not known", _blind_work, grace_s=30
    ),
    FlightRule(
        "propellant-reserve",
        f"{PROPELLANT_RESERVE_KG:g} kg of xenon and of hydrazine stay",
        lambda t, _: (
            float(t["ips.xenon_kg"]) < PROPELLANT_RESERVE_KG or float(t["rcs.hydrazine_kg"]) < PROPELLANT_RESERVE_KG
        ),
    ),
)


@dataclass(frozen=True, slots=True)
class RuleViolation:
    """A rule broken: what it forbids was seen from `start` on (seconds), up to and including `end`."""

    rule: str
    start: int
    end: int


class RuleWatch:
    """Looks second by second, and keeps each unbroken stretch of violation as one."""

    def __init__(self) -> None:
        self._grace = {rule.name: rule.grace_s for rule in FLIGHT_RULES}
        self._open: dict[str, tuple[int, int]] = {}
        self._closed: list[RuleViolation] = []

    def look(self, time: int, telemetry: Telemetry, commands: Commands = ()) -> None:
        """One second."""
        for rule in FLIGHT_RULES:
            if rule.broken(telemetry, commands):
                start, _ = self._open.get(rule.name, (time, time))
                self._open[rule.name] = (start, time)
            elif self._open and rule.name in self._open:
                self._close(rule.name, self._closed)

    def violations(self) -> tuple[RuleViolation, ...]:
        """All so far, those that still last included, in order of their start."""
        found = list(self._closed)
        for name, (start, end) in self._open.items():
            if end - start >= self._grace[name]:
                found.append(RuleViolation(name, start, end))
        return tuple(sorted(found, key=lambda v: (v.start, v.rule)))

    def _close(self, name: str, into: list[RuleViolation]) -> None:
        start, end = self._open.pop(name)
        if end - start >= self._grace[name]:
            into.append(RuleViolation(name, start, end))
