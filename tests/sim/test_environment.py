import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim import ConfigurationError, SpacecraftConfig, Target
from sim.environment import POINTING_AXIS_B, WING_AXIS_B, Environment, wing_angle_rad
from sim.quaternion import dot, rotate, rotate_inverse, unit

numbers = st.floats(-1.0, 1.0)
directions = st.tuples(numbers, numbers, numbers).filter(lambda v: dot(v, v) > 1e-2)


def environment(kind, direction, sun):
    targets = (Target("x", kind, direction), Target("home", "earth" if kind != "earth" else "thrust", (0.0, 0.0, 1.0)))
    return Environment(SpacecraftConfig(targets=targets, sun_direction_I=sun, initial_target="x"))


@settings(max_examples=120, derandomize=True, deadline=None)
@given(st.sampled_from(sorted(POINTING_AXIS_B)), directions, directions)
def test_the_right_axis_looks_there_and_the_wings_can_face_the_sun(kind, direction, sun):
    env = environment(kind, direction, sun)
    attitude = env.target_attitude_IB("x", 0.0)
    assert rotate(attitude, POINTING_AXIS_B[kind]) == pytest.approx(unit(direction), abs=1e-9)
    assert env.pointing_error_rad(attitude, "x", 0.0) < 1e-7
    sun_B = rotate_inverse(attitude, env.sun_direction_I(0.0))
    assert dot(sun_B, WING_AXIS_B) == pytest.approx(0.0, abs=1e-5)
    angle = wing_angle_rad(sun_B)
    normal = (math.cos(angle), 0.0, -math.sin(angle))
    assert dot(normal, sun_B) == pytest.approx(1.0, abs=1e-9)
    assert sun_B[2] <= 1e-5 if kind == "earth" else sun_B[0] >= -1e-5


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("kind", sorted(POINTING_AXIS_B))
def test_a_target_on_the_sun_line_is_pointed_at(kind, sign):
    env = environment(kind, (sign, 0.0, 0.0), (1.0, 0.0, 0.0))
    attitude = env.target_attitude_IB("x", 0.0)
    assert rotate(attitude, POINTING_AXIS_B[kind]) == pytest.approx((sign, 0.0, 0.0), abs=1e-12)


def test_slew_angles_are_those_of_a_metric():
    env = Environment(SpacecraftConfig())
    for a in env.targets:
        assert env.slew_angle(a, a, 0.0) == pytest.approx(0.0, abs=1e-7)
        for b in env.targets:
            assert env.slew_angle(a, b, 0.0) == pytest.approx(env.slew_angle(b, a, 0.0))
            assert all(
                env.slew_angle(a, b, 0.0) <= env.slew_angle(a, c, 0.0) + env.slew_angle(c, b, 0.0) + 1e-9
                for c in env.targets
            )


def test_an_unknown_target_is_named():
    with pytest.raises(ConfigurationError, match=r"expected one of earth.*found 'vulcan'"):
        Environment(SpacecraftConfig()).slew_angle("earth", "vulcan", 0.0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"time_step_s": 0.3}, "time_step_s.*whole fraction"),
        ({"control_period_s": 0}, "control_period_s"),
        ({"base_load_W": -1.0}, "base_load_W.*found -1"),
        ({"base_load_W": math.nan}, "base_load_W"),
        ({"camera_warmup_s": (9.0, 3.0)}, "camera_warmup_s.*9.0, 3.0"),
        ({"battery_initial_soc": 1.5}, "battery_initial_soc"),
        ({"sun_distance_au": 0.0}, "sun_distance_au"),
        ({"sun_direction_I": (0.0, 0.0, 0.0)}, "sun_direction_I"),
        ({"initial_target": "vulcan"}, "initial_target.*vulcan"),
        ({"targets": (Target("earth", "planet", (1.0, 0.0, 0.0)),)}, "kind.*planet"),
        ({"targets": (Target("earth", "earth", (0.0, 0.0, 0.0)),)}, "direction"),
        ({"targets": (Target("earth", "earth", (1.0, 0.0, 0.0)),) * 2}, "name of its own"),
        ({"targets": (Target("a", "asteroid", (1.0, 0.0, 0.0)),), "initial_target": "a"}, "one of kind earth"),
    ],
)
def test_what_cannot_fly_is_refused_by_field(changes, message):
    with pytest.raises(ConfigurationError, match=message):
        SpacecraftConfig(**changes)
