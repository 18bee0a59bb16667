"""Days of cruise: the way about the Sun under thrust, and the sky that moves with it."""

import math

import numpy as np
import pytest

from sim import ConfigurationError, Spacecraft, SpacecraftConfig, Target
from sim.control import slew_bounds
from sim.environment import Environment
from sim.orbits import AU_M, LIGHT_M_S, SUN_MU_M3_S2, Elements
from sim.slews import slew_bounds_between
from tests.sim.flights import command, slew, thrusting

DAY_S = 86_400
EARTH = Target("earth", "earth", orbit=Elements(1.0, 0.0167, 0.0, 0.0, 103.0, 10.0))


def test_two_days_of_thrust_move_the_spacecraft_as_newton_s_law_says():
    """Against RK4 of gravity and thrust together, both along a fixed heading, from the state at the start of thrust."""
    craft = Spacecraft(
        SpacecraftConfig(initial_target="thrust_a", engine_start_s=(1.0, 2.0), solar_pressure_1au_Pa=0.0), 1
    )
    thrusting(craft, 90)
    craft.advance(120)
    orbit, since = craft.environment._orbit, craft.environment._since_s
    assert since == 120
    position, velocity = orbit.at(0.0)
    mass_kg = craft.state_for_recording().mass_kg
    heading = np.array(craft.environment.direction_I("thrust_a", 0.0))
    thrust_N = craft.telemetry()["ips.thrust_N"]
    craft.advance(120 + DAY_S)
    flow_kg_s = (mass_kg - craft.state_for_recording().mass_kg) / DAY_S

    def slope(time_s, y):
        gravity = -SUN_MU_M3_S2 * y[:3] / np.linalg.norm(y[:3]) ** 3
        return np.concatenate((y[3:], gravity + thrust_N / (mass_kg - flow_kg_s * time_s) * heading))

    y, h = np.array([*position, *velocity]), 600.0
    for k in range(round(DAY_S / h)):
        t = k * h
        a = slope(t, y)
        b = slope(t + 0.5 * h, y + 0.5 * h * a)
        c = slope(t + 0.5 * h, y + 0.5 * h * b)
        d = slope(t + h, y + h * c)
        y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    found = np.array(craft.state_for_recording().heliocentric_position_I_m)
    ballistic = np.array(orbit.at(DAY_S)[0])
    assert np.linalg.norm(found - ballistic) > 5e5, "the thrust should show"
    assert found == pytest.approx(y[:3], abs=2e3)


def test_distance_light_and_power_follow_the_way_about_the_sun():
    config = SpacecraftConfig(orbit=Elements(1.3, 0.35, 5.0, 20.0, 100.0, 60.0), targets=(EARTH,))
    craft = Spacecraft(config, 1)
    sky = Environment(config)
    first = craft.state_for_recording()
    assert first.sun_distance_au == pytest.approx(np.linalg.norm(config.orbit.orbit().position_m) / AU_M)
    craft.advance(4 * DAY_S)
    last = craft.state_for_recording()
    expected = np.array(config.orbit.orbit().at(4 * DAY_S)[0])
    assert np.array(last.heliocentric_position_I_m) == pytest.approx(expected, abs=1e5), "sunlight alone pushes it"
    assert abs(last.sun_distance_au - first.sun_distance_au) > 0.01
    telemetry = craft.telemetry()
    assert telemetry["power.array_W"] == pytest.approx(2500.0 / last.sun_distance_au**2, rel=1e-4)
    assert telemetry["sun.distance_au"] == pytest.approx(last.sun_distance_au, abs=1e-5)
    earth = np.array(EARTH.orbit.orbit().at(4 * DAY_S)[0])
    assert telemetry["earth.light_time_s"] == pytest.approx(np.linalg.norm(earth - expected) / LIGHT_M_S, abs=0.1)
    turned = math.acos(float(np.dot(sky.direction_I("earth", 0.0), sky.direction_I("earth", 4.0 * DAY_S))))
    assert turned > 0.02
    assert telemetry["acs.state"] == "settled", "it follows the Earth all the while"
    assert craft.environment.pointing_error_rad(last.attitude_IB, "earth", craft.time) < 2e-4


