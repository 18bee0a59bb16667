import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim import Acknowledgement, Spacecraft, SpacecraftConfig
from sim.dictionary import TELECOMMANDS, TELEMETRY, round_telemetry
from tests.sim.flights import thrusting

TYPES = {"str": str, "int": int, "float": float}


def test_the_contract_with_the_flight_side():
    signatures = {
        name: {argument.name: argument.type for argument in command.arguments} for name, command in TELECOMMANDS.items()
    }
    assert signatures == {
        "acs.point": {"target": "str"},
        "acs.standby": {},
        "acs.sun_standby": {},
        "acs.actuators": {"name": "str"},
        "acs.unload": {},
        "rcs.mode": {"mode": "str"},
        "pasm.power": {"on": "bool"},
        "lpe.status": {},
        "terminal.reset": {"name": "str"},
        "ips.start": {},
        "ips.thrust": {"level": "int"},
        "ips.idle": {},
        "ips.stop": {},
        "micas.power": {"on": "bool"},
        "micas.expose": {"target": "str", "seconds": "float"},
        "radio.power": {"on": "bool"},
        "radio.downlink": {"on": "bool"},
    }
    promised = (
        "acs.mode acs.target acs.state acs.error_rad acs.rate_rad_s wheels.speed_1_rad_s wheels.speed_2_rad_s "
        "wheels.speed_3_rad_s wheels.speed_4_rad_s wheels.momentum_Nms ips.state ips.level ips.thrust_N ips.power_W "
        "ips.xenon_kg ips.thrust_seconds micas.switch micas.state micas.images micas.power_W power.array_W "
        "power.load_W power.margin_W battery.soc radio.state recorder.stored_Mbit recorder.downlinked_Mbit "
        "power.bus acs.actuators acs.estimate_sigma_rad tracker.state rcs.mode rcs.hydrazine_kg pasm.switch "
        "neb1.status neb1.current_A neb1s.status neb1s.current_A neb2.status neb2.current_A"
    )
    assert set(promised.split()) <= set(TELEMETRY)


def test_telemetry_is_what_its_table_says():
    craft = Spacecraft(SpacecraftConfig(), 1)
    craft.send("acs.point", {"target": "asteroid_b"})
    thrusting(craft, 48)
    craft.advance(craft.time + 100)
    telemetry = craft.telemetry()
    assert list(telemetry) == list(TELEMETRY)
    for name, value in telemetry.items():
        channel = TELEMETRY[name]
        assert type(value) is TYPES[channel.type], name
        if channel.resolution:
            counts = value / channel.resolution
            assert counts == pytest.approx(round(counts), abs=1e-3), name
            assert math.log10(channel.resolution).is_integer() or channel.resolution in (1e-6, 1e-7)


@settings(max_examples=200, derandomize=True)
@given(st.sampled_from([c for c in TELEMETRY.values() if c.resolution]), st.floats(-5000.0, 5000.0))
def test_rounding_goes_to_the_nearest_count_and_has_no_negative_zero(channel, value):
    values = dict.fromkeys(TELEMETRY, 0.0) | {channel.name: value}
    rounded = round_telemetry(values)[channel.name]
    assert abs(rounded - value) <= 0.5000001 * channel.resolution + 1e-12
    assert rounded == round(rounded, 9)
    assert not (rounded == 0.0 and math.copysign(1.0, rounded) < 0.0)


@pytest.mark.parametrize(
    ("name", "arguments", "reason"),
    [
        ("warp.engage", {}, "command: expected one of acs.point.*found 'warp.engage'"),
        ("acs.point", {}, "acs.point: expected arguments.*target.*found none"),
        ("acs.standby", {"target": "earth"}, "acs.standby: expected arguments none, found.*target"),
        ("acs.point", {"target": 3}, "acs.point.target: expected str, found 3"),
        ("acs.point", {"target": "vulcan"}, "acs.point.target: expected one of earth.*found 'vulcan'"),
        ("micas.expose", {"target": "vulcan", "seconds": 1.0}, "micas.expose.target.*found 'vulcan'"),
        ("micas.expose", {"target": "asteroid_a", "seconds": math.nan}, "micas.expose.seconds: expected float"),
        ("micas.expose", {"target": "asteroid_a", "seconds": True}, "micas.expose.seconds: expected float"),
        ("ips.thrust", {"level": 7}, "ips.thrust.level: expected one of 6, 27, 48, 69, 83, 90, found 7"),
        ("ips.thrust", {"level": 27.0}, "ips.thrust.level: expected int, found 27.0"),
        ("micas.power", {"on": 1}, "micas.power.on: expected bool, found 1"),
        ("ips.idle", {}, "ips.idle needs state thrusting, found standby"),
    ],
)
def test_a_wrong_command_is_refused_with_its_reason_and_does_nothing(name, arguments, reason):
    craft = Spacecraft(SpacecraftConfig(), 1)
    before = craft.telemetry()
    answer = craft.send(name, arguments)
    assert answer is not None
    assert not answer.accepted
    import re

    assert re.search(reason, answer.reason), answer.reason
    assert craft.telemetry() == before


def test_whole_seconds_may_be_an_int():
    craft = Spacecraft(SpacecraftConfig(camera_warmup_s=(1.0, 1.0)), 1)
    craft.send("micas.power", {"on": True})
    craft.advance(2)
    assert craft.send("micas.expose", {"target": "earth", "seconds": 5}) == Acknowledgement(True)
