"""Pictures of the real sky and what is read from them: star tracker, science camera, navigation."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from sim import Spacecraft, SpacecraftConfig
from sim.navigation import take
from sim.optics import FULL_SCALE, MICAS, STAR_TRACKER, Body, Optics, expose
from sim.plates import Plate, UnsolvedError, solve_narrow, solve_wide
from sim.quaternion import about, multiply
from sim.sky import Floats, from_angles, inertial_of, load_sky, to_angles
from sim.star_tracker import TRACKER_AXES_B, StarTracker, axes_I, calibrate

SUN = np.array([1.0, 0.0, 0.0])


def looking_at(direction: Floats, roll_rad: float = 0.3) -> Floats:
    backward = -direction / np.linalg.norm(direction)
    right = np.cross([0.0, 0.0, 1.0], backward)
    right /= np.linalg.norm(right)
    up = np.cross(backward, right)
    cosine, sine = math.cos(roll_rad), math.sin(roll_rad)
    return np.array([cosine * right + sine * up, cosine * up - sine * right, backward])


def asteroids() -> list[Floats]:
    directions = [np.array(t.direction_I) for t in SpacecraftConfig().targets if t.kind == "asteroid"]
    return [d / np.linalg.norm(d) for d in directions]


def body(direction: Floats, diameter_rad: float = 0.0) -> Body:
    return Body(direction, SUN, diameter_rad, 9.0)


def test_the_sky_is_the_real_one() -> None:
    sky = load_sky()
    assert np.linalg.norm(sky.directions_I, axis=1) == pytest.approx(1.0)
    assert np.all(np.diff(sky.magnitudes) >= 0.0)
    # Sirius, the brightest, by its coordinates of J2000 as any almanac has them: 6 h 45 m 9 s, -16 deg 42' 58".
    ra, dec = math.radians(15 * (6 + 45 / 60 + 9 / 3600)), -math.radians(16 + 42 / 60 + 58 / 3600)
    sirius = inertial_of(from_angles(np.array([ra]), np.array([dec])))[0]
    assert math.acos(sky.directions_I[0] @ sirius) < math.radians(30 / 3600)  # its own motion in 16 years
    pole = inertial_of(np.array([[0.0, 0.0, 1.0]]))[0]
    assert math.degrees(math.acos(pole[2])) == pytest.approx(23.4393, abs=1e-4)
    for direction in asteroids():
        assert len(sky.near(direction, math.radians(0.33))) >= 3
    angles = np.array([0.3, 4.0]), np.array([-1.2, 0.4])
    assert np.allclose(to_angles(from_angles(*angles)), angles)


def test_light_is_counted_and_falls_where_the_pinhole_puts_it() -> None:
    sky, axes = load_sky(), looking_at(asteroids()[2])
    empty = replace(sky, directions_I=sky.directions_I[:0], magnitudes=sky.magnitudes[:0])
    place = np.array([200.3, 310.8])
    point = Body(MICAS.direction(place, axes), SUN, 0.0, 8.0)
    assert MICAS.project(point.direction[None, :], axes)[0] == pytest.approx(place, abs=1e-9)
    fine = Optics(MICAS.pixels, MICAS.field_rad, 1.5, MICAS.zero_point_e_s, 0.0, 0.0, 1.0)
    frame = expose(fine, empty, (axes,), 10.0, point, None).astype(float)
    assert frame.sum() == pytest.approx(fine.electrons(8.0, 10.0), rel=0.01)
    rows, columns = np.indices(frame.shape)
    assert (columns * frame).sum() / frame.sum() == pytest.approx(place[0], abs=0.02)
    assert (rows * frame).sum() / frame.sum() == pytest.approx(place[1], abs=0.02)


def test_noise_is_that_of_light_and_of_reading() -> None:
    sky, axes = load_sky(), looking_at(asteroids()[0])
    empty = replace(sky, directions_I=sky.directions_I[:0], magnitudes=sky.magnitudes[:0])
    optics = replace(MICAS, background_e_s=100.0, gain_e=1.0)
    frame = expose(optics, empty, (axes,), 20.0, None, np.random.default_rng(1)).astype(float)
    assert frame.mean() == pytest.approx(2000.0, abs=1.0)
    assert frame.std() == pytest.approx(math.sqrt(2000.0 + 20.0**2), rel=0.01)


@pytest.mark.parametrize("diameter_rad", [0.0, 5e-4, 1.2e-3])
def test_the_direction_measured_is_the_target_s(diameter_rad: float) -> None:
    """Within 2 microradians, a twelfth of a pixel, though the filter's attitude is off by 40."""
    for seed, direction in enumerate(asteroids()):
        true = looking_at(direction + 1e-4)
        believed = looking_at(direction + 1e-4 + np.array([0.0, 3e-5, -2e-5]), 0.30002)
        frame = take("x", body(direction, diameter_rad), [true] * 31, 30.0, believed, np.random.default_rng(seed))
        assert frame.status == "stars"
        assert frame.direction_I is not None
        assert np.linalg.norm(frame.direction_I - direction) < 2e-6


