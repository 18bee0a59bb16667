import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from sim import Spacecraft, SpacecraftConfig, Target
from sim.components.wheels import Wheels
from sim.control import AttitudeControl, profile_duration_s, slew_bounds
from sim.quaternion import about, axis_angle, conjugate, cross, dot, multiply
from sim.slews import slew_bounds_between
from tests.sim.flights import command, slew, until

NAMES = [target.name for target in SpacecraftConfig().targets]


def tour():
    """A closed way from earth over every ordered pair of targets once (Hierholzer)."""
    left = {a: [b for b in NAMES if b != a] for a in NAMES}
    stack, way = ["earth"], []
    while stack:
        if left[stack[-1]]:
            stack.append(left[stack[-1]].pop())
        else:
            way.append(stack.pop())
    return way[::-1]


def test_every_slew_settles_within_its_bounds():
    config = SpacecraftConfig(wheel_initial_speed_rad_s=300.0, solar_pressure_1au_Pa=0.0)
    craft = Spacecraft(config, 2)
    before = np.array(craft.angular_momentum_I())
    way = tour()
    assert len(way) == len(NAMES) * (len(NAMES) - 1) + 1
    for here, there in itertools.pairwise(way):
        bounds = slew_bounds(craft.environment.slew_angle(here, there, craft.time), config)
        command(craft, "acs.point", target=there)
        craft.advance(craft.time + bounds.lower_s - 1)
        assert craft.telemetry()["acs.state"] == "slewing", (here, there)
        craft.advance(craft.time + bounds.upper_s - bounds.lower_s + 1)
        telemetry = craft.telemetry()
        assert telemetry["acs.state"] == "settled", (here, there)
        assert telemetry["acs.error_rad"] < config.settle_error_rad
        assert telemetry["acs.target"] == there
    after = np.array(craft.angular_momentum_I())
    assert np.linalg.norm(after - before) / np.linalg.norm(before) < 1e-8


numbers = st.floats(-1.0, 1.0)
directions = st.tuples(numbers, numbers, numbers).filter(lambda v: dot(v, v) > 1e-2)


@settings(max_examples=15, derandomize=True, deadline=None)
@given(directions, directions, st.sampled_from(["asteroid", "thrust"]), st.integers(0, 1000))
def test_any_slew_settles_within_its_bounds_and_limits(first, second, kind, seed):
    assume(first[0] < 0.3 * math.hypot(*first) and second[0] < 0.3 * math.hypot(*second))  # else refused
    targets = (
        Target("first", kind, first),
        Target("second", "asteroid", second),
        Target("home", "earth", (0.0, 1.0, 0.0)),
    )
    config = SpacecraftConfig(targets=targets, initial_target="first")
    craft = Spacecraft(config, seed)
    bounds = slew_bounds_between(craft.environment, config, "first", "second", 0.0, 0.0)
    command(craft, "acs.point", target="second")
    fastest, taken = 0.0, None
    for second_of_flight in range(1, bounds.upper_s + 1):
        craft.advance(second_of_flight)
        telemetry = craft.telemetry()
        fastest = max(fastest, telemetry["acs.rate_rad_s"])
        if telemetry["acs.state"] == "settled":
            taken = second_of_flight
            break
    assert taken is not None
    assert taken >= bounds.lower_s
    assert fastest < 1.05 * config.slew_rate_limit_rad_s


@settings(max_examples=60, derandomize=True, deadline=None)
@given(st.floats(1e-3, math.pi - 1e-3), st.sampled_from([1.0, 0.25]))
def test_the_profile_keeps_its_limits_and_ends_at_the_target(angle, factor):
    """Flown by a body that does exactly what the torque says: one axis, so the law is the profile alone."""
    config, inertia = SpacecraftConfig(), 900.0
    level, goal = (1.0, 0.0, 0.0, 0.0), about((1.0, 0.0, 0.0), angle)
    control = AttitudeControl(config, (inertia, inertia, inertia), level, "earth")
    control.set_fault("slow_slew", factor < 1.0, {"factor": factor})
    control.point("x", (goal,))
    turned, rate, seconds, fastest, hardest = 0.0, 0.0, 0, 0.0, 0.0
    while not control.settled:
        acceleration = control.step(1.0, (0.0, 0.0, 0.0))[0] / inertia
        turned += rate + 0.5 * acceleration
        rate += acceleration
        fastest, hardest = max(fastest, abs(rate)), max(hardest, abs(acceleration))
        control.observe(1.0, about((1.0, 0.0, 0.0), turned), (rate, 0.0, 0.0))
        seconds += 1
        assert seconds < 10_000
    assert turned == pytest.approx(angle, abs=1e-8)
    assert fastest <= config.slew_rate_limit_rad_s * factor * (1.0 + 1e-6)
    assert hardest <= config.slew_acceleration_limit_rad_s2 * (1.0 + 1e-3)
    if factor == 1.0:
        assert 0 <= seconds - config.settle_hold_s - profile_duration_s(angle, config) + 2 <= 6


