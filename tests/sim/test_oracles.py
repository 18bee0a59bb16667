"""The flight against mechanics done again by other means: Euler's equations, the rocket equation, energy, sums."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim import Spacecraft, SpacecraftConfig
from sim.assembly import load_assembly
from sim.components import thrusters
from sim.components.ion_engine import STANDARD_GRAVITY_M_S2, THROTTLE_TABLE
from sim.components.wheels import SPEEDS
from sim.physics import Physics
from sim.quaternion import axis_angle, conjugate, multiply
from tests.sim.flights import command, slew, thrusting

ROOT = 3.0**-0.5
AXES = np.array(((ROOT, ROOT, ROOT), (-ROOT, ROOT, ROOT), (-ROOT, -ROOT, ROOT), (ROOT, -ROOT, ROOT)))
PLACES = np.array(((0.3, 0.3, 0.0), (-0.3, 0.3, 0.0), (-0.3, -0.3, 0.0), (0.3, -0.3, 0.0)))
SPIN, ACROSS, WHEEL_KG = 0.0191, 0.0105, 8.0
"""A wheel's inertia (kg m2) about its axis and across it, and its mass."""
WING, WING_KG, WING_ARM_M = np.array((68.8, 12.2, 56.6)), 27.7, 3.4
BUS = np.array((115.0, 115.0, 80.4))
STIFFNESS, DAMPING = 0.2745, 3.66
"""Of a wing's drive, N m/rad and N m s/rad."""


def inertia_of(angles):
    """Of everything (kg m2, body axes), the wings at `angles` (rad)."""
    total = np.diag(BUS)
    for axis, place in zip(AXES, PLACES, strict=True):
        total = total + ACROSS * np.eye(3) + (SPIN - ACROSS) * np.outer(axis, axis)
        total = total + WHEEL_KG * (place @ place * np.eye(3) - np.outer(place, place))
    for angle in angles:
        turn = about_y(angle)
        total = total + turn @ np.diag(WING) @ turn.T + WING_KG * WING_ARM_M**2 * np.diag((1.0, 0.0, 1.0))
    return total


