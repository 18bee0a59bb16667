import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim import ConfigurationError, SimulationError, Spacecraft, SpacecraftConfig
from sim import filter_law as law
from sim.estimator import Estimator, Sensors
from sim.quaternion import about, axis_angle, conjugate, dot, multiply, rotate_inverse, unit
from tests.sim.flights import command, slew, until

CONFIG = SpacecraftConfig()
LEVEL = (1.0, 0.0, 0.0, 0.0)
SUN_I = np.array([0.6, 0.64, 0.48])


def slewing(second):
    """A rate (rad/s, body axes) that rests, turns faster than the tracker can follow, and rests again."""
    share = math.sin(math.pi * (second - 60) / 180) if 60 <= second < 240 else 0.0
    return (2.0e-3 * share, -1.0e-3 * share, 0.5e-3 * share)


def fly(seed, seconds, motion, config=CONFIG):
    """Sensors and filter on a known motion; yields second, true attitude, sensors and filter."""
    generator = np.random.default_rng(seed)
    attitude = LEVEL
    sensors = Sensors(config, generator, attitude)
    filter_ = Estimator(config, generator, attitude, sensors.memory[law.GYRO_BIAS : law.GYRO_BIAS + 3].copy())
    for second in range(seconds):
        rate = motion(second)
        size = math.sqrt(dot(rate, rate))
        if size > 0.0:
            attitude = multiply(attitude, about(unit(rate), size))
        block, row = sensors.noise()
        law.sense(sensors.memory, np.array(attitude), np.array(rate), SUN_I, block[row], 1.0)
        law.propagate(filter_.memory, sensors.memory, 1.0)
        law.correct(filter_.memory, sensors.memory, SUN_I)
        yield second, attitude, sensors, filter_


def error_of(attitude, sensors, filter_):
    """Attitude error (rad, body axes) and bias error, as the filter defines them."""
    w, x, y, z = multiply(conjugate(filter_.attitude_IB), attitude)
    sign = math.copysign(2.0, w)
    bias = sensors.memory[law.GYRO_BIAS : law.GYRO_BIAS + 3] - filter_.memory[law.BIAS : law.BIAS + 3]
    return np.array([sign * x, sign * y, sign * z, *bias])


@pytest.mark.parametrize("second", [50, 150, 239, 299])
def test_the_filter_knows_how_wrong_it_is(second):
    """Normalised squared error over 100 seeds against chi-square with 600 degrees of freedom, 99.9 % bounds."""
    total = 0.0
    for seed in range(100):
        *_, (_, attitude, sensors, filter_) = fly(seed, second + 1, slewing)
        error = error_of(attitude, sensors, filter_)
        covariance = filter_.memory[law.COVARIANCE : law.COVARIANCE + 36].reshape(6, 6)
        assert covariance == pytest.approx(covariance.T, abs=1e-18)
        total += float(error @ np.linalg.solve(covariance, error))
        assert bool(sensors.memory[law.TRACKER_VALID]) == (second in (50, 299, 239))
    assert 493.0 < total < 719.0


@settings(max_examples=50, derandomize=True, deadline=None)
@given(st.tuples(*[st.floats(-0.05, 0.05)] * 3), st.integers(0, 10_000))
def test_the_covariance_is_carried_on_as_by_matrices(turn, seed):
    generator = np.random.default_rng(seed)
    filter_ = Estimator(CONFIG, generator, LEVEL, np.zeros(3))
    sensors = Sensors(CONFIG, generator, LEVEL)
    f, s = filter_.memory, sensors.memory
    root = generator.standard_normal((6, 6))
    before = root @ root.T
    f[law.COVARIANCE : law.COVARIANCE + 36] = before.ravel()
    f[law.BIAS : law.BIAS + 3] = (1e-3, -2e-3, 5e-4)
    s[law.GYRO_TURN : law.GYRO_TURN + 3] = np.array(turn) + f[law.BIAS : law.BIAS + 3] * 0.5
    law.propagate(f, s, 0.5)
    x, y, z = turn
    carry = np.eye(6)
    carry[:3, :3] -= np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    carry[:3, 3:] = -0.5 * np.eye(3)
    noise = np.repeat((CONFIG.gyro_angle_walk_rad_rs, CONFIG.gyro_bias_walk_rad_s_rs), 3) ** 2 * 0.5
    expected = carry @ before @ carry.T + np.diag(noise)
    assert f[law.COVARIANCE : law.COVARIANCE + 36].reshape(6, 6) == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert axis_angle(filter_.attitude_IB)[1] == pytest.approx(np.linalg.norm(turn), abs=1e-4)


