import math

import numpy as np
import pytest

from sim import SimulationError
from sim.assembly import load_assembly
from sim.physics import Physics

LEVEL = (1.0, 0.0, 0.0, 0.0)
STILL = [0.0] * 6
NOWHERE = (0.0, 0.0, 0.0)


def test_the_model_is_the_spacecraft_that_its_file_promises():
    assembly = load_assembly(0.5)
    assert assembly.total_mass_kg == pytest.approx(486.3)
    assert assembly.wheel_inertia_kg_m2 == pytest.approx(0.0191)
    assert np.array(assembly.wheel_axes_B).T @ np.array(assembly.wheel_axes_B) == pytest.approx(4.0 / 3.0 * np.eye(3))
    physics = Physics(assembly, LEVEL, [0.0] * 4)
    data = physics.scratch()
    import mujoco

    mujoco.mj_forward(assembly.model, data)
    assert data.subtree_com[assembly.bus_body] == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)


def test_torque_free_hour_keeps_angular_momentum():
    physics = Physics(load_assembly(0.5), LEVEL, [200.0, -300.0, 100.0, 250.0])
    physics.set_rate((0.002, 0.001, -0.002))
    before = np.array(physics.angular_momentum_I())
    for _ in range(60):
        physics.advance(120, STILL, NOWHERE)
    after = np.array(physics.angular_momentum_I())
    assert np.linalg.norm(after - before) / np.linalg.norm(before) < 1e-8
    assert max(map(abs, physics.rate_B)) > 1e-3, "it should have tumbled"


def test_momentum_stays_while_wheels_and_wings_are_driven():
    physics = Physics(load_assembly(0.5), LEVEL, [50.0, -60.0, 70.0, -80.0])
    before = np.array(physics.angular_momentum_I())
    for second in range(3600):
        swing = math.sin(second / 200.0)
        controls = [0.02 * swing, -0.01 * swing, 0.015 * swing, -0.01 * swing, 0.5 * swing, 0.3 * swing]
        physics.advance(2, controls, NOWHERE)
    after = np.array(physics.angular_momentum_I())
    assert np.linalg.norm(after - before) / np.linalg.norm(before) < 1e-8


def test_a_wheel_pushes_the_bus_the_other_way():
    assembly = load_assembly(0.5)
    physics = Physics(assembly, LEVEL, [0.0] * 4)
    # Wheels 1 and 4 turn towards +X, 2 and 3 against: a torque about X alone, sqrt(3)/4 of it on each motor.
    torque, seconds = 0.05, 20
    share = 0.25 * math.sqrt(3.0) * torque
    physics.advance(2 * seconds, [share, -share, -share, share, 0.0, 0.0], NOWHERE)
    free_inertia = assembly.inertia_kg_m2[0] - 4.0 / 3.0 * assembly.wheel_inertia_kg_m2
    expected = [-torque * seconds / free_inertia, 0.0, 0.0]
    assert physics.rate_B == pytest.approx(expected, rel=1e-4, abs=1e-9)


def test_force_moves_the_mass_that_is_left_and_turns_nothing():
    physics = Physics(load_assembly(0.5), LEVEL, [0.0] * 4)
    physics.set_xenon_used(40.0)
    physics.advance(200, STILL, (0.0, 0.09, 0.0))
    assert physics.velocity_I == pytest.approx((0.0, 0.09 * 100.0 / (486.3 - 40.0), 0.0), rel=1e-9, abs=1e-15)
    assert physics.rate_B == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


@pytest.mark.parametrize(("place", "component"), [(0, "wheel_1"), (3, "wheel_4"), (5, "wing_minus")])
def test_a_command_that_is_no_number_names_its_component_and_time(place, component):
    physics = Physics(load_assembly(0.5), LEVEL, [0.0] * 4)
    physics.advance(20, STILL, NOWHERE)
    controls = list(STILL)
    controls[place] = math.nan
    with pytest.raises(SimulationError, match=rf"{component} at 10\.000 s.*nan") as caught:
        physics.advance(2, controls, NOWHERE)
    assert (caught.value.component, caught.value.time_s) == (component, 10.0)


def test_a_thrust_that_is_no_number_is_the_engines():
    physics = Physics(load_assembly(0.5), LEVEL, [0.0] * 4)
    with pytest.raises(SimulationError, match="in ips"):
        physics.advance(2, STILL, (math.inf, 0.0, 0.0))


def test_instability_is_an_error_and_no_silent_reset(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its log where it stands
    physics = Physics(load_assembly(0.5), LEVEL, [0.0] * 4)
    physics.advance(200, STILL, NOWHERE)
    with pytest.raises(SimulationError, match="wheel_2") as caught:
        physics.advance(20, [0.0, 1e9, 0.0, 0.0, 0.0, 0.0], NOWHERE)
    assert 100.0 <= caught.value.time_s <= 101.0, "the step that went wrong; a reset would have set the clock back"


def test_models_do_not_share_anything():
    one, two = load_assembly(0.5), load_assembly(1.0)
    Physics(one, LEVEL, [0.0] * 4).set_xenon_used(10.0)
    assert two.model.opt.timestep == 1.0
    assert float(two.model.body_mass.sum()) == pytest.approx(486.3)