def about_y(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array(((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)))


def derivative(state, motors, set_points, torque_B):
    """Of quaternion (4), body rate (3), wheel speeds (4), wing angles (2) and rates (2) against the bus.

    Euler's equations of a gyrostat with two driven wings. Unknown are the accelerations of body, wheels and wings: the
    momentum of all changes by the outer torque, a wheel's along its axis by its motor, a wing's about +Y by its drive.
    """
    quaternion, rate, speeds, angles, turns = np.split(state, (4, 7, 11, 13))
    inertia = inertia_of(angles)
    matrix, right = np.zeros((9, 9)), np.zeros(9)
    momentum = inertia @ rate + SPIN * AXES.T @ speeds + np.array((0.0, WING[1] * turns.sum(), 0.0))
    changing = np.zeros((3, 3))
    for angle, turn in zip(angles, turns, strict=True):
        spin = np.array(((0.0, 0.0, turn), (0.0, 0.0, 0.0), (-turn, 0.0, 0.0)))
        wing = about_y(angle) @ np.diag(WING) @ about_y(angle).T
        changing = changing + spin @ wing - wing @ spin
    matrix[:3, :3] = inertia
    matrix[:3, 3:7] = SPIN * AXES.T
    matrix[1, 7:9] = WING[1]
    right[:3] = torque_B - np.cross(rate, momentum) - changing @ rate
    for k in range(4):
        matrix[3 + k, :3], matrix[3 + k, 3 + k], right[3 + k] = SPIN * AXES[k], SPIN, motors[k]
    for k in range(2):
        own = about_y(angles[k]).T @ rate
        matrix[7 + k, 1] = matrix[7 + k, 7 + k] = WING[1]
        drive = STIFFNESS * (set_points[k] - angles[k]) - DAMPING * turns[k]
        right[7 + k] = drive - (WING[0] - WING[2]) * own[0] * own[2]
    accelerations = np.linalg.solve(matrix, right)
    w, x, y, z = quaternion
    p, q, r = rate
    spun = 0.5 * np.array((-x * p - y * q - z * r, w * p + y * r - z * q, w * q + z * p - x * r, w * r + x * q - y * p))
    return np.concatenate((spun, accelerations[:7], turns, accelerations[7:]))


def integrate(state, second, motors, set_points, torque_B):
    """One second in two steps of Kutta's 3/8 rule, of fourth order as the one that is judged, but another one."""
    step = second / 2.0
    for _ in range(2):
        a = derivative(state, motors, set_points, torque_B)
        b = derivative(state + step * a / 3.0, motors, set_points, torque_B)
        c = derivative(state + step * (b - a / 3.0), motors, set_points, torque_B)
        d = derivative(state + step * (a - b + c), motors, set_points, torque_B)
        state = state + step * (a + 3.0 * b + 3.0 * c + d) / 8.0
        state[:4] /= np.linalg.norm(state[:4])
    return state


def state_of(craft):
    """As `derivative` takes it."""
    physics = craft._physics
    qpos, qvel = np.array(physics.qpos), np.array(physics.qvel)
    return np.concatenate((qpos[3:7], qvel[3:6], qvel[6:10], qpos[11:13], qvel[10:12]))


@pytest.mark.parametrize(("target", "actuators"), [("asteroid_d", "wheels"), ("asteroid_a", "thrusters")])
def test_a_slew_is_what_euler_s_equations_make_of_its_torques(target, actuators):
    """A whole closed-loop slew, its motor torques, set points and outer torques taken along second by second."""
    craft = Spacecraft(SpacecraftConfig(wheel_initial_speed_rad_s=300.0), 4)
    command(craft, "acs.actuators", name=actuators)
    command(craft, "acs.point", target=target)
    expected = state_of(craft)
    while craft.telemetry()["acs.state"] != "settled":
        craft.advance(craft.time + 1)
        _, _, controls, applied = craft._physics.drive_views
        expected = integrate(expected, 1.0, controls[:4], controls[4:6], applied[3:6])
    found = state_of(craft)
    assert craft.time > 250
    assert axis_angle(multiply(conjugate(tuple(expected[:4])), tuple(found[:4])))[1] < 5e-7
    assert found[4:7] == pytest.approx(expected[4:7], abs=1e-8)
    assert found[7:11] == pytest.approx(expected[7:11], rel=1e-6, abs=1e-5)
    assert found[11:] == pytest.approx(expected[11:], abs=1e-6)


def tumble(step_s, seconds=1800.0):
    """Relative change of the kinetic energy of a free tumble with spinning wheels, the wings loose on their hinges."""
    import mujoco

    assembly = load_assembly(step_s)
    assembly.model.actuator_gainprm[:] = assembly.model.actuator_biasprm[:] = 0.0
    physics = Physics(assembly, (1.0, 0.0, 0.0, 0.0), [200.0, -300.0, 100.0, 250.0])
    physics.set_rate((0.02, 0.01, -0.02))
    matrix = np.zeros((assembly.model.nv, assembly.model.nv))

    def energy():
        copy = physics.scratch()
        mujoco.mj_forward(assembly.model, copy)
        mujoco.mj_fullM(assembly.model, copy, matrix)
        return 0.5 * copy.qvel @ matrix @ copy.qvel

    before = energy()
    physics.step(round(seconds / step_s), step_s)
    return abs(energy() - before) / before


def test_energy_drifts_as_a_fourth_order_integrator_lets_it():
    """The drift falls by 16 and more with every halving of the step, and is nothing at the default one."""
    drifts = [tumble(step_s) for step_s in (4.0, 2.0, 1.0)]
    for coarse, fine in itertools.pairwise(drifts):
        assert coarse / fine > 14.0, drifts
    assert tumble(0.5) < 1e-8


@pytest.mark.parametrize("level", [6, 90])
def test_ion_thrust_obeys_the_rocket_equation(level):
    config = SpacecraftConfig(initial_target="thrust_a", engine_start_s=(1.0, 2.0), solar_pressure_1au_Pa=0.0)
    craft = Spacecraft(config, 1)
    thrusting(craft, level)
    before = craft.state_for_recording()
    craft.advance(craft.time + 20_000)
    after = craft.state_for_recording()
    exhaust_m_s = THROTTLE_TABLE[level].specific_impulse_s * STANDARD_GRAVITY_M_S2
    used_kg = THROTTLE_TABLE[level].thrust_N / exhaust_m_s * 20_000.0
    assert before.mass_kg - after.mass_kg == pytest.approx(used_kg, rel=1e-6)
    gained_m_s = np.linalg.norm(np.subtract(after.velocity_I_m_s, before.velocity_I_m_s))
    assert gained_m_s == pytest.approx(exhaust_m_s * math.log(before.mass_kg / after.mass_kg), rel=1e-6)


def test_a_straight_hydrazine_burn_obeys_the_rocket_equation():
    """Wheels loaded about Z alone: unloading fires pairs of x-thrusters, all along -X, the wheels hold the attitude."""
    craft = Spacecraft(SpacecraftConfig(solar_pressure_1au_Pa=0.0, attitude_source="truth", unload_Nm=0.02), 1)
    craft._physics.qvel_view[6:10] = craft._wheels.memory[SPEEDS : SPEEDS + 4] = 400.0
    craft._wheels.observe([400.0] * 4)
    before = craft.state_for_recording()
    command(craft, "acs.unload")
    craft.advance(800)
    after = craft.state_for_recording()
    exhaust_m_s = craft.config.thruster_specific_impulse_s * STANDARD_GRAVITY_M_S2
    assert before.mass_kg - after.mass_kg > 5e-3
    gained_m_s = np.linalg.norm(np.subtract(after.velocity_I_m_s, before.velocity_I_m_s))
    assert gained_m_s == pytest.approx(exhaust_m_s * math.log(before.mass_kg / after.mass_kg), rel=1e-6)


@settings(max_examples=40, derandomize=True, deadline=None)
@given(st.tuples(*[st.floats(-0.3, 0.3)] * 3), st.sampled_from(thrusters.MODES))
def test_hydrazine_used_is_impulse_over_exhaust_speed(torque, mode):
    """The impulse of every single opening, whatever the pushes of pairs add up to."""
    config = SpacecraftConfig()
    units = thrusters.Thrusters(config)
    units.select(mode)
    impulse_Ns = 0.0
    for _ in range(30):
        thrusters.fire(units.memory, 1.0, *torque)
        impulse_Ns += config.thruster_N * float(units.memory[thrusters.ON : thrusters.ON + 8].sum())
    exhaust_m_s = config.thruster_specific_impulse_s * STANDARD_GRAVITY_M_S2
    assert units.used_kg == pytest.approx(impulse_Ns / exhaust_m_s, rel=1e-9, abs=1e-15)


def test_mass_and_inertia_follow_the_propellant():
    """What the physics integrate with: lighter, and by a sphere's inertia easier to turn."""
    craft = Spacecraft(SpacecraftConfig(initial_target="thrust_a", engine_start_s=(1.0, 2.0)), 1)
    thrusting(craft, 90)
    craft.advance(50_000)
    used_kg = 486.3 - craft.state_for_recording().mass_kg
    assert used_kg > 0.1
    model = craft._assembly.model
    assert float(model.body_mass.sum()) == pytest.approx(486.3 - used_kg, abs=2e-4)
    assert model.body_inertia[craft._assembly.bus_body] == pytest.approx(BUS - 0.4 * used_kg * 0.3**2, abs=1e-5)


def test_the_attitude_s_quaternion_stays_of_length_one():
    craft = Spacecraft(SpacecraftConfig(), 1)
    for target in ("asteroid_b", "thrust_a", "earth"):
        slew(craft, target)
        assert np.linalg.norm(craft.state_for_recording().attitude_IB) == pytest.approx(1.0, abs=1e-14)
        assert np.linalg.norm(craft._estimator.attitude_IB) == pytest.approx(1.0, abs=1e-14)