@settings(max_examples=50, derandomize=True, deadline=None)
@given(st.tuples(*[st.floats(-1.0, 1.0)] * 3), st.floats(1e-3, 10.0), st.integers(0, 10_000))
def test_a_measurement_is_taken_as_by_matrices(direction, variance, seed):
    """Gain, correction and covariance of the textbook, for one scalar after some correction already made."""
    generator = np.random.default_rng(seed)
    root = generator.standard_normal((6, 6))
    before, correction = root @ root.T, generator.standard_normal(6)
    memory = np.zeros(law.FILTER_SIZE)
    memory[law.COVARIANCE : law.COVARIANCE + 36] = before.ravel()
    row = np.array([*direction, 0.0, 0.0, 0.0])
    gain = before @ row / (row @ before @ row + variance)
    expected = correction + gain * (0.7 - row @ correction)
    law.take(memory, correction, *direction, 0.7, variance)
    assert correction == pytest.approx(expected, abs=1e-9)
    after = (np.eye(6) - np.outer(gain, row)) @ before
    assert memory[law.COVARIANCE : law.COVARIANCE + 36].reshape(6, 6) == pytest.approx(after, abs=1e-9)


def test_the_filter_is_better_than_its_sensors_and_finds_the_bias():
    config = SpacecraftConfig(initial_bias_error_rad_s=2e-6, initial_attitude_error_rad=1e-3)
    errors = []
    for second, attitude, sensors, filter_ in fly(1, 3000, lambda second: (0.0, 0.0, 0.0), config):
        if second >= 2000:
            errors.append(error_of(attitude, sensors, filter_))
    spread = np.sqrt(np.mean(np.square(errors), axis=0))
    assert (spread[:3] < 0.5 * np.array(config.tracker_noise_rad)).all()
    assert (spread[3:] < 2e-7).all()


@pytest.mark.parametrize("seed", range(5))
def test_the_sun_alone_tells_the_attitude_across_its_line(seed):
    """Without tracker: noise of 1.7e-3 rad a reading, a known gyro, so that a thousand readings average."""
    config = SpacecraftConfig(initial_attitude_error_rad=3e-3, initial_bias_error_rad_s=1e-8)
    generator = np.random.default_rng(seed)
    sensors = Sensors(config, generator, LEVEL)
    sensors.set_fault("tracker_fails", True, {})
    filter_ = Estimator(config, generator, LEVEL, sensors.memory[law.GYRO_BIAS : law.GYRO_BIAS + 3].copy())
    start = error_of(LEVEL, sensors, filter_)[:3]
    for _ in range(1000):
        block, row = sensors.noise()
        law.sense(sensors.memory, np.array(LEVEL), np.zeros(3), SUN_I, block[row], 1.0)
        law.propagate(filter_.memory, sensors.memory, 1.0)
        law.correct(filter_.memory, sensors.memory, SUN_I)
    end = error_of(LEVEL, sensors, filter_)[:3]
    line = SUN_I / np.linalg.norm(SUN_I)
    assert np.linalg.norm(end - (end @ line) * line) < 4e-4
    assert end @ line == pytest.approx(start @ line, abs=4e-4), "about its line the Sun tells nothing"


def test_every_noise_has_its_size():
    readings = {"turn": [], "rate": [], "tracker": [], "sun": []}
    biases = []
    for _, attitude, sensors, _ in fly(3, 4000, lambda second: (1e-4, 2e-4, -1e-4)):
        s = sensors.memory
        biases.append(s[law.GYRO_BIAS : law.GYRO_BIAS + 3].copy())
        turn = np.array((1e-4, 2e-4, -1e-4))
        bias = biases[-2] if len(biases) > 1 else biases[-1]
        readings["turn"].append(s[law.GYRO_TURN : law.GYRO_TURN + 3] - turn - bias)
        readings["rate"].append(s[law.GYRO_RATE : law.GYRO_RATE + 3] - turn - bias)
        _, x, y, z = multiply(conjugate(attitude), tuple(s[law.TRACKER : law.TRACKER + 4]))
        readings["tracker"].append([2.0 * x, 2.0 * y, 2.0 * z])
        seen = np.array(rotate_inverse(attitude, tuple(SUN_I)))
        readings["sun"].append(s[law.SUN_READING : law.SUN_READING + 3] - seen)
    expected = {
        "turn": (CONFIG.gyro_angle_walk_rad_rs,) * 3,
        "rate": (CONFIG.gyro_rate_noise_rad_s,) * 3,
        "tracker": CONFIG.tracker_noise_rad,
        "sun": (CONFIG.sun_sensor_noise_rad,) * 3,
    }
    for name, sigma in expected.items():
        values = np.array(readings[name][1:]) / np.array(sigma)
        # Four standard errors: 1/sqrt(n) of the mean, 1/sqrt(2 n) of the spread.
        assert values.mean(axis=0) == pytest.approx(np.zeros(3), abs=4.0 / math.sqrt(len(values))), name
        assert values.std(axis=0) == pytest.approx(np.ones(3), abs=4.0 / math.sqrt(2 * len(values))), name
        lag_one = (values[1:] * values[:-1]).mean(axis=0)
        assert lag_one == pytest.approx(np.zeros(3), abs=4.0 / math.sqrt(len(values))), f"{name} is white"
    steps = np.diff(np.array(biases), axis=0) / CONFIG.gyro_bias_walk_rad_s_rs
    assert steps.std(axis=0) == pytest.approx(np.ones(3), abs=4.0 / math.sqrt(2 * len(steps)))


