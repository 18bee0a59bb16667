"""From the model file to a compiled MuJoCo model, with what the rest of the simulator needs to know of it.

The file is `assets/spacecraft.xml`; it defines the body frame. Nothing here holds a state.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files

import mujoco
import numpy as np

from sim.errors import ConfigurationError
from sim.quaternion import Vector

WHEELS = ("wheel_1", "wheel_2", "wheel_3", "wheel_4")
WINGS = ("wing_plus", "wing_minus")
JOINTS = ("bus", *WHEELS, *WINGS)

# Where things lie in qpos (13) and qvel (12): the free joint first, then wheels, then wings, as in JOINTS.
QPOS_ATTITUDE = slice(3, 7)
QPOS_WINGS = slice(11, 13)
QVEL_RATE = slice(3, 6)
QVEL_WHEELS = slice(6, 10)
QVEL_WINGS = slice(10, 12)


@dataclass(frozen=True, eq=False)
class Assembly:
    """The compiled model and its constants. Inertia: principal values about the centre of mass, wings at angle 0."""

    model: mujoco.MjModel
    bus_body: int
    total_mass_kg: float
    inertia_kg_m2: Vector
    wheel_inertia_kg_m2: float
    wheel_axes_B: tuple[Vector, Vector, Vector, Vector]

    def __repr__(self) -> str:
        return f"Assembly({self.total_mass_kg:.1f} kg, {self.model.nv} degrees of freedom)"


def load_assembly(time_step_s: float) -> Assembly:
    """Compile the spacecraft's model for integration steps of `time_step_s`; every call gives a model of its own."""
    text = files("assets").joinpath("spacecraft.xml").read_text(encoding="utf-8")
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.timestep = time_step_s
    names = tuple(model.joint(i).name for i in range(model.njnt))
    actuators = tuple(model.actuator(i).name for i in range(model.nu))
    if names != JOINTS or actuators != (*WHEELS, *WINGS):
        raise ConfigurationError(f"assets/spacecraft.xml: expected joints {JOINTS}, found {names}, {actuators}")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mass_matrix = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass_matrix)
    inertia = np.diag(mass_matrix)[3:6].tolist()
    axes: list[Vector] = [tuple(model.jnt_axis[model.joint(name).id].tolist()) for name in WHEELS]
    return Assembly(
        model=model,
        bus_body=int(model.body("bus").id),
        total_mass_kg=float(model.body_mass.sum()),
        inertia_kg_m2=(inertia[0], inertia[1], inertia[2]),
        wheel_inertia_kg_m2=float(mass_matrix[6, 6]),
        wheel_axes_B=(axes[0], axes[1], axes[2], axes[3]),
    )