def test_a_frame_full_of_stars_is_not_lost_to_a_wide_search() -> None:
    """Eleven stars, the attitude known to a pixel: searched for within 4 mrad alone this one finds no match."""
    direction = from_angles(np.array([3.478923]), np.array([0.060574]))[0]
    believed = looking_at(direction + np.array([0.0, 7e-6, 5e-6]), 3.537)
    rng = np.random.default_rng(85)
    assert take("x", body(direction, 8e-4), [looking_at(direction, 3.537)], 30.0, believed, rng).status == "stars"


def test_what_spoils_a_frame() -> None:
    direction, rng = asteroids()[3], np.random.default_rng(5)
    steady = looking_at(direction)
    smeared = [looking_at(direction + np.array([0.0, 4e-5 * second, 0.0])) for second in range(31)]
    assert not take("x", body(direction), smeared, 30.0, steady, rng).good
    elsewhere = looking_at(direction + np.array([0.02, 0.0, 0.0]))
    assert not take("x", body(direction), [elsewhere] * 31, 30.0, elsewhere, rng).good
    assert not take(
        "x", body(direction), [looking_at(direction + np.array([0.008, 0, 0]))] * 31, 30.0, steady, rng
    ).good
    assert take("x", body(direction), [steady] * 31, 30.0, steady, rng).good


def test_where_stars_are_too_few_the_attitude_serves() -> None:
    sky = load_sky()
    places = from_angles(np.linspace(0.0, 6.0, 100), np.full(100, 1.3))
    lonely = next(place for place in places if len(sky.near(place, 0.0062)) < 2)
    axes = looking_at(lonely)
    frame = take("x", body(lonely), [axes], 30.0, looking_at(lonely + 3e-5), np.random.default_rng(2))
    assert frame.status == "attitude"
    assert frame.direction_I is not None
    assert np.linalg.norm(frame.direction_I - lonely) < 8e-5


def test_a_plate_needs_stars() -> None:
    dark = np.zeros((MICAS.pixels, MICAS.pixels), np.uint16)
    with pytest.raises(UnsolvedError, match="too few"):
        solve_narrow(dark, MICAS, looking_at(asteroids()[0]))
    with pytest.raises(UnsolvedError, match="0 centroids"):
        solve_wide(np.zeros((STAR_TRACKER.pixels, STAR_TRACKER.pixels), np.uint16))


def test_the_tracker_s_noise_model_is_calibrated() -> None:
    """The model's deviations are those of the chain of picture, centroids and solution, within 40 %."""
    deviations, failed = calibrate(np.random.default_rng(3), 40)
    assert failed <= 0.02
    assert deviations == pytest.approx(SpacecraftConfig().tracker_noise_rad, rel=0.4)


def test_the_tracker_s_error_has_its_sign(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is the small turn in body axes that makes the measured attitude of the true one, as the noise model's is."""
    error_B, attitude = np.array([3e-4, -2e-4, 1e-4]), (0.5, 0.5, -0.5, 0.5)
    size = float(np.linalg.norm(error_B))
    x, y, z = (error_B / size).tolist()
    measured = multiply(attitude, about((x, y, z), size))
    plate = Plate(axes_I(measured, TRACKER_AXES_B), np.empty((0, 2)), np.empty((0, 2)), 0.0)
    monkeypatch.setattr("sim.star_tracker.solve_wide", lambda frame: plate)
    assert StarTracker(np.random.default_rng(4)).error_B(attitude) == pytest.approx(error_B, abs=1e-7)


def test_a_session_on_pictures_and_one_on_limits() -> None:
    """In flight: settled, the frame holds the target; commanded while the spacecraft turns, it does not."""
    for frames in (True, False):
        craft = Spacecraft(SpacecraftConfig(initial_target="asteroid_a", camera_frames=frames), 1)
        craft.send("micas.power", {"on": True})
        craft.advance(1000)
        craft.send("micas.expose", {"target": "asteroid_a", "seconds": 30.0})
        craft.advance(1100)
        assert craft.telemetry()["micas.images"] == 1
        assert craft.telemetry()["optnav.status"] == ("stars" if frames else "none")
        if frames:
            seen = from_angles(*(np.array([craft.telemetry()[f"optnav.{n}_rad"]]) for n in ("longitude", "latitude")))
            assert np.linalg.norm(seen[0] - craft.environment.direction_I("asteroid_a", 1100.0)) < 5e-6
            assert craft.last_frame is not None
            assert craft.last_frame.pixels.max() <= FULL_SCALE
        craft.send("acs.point", {"target": "asteroid_b"})
        craft.advance(1200)
        craft.send("micas.expose", {"target": "asteroid_b", "seconds": 30.0})
        craft.advance(1300)
        assert craft.telemetry()["micas.images"] == 1


def test_a_tracker_that_takes_pictures() -> None:
    craft = Spacecraft(SpacecraftConfig(tracker_frames=True), 1)
    craft.advance(15)
    telemetry = craft.telemetry()
    assert telemetry["tracker.state"] == "tracking"
    assert float(telemetry["acs.error_rad"]) < 1e-4
