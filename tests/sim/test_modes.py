"""Attitude modes: gimbals, the two standbys, and the cones that the Sun keeps to."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim import Acknowledgement, Spacecraft, SpacecraftConfig, Target
from sim.components import gimbals
from sim.components.gimbals import Gimbals
from sim.cones import SUN_SENSOR_AXIS_B, Cones, legs_rad
from sim.control import profile_duration_s
from sim.quaternion import about, axis_angle, conjugate, cross, dot, from_axes, multiply, rotate, rotate_inverse, unit
from tests.sim.flights import command, slew, thrusting, until

CONFIG = SpacecraftConfig()
TO_THRUST = SpacecraftConfig(initial_target="thrust_a", engine_start_s=(1.0, 2.0))


def angle(a, b):
    across = cross(a, b)
    return math.atan2(math.sqrt(dot(across, across)), dot(a, b))


@settings(max_examples=60, derandomize=True, deadline=None)
@given(st.floats(-5e-3, 5e-3), st.floats(-5e-3, 5e-3), st.floats(0.02, 0.092))
def test_gimbals_give_the_torque_that_is_wanted_as_far_as_they_reach(tx, ty, thrust_N):
    """And thrust, arm and torque belong together: r x F of a thrust of unchanged size."""
    units = Gimbals(CONFIG)
    for _ in range(20):
        gimbals.steer(units.memory, 1.0, thrust_N, tx, ty)
    m = units.memory
    direction = m[gimbals.DIRECTION : gimbals.DIRECTION + 3]
    assert np.linalg.norm(direction) == pytest.approx(1.0)
    torque = np.cross((0.0, 0.0, -CONFIG.gimbal_arm_m), thrust_N * direction)
    assert m[gimbals.TORQUE : gimbals.TORQUE + 2] == pytest.approx(torque[:2])
    for k, wanted in enumerate((tx, ty)):
        reach = thrust_N * CONFIG.gimbal_arm_m * math.sin(CONFIG.gimbal_limit_rad)
        expected = max(-reach, min(reach, wanted))
        assert torque[k] == pytest.approx(expected, rel=5e-3), "the other gimbal's cosine"


@pytest.mark.parametrize(("beside", "level"), [("wheels", 90), ("thrusters", 6)])
def test_the_engine_s_gimbals_hold_the_attitude_while_it_thrusts(beside, level):
    craft = Spacecraft(TO_THRUST, 4)
    assert "need the ion engine thrusting" in craft.send("acs.actuators", {"name": "gimbals"}).reason
    thrusting(craft, level)
    command(craft, "acs.actuators", name=beside)
    before = craft.telemetry()
    command(craft, "acs.actuators", name="gimbals")
    telemetry = craft.telemetry()
    assert (telemetry["acs.mode"], telemetry["acs.actuators"]) == ("earth_standby", "gimbals")
    command(craft, "acs.point", target="thrust_a")
    assert craft.telemetry()["acs.mode"] == "tvc"
    moved = 0.0
    for _ in range(120):
        craft.advance(craft.time + 60)
        telemetry = craft.telemetry()
        assert telemetry["acs.state"] == "settled"
        assert max(abs(telemetry["ips.gimbal_x_rad"]), abs(telemetry["ips.gimbal_y_rad"])) <= CONFIG.gimbal_limit_rad
        moved = max(moved, abs(telemetry["ips.gimbal_x_rad"]))
    assert moved > 0.0
    truth = craft.state_for_recording().attitude_IB
    assert craft.environment.pointing_error_rad(truth, "thrust_a", craft.time) < 3e-4
    if beside == "thrusters":
        assert 0.0 < before["rcs.hydrazine_kg"] - telemetry["rcs.hydrazine_kg"] < 0.05, "for the turn about Z alone"
    assert "do not turn" in craft.send("acs.point", {"target": "earth"}).reason
    command(craft, "acs.point", target="thrust_a")
    command(craft, "ips.idle")
    assert craft.telemetry()["acs.actuators"] == beside
    slew(craft, "earth")


def test_standby_takes_the_attitude_from_the_gimbals_and_a_stuck_gimbal_loses_it():
    craft = Spacecraft(TO_THRUST, 4)
    thrusting(craft, 90)
    command(craft, "acs.actuators", name="gimbals")
    craft.advance(300)
    craft._gimbals.memory[gimbals.ANGLE_X] = 0.02
    craft.inject("gimbal-x-stuck", craft.time)
    until(craft, "acs.state", "slewing")
    command(craft, "acs.standby")
    telemetry = craft.telemetry()
    assert (telemetry["acs.mode"], telemetry["acs.actuators"]) == ("earth_standby", "wheels")
    until(craft, "acs.state", "settled")


@pytest.mark.parametrize("actuators", ["wheels", "thrusters"])
@pytest.mark.parametrize("rate", [(0.0, 0.0, 0.0), (4e-3, -3e-3, 2e-3)])
def test_sun_standby_needs_neither_star_tracker_nor_a_true_estimate(rate, actuators):
    """Tumbling, the tracker dead and the filter off by 40 degrees: Sun sensors and gyro bring +X to the Sun."""
    craft = Spacecraft(CONFIG, 3)
    craft.inject("star-tracker-fails", 0.0)
    craft._physics.set_rate(rate)
    attitude = multiply(craft._estimator.attitude_IB, about(unit((0.3, 1.0, -0.4)), math.radians(40.0)))
    craft._estimator.memory[0:4] = attitude
    command(craft, "acs.actuators", name=actuators)
    command(craft, "acs.sun_standby")
    telemetry = craft.telemetry()
    assert (telemetry["acs.mode"], telemetry["acs.target"], telemetry["acs.state"]) == ("sun_standby", "sun", "slewing")
    until(craft, "acs.state", "settled", 2400)
    craft.advance(craft.time + 1800)
    state = craft.state_for_recording()
    assert angle(rotate(state.attitude_IB, (1.0, 0.0, 0.0)), state.sun_direction_I) < 5e-3
    assert state.rate_B_rad_s == pytest.approx((2.0 * math.pi / 3600.0, 0.0, 0.0), abs=1e-4)
    telemetry = craft.telemetry()
    assert telemetry["acs.state"] == "settled"
    assert telemetry["power.array_W"] == pytest.approx(2500.0 / state.sun_distance_au**2, rel=1e-3)


def test_sun_standby_ends_with_the_next_target():
    craft = Spacecraft(CONFIG, 3)
    command(craft, "acs.sun_standby")
    until(craft, "acs.state", "settled")
    assert "settled target" in refused_with_thrust(craft)
    slew(craft, "asteroid_a")
    assert craft.telemetry()["acs.mode"] == "wheels"
    command(craft, "acs.standby")
    until(craft, "acs.state", "settled")
    assert craft.telemetry()["acs.mode"] == "earth_standby"


def refused_with_thrust(craft):
    craft._engine.state = "thrusting"
    reason = craft.send("acs.actuators", {"name": "gimbals"}).reason
    craft._engine.state = "standby"
    return reason


polar = st.floats(0.0, 0.98 * CONFIG.sun_sensor_half_field_rad)
turns = st.floats(0.0, 2.0 * math.pi)


def with_sun(polar_rad, about_axis_rad, roll_rad):
    """An attitude that has the Sun, inertial +X, there in the sensor's field, rolled about the Sun line."""
    axis = SUN_SENSOR_AXIS_B
    side = unit(cross(axis, (0.0, 1.0, 0.0)))
    other = cross(axis, side)
    c, s = math.cos(polar_rad), math.sin(polar_rad)
    p, q = s * math.cos(about_axis_rad), s * math.sin(about_axis_rad)
    sun_B = tuple(c * axis[k] + p * side[k] + q * other[k] for k in range(3))
    y_B = unit(cross(sun_B, (0.3, 0.5, 0.8)))
    body_of_sun = from_axes(sun_B, y_B, cross(sun_B, y_B))
    return conjugate(multiply(body_of_sun, about((1.0, 0.0, 0.0), roll_rad)))


