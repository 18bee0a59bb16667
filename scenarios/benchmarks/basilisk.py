"""The same slew flown by MuJoCo as we step it and by Basilisk, where that is installed (`pip install bsk`).

A rigid bus of our spacecraft's inertia with its four wheels (no friction, no disturbance) turns from rest to another
attitude under the same law at 1 s: torque -K sigma - P omega, sigma the modified Rodrigues parameters of the error (H.
Schaub, J. Junkins, "Analytical Mechanics of Space Systems", section 8.4), shared among the wheels by least squares.
RK4 at 0.5 s in both. The wings' joints, which the flight has, are left out: Basilisk's bus is rigid too. That it is the
same slew shows in the attitudes at its end.
"""

from __future__ import annotations

import math
import time
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from sim.assembly import Assembly, load_assembly
from sim.kernels import Memory, compiled

DURATION_S = 600
STEP_S = 0.5
REPEATS = 10
TARGET_MRP = (0.2, 0.3, 0.1)
STIFFNESS_NM, DAMPING_NMS = 0.5, 21.0
Outcome = tuple[float, NDArray[np.float64]]


_MODEL = """<mujoco><option timestep="{step}" integrator="RK4" gravity="0 0 0"/><worldbody><body><freejoint/>
<inertial pos="0 0 0" mass="{mass}" diaginertia="{inertia}"/>{wheels}</body></worldbody>
<actuator>{motors}</actuator></mujoco>"""
_WHEEL = (
    """<body><joint name="wheel{k}" axis="{axis}"/><inertial pos="0 0 0" mass="1" diaginertia="{j} {j} {j}"/></body>"""
)
_MOTOR = """<motor joint="wheel{k}"/>"""


@compiled
def wheel_torques(attitude: Memory, rate: Memory, sharing: Memory, target: Memory, torques: Memory) -> None:
    """The law. `attitude`, `target`: quaternions, body to inertial; `rate` (3) in body axes; `sharing` (4, 3)."""
    w, x, y, z = attitude[0], attitude[1], attitude[2], attitude[3]
    tw, tx, ty, tz = target[0], -target[1], -target[2], -target[3]
    ew = tw * w - tx * x - ty * y - tz * z
    sign = 1.0 if ew >= 0.0 else -1.0
    share = sign * STIFFNESS_NM / (1.0 + sign * ew)
    bx = share * (tw * x + tx * w + ty * z - tz * y) + DAMPING_NMS * rate[0]
    by = share * (tw * y - tx * z + ty * w + tz * x) + DAMPING_NMS * rate[1]
    bz = share * (tw * z + tx * y - ty * x + tz * w) + DAMPING_NMS * rate[2]
    for k in range(4):
        torques[k] = sharing[k, 0] * bx + sharing[k, 1] * by + sharing[k, 2] * bz


def rigid_model(assembly: Assembly) -> mujoco.MjModel:
    """Bus and wheels; a wheel's inertia is the same about all axes, and is taken out of the bus's."""
    spin, axes = assembly.wheel_inertia_kg_m2, assembly.wheel_axes_B
    wheels = [_WHEEL.format(k=k, axis="{:.17g} {:.17g} {:.17g}".format(*axis), j=spin) for k, axis in enumerate(axes)]
    text = _MODEL.format(
        step=STEP_S,
        mass=assembly.total_mass_kg - len(axes),
        inertia=" ".join(str(about - len(axes) * spin) for about in assembly.inertia_kg_m2),
        wheels="".join(wheels),
        motors="".join(_MOTOR.format(k=k) for k in range(len(axes))),
    )
    return mujoco.MjModel.from_xml_string(text)


def fly_ours(assembly: Assembly) -> Outcome:
    """Seconds it took, and the MRP of the attitude at the end."""
    model = rigid_model(assembly)
    data = mujoco.MjData(model)
    attitude, rate, torques = data.qpos[3:7], data.qvel[3:6], data.ctrl
    sharing = np.ascontiguousarray(np.linalg.pinv(np.array(assembly.wheel_axes_B).T))
    square = sum(part * part for part in TARGET_MRP)
    target = np.array([1.0 - square, *(2.0 * part for part in TARGET_MRP)]) / (1.0 + square)
    steps = round(1.0 / STEP_S)
    wheel_torques(attitude, rate, sharing, target, torques)  # compiled before the clock runs
    begin = time.perf_counter()
    for _ in range(DURATION_S):
        wheel_torques(attitude, rate, sharing, target, torques)
        mujoco.mj_step(model, data, nstep=steps)
    taken = time.perf_counter() - begin
    w, *vector = attitude.tolist()
    return taken, np.array(vector) / (1.0 + abs(w)) * math.copysign(1.0, w)