def test_a_slew_meets_a_target_that_moves_on_and_keeps_it():
    near = Target("rock", "asteroid", orbit=Elements(1.05, 0.0, 80.0, 178.36))
    craft = Spacecraft(SpacecraftConfig(targets=(EARTH, near)), 2)
    command(craft, "acs.point", target="rock")
    before = craft.environment.direction_I("rock", 0.0)
    slew(craft, "rock")
    after = craft.environment.direction_I("rock", craft.time)
    assert math.dist(before, after) > 5e-4, "beyond the settling threshold"
    for _ in range(60):
        craft.advance(craft.time + 60)
        assert craft.telemetry()["acs.state"] == "settled"
        truth = craft.state_for_recording().attitude_IB
        assert craft.environment.pointing_error_rad(truth, "rock", craft.time) < 4e-4


def test_bodies_grow_as_they_come_nearer_and_directions_at_infinity_stay():
    sky = Environment(SpacecraftConfig())
    days = 30 * DAY_S
    for name, target in sky.targets.items():
        assert sky.direction_I(name, 0.0) == pytest.approx(
            np.array(target.direction_I) / np.linalg.norm(target.direction_I), abs=1e-9
        )
        if target.distance_au:
            assert sky.distance_m(name, 0.0) == pytest.approx(target.distance_au * AU_M)
            shrunk = sky.distance_m(name, 0.0) / sky.distance_m(name, days)
            assert sky.angular_diameter_rad(name, days) == pytest.approx(target.angular_diameter_rad * shrunk)
            assert sky.direction_I(name, days) != pytest.approx(sky.direction_I(name, 0.0), abs=1e-3)
        else:
            assert sky.distance_m(name, days) == math.inf
            assert sky.direction_I(name, days) == sky.direction_I(name, 0.0)


def test_a_spacecraft_thrusts_without_changing_the_sky_of_another():
    config = SpacecraftConfig(initial_target="thrust_a", engine_start_s=(1.0, 2.0))
    one, other = Spacecraft(config, 1), Spacecraft(config, 1)
    thrusting(one, 90)
    one.advance(DAY_S // 4)
    other.advance(DAY_S // 4)
    ways = [np.array(craft.state_for_recording().heliocentric_position_I_m) for craft in (one, other)]
    assert 1e4 < np.linalg.norm(ways[0] - ways[1]) < 1e6


def test_a_body_in_the_spacecraft_s_own_place_is_refused():
    own = Elements(1.2, 0.1)
    with pytest.raises(ConfigurationError, match="targets, 'twin': expected a place of its own"):
        Environment(SpacecraftConfig(orbit=own, targets=(EARTH, Target("twin", "asteroid", orbit=own))))


def test_turn_bounds_over_a_span_hold_at_its_start_in_it_and_at_its_end():
    """The sky of three days moves some turns by more than their bounds at one instant would allow for."""
    config = SpacecraftConfig()
    sky = Environment(config)
    span = 3.0 * DAY_S
    for here, there in (("earth", "asteroid_a"), ("asteroid_d", "thrust_b"), ("asteroid_b", "asteroid_c")):
        whole = slew_bounds_between(sky, config, here, there, 0.0, span)
        for time_s in np.linspace(0.0, span, 60):
            now = slew_bounds(sky.slew_angle(here, there, time_s), config)
            assert whole.lower_s <= now.lower_s
            assert now.upper_s <= whole.upper_s
    craft = Spacecraft(config, 6)
    craft.advance(2 * DAY_S)
    slew(craft, "asteroid_d")
    bounds = slew_bounds_between(sky, config, "asteroid_d", "thrust_b", 0.0, span)
    assert bounds.lower_s <= slew(craft, "thrust_b") <= bounds.upper_s
