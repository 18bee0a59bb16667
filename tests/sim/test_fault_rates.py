import numpy as np
import pytest

from sim import ConfigurationError, FaultRate, Spacecraft, SpacecraftConfig, draw_faults
from sim.fault_rates import RECYCLES
from tests.sim.flights import FAST, command, thrusting, until

DAY_S = 86_400.0
BLIND = FaultRate("star-tracker-fails", 2.0 * DAY_S, lasting_s=(600.0, 1200.0))


def test_faults_come_at_their_rates_with_parameters_and_lengths_in_their_ranges():
    drawn = draw_faults((RECYCLES, BLIND), 7, 400 * DAY_S)
    assert list(drawn) == sorted(drawn, key=lambda fault: fault.at_s)
    for rate, mean in ((RECYCLES, 400 * 24 / 14.4), (BLIND, 200)):
        own = [fault for fault in drawn if fault.name == rate.name]
        assert len(own) == pytest.approx(mean, abs=4.0 * mean**0.5)
        gaps = np.diff([fault.at_s for fault in own]) / rate.mean_between_s
        assert gaps.std() == pytest.approx(1.0, abs=0.2), "exponential: as wide as its mean"
    for fault in drawn:
        if fault.name == "ips-recycle":
            assert 60.0 <= fault.parameters["seconds"] <= 240.0
            assert fault.end_s is None
        else:
            assert 600 <= fault.end_s - fault.at_s <= 1200


def test_the_seed_decides_and_one_rate_does_not_change_another():
    both = draw_faults((RECYCLES, BLIND), 7, 30 * DAY_S)
    assert both == draw_faults((BLIND, RECYCLES), 7, 30 * DAY_S)
    assert both != draw_faults((RECYCLES, BLIND), 8, 30 * DAY_S)
    alone = draw_faults((RECYCLES,), 7, 30 * DAY_S)
    assert alone == tuple(fault for fault in both if fault.name == "ips-recycle")


def test_what_lasts_for_good_comes_once():
    drawn = draw_faults((FaultRate("micas-stuck-on", 1000.0),), 1, DAY_S)
    assert len(drawn) == 1
    assert draw_faults((FaultRate("micas-stuck-on", 1e12),), 1, DAY_S) == ()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("gremlins", 1.0), "expected one of .*'gremlins'"),
        (("ips-recycle", 0.0), "mean time between of more than 0, found 0"),
        (("ips-recycle", 1.0, {"minutes": (1.0, 2.0)}), "expected parameters seconds, found 'minutes'"),
        (("slow-slew", 1.0, {"factor": (0.5, 2.0)}), "a range within 0.01 to 1, found 0.5, 2"),
        (("slow-slew", 1.0, {}, (5.0, 2.0)), "shortest <= longest"),
    ],
)
def test_what_cannot_be_is_refused(arguments, message):
    with pytest.raises(ConfigurationError, match=message):
        FaultRate(*arguments)


def test_a_recycle_with_a_time_goes_on_by_itself_at_the_level_that_was_commanded_last():
    craft = Spacecraft(FAST, 1)
    thrusting(craft, 48)
    craft.inject("ips-recycle", craft.time + 10.0, parameters={"seconds": 90.0})
    craft.advance(craft.time + 10)
    assert craft.telemetry()["ips.state"] == "ready"
    assert until(craft, "ips.state", "thrusting") in (90, 91)
    assert craft.telemetry()["ips.level"] == 48
    craft.inject("ips-recycle", craft.time, parameters={"seconds": 60.0})
    command(craft, "ips.thrust", level=27)
    assert craft.telemetry()["ips.state"] == "ready"
    until(craft, "ips.state", "thrusting")
    assert craft.telemetry()["ips.level"] == 27
    craft.inject("ips-recycle", craft.time, parameters={"seconds": 60.0})
    command(craft, "ips.stop")
    until(craft, "ips.state", "standby")
    craft.advance(craft.time + 100)
    assert craft.telemetry()["ips.state"] == "standby", "told to stop, it does not come back"


def test_a_valve_that_stays_open_pushes_turns_and_drinks_until_it_closes():
    """One second: it closes before the interlock closes the latch valve, and the thrusters are there as before."""
    craft = Spacecraft(SpacecraftConfig(), 1)
    craft.inject("thruster-ax-open", 10.0, 11.0)
    craft.advance(11)
    used_kg = 31.1 - craft.telemetry()["rcs.hydrazine_kg"]
    assert used_kg == pytest.approx(0.9 / (220.0 * 9.80665), abs=1e-4)
    craft.advance(12)
    assert craft.telemetry()["acs.error_rad"] > 1e-4, "the kick is more than the wheels take out at once"
    craft.advance(120)
    assert craft.telemetry()["rcs.hydrazine_kg"] == pytest.approx(31.1 - used_kg)
    assert craft.telemetry()["rcs.latch"] == "open"


def test_stuck_wings_lose_the_sun_and_a_silent_transmitter_goes_off():
    craft = Spacecraft(SpacecraftConfig(), 1)
    full_W = craft.telemetry()["power.array_W"]
    craft.inject("wing-drives-stuck", 0.0)
    command(craft, "acs.point", target="asteroid_b")
    until(craft, "acs.state", "settled")
    assert craft.telemetry()["power.array_W"] < 0.9 * full_W
    command(craft, "radio.power", on=True)
    craft.inject("radio-transmitter-fails", craft.time, craft.time + 10.0)
    assert craft.telemetry()["radio.state"] == "off"
    command(craft, "radio.power", on=True)
    assert craft.telemetry()["radio.state"] == "off"
    craft.advance(craft.time + 10)
    command(craft, "radio.power", on=True)
    assert craft.telemetry()["radio.state"] == "on"