def fly_basilisk(assembly: Assembly) -> Outcome:
    """The same of Basilisk; ImportError when it is not installed."""
    from Basilisk.architecture import messaging
    from Basilisk.fswAlgorithms import attTrackingError, inertial3D, mrpFeedback, rwMotorTorque
    from Basilisk.simulation import reactionWheelStateEffector, simpleNav, spacecraft, svIntegrators
    from Basilisk.utilities import SimulationBaseClass, macros, simIncludeRW

    simulation = SimulationBaseClass.SimBaseClass()
    process = simulation.CreateNewProcess("slew")
    process.addTask(simulation.CreateNewTask("dynamics", macros.sec2nano(STEP_S)))
    process.addTask(simulation.CreateNewTask("control", macros.sec2nano(1.0)))
    inertia = np.diag(assembly.inertia_kg_m2)

    bus = spacecraft.Spacecraft()
    bus.hub.mHub, bus.hub.IHubPntBc_B = assembly.total_mass_kg, inertia.tolist()
    integrator = svIntegrators.svIntegratorRK4(bus)
    bus.setIntegrator(integrator)
    factory = simIncludeRW.rwFactory()
    for axis in assembly.wheel_axes_B:
        factory.create("custom", list(axis), Omega=0.0, Js=assembly.wheel_inertia_kg_m2, useMaxTorque=False)
    wheels = reactionWheelStateEffector.ReactionWheelStateEffector()
    factory.addToSpacecraft("wheels", wheels, bus)

    navigation, reference = simpleNav.SimpleNav(), inertial3D.inertial3D()
    navigation.scStateInMsg.subscribeTo(bus.scStateOutMsg)
    reference.sigma_R0N = list(TARGET_MRP)
    error, law, sharing = attTrackingError.attTrackingError(), mrpFeedback.mrpFeedback(), rwMotorTorque.rwMotorTorque()
    error.attNavInMsg.subscribeTo(navigation.attOutMsg)
    error.attRefInMsg.subscribeTo(reference.attRefOutMsg)
    law.K, law.P, law.Ki = STIFFNESS_NM, DAMPING_NMS, -1.0  # without the integral term
    payload = messaging.VehicleConfigMsgPayload(ISCPntB_B=inertia.ravel().tolist())
    vehicle, parameters = messaging.VehicleConfigMsg().write(payload), factory.getConfigMessage()
    law.guidInMsg.subscribeTo(error.attGuidOutMsg)
    law.vehConfigInMsg.subscribeTo(vehicle)
    law.rwParamsInMsg.subscribeTo(parameters)
    law.rwSpeedsInMsg.subscribeTo(wheels.rwSpeedOutMsg)
    sharing.controlAxes_B = np.eye(3).ravel().tolist()
    sharing.rwParamsInMsg.subscribeTo(parameters)
    sharing.vehControlInMsg.subscribeTo(law.cmdTorqueOutMsg)
    wheels.rwMotorCmdInMsg.subscribeTo(sharing.rwMotorTorqueOutMsg)
    for part in (wheels, bus, navigation):
        simulation.AddModelToTask("dynamics", part)
    for part in (reference, error, law, sharing):
        simulation.AddModelToTask("control", part)

    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(float(DURATION_S)))
    begin = time.perf_counter()
    simulation.ExecuteSimulation()
    taken = time.perf_counter() - begin
    return taken, np.array(bus.scStateOutMsg.read().sigma_BN)


def figures(repeats: int = REPEATS) -> dict[str, Any]:
    """Simulated seconds a second of both, ours over Basilisk's, and how far apart (rad) they end; None without it."""
    names = ("sim_seconds_per_second", "basilisk_seconds_per_second", "ratio_to_basilisk", "attitudes_apart_rad")
    assembly = load_assembly(STEP_S)
    try:
        flown = [(fly_ours(assembly), fly_basilisk(assembly)) for _ in range(repeats)]
    except ImportError as error:
        return {**dict.fromkeys(names), "reason": f"Basilisk is not installed (pip install bsk): {error}"}
    ours, theirs = min(one[0] for one, _ in flown), min(other[0] for _, other in flown)
    apart = 4.0 * float(np.linalg.norm(flown[0][0][1] - flown[0][1][1]))
    return dict(zip(names, (DURATION_S / ours, DURATION_S / theirs, theirs / ours, apart), strict=True))
