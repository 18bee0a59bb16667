import itertools
import math

import numpy as np
import pytest

from sim import ConfigurationError, Spacecraft, SpacecraftConfig, Target
from sim.environment import Environment
from sim.ground import OBLIQUITY_RAD, SIDEREAL_RAD_S, STATIONS, GroundSegment
from sim.orbits import AU_M, LIGHT_M_S
from tests.sim.flights import FAST, command

DAY_S = 86_400.0
ONE = SpacecraftConfig(ground_stations="goldstone")


def test_a_station_sees_what_hour_angle_and_declination_say():
    """sin(elevation) = sin(lat) sin(dec) + cos(lat) cos(dec) cos(hour angle), all in equatorial coordinates."""
    generator = np.random.default_rng(2)
    for _ in range(50):
        right_ascension, declination = generator.uniform(-math.pi, math.pi), generator.uniform(-0.4, 0.4)
        time_s, sidereal = generator.uniform(0.0, 10 * DAY_S), generator.uniform(0.0, 6.0)
        station = STATIONS["canberra"]
        hour = sidereal + SIDEREAL_RAD_S * time_s + math.radians(station.longitude_deg) - right_ascension
        latitude = math.radians(station.latitude_deg)
        expected = math.sin(latitude) * math.sin(declination)
        expected += math.cos(latitude) * math.cos(declination) * math.cos(hour)
        x = math.cos(declination) * math.cos(right_ascension)
        y, z = math.cos(declination) * math.sin(right_ascension), math.sin(declination)
        c, s = math.cos(OBLIQUITY_RAD), math.sin(OBLIQUITY_RAD)
        ecliptic = (x, c * y + s * z, c * z - s * y)
        assert math.sin(station.elevation_rad(ecliptic, time_s, sidereal)) == pytest.approx(expected, abs=1e-9)


def test_one_station_hears_in_passes_a_day_apart_and_three_nearly_always():
    windows = Environment(ONE).downlink_windows(0.0, 4 * DAY_S)
    assert 3 <= len(windows) <= 5
    whole = [(a, b) for a, b in windows if a > 0.0 and b < 4 * DAY_S]
    for (start, end), (following, _) in itertools.pairwise(whole):
        assert 6 * 3600 < end - start < 14 * 3600
        assert following - start == pytest.approx(DAY_S, abs=900)
    always = Environment(SpacecraftConfig()).downlink_windows(0.0, 4 * DAY_S)
    assert sum(end - start for start, end in always) > 0.97 * 4 * DAY_S


def test_data_go_down_only_while_a_station_hears_and_arrive_a_light_time_later():
    config = SpacecraftConfig(ground_stations="goldstone", recorder_capacity_Mbit=5000.0)
    craft = Spacecraft(config, 1)
    craft._recorder.store(4000.0)
    command(craft, "radio.power", on=True)
    command(craft, "radio.downlink", on=True)
    windows = craft.environment.downlink_windows(0.0, 1.5 * DAY_S)

    def sent_by(time_s):
        return config.downlink_Mbit_s * sum(max(0.0, min(time_s, end) - start) for start, end in windows)

    for hour in range(1, 37):
        craft.advance(3600 * hour)
        telemetry = craft.telemetry()
        assert telemetry["recorder.downlinked_Mbit"] == pytest.approx(sent_by(craft.time), abs=5.0)
        assert (telemetry["earth.station"] == "none") == all(not a <= craft.time <= b for a, b in windows)
        light_s = telemetry["earth.light_time_s"]
        assert light_s == pytest.approx(1.534 * AU_M / LIGHT_M_S, rel=0.05)
        assert craft.received_Mbit == pytest.approx(sent_by(craft.time - light_s), abs=5.0)


def test_without_a_station_nothing_goes_down():
    craft = Spacecraft(SpacecraftConfig(ground_stations="", camera_warmup_s=FAST.camera_warmup_s), 1)
    craft._recorder.store(100.0)
    command(craft, "radio.power", on=True)
    command(craft, "radio.downlink", on=True)
    craft.advance(600)
    assert craft.telemetry()["recorder.downlinked_Mbit"] == 0.0
    assert craft.telemetry()["earth.station"] == "none"
    with pytest.raises(ConfigurationError, match=r"ground_stations: expected of goldstone.*found 'arecibo'"):
        SpacecraftConfig(ground_stations="arecibo")


def test_the_ground_knows_a_light_time_later():
    ground = GroundSegment()
    for minute in range(100):
        ground.sent(60.0 * minute, 500.0, float(max(0, min(50, minute - 20))))
    expected = [max(0.0, min(50.0, (t - 500.0) / 60.0 - 20.0)) for t in range(0, 6000, 7)]
    assert [ground.received_Mbit(float(t)) for t in range(0, 6000, 7)] == pytest.approx(expected, abs=1e-9)


def test_an_earth_without_a_distance_hears_at_once():
    config = SpacecraftConfig(targets=(Target("earth", "earth", (0.7, 0.7, 0.0)),))
    assert Environment(config).light_time_s(0.0) == 0.0
