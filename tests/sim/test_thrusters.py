import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim import Acknowledgement, Spacecraft, SpacecraftConfig
from sim.components import thrusters
from sim.components.ion_engine import STANDARD_GRAVITY_M_S2
from sim.components.thrusters import MODES, NAMES, Thrusters
from sim.slews import slew_bounds_between
from tests.sim.flights import command, slew, until

CONFIG = SpacecraftConfig()
# The sign table of the flown model, a palette a row: torque of the x-thruster, then of the z-thruster.
TABLE = {"a": ("+Y +Z", "+X -Y"), "b": ("-Y -Z", "+X +Y"), "c": ("-Y +Z", "-X +Y"), "d": ("+Y -Z", "-X -Y")}


def alone(name):
    """Torque and force of one thruster fully open for a second."""
    units = Thrusters(CONFIG)
    for other in NAMES:
        if other != name:
            units.set_fault(f"closed_{other}", True, {})
    torque, force = np.zeros(3), np.zeros(3)
    for mode in MODES:
        for axis in range(3):
            for sign in (1.0, -1.0):
                units.select(mode)
                wanted = [0.0, 0.0, 0.0]
                wanted[axis] = sign * 2.0
                thrusters.fire(units.memory, 1.0, *wanted)
                if np.any(units.memory[thrusters.TORQUE : thrusters.TORQUE + 3]):
                    torque = units.memory[thrusters.TORQUE : thrusters.TORQUE + 3].copy()
                    force = units.memory[thrusters.FORCE : thrusters.FORCE + 3].copy()
    return torque, force


@pytest.mark.parametrize("name", NAMES)
def test_every_thruster_turns_as_its_sign_table_says(name):
    torque, force = alone(name)
    expected = np.zeros(3)
    for part in TABLE[name[0]]["xz".index(name[1])].split():
        expected["XYZ".index(part[1])] = 1.0 if part[0] == "+" else -1.0
    assert torque == pytest.approx(expected * CONFIG.thruster_N * CONFIG.thruster_lever_m)
    assert force == pytest.approx([-0.9, 0.0, 0.0] if name[1] == "x" else [0.0, 0.0, 0.9])


@settings(max_examples=100, derandomize=True, deadline=None)
@given(st.tuples(*[st.floats(-0.2, 0.2)] * 3), st.sampled_from(MODES))
def test_the_impulse_that_is_wanted_comes_sooner_or_later(torque, mode):
    """Over a minute all of it but what still waits for the minimum opening, about each axis."""
    units = Thrusters(CONFIG)
    units.select(mode)
    given_Nms = np.zeros(3)
    for _ in range(60):
        thrusters.fire(units.memory, 1.0, *torque)
        given_Nms += units.memory[thrusters.TORQUE : thrusters.TORQUE + 3]
        on_s = units.memory[thrusters.ON : thrusters.ON + 8]
        assert ((on_s == 0.0) | (on_s >= CONFIG.thruster_minimum_s)).all()
    least_Nms = 2.0 * CONFIG.thruster_N * CONFIG.thruster_lever_m * CONFIG.thruster_minimum_s
    assert given_Nms == pytest.approx(60.0 * np.array(torque), abs=1.0001 * least_Nms)


@pytest.mark.parametrize("mode", MODES)
def test_the_modes_use_the_thrusters_that_they_promise(mode):
    units = Thrusters(CONFIG)
    units.select(mode)
    users = {}
    for axis in range(3):
        wanted = [0.0, 0.0, 0.0]
        wanted[axis] = 0.1
        thrusters.fire(units.memory, 1.0, *wanted)
        users[axis] = {name[1] for name, on in zip(NAMES, units.memory[:8], strict=True) if on > 0.0}
        assert sum(units.memory[:8] > 0.0) == 2
    assert users == {0: {"z"}, 1: {"x"} if mode == "x_for_y" else {"z"}, 2: {"x"}}


def test_hydrazine_and_speed_obey_the_rocket_equation():
    config = SpacecraftConfig(solar_pressure_1au_Pa=0.0)
    craft = Spacecraft(config, 1)
    command(craft, "acs.actuators", name="thrusters")
    # One x-thruster less: every turn about Y or Z now pushes sideways too, and costs more.
    before = craft.state_for_recording()
    slew(craft, "asteroid_a")
    after = craft.state_for_recording()
    used_kg = before.mass_kg - after.mass_kg
    assert 0.001 < used_kg < 0.5
    assert craft.telemetry()["rcs.hydrazine_kg"] == pytest.approx(31.1 - used_kg, abs=1e-4)
    exhaust = config.thruster_specific_impulse_s * STANDARD_GRAVITY_M_S2
    bound = exhaust * math.log(before.mass_kg / after.mass_kg)
    gained = np.linalg.norm(np.subtract(after.velocity_I_m_s, before.velocity_I_m_s))
    assert 0.0 < gained <= bound, "pairs push the same way, turns in between spread the direction"


