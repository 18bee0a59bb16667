"""Flight rules: each is broken once on purpose, and what only looks like a violation breaks none."""

from __future__ import annotations

from typing import Any

import pytest

from executive.port import Command
from scenarios.bridge import SpacecraftPlant
from scenarios.flight_rules import FLIGHT_RULES, BusCommand, RuleWatch
from sim import Spacecraft, SpacecraftConfig

HUNG = (BusCommand("radio.power", "radio", False), BusCommand("radio.downlink", "radio", False))
PLANTED: tuple[tuple[str, dict[str, Any], tuple[BusCommand, ...]], ...] = (
    ("no-thrust-while-exposing", {"micas.state": "exposing", "ips.state": "thrusting"}, ()),
    ("no-turn-while-exposing", {"micas.state": "exposing", "acs.state": "slewing"}, ()),
    ("no-thrust-while-turning", {"ips.state": "thrusting", "acs.state": "slewing"}, ()),
    ("sun-out-of-camera", {"sun_sensor.x": 0.6, "sun_sensor.y": 0.0, "sun_sensor.z": 0.8}, ()),
    ("sun-on-sensor", {"sun_sensor.x": 0.0, "sun_sensor.y": 1.0, "sun_sensor.z": 0.0}, ()),
    ("bus-voltage", {"power.bus": "undervoltage"}, ()),
    ("battery-floor", {"battery.soc": 0.39}, ()),
    ("power-within-supply", {"power.margin_W": -3.0}, ()),
    ("wheel-speed", {"wheels.speed_3_rad_s": -625.0}, ()),
    ("one-command-at-a-time", {}, HUNG),
    ("downlink-to-earth", {"radio.state": "downlinking", "acs.target": "thrust_a"}, ()),
    ("attitude-known", {"ips.state": "thrusting", "acs.estimate_sigma_rad": 2e-3}, ()),
    ("propellant-reserve", {"rcs.hydrazine_kg": 0.9}, ()),
)
ALSO = {"sun-out-of-camera": "sun-on-sensor"}
"""With the Sun in the camera its sensor, which looks the other way, has lost it."""
GRACE = {rule.name: rule.grace_s for rule in FLIGHT_RULES}


@pytest.fixture(scope="module")
def healthy() -> dict[str, Any]:
    return dict(Spacecraft(SpacecraftConfig(), 0).telemetry()) | {
        "sun_sensor.x": 0.7071,
        "sun_sensor.y": 0.0,
        "sun_sensor.z": -0.7071,
    }


def test_every_rule_is_planted() -> None:
    assert [rule.name for rule in FLIGHT_RULES] == [name for name, _, _ in PLANTED]
    assert len(GRACE) == len(FLIGHT_RULES)


@pytest.mark.parametrize(("name", "changes", "commands"), PLANTED)
def test_a_broken_rule_is_caught_from_its_first_to_its_last_second(
    healthy: dict[str, Any], name: str, changes: dict[str, Any], commands: tuple[BusCommand, ...]
) -> None:
    watch, grace = RuleWatch(), GRACE[name]
    stretches = [(5, 5 + grace + 2), (grace + 10, 2 * grace + 10), (2 * grace + 12, 3 * grace + 12)]
    let_pass = (3 * grace + 20, 4 * grace + 19)
    for second in range(4 * grace + 30):
        if any(start <= second <= end for start, end in (*stretches, let_pass)):
            watch.look(second, healthy | changes, commands)
        else:
            watch.look(second, healthy)
    found = [(v.start, v.end) for v in watch.violations() if v.rule == name]
    assert found == stretches
    assert {v.rule for v in watch.violations()} == {name, ALSO.get(name, name)}


@pytest.mark.parametrize(("name", "changes", "commands"), PLANTED)
def test_a_violation_that_lasts_to_the_end_is_told(
    healthy: dict[str, Any], name: str, changes: dict[str, Any], commands: tuple[BusCommand, ...]
) -> None:
    watch, last = RuleWatch(), 3 + GRACE[name]
    for second in range(3, last):
        watch.look(second, healthy | changes, commands)
    assert watch.violations() == ()
    watch.look(last, healthy | changes, commands)
    assert (name, 3, last) in [(v.rule, v.start, v.end) for v in watch.violations()]


@pytest.mark.parametrize(
    "changes",
    [
        {"micas.state": "exposing"},
        {"ips.state": "thrusting"},
        {"acs.state": "slewing"},
        {"radio.state": "downlinking"},
        {"acs.state": "slewing", "power.margin_W": -50.0},
        {"sun_sensor.x": 0.0, "sun_sensor.y": 0.0, "sun_sensor.z": 0.0},
        {"sun_sensor.x": 1.0, "sun_sensor.y": 0.0, "sun_sensor.z": 0.0},
        {"acs.estimate_sigma_rad": 1.0},
    ],
)
def test_half_of_a_condition_breaks_nothing(healthy: dict[str, Any], changes: dict[str, Any]) -> None:
    watch = RuleWatch()
    for second in range(2000):
        watch.look(second, healthy | changes)
    assert watch.violations() == ()


def test_commands_that_are_answered_or_go_to_others_break_nothing(healthy: dict[str, Any]) -> None:
    watch = RuleWatch()
    answered = BusCommand("radio.power", "radio", True)
    watch.look(0, healthy, (answered, answered, BusCommand("radio.downlink", "radio", False)))
    watch.look(1, healthy, (HUNG[0], BusCommand("micas.power", "micas", False)))
    watch.look(2, healthy, (HUNG[0],))
    assert watch.violations() == ()


def test_a_silent_terminal_gets_its_next_command_a_second_later() -> None:
    craft = Spacecraft(SpacecraftConfig(), 0)
    plant = SpacecraftPlant(craft, frozenset({"radio.state", "ips.state"}))
    craft.inject("radio-terminal-hung", 0.0)
    plant.advance(0)
    for number, name in enumerate(("radio.power", "radio.downlink", "radio.power"), 1):
        plant.send(Command(number, name, {"on": False}))
    plant.send(Command(4, "ips.stop", {}))
    assert [(c.name, c.answered) for c in plant.on_bus] == [("radio.power", False), ("ips.stop", True)]
    assert [a.command_id for a in plant.advance(1).acknowledgements] == [4]
    assert [c.name for c in plant.on_bus] == ["radio.downlink"]
    craft.send("terminal.reset", {"name": "radio"})
    assert [a.command_id for a in plant.advance(2).acknowledgements] == [3]
    assert plant.advance(3).acknowledgements == ()