def test_a_slew_with_loaded_wheels_stays_on_its_eigenaxis():
    craft = Spacecraft(SpacecraftConfig(wheel_initial_speed_rad_s=300.0), 2)
    assert craft.telemetry()["wheels.momentum_Nms"] > 3.0, "the case should have something to decouple"
    start = craft.state_for_recording().attitude_IB
    goal = craft.environment.target_attitude_IB("asteroid_b", 0.0)
    axis, _ = axis_angle(multiply(conjugate(start), goal))
    command(craft, "acs.point", target="asteroid_b")
    for time in range(10, 1000, 10):
        craft.advance(time)
        _, x, y, z = multiply(conjugate(start), craft.state_for_recording().attitude_IB)
        aside = cross(axis, (x, y, z))
        assert 2.0 * math.sqrt(dot(aside, aside)) < 1e-3, time


def test_a_new_target_in_the_middle_of_a_slew_brakes_and_goes():
    craft = Spacecraft(SpacecraftConfig(), 3)
    command(craft, "acs.point", target="asteroid_d")
    craft.advance(300)
    assert craft.telemetry()["acs.rate_rad_s"] > 2e-3
    command(craft, "acs.point", target="thrust_a")
    last = craft.state_for_recording().rate_B_rad_s
    for time in range(301, 400):
        craft.advance(time)
        now = craft.state_for_recording().rate_B_rad_s
        change = math.dist(now, last)
        assert change < 1.3 * craft.config.slew_acceleration_limit_rad_s2, time
        last = now
    until(craft, "acs.state", "settled")
    assert craft.telemetry()["acs.target"] == "thrust_a"
    assert craft.telemetry()["acs.error_rad"] < 5e-4


def test_pointing_where_it_points_stays_settled_and_standby_goes_to_earth():
    craft = Spacecraft(SpacecraftConfig(), 3)
    slew(craft, "asteroid_a")
    command(craft, "acs.point", target="asteroid_a")
    assert craft.telemetry()["acs.state"] == "settled"
    command(craft, "acs.standby")
    telemetry = craft.telemetry()
    assert (telemetry["acs.mode"], telemetry["acs.target"], telemetry["acs.state"]) == (
        "earth_standby",
        "earth",
        "slewing",
    )
    until(craft, "acs.state", "settled")
    command(craft, "acs.point", target="earth")
    telemetry = craft.telemetry()
    assert (telemetry["acs.mode"], telemetry["acs.state"]) == ("wheels", "settled")


@pytest.mark.parametrize(("source", "friction_left", "within"), [("estimator", 0.1, 1.5e-4), ("truth", 0.0, 1e-5)])
def test_pointing_holds_while_the_engine_thrusts_for_two_hours(source, friction_left, within):
    config = SpacecraftConfig(
        initial_target="thrust_a",
        engine_start_s=(1.0, 2.0),
        attitude_source=source,
        wheel_friction_left=friction_left,
    )
    craft = Spacecraft(config, 4)
    command(craft, "ips.start")
    craft.advance(5)
    command(craft, "ips.thrust", level=90)
    craft.advance(2 * 3600)
    assert craft.telemetry()["acs.state"] == "settled"
    assert craft.telemetry()["acs.error_rad"] < within
    truth = craft.state_for_recording().attitude_IB
    assert craft.environment.pointing_error_rad(truth, "thrust_a", craft.time) < within, "the truth, not the estimate"


def test_wheels_keep_their_torque_and_speed_limits():
    config = SpacecraftConfig(wheel_speed_limit_rad_s=60.0, wheel_initial_speed_rad_s=55.0)
    craft = Spacecraft(config, 5)
    command(craft, "acs.point", target="asteroid_d")
    last = craft.state_for_recording().wheel_speeds_rad_s
    saturated = False
    for time in range(1, 1200):
        craft.advance(time)
        speeds = craft.state_for_recording().wheel_speeds_rad_s
        # Motors are cut by the wheel's own inertia; what the bus does meanwhile moves the speed against it a little.
        assert max(map(abs, speeds)) <= 60.0 + 0.05
        changes = [abs(now - then) * 0.0191 for now, then in zip(speeds, last, strict=True)]
        assert max(changes) <= config.wheel_torque_limit_Nm + 1e-3
        saturated = saturated or max(map(abs, speeds)) > 59.9
        last = speeds
    assert saturated, "the case should reach the limit"


@settings(max_examples=80, derandomize=True, deadline=None)
@given(st.tuples(*[st.floats(-0.5, 0.5)] * 3))
def test_allocation_puts_the_wanted_torque_on_the_bus_or_less_of_the_same(torque):
    root = 3.0**-0.5
    axes = ((root, root, root), (-root, root, root), (-root, -root, root), (root, -root, root))
    motors = Wheels(axes, 0.0191, 0.2, 628.0, [0.0] * 4).step(1.0, torque)
    on_bus = -np.array(axes).T @ motors
    assert max(map(abs, motors)) <= 0.2 + 1e-12
    size = np.linalg.norm(torque)
    if size > 1e-9:
        share = float(on_bus @ torque) / size**2
        assert on_bus == pytest.approx(share * np.array(torque), abs=1e-12)
        assert share == pytest.approx(1.0) or max(map(abs, motors)) == pytest.approx(0.2)