@pytest.mark.parametrize("mode", MODES)
def test_thrusters_slew_and_hold_without_the_wheels(mode):
    craft = Spacecraft(CONFIG, 3)
    command(craft, "acs.actuators", name="thrusters")
    command(craft, "rcs.mode", mode=mode)
    speeds = craft.state_for_recording().wheel_speeds_rad_s
    slew(craft, "asteroid_c")
    telemetry = craft.telemetry()
    assert (telemetry["acs.actuators"], telemetry["rcs.mode"]) == ("thrusters", mode)
    craft.advance(craft.time + 1200)
    assert craft.telemetry()["acs.state"] == "settled"
    now = craft.state_for_recording().wheel_speeds_rad_s
    assert np.allclose(now, speeds, atol=15.0), "only friction touches them"
    command(craft, "acs.actuators", name="wheels")
    slew(craft, "earth")


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", ["ax", "dx", "az", "cz"])
def test_a_closed_valve_breaks_the_mode_that_turns_about_y_with_it_and_no_other(name, mode):
    craft = Spacecraft(CONFIG, 1)
    craft.inject(f"thruster-{name}-closed", 0.0)
    command(craft, "acs.actuators", name="thrusters")
    command(craft, "rcs.mode", mode=mode)
    command(craft, "acs.point", target="asteroid_b")
    craft.advance(1600)
    expected = "slewing" if mode[0] == name[1] else "settled"
    assert craft.telemetry()["acs.state"] == expected


def test_unloading_takes_the_momentum_out_of_the_wheels_and_stops():
    craft = Spacecraft(SpacecraftConfig(wheel_initial_speed_rad_s=400.0), 2)
    assert craft.telemetry()["wheels.momentum_Nms"] > 4.0
    command(craft, "acs.unload")
    assert craft.telemetry()["acs.actuators"] == "unloading"
    taken = until(craft, "acs.actuators", "wheels")
    assert taken < 600
    telemetry = craft.telemetry()
    assert telemetry["wheels.momentum_Nms"] < CONFIG.unloaded_Nms + 0.1
    assert telemetry["rcs.hydrazine_kg"] < 31.1
    until(craft, "acs.state", "settled")
    left = telemetry["rcs.hydrazine_kg"]
    craft.advance(craft.time + 600)
    assert craft.telemetry()["rcs.hydrazine_kg"] == left
    command(craft, "acs.actuators", name="thrusters")
    answer = craft.send("acs.unload", {})
    assert answer is not None
    assert "needs actuators wheels" in answer.reason


def test_sunlight_loads_the_wheels_by_its_torque():
    config = SpacecraftConfig(wheel_dry_Nm=0.0, wheel_viscous_Nms=0.0)
    craft = Spacecraft(config, 1)
    before = np.array(craft.angular_momentum_I())
    craft.advance(3600)
    halfway = craft.state_for_recording()
    craft.advance(7200)
    gained = np.array(craft.angular_momentum_I()) - before
    force_N = config.solar_pressure_1au_Pa * config.sunlit_area_m2 / config.sun_distance_au**2
    from sim.quaternion import cross, rotate, rotate_inverse

    sun_B = rotate_inverse(halfway.attitude_IB, halfway.sun_direction_I)
    torque_B = cross(config.pressure_centre_B_m, tuple(-force_N * part for part in sun_B))
    assert gained == pytest.approx(7200.0 * np.array(rotate(halfway.attitude_IB, torque_B)), rel=1e-3, abs=1e-6)


def test_no_power_on_neb1s_no_thrusters():
    craft = Spacecraft(CONFIG, 1)
    craft.inject("neb1s-off", 0.0)
    command(craft, "acs.actuators", name="thrusters")
    command(craft, "acs.point", target="asteroid_a")
    craft.advance(600)
    assert craft.telemetry()["rcs.hydrazine_kg"] == 31.1
    assert craft.telemetry()["acs.error_rad"] > 0.3


def test_wrong_modes_are_refused():
    craft = Spacecraft(CONFIG, 1)
    for name, arguments in (("rcs.mode", {"mode": "y_for_x"}), ("acs.actuators", {"name": "sails"})):
        answer = craft.send(name, arguments)
        assert isinstance(answer, Acknowledgement)
        assert not answer.accepted
        assert "expected one of" in answer.reason


@pytest.mark.parametrize("name", NAMES)
def test_a_valve_stuck_open_is_cut_off_by_the_latch_valve(name):
    craft = Spacecraft(SpacecraftConfig(), 1)
    craft.inject(f"thruster-{name}-open", at_s=100)
    craft.advance(1500)
    telemetry = craft.telemetry()
    assert telemetry["rcs.latch"] == "closed"
    flow_kg_s = 0.9 / (220.0 * 9.80665)
    assert 31.1 - float(telemetry["rcs.hydrazine_kg"]) == pytest.approx(2.0 * flow_kg_s, abs=2e-4)
    assert telemetry["acs.state"] == "settled"
    assert float(telemetry["wheels.momentum_Nms"]) < 6.0


@pytest.mark.parametrize("mode", ["x_for_y", "z_for_y"])
def test_thrusters_in_place_of_lost_wheels_keep_the_bounds_of_turns(mode):
    """What a planner counts on stays true when the actuators change, wheels still spinning and one without torque."""
    config = SpacecraftConfig(wheel_initial_speed_rad_s=300.0)
    craft = Spacecraft(config, 3)
    craft.inject("wheel-2-fails", at_s=1)
    craft.send("acs.actuators", {"name": "thrusters"})
    craft.send("rcs.mode", {"mode": mode})
    craft.advance(600)
    here = "earth"
    for there in ("asteroid_a", "thrust_a", "asteroid_c", "asteroid_d", "thrust_b", "earth"):
        bounds = slew_bounds_between(craft.environment, config, here, there, 0.0, 43_200.0)
        began_s = craft.time
        assert craft.send("acs.point", {"target": there}).accepted
        craft.advance(began_s + 5)
        while craft.telemetry()["acs.state"] != "settled" and craft.time - began_s <= bounds.upper_s:
            craft.advance(craft.time + 1)
        assert bounds.lower_s <= craft.time - began_s <= bounds.upper_s, (here, there)
        craft.advance(craft.time + 100)
        here = there