def test_the_tracker_is_blind_when_slewing_fast_and_with_the_sun_in_its_cone():
    craft = Spacecraft(CONFIG, 1)
    assert craft.telemetry()["tracker.state"] == "tracking"
    command(craft, "acs.point", target="asteroid_b")
    assert until(craft, "tracker.state", "blind") < 60
    sigma = craft.telemetry()["acs.estimate_sigma_rad"]
    craft.advance(craft.time + 200)
    assert craft.telemetry()["acs.estimate_sigma_rad"] > sigma
    until(craft, "acs.state", "settled")
    assert craft.telemetry()["tracker.state"] == "tracking"
    sensors = Sensors(CONFIG, np.random.default_rng(1), LEVEL)
    for sun, valid in (((-1.0, 0.0, 0.0), 0.0), ((-0.8, 0.6, 0.0), 1.0), ((-0.9, 0.436, 0.0), 0.0)):
        law.sense(sensors.memory, np.array(LEVEL), np.zeros(3), np.array(sun), np.zeros(15), 1.0)
        assert sensors.memory[law.TRACKER_VALID] == valid, sun


def test_telemetry_and_control_see_the_filter_and_the_truth_only_when_asked():
    estimated, true = (Spacecraft(SpacecraftConfig(attitude_source=source), 1) for source in ("estimator", "truth"))
    for craft in (estimated, true):
        craft.inject("star-tracker-fails", 0.0)
        craft.inject("sun-sensors-fail", 0.0)
        craft.inject("gyro-bias-jumps", 10.0, parameters={"size": 20.0})
        craft.advance(600)
    # 20 degrees an hour for 590 s turn the estimate by 3.3 degrees about each axis, and the controller follows it.
    assert estimated.telemetry()["acs.error_rad"] < 2e-3
    truth = estimated.state_for_recording().attitude_IB
    off = axis_angle(multiply(conjugate(estimated.environment.target_attitude_IB("earth", 0.0)), truth))[1]
    assert off == pytest.approx(math.sqrt(3.0) * math.radians(20.0) * 590 / 3600, rel=0.1)
    assert true.telemetry()["acs.state"] == "settled"
    with pytest.raises(ConfigurationError, match="attitude_source: expected estimator or truth"):
        SpacecraftConfig(attitude_source="oracle")


def test_the_filter_swallows_a_bias_jump_while_the_tracker_sees():
    craft = Spacecraft(CONFIG, 2)
    craft.inject("gyro-bias-jumps", 10.0, parameters={"size": 2.0})
    craft.advance(1800)
    truth = craft.state_for_recording().attitude_IB
    assert craft.environment.pointing_error_rad(truth, "earth", 0.0) < CONFIG.settle_error_rad


def test_a_slew_ends_within_the_settling_threshold_in_truth():
    craft = Spacecraft(CONFIG, 5)
    for target in ("asteroid_c", "thrust_b"):
        slew(craft, target)
        truth = craft.state_for_recording().attitude_IB
        assert craft.environment.pointing_error_rad(truth, target, 0.0) < 1.5 * CONFIG.settle_error_rad


@pytest.mark.parametrize(
    ("unit_name", "place", "component"),
    [
        ("_sensors", law.GYRO_BIAS, "sensors"),
        ("_estimator", law.BIAS + 1, "estimator"),
        ("_control", 4, "acs"),
        ("_power", 0, "power"),
        ("_wings", 0, "wings"),
        ("_thrusters", 53, "rcs"),
    ],
)
def test_a_unit_that_gives_no_number_is_named_with_the_time(unit_name, place, component):
    craft = Spacecraft(CONFIG, 1)
    craft.advance(20)
    getattr(craft, unit_name).memory[place] = math.nan
    with pytest.raises(SimulationError, match=rf"{component} at 2[01]\.000 s.*finite") as caught:
        craft.advance(25)
    assert caught.value.component == component