@settings(max_examples=150, derandomize=True, deadline=None)
@given(st.tuples(polar, turns, turns), st.tuples(polar, turns, turns))
def test_every_way_keeps_the_sun_in_its_cones(first, second):
    """From and to any attitudes that keep them, sampled finer than the way was planned."""
    cones, sun_I = Cones.of(CONFIG), (1.0, 0.0, 0.0)
    here, goal = with_sun(*first), with_sun(*second)
    way = cones.way(here, goal, sun_I)
    assert way is not None, "the sensor's field is convex"
    assert way[-1] == goal
    start = here
    for stop, leg in zip(way, legs_rad(here, way), strict=True):
        axis, turned = axis_angle(multiply(conjugate(start), stop))
        assert turned == pytest.approx(leg)
        for k in range(201):
            sun_B = rotate_inverse(multiply(start, about(axis, turned * k / 200)), sun_I)
            assert cones.margin_rad(sun_B) > -0.01
        start = stop


SUNWARD = (
    Target("earth", "earth", (0.766, 0.6428, 0.0)),
    Target("here", "asteroid", (-0.2, 0.9, 0.4)),
    Target("there", "thrust", (0.1, -0.9, 0.4)),
    Target("near", "asteroid", (0.9, 0.4, 0.0)),
)


def test_a_turn_goes_round_the_cones_and_settles_as_the_longer_way_takes():
    config = SpacecraftConfig(attitude_source="truth")
    cones = Cones.of(config)
    craft = Spacecraft(config, 1)
    sky = craft.environment
    sun_I, goal = sky.sun_direction_I(0.0), sky.target_attitude_IB("thrust_a", 0.0)
    starts = (with_sun(1.0, 0.1 * k, 0.37 * k) for k in range(1000))
    here = next(start for start in starts if len(cones.way(start, goal, sun_I)) == 2)
    craft._physics.qpos_view[3:7] = here
    craft.advance(1)
    command(craft, "acs.point", target="thrust_a")
    legs = legs_rad(here, cones.way(here, goal, sun_I))
    start = craft.time
    while craft.telemetry()["acs.state"] != "settled":
        craft.advance(craft.time + 1)
        telemetry = craft.telemetry()
        assert telemetry["acs.cones"] == "kept"
        assert telemetry["acs.sun_from_sensor_rad"] <= config.sun_sensor_half_field_rad + 3e-3
        assert telemetry["acs.sun_from_camera_rad"] >= config.camera_sun_exclusion_rad
    profile_s = sum(profile_duration_s(leg, config) for leg in legs)
    assert 50.0 <= craft.time - start - profile_s <= 140.0
    state = craft.state_for_recording()
    assert sky.pointing_error_rad(state.attitude_IB, "thrust_a", craft.time) < 1e-3


def test_a_target_in_the_sun_s_cone_is_refused_and_a_standby_never():
    craft = Spacecraft(SpacecraftConfig(targets=SUNWARD, initial_target="here"), 1)
    before = craft.telemetry()
    answer = craft.send("acs.point", {"target": "near"})
    assert not answer.accepted
    assert "near would put the Sun 24.0 deg from the camera's boresight, expected at least 40.0 deg" in answer.reason
    assert craft.telemetry() == before
    behind = (Target("earth", "earth", (-0.99, 0.1, 0.0)), *SUNWARD[1:])
    craft = Spacecraft(SpacecraftConfig(targets=behind, initial_target="here"), 1)
    assert "Sun sensor's axis" in craft.send("acs.point", {"target": "earth"}).reason
    assert craft.send("acs.standby", {}) == Acknowledgement(True)
    until(craft, "acs.state", "settled")
    assert craft.telemetry()["acs.cones"] == "broken"
    slew(craft, "here")
    assert craft.telemetry()["acs.cones"] == "kept"
