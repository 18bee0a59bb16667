import subprocess
import sys

import numpy as np
import pytest

from sim import ConfigurationError, RenderingUnavailable, Spacecraft, SpacecraftConfig, offscreen
from sim.sky import load_sky, star_image


@pytest.fixture
def gl():
    try:
        offscreen.find_backend()
    except RenderingUnavailable as reason:
        pytest.skip(str(reason))


def test_the_science_camera_has_one_picture_and_it_needs_no_opengl(monkeypatch):
    """The view for people shows stars and target where the frame in flight has them, and disturbs nothing."""
    monkeypatch.setattr(offscreen, "find_backend", lambda: pytest.fail("OpenGL was asked for"))
    crafts = [Spacecraft(SpacecraftConfig(initial_target="asteroid_b", camera_warmup_s=(10.0, 10.0)), 3) for _ in "ab"]
    for number, craft in enumerate(crafts):
        craft.send("micas.power", {"on": True})
        craft.advance(100)
        craft.send("micas.expose", {"target": "asteroid_b", "seconds": 30.0})
        if number:
            craft.render("micas", 64, 64)
        craft.advance(200)
    frame, other = (craft.last_frame for craft in crafts)
    assert np.array_equal(frame.pixels, other.pixels)
    view = crafts[1].render("micas", 512, 512)
    assert (view.shape, view.dtype) == ((512, 512, 3), np.uint8)
    assert len(frame.stars) >= 3
    for column, row in [*frame.stars.tolist(), frame.place]:
        patch = view[round(row) - 3 : round(row) + 4, round(column) - 3 : round(column) + 4, 0]
        assert patch.max() > 40
    small = crafts[1].render("micas", 96, 64)
    assert small.shape == (64, 96, 3)
    assert not small[:, :16].any()
    assert small[:, 16:80].max() == view.max()


@pytest.mark.gl
@pytest.mark.usefixtures("gl")
def test_chase_shows_the_spacecraft():
    craft = Spacecraft(SpacecraftConfig(initial_target="asteroid_a"), 1)
    chase = craft.render("chase", 320, 240)
    assert np.count_nonzero(chase[60:180, 80:240].max(axis=2)) > 1000
    craft.close()
    assert craft.render("chase", 32, 16).shape == (16, 32, 3)
    craft.close()


@pytest.mark.gl
@pytest.mark.usefixtures("gl")
def test_pictures_do_not_disturb_the_flight():
    seen, unseen = Spacecraft(SpacecraftConfig(), 2), Spacecraft(SpacecraftConfig(), 2)
    for craft in (seen, unseen):
        craft.send("acs.point", {"target": "asteroid_a"})
        craft.advance(100)
    seen.render("chase", 64, 64)
    for craft in (seen, unseen):
        craft.advance(200)
    assert seen.state_for_recording() == unseen.state_for_recording()
    with pytest.raises(ConfigurationError, match="camera: expected one of micas, chase, found 'selfie'"):
        seen.render("selfie", 64, 64)
    with pytest.raises(ConfigurationError, match="found 0 x 64"):
        seen.render("chase", 0, 64)
    seen.close()


def test_without_opengl_the_flight_goes_on_and_the_error_names_the_packages(monkeypatch):
    monkeypatch.setattr(offscreen, "_loads", lambda library: False)
    offscreen.find_backend.cache_clear()
    try:
        craft = Spacecraft(SpacecraftConfig(), 1)
        with pytest.raises(RenderingUnavailable, match=r"libegl1 libgl1.*libosmesa6"):
            craft.render("chase", 64, 64)
        craft.advance(10)
    finally:
        offscreen.find_backend.cache_clear()


def test_a_backend_whose_libraries_load_but_do_not_work_is_passed_over(monkeypatch):
    monkeypatch.setattr(offscreen, "_loads", lambda library: True)
    monkeypatch.setattr(offscreen, "_PROBE", "import sys; sys.exit('{backend}' == 'egl' or print('rendering works'))")
    offscreen.find_backend.cache_clear()
    try:
        monkeypatch.delenv("MUJOCO_GL", raising=False)
        assert offscreen.find_backend() == "osmesa"
    finally:
        offscreen.find_backend.cache_clear()


def test_importing_the_simulator_touches_no_opengl():
    code = "import sim, sys; assert not {'OpenGL', 'mujoco.egl', 'mujoco.osmesa'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_star_falls_on_its_pixel():
    sky = load_sky()
    brightest = sky.directions_I[0]
    backward = -brightest
    right = np.cross([0.0, 0.0, 1.0], backward)
    right /= np.linalg.norm(right)
    axes = np.array([right, np.cross(backward, right), backward])
    image = star_image(sky, axes, np.radians(0.7), 101, 81, faintest=10.0)
    assert np.unravel_index(image.argmax(), image.shape) == (40, 50)
    offset = 0.1 * np.radians(0.7)
    cosine, sine = np.cos(offset), np.sin(offset)
    tilted = np.array([cosine * right - sine * backward, axes[1], sine * right + cosine * backward])
    image = star_image(sky, tilted, np.radians(0.7), 101, 81, faintest=10.0)
    row, column = np.unravel_index(image.argmax(), image.shape)
    assert row == 40
    assert abs(column - 50) == pytest.approx(0.1 * 81, abs=1.0)


@pytest.mark.gl
@pytest.mark.usefixtures("gl")
def test_a_context_that_is_lost_in_flight_is_told_with_its_time_and_the_flight_goes_on(monkeypatch):
    craft = Spacecraft(SpacecraftConfig(), 1)
    craft.render("chase", 32, 32)
    craft.advance(60)
    renderer = craft._views._renderer

    def lost():
        raise RuntimeError("EGL_CONTEXT_LOST")

    with monkeypatch.context() as patch:
        patch.setattr(renderer._context, "make_current", lost)
        with pytest.raises(RenderingUnavailable, match="lost at 60 s: EGL_CONTEXT_LOST"):
            craft.render("chase", 32, 32)
    craft.advance(120)
    assert craft.render("chase", 32, 32).shape == (32, 32, 3)
    craft.close()
