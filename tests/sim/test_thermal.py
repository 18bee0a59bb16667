import math

import numpy as np
import pytest

from sim import Spacecraft, SpacecraftConfig
from sim.components import thermal
from sim.components.thermal import CAMERA, CATHODE, Thermal
from tests.sim.flights import command, slew, until

CONFIG = SpacecraftConfig()


def test_a_node_relaxes_as_its_equation_says_however_time_is_cut():
    """T' = (T_eq - T) / tau against Euler's rule in steps of a hundredth of a second."""
    units = [Thermal(CONFIG, np.random.default_rng(1)) for _ in range(2)]
    for unit in units:
        unit.camera.switch_on()
    m = units[0].memory
    expected, tau_s, goal_C = float(m[CAMERA]), float(m[thermal.TAU_S]), float(m[thermal.EQUILIBRIUM_C])
    for _ in range(60_000):
        expected += 0.01 * (goal_C - expected) / tau_s
    for _ in range(600):
        thermal.step(units[0].memory, 1.0)
    thermal.step(units[1].memory, 600.0)
    assert units[0].memory[CAMERA] == pytest.approx(expected, abs=1e-3)
    assert units[0].memory == pytest.approx(units[1].memory, abs=1e-9)


@pytest.mark.parametrize(("node", "span_s"), [(CAMERA, CONFIG.camera_warmup_s), (CATHODE, CONFIG.engine_start_s)])
def test_warm_ups_take_their_spans_whatever_was_before_and_differ(node, span_s):
    """Cold ones, and ones switched off a while ago; from the coldest it takes the longest time."""
    taken = []
    for seed in range(40):
        generator = np.random.default_rng(seed)
        heat = Thermal(CONFIG, generator)
        unit = heat.camera if node == CAMERA else heat.cathode
        for _ in range(3):
            unit.switch_on()
            seconds = 0
            ready = False
            while not ready:
                thermal.step(heat.memory, 1.0)
                ready = unit.step(1.0, 1.0)
                seconds += 1
            taken.append(seconds)
            unit.switch_off()
            thermal.step(heat.memory, float(generator.exponential(3000.0)))
    assert span_s[0] <= min(taken)
    assert max(taken) <= math.ceil(span_s[1])
    assert min(taken) == span_s[0], "still warm from the last time, it waits for its electronics alone"
    assert max(taken) > 0.9 * span_s[1]
    assert np.std(taken) > 0.05 * (span_s[1] - span_s[0])


def test_temperatures_show_in_telemetry_and_a_camera_kept_off_cools():
    craft = Spacecraft(CONFIG, 3)
    before = craft.telemetry()["thermal.camera_C"]
    assert before < 20.0
    command(craft, "micas.power", on=True)
    until(craft, "micas.state", "ready")
    craft.advance(craft.time + 600)
    assert craft.telemetry()["thermal.camera_C"] == pytest.approx(20.0, abs=0.2)
    command(craft, "micas.power", on=False)
    craft.advance(craft.time + 6 * 3600)
    assert craft.telemetry()["thermal.camera_C"] < 10.0
    assert craft.telemetry()["thermal.tank_C"] == 15.0


def test_a_cold_tank_gives_no_thrust_and_a_cold_battery_takes_no_charge():
    craft = Spacecraft(SpacecraftConfig(battery_initial_soc=0.5, battery_charge_limit_W=5.0), 1)
    craft.inject("tank-heater-fails", 0.0, 6 * 3600.0)
    craft.inject("battery-heater-fails", 0.0)
    craft.advance(6 * 3600)
    telemetry = craft.telemetry()
    assert telemetry["thermal.tank_C"] < 3.0
    assert telemetry["thermal.battery_C"] == pytest.approx(-20.0 + 35.0 * math.exp(-6.0 / 8.0), abs=0.1)
    command(craft, "acs.actuators", name="thrusters")
    command(craft, "acs.point", target="asteroid_a")
    craft.advance(craft.time + 600)
    assert craft.telemetry()["rcs.hydrazine_kg"] == 31.1
    assert craft.telemetry()["acs.error_rad"] > 0.1
    craft.advance(12 * 3600)
    assert craft.telemetry()["thermal.battery_C"] < 0.0
    soc = craft.telemetry()["battery.soc"]
    assert 0.5 < soc < 1.0
    craft.advance(14 * 3600)
    assert craft.telemetry()["battery.soc"] == soc
    assert craft.telemetry()["thermal.tank_C"] > 3.0
    until(craft, "acs.state", "settled")
    slew(craft, "earth")
