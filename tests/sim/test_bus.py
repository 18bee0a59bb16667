"""Power buses, bus terminals and the faults around them."""

import numpy as np
import pytest

from sim import FAULTS, Acknowledgement, ConfigurationError, Spacecraft, SpacecraftConfig
from sim.faults import random_faults
from tests.sim.flights import FAST, command, thrusting, until

CONFIG = SpacecraftConfig()


def test_a_false_status_of_neb1_is_contradicted_by_current_and_tracker():
    craft = Spacecraft(CONFIG, 1)
    healthy = craft.telemetry()
    assert healthy["neb1.status"] == "on"
    assert healthy["neb1.current_A"] > 0.1
    craft.inject("neb1-status-false", 100.0, 200.0)
    craft.advance(150)
    telemetry = craft.telemetry()
    assert telemetry["neb1.status"] == "off"
    assert (telemetry["neb1.current_A"], telemetry["tracker.state"]) == (healthy["neb1.current_A"], "tracking")
    craft.advance(200)
    assert craft.telemetry()["neb1.status"] == "on"


def test_a_bus_that_is_really_off_takes_its_units_down():
    craft = Spacecraft(FAST, 1)
    thrusting(craft, 27)
    command(craft, "micas.power", on=True)
    until(craft, "micas.state", "ready")
    for fault in ("neb1-off", "neb2-off"):
        craft.inject(fault, craft.time)
    craft.advance(craft.time + 2)
    telemetry = craft.telemetry()
    assert (telemetry["neb1.status"], telemetry["neb1.current_A"], telemetry["tracker.state"]) == ("off", 0.0, "off")
    assert (telemetry["neb2.current_A"], telemetry["micas.state"], telemetry["ips.state"]) == (0.0, "off", "standby")
    assert telemetry["ips.thrust_N"] == 0.0
    answer = craft.send("ips.start", {})
    assert answer is not None
    assert "NEB2" in answer.reason


def test_the_camera_shows_in_the_current_of_its_bus():
    craft = Spacecraft(FAST, 1)
    before = craft.telemetry()["neb2.current_A"]
    command(craft, "micas.power", on=True)
    assert craft.telemetry()["neb2.current_A"] == pytest.approx(before + 150.0 / 28.0, abs=0.01)


def test_the_lpe_needs_pasm_and_a_reset_cures_a_hang():
    craft = Spacecraft(CONFIG, 1)
    assert craft.send("lpe.status", {}) is None, "PASM is off"
    command(craft, "pasm.power", on=True)
    assert craft.telemetry()["pasm.switch"] == "on"
    assert craft.telemetry()["power.load_W"] == 355.0
    command(craft, "lpe.status")
    craft.inject("lpe-terminal-hung", 10.0)
    craft.advance(10)
    assert craft.send("lpe.status", {}) is None
    command(craft, "terminal.reset", name="lpe")
    command(craft, "lpe.status")
    craft.inject("lpe-terminal-dead", 20.0)
    craft.advance(20)
    command(craft, "terminal.reset", name="lpe")
    assert craft.send("lpe.status", {}) is None, "a reset does not help"


def test_a_lost_confirmation_hides_a_command_that_worked():
    craft = Spacecraft(FAST, 1)
    craft.inject("ips-confirmation-lost", 0.0, 5.0)
    assert craft.send("ips.start", {}) is None
    assert craft.telemetry()["ips.state"] == "starting"
    craft.advance(5)
    command(craft, "ips.stop")


def test_a_recycle_breaks_thrust_off_once():
    craft = Spacecraft(FAST, 1)
    thrusting(craft, 48)
    craft.inject("ips-recycle", craft.time + 10.0)
    craft.advance(craft.time + 10)
    assert (craft.telemetry()["ips.state"], craft.telemetry()["ips.thrust_N"]) == ("ready", 0.0)
    command(craft, "ips.thrust", level=48)
    craft.advance(craft.time + 100)
    assert craft.telemetry()["ips.state"] == "thrusting"


def test_a_wheel_that_fails_still_leaves_three_to_turn_with():
    craft = Spacecraft(CONFIG, 1)
    craft.inject("wheel-2-fails", 0.0)
    before = craft.state_for_recording().wheel_speeds_rad_s
    command(craft, "acs.point", target="asteroid_a")
    way_rad = craft.telemetry()["acs.error_rad"]
    craft.advance(300)
    after = craft.state_for_recording().wheel_speeds_rad_s
    friction_Nm = CONFIG.wheel_dry_Nm + CONFIG.wheel_viscous_Nms * abs(before[1])
    braked = abs(before[1]) - abs(after[1])
    assert braked == pytest.approx(300 * friction_Nm / 0.0191, rel=0.2), "nothing but its friction"
    assert craft.telemetry()["acs.error_rad"] < 0.1 * way_rad


def test_random_faults_come_at_their_rates_and_from_the_generator_alone():
    rates = {"ips-recycle": 24.0 / 14.4, "gyro-bias-jumps": 0.5}
    faults = random_faults(np.random.default_rng(4), rates, 400 * 86_400.0)
    assert faults == random_faults(np.random.default_rng(4), dict(reversed(rates.items())), 400 * 86_400.0)
    assert faults != random_faults(np.random.default_rng(5), rates, 400 * 86_400.0)
    assert list(faults) == sorted(faults, key=lambda fault: fault[1])
    for name, rate in rates.items():
        count = sum(fault[0] == name for fault in faults)
        assert count == pytest.approx(400 * rate, abs=4.0 * (400 * rate) ** 0.5)
    assert random_faults(np.random.default_rng(1), {"ips-recycle": 0.0}, 1e9) == ()
    with pytest.raises(ConfigurationError, match="expected one of"):
        random_faults(np.random.default_rng(1), {"meteor": 1.0}, 1e5)
    with pytest.raises(ConfigurationError, match="at least 0"):
        random_faults(np.random.default_rng(1), {"ips-recycle": -1.0}, 1e5)


def test_every_fault_comes_and_goes_and_leaves_no_trace():
    """Begin and end before anything happens: the flight after is the flight without."""
    plain, tried = Spacecraft(CONFIG, 6), Spacecraft(CONFIG, 6)
    for name in FAULTS:
        tried.inject(name, 0.0)
        tried.inject(name, 0.0, 1e-9)
    tried.advance(0)
    for craft in (plain, tried):
        craft.advance(1)
        craft.send("acs.point", {"target": "asteroid_d"})
    assert plain.send("lpe.status", {}) == tried.send("lpe.status", {}) is None
    assert isinstance(tried.send("ips.start", {}), Acknowledgement)
