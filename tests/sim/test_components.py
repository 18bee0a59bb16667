import itertools

import numpy as np
import pytest

from sim import SpacecraftConfig
from sim.components import thermal
from sim.components.camera import Camera
from sim.components.ion_engine import LEVELS, STANDARD_GRAVITY_M_S2, THROTTLE_TABLE, IonEngine
from sim.components.power import RECOVERED_SOC, Power
from sim.components.radio import Radio, Recorder
from sim.components.terminal import Acknowledgement, BusTerminal
from sim.components.wings import Wings

CONFIG = SpacecraftConfig()


def generator(seed=0):
    return np.random.default_rng(seed)


def warmed(unit, heat):
    """A unit whose temperature takes its course before it does."""
    own = unit.step

    def step(dt_s):
        thermal.step(heat.memory, dt_s)
        return own(dt_s)

    unit.step = step
    return unit


def engine_of(config, source):
    heat = thermal.Thermal(config, source)
    return warmed(IonEngine(config, source, heat.cathode), heat)


def camera_of(config, source):
    heat = thermal.Thermal(config, source)
    return warmed(Camera(config, source, heat.camera), heat)


def test_throttle_table_has_the_public_range():
    assert tuple(THROTTLE_TABLE) == LEVELS == (6, 27, 48, 69, 83, 90)
    low, high = THROTTLE_TABLE[6], THROTTLE_TABLE[90]
    assert (low.power_W, low.thrust_N, low.specific_impulse_s) == pytest.approx((500.0, 0.020, 1950.0))
    assert (high.power_W, high.thrust_N) == pytest.approx((2100.0, 0.084))
    points = list(THROTTLE_TABLE.values())
    for below, above in itertools.pairwise(points):
        assert below.power_W < above.power_W
        assert below.thrust_N < above.thrust_N
        assert 1950.0 <= below.specific_impulse_s < above.specific_impulse_s <= 3100.0
    for point in points:
        jet_power = 0.5 * point.thrust_N * point.specific_impulse_s * STANDARD_GRAVITY_M_S2
        assert 0.3 < jet_power / point.power_W < 0.7, (
            "an ion engine turns a third to two thirds of its power into the jet"
        )


@pytest.mark.parametrize("seed", range(20))
def test_engine_start_and_stop_take_their_spans(seed):
    engine = engine_of(CONFIG, generator(seed))
    assert engine.start() is None
    seconds = 0
    while engine.state == "starting":
        assert engine.power_W == CONFIG.engine_starting_W
        engine.step(1.0)
        seconds += 1
    assert engine.state == "ready"
    assert 600 <= seconds <= 1200
    assert engine.stop() is None
    seconds = 0
    while engine.state == "stopping":
        engine.step(1.0)
        seconds += 1
    assert engine.state == "standby"
    assert 60 <= seconds <= 240


def test_engine_uses_xenon_and_counts_thrust():
    engine = engine_of(CONFIG, generator())
    engine.start()
    for _ in range(1300):
        engine.step(1.0)
    engine.thrust(90)
    for _ in range(3600):
        engine.step(1.0)
    telemetry = engine.telemetry()
    flow = 0.084 / (THROTTLE_TABLE[90].specific_impulse_s * 9.80665)
    assert engine.xenon_kg == pytest.approx(81.5 - 3600 * flow)
    assert engine.xenon_used_kg == pytest.approx(3600 * flow)
    assert engine.thrust_seconds == 3600
    assert (telemetry["ips.state"], telemetry["ips.level"], telemetry["ips.power_W"]) == ("thrusting", 90, 2100.0)
    assert engine.thrust(27) is None
    assert (engine.level, engine.thrust_N) == (27, THROTTLE_TABLE[27].thrust_N)
    assert engine.idle() is None
    assert (engine.state, engine.level, engine.thrust_N) == ("ready", 0, 0.0)


def test_engine_refuses_what_its_state_forbids():
    engine = engine_of(CONFIG, generator())
    for refused in (engine.idle(), engine.stop(), engine.thrust(6)):
        assert refused is not None
        assert "found standby" in refused
    engine.start()
    assert "found starting" in str(engine.start())
    assert engine.stop() is None
    assert "found stopping" in str(engine.stop())


def test_engine_without_xenon_goes_out():
    engine = engine_of(SpacecraftConfig(xenon_kg=1e-5, engine_start_s=(1.0, 1.0)), generator())
    engine.start()
    engine.step(1.0)
    engine.thrust(90)
    for _ in range(10):
        engine.step(1.0)
    assert (engine.state, engine.thrust_N, engine.xenon_kg) == ("ready", 0.0, 0.0)
    assert "none left" in str(engine.thrust(6))


@pytest.mark.parametrize("seed", range(20))
def test_camera_warms_up_and_takes_a_frame_in_its_spans(seed):
    camera = camera_of(CONFIG, generator(seed))
    assert "found off" in str(camera.expose("x", 10.0))
    camera.power(True)
    seconds = 0
    while camera.state == "warming":
        assert camera.power_W == 150.0
        camera.step(1.0)
        seconds += 1
    assert 600 <= seconds <= 900
    assert (camera.state, camera.power_W) == ("ready", 100.0)
    assert camera.expose("x", 10.0) is None
    assert "found exposing" in str(camera.expose("x", 10.0))
    seconds, frame = 0, None
    while frame is None:
        frame = camera.step(1.0)
        seconds += 1
    assert frame is True
    assert 30 <= seconds <= 50
    assert camera.state == "ready"


