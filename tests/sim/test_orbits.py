import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim import ConfigurationError
from sim.orbits import AU_M, SUN_MU_M3_S2, Elements, Orbit

DAY_S = 86_400.0

ellipses = st.builds(
    Elements,
    st.floats(0.3, 5.0),
    st.floats(0.0, 0.95),
    st.floats(0.0, 180.0),
    st.floats(0.0, 360.0),
    st.floats(0.0, 360.0),
    st.floats(-180.0, 180.0),
)


def integrated(position, velocity, seconds, steps):
    """Newton's law with classical RK4."""

    def slope(y):
        return np.concatenate((y[3:], -SUN_MU_M3_S2 * y[:3] / np.linalg.norm(y[:3]) ** 3))

    y, h = np.array([*position, *velocity]), seconds / steps
    for _ in range(steps):
        a = slope(y)
        b = slope(y + 0.5 * h * a)
        c = slope(y + 0.5 * h * b)
        d = slope(y + h * c)
        y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return y


def test_an_orbit_moves_as_newton_s_law_says():
    orbit = Elements(1.4, 0.35, 12.0, 50.0, 110.0, -30.0).orbit()
    position, velocity = orbit.at(40.0 * DAY_S)
    expected = integrated(orbit.position_m, orbit.velocity_m_s, 40.0 * DAY_S, 2000)
    assert np.array(position) == pytest.approx(expected[:3], abs=1e-9 * AU_M)
    assert np.array(velocity) == pytest.approx(expected[3:], abs=1e-5)


@settings(max_examples=100, derandomize=True, deadline=None)
@given(ellipses, st.floats(-2000.0, 2000.0))
def test_energy_momentum_and_way_back(elements, days):
    orbit = elements.orbit()
    position, velocity = orbit.at(days * DAY_S)
    r, v = np.array(position), np.array(velocity)
    energy = 0.5 * v @ v - SUN_MU_M3_S2 / np.linalg.norm(r)
    assert -0.5 * SUN_MU_M3_S2 / energy == pytest.approx(elements.semimajor_axis_au * AU_M, rel=1e-9)
    before, after = np.cross(orbit.position_m, orbit.velocity_m_s), np.cross(r, v)
    assert after == pytest.approx(before, abs=1e-9 * np.linalg.norm(before))
    back, _ = Orbit(position, velocity).at(-days * DAY_S)
    assert np.array(back) == pytest.approx(np.array(orbit.position_m), abs=1e-6 * AU_M)


def test_the_elements_are_those_of_a_known_orbit():
    """A quarter of the mean anomaly from the periapsis of a circle, inclined and turned: geometry by hand."""
    orbit = Elements(1.0, 0.0, 90.0, 0.0, 0.0, 90.0).orbit()
    assert orbit.position_m == pytest.approx((0.0, 0.0, AU_M), abs=1.0)
    assert orbit.velocity_m_s == pytest.approx((-math.sqrt(SUN_MU_M3_S2 / AU_M), 0.0, 0.0), abs=1e-6)
    periapsis = Elements(2.0, 0.5, 0.0, 0.0, 90.0).orbit()
    assert periapsis.position_m == pytest.approx((0.0, AU_M, 0.0), abs=1.0)
    year_s = 2.0 * math.pi * math.sqrt(AU_M**3 / SUN_MU_M3_S2)
    assert year_s / DAY_S == pytest.approx(365.26, abs=0.01)
    again, _ = orbit.at(year_s)
    assert again == pytest.approx(orbit.position_m, abs=1e3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Elements(0.0), "semimajor_axis_au: expected more than 0"),
        (lambda: Elements(1.0, 1.0), "eccentricity: expected 0 to under 1, found 1.0"),
        (lambda: Elements(1.0, 0.1, math.nan), "inclination_deg: expected a finite number"),
        (lambda: Orbit((AU_M, 0.0, 0.0), (0.0, 43_000.0, 0.0)), "orbit: expected an ellipse"),
        (lambda: Orbit((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)), "orbit: expected an ellipse"),
    ],
)
def test_what_is_no_ellipse_is_refused(make, message):
    with pytest.raises(ConfigurationError, match=message):
        make()
