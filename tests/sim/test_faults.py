import pytest

from sim import FAULTS, Acknowledgement, ConfigurationError, Spacecraft, SpacecraftConfig
from tests.sim.flights import FAST, command, slew, until


def test_every_fault_of_the_table_begins_and_ends_on_its_component():
    craft = Spacecraft(SpacecraftConfig(), 1)
    for name in FAULTS:
        craft.inject(name, 10.0, 20.0)
    assert craft.state_for_recording().active_faults == ()
    craft.advance(10)
    assert craft.state_for_recording().active_faults == tuple(FAULTS)
    craft.advance(19)
    assert craft.state_for_recording().active_faults == tuple(FAULTS)
    craft.advance(20)
    assert craft.state_for_recording().active_faults == ()


def test_micas_stuck_on_acknowledges_off_and_stays_on():
    craft = Spacecraft(FAST, 1)
    command(craft, "micas.power", on=True)
    craft.inject("micas-stuck-on", 30.0, 60.0)
    craft.advance(29)
    command(craft, "micas.power", on=False)
    assert craft.telemetry()["micas.switch"] == "off"
    command(craft, "micas.power", on=True)
    craft.advance(40)
    assert craft.send("micas.power", {"on": False}) == Acknowledgement(True)
    telemetry = craft.telemetry()
    assert (telemetry["micas.switch"], telemetry["micas.state"], telemetry["micas.power_W"]) == ("on", "ready", 100.0)
    craft.advance(60)
    assert craft.telemetry()["micas.switch"] == "on", "healed, but nobody has thrown it yet"
    command(craft, "micas.power", on=False)
    assert craft.telemetry()["micas.switch"] == "off"


def test_ips_start_fails_never_gets_ready_until_it_ends():
    craft = Spacecraft(SpacecraftConfig(), 1)
    craft.inject("ips-start-fails", 0.0, 5000.0)
    command(craft, "ips.start")
    craft.advance(4999)
    assert craft.telemetry()["ips.state"] == "starting"
    command(craft, "ips.stop")
    until(craft, "ips.state", "standby")
    command(craft, "ips.start")
    assert 600 <= until(craft, "ips.state", "ready") <= 1200


@pytest.mark.parametrize("fault", ["ips-terminal-hung", "micas-terminal-hung"])
def test_a_hung_terminal_neither_answers_nor_acts(fault):
    craft = Spacecraft(FAST, 1)
    craft.inject(fault, 0.0, 10.0)
    name, arguments = ("ips.start", {}) if fault.startswith("ips") else ("micas.power", {"on": True})
    before = craft.telemetry()
    assert craft.send(name, arguments) is None
    assert craft.telemetry() == before
    assert craft.send("radio.power", {"on": True}) == Acknowledgement(True)
    craft.advance(10)
    assert craft.send(name, arguments) == Acknowledgement(True)


@pytest.mark.parametrize(("factor", "at_s"), [(0.25, 0.0), (0.5, 0.0), (0.25, 200.0)])
def test_slow_slew_takes_longer_by_its_factor(factor, at_s):
    healthy = Spacecraft(SpacecraftConfig(), 1)
    slow = Spacecraft(SpacecraftConfig(), 1)
    slow.inject("slow-slew", at_s, parameters={"factor": factor})
    expected = slew(healthy, "asteroid_b")
    taken = slew(slow, "asteroid_b", 9000)
    left = expected - 60 - at_s
    assert taken == pytest.approx(60 + at_s + left / factor, rel=0.12)
    limit = factor * SpacecraftConfig().slew_rate_limit_rad_s
    command(slow, "acs.point", target="earth")
    slow.advance(slow.time + 200)
    assert slow.telemetry()["acs.rate_rad_s"] == pytest.approx(limit, rel=0.05)


def test_camera_warmup_slow_takes_longer_by_its_factor():
    taken = []
    for factor in (None, 2.0):
        craft = Spacecraft(SpacecraftConfig(), 7)
        if factor:
            craft.inject("camera-warmup-slow", 0.0, None, {"factor": factor})
        command(craft, "micas.power", on=True)
        taken.append(until(craft, "micas.state", "ready"))
    assert taken[1] == pytest.approx(2.0 * taken[0], abs=2)


def test_array_degraded_gives_its_fraction():
    craft = Spacecraft(SpacecraftConfig(), 1)
    before = craft.telemetry()["power.array_W"]
    craft.inject("array-degraded", 0.0, None, {"factor": 0.5})
    craft.advance(1)
    assert craft.telemetry()["power.array_W"] == pytest.approx(0.5 * before, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "at_s", "end_s", "parameters", "message"),
    [
        ("gremlins", 0.0, None, {}, r"expected one of micas-stuck-on.*'gremlins'"),
        ("slow-slew", -1.0, None, {}, "start at 0 s or later, found -1"),
        ("slow-slew", float("nan"), None, {}, "start at 0 s or later"),
        ("slow-slew", 5.0, 5.0, {}, "end after its start at 5.0 s, found 5.0"),
        ("slow-slew", 0.0, None, {"speed": 1.0}, "expected parameters factor, found 'speed'"),
        ("micas-stuck-on", 0.0, None, {"factor": 1.0}, "expected parameters none, found 'factor'"),
        ("slow-slew", 0.0, None, {"factor": 2.0}, "slow-slew, factor: expected 0.01 to 1, found 2"),
    ],
)
def test_what_the_table_forbids_is_an_error(name, at_s, end_s, parameters, message):
    with pytest.raises(ConfigurationError, match=message):
        Spacecraft(SpacecraftConfig(), 1).inject(name, at_s, end_s, parameters)