@pytest.mark.parametrize(("error", "rate", "good"), [(1e-4, 1e-5, True), (1e-2, 0.0, False), (0.0, 1e-3, False)])
def test_a_frame_is_good_when_aimed_and_steady(error, rate, good):
    camera = camera_of(SpacecraftConfig(camera_warmup_s=(1.0, 1.0)), generator())
    camera.power(True)
    camera.step(1.0)
    camera.expose("x", 5.0)
    camera.watch(0.0, 0.0)
    camera.watch(error, rate)
    camera.watch(0.0, 0.0)
    frames = [frame for frame in (camera.step(1.0) for _ in range(60)) if frame is not None]
    assert frames == [good]


def test_camera_off_loses_the_frame_and_the_heat():
    camera = camera_of(SpacecraftConfig(camera_warmup_s=(1.0, 1.0)), generator())
    camera.power(True)
    camera.step(1.0)
    camera.expose("x", 5.0)
    camera.power(False)
    assert (camera.state, camera.power_W, camera.switch_on) == ("off", 0.0, False)
    assert all(camera.step(1.0) is None for _ in range(60))
    camera.power(True)
    camera.power(True)
    assert camera.state == "warming"
    camera.supply(False)
    assert (camera.state, camera.switch_on) == ("off", True)
    camera.supply(True)
    assert camera.state == "warming"


@pytest.mark.parametrize("seconds", [0.0, -1.0, 601.0])
def test_camera_refuses_exposures_beyond_its_limit(seconds):
    camera = camera_of(SpacecraftConfig(camera_warmup_s=(1.0, 1.0)), generator())
    camera.power(True)
    camera.step(1.0)
    assert "at most 600" in str(camera.expose("x", seconds))
    assert camera.state == "ready"


def test_battery_keeps_account_of_energy():
    power = Power(SpacecraftConfig(battery_capacity_Wh=100.0, battery_initial_soc=0.5, sun_distance_au=1.0))
    power.observe(0.0, 10.0)
    assert (power.array_W, power.load_W) == (0.0, 360.0)
    for _ in range(100):
        power.step(1.0)
    assert power.soc == pytest.approx(0.5 - 360.0 * 100.0 / 360_000.0)
    power.observe(1.0, 0.0)
    assert power.array_W == 2500.0
    for _ in range(100):
        power.step(1.0)
    assert power.soc == pytest.approx(0.4 + 0.9 * 300.0 * 100.0 / 360_000.0), "charging is limited and loses a tenth"
    for _ in range(10_000):
        power.step(1.0)
    assert power.soc == 1.0


def test_an_empty_battery_is_undervoltage_until_recovered():
    power = Power(SpacecraftConfig(battery_capacity_Wh=1.0, battery_initial_soc=0.1))
    power.observe(0.0, 0.0)
    while not power.undervoltage:
        power.step(1.0)
    assert power.soc == 0.0
    power.observe(1.0, 0.0)
    power.step(0.1)
    assert power.undervoltage
    while power.soc < RECOVERED_SOC:
        assert power.undervoltage
        power.step(0.1)
    assert not power.undervoltage
    assert power.telemetry()["power.bus"] == "nominal"


def test_radio_and_recorder():
    radio, recorder = Radio(CONFIG), Recorder(20.0)
    assert "found state off" in str(radio.downlink(True))
    radio.power(True)
    assert (radio.state, radio.power_W) == ("on", 15.0)
    assert radio.rate_Mbit_s == 0.0
    radio.downlink(True)
    radio.power(True)
    assert (radio.state, radio.power_W) == ("downlinking", 60.0)
    assert radio.rate_Mbit_s == pytest.approx(0.02)
    radio.downlink(False)
    assert radio.state == "on"
    radio.power(False)
    assert (radio.state, radio.rate_Mbit_s) == ("off", 0.0)
    assert recorder.store(12.6)
    assert not recorder.store(12.6)
    recorder.play(100.0, 0.1)
    assert recorder.stored_Mbit == pytest.approx(2.6)
    recorder.play(100.0, 0.1)
    assert (recorder.stored_Mbit, recorder.downlinked_Mbit) == (0.0, pytest.approx(12.6))


def test_terminal_answers_for_its_unit():
    terminal = BusTerminal("ips")
    assert terminal.deliver(lambda: None) == Acknowledgement(True)
    assert terminal.deliver(lambda: "not now") == Acknowledgement(False, "not now")


def test_wings_take_the_short_way_and_wait_with_the_sun_on_their_axis():
    wings = Wings(0.01, (1.0, 0.0, 0.0))
    assert wings.step(1.0, (-0.8, 0.0, 0.6)) == pytest.approx(-0.01)
    assert wings.step(1.0, (0.05, 0.99, -0.05)) == pytest.approx(-0.01)
    assert wings.incidence_cosine([0.0, 0.5], (1.0, 0.0, 0.0)) == pytest.approx(0.5 * (1.0 + np.cos(0.5)))
    assert wings.incidence_cosine([0.0, 0.0], (-1.0, 0.0, 0.0)) == 0.0
