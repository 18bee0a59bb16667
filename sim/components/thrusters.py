"""Eight hydrazine thrusters and their valves.

Four palettes A to D carry an x-thruster (force along -X) and a z-thruster (force along +Z) each, off the axes, so that
each also turns the spacecraft:

    palette   x-thruster   z-thruster
    A         +Y +Z        +X -Y
    B         -Y -Z        +X +Y
    C         -Y +Z        -X +Y
    D         +Y -Z        -X -Y

Two thrusters that share a sign about one axis turn about that axis alone. In mode `x_for_y` the x-thrusters serve Y
and Z, the z-thrusters X; in `z_for_y` the z-thrusters serve Y and X, the x-thrusters Z. A thruster opens at least for
its minimum time; a smaller impulse waits until enough has come together.

The drive has an interlock: a chamber that is under pressure for two seconds without its command closes the latch valve
of the tank, for good. Without it, a valve stuck open turns the spacecraft faster until it breaks; with it, all eight
thrusters are lost (assumption; the flight's plumbing was not published in that detail).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sim.components.hooks import refuse_fault
from sim.components.ion_engine import STANDARD_GRAVITY_M_S2
from sim.config import SpacecraftConfig
from sim.kernels import Memory, compiled

NAMES = ("ax", "bx", "cx", "dx", "az", "bz", "cz", "dz")
MODES = ("x_for_y", "z_for_y")
# Signs of the torque about X, Y, Z, in the order of NAMES: the table above.
_SIGNS = ((0, 1, 1), (0, -1, -1), (0, -1, 1), (0, 1, -1), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (-1, -1, 0))

ON, WORKS, SIGNS, CARRY = 0, 8, 16, 40
TORQUE, FORCE = 43, 46
FORCE_N, LEVER_M, MINIMUM_S, FLOW_KG_S = 49, 50, 51, 52
USED_KG, LEFT_KG, POWERED, Z_FOR_Y = 53, 54, 55, 56
STUCK_OPEN, LEAKS, FROZEN, LEAKED_S, LATCHED = 57, 65, 66, 67, 68
SIZE = 69
LATCH_AFTER_S = 2.0


@compiled
def fire(m: Memory, dt_s: float, tx: float, ty: float, tz: float) -> None:
    """Open valves in the next `dt_s` for this mean torque (N m), as far as it goes; memory tells what came of it."""
    pair_Nm = 2.0 * m[FORCE_N] * m[LEVER_M]
    for k in range(8):
        m[ON + k] = 0.0
    for axis in range(3):
        torque = tx if axis == 0 else (ty if axis == 1 else tz)
        wanted = m[CARRY + axis] + torque * dt_s
        on_s = abs(wanted) / pair_Nm
        if on_s < m[MINIMUM_S]:
            m[CARRY + axis] = wanted
            continue
        m[CARRY + axis] = 0.0
        first = 0 if axis == 2 or (axis == 1 and m[Z_FOR_Y] == 0.0) else 4
        for k in range(first, first + 4):
            if m[SIGNS + 3 * k + axis] * wanted > 0.0:
                m[ON + k] = min(dt_s, m[ON + k] + on_s)
    push(m, dt_s)


@compiled
def push(m: Memory, dt_s: float) -> None:
    """Torque and force of the valves that are open in the next `dt_s`, and what they use."""
    for axis in range(3):
        m[TORQUE + axis] = m[FORCE + axis] = 0.0
    if m[LEFT_KG] <= 0.0 or m[FROZEN] != 0.0 or m[LATCHED] != 0.0:
        return
    leaking = False
    for k in range(8):
        share = m[WORKS + k] * m[POWERED] * m[ON + k] / dt_s
        if m[STUCK_OPEN + k] != 0.0:
            share = 1.0
            leaking = True
        for axis in range(3):
            m[TORQUE + axis] += share * m[FORCE_N] * m[LEVER_M] * m[SIGNS + 3 * k + axis]
        m[FORCE if k < 4 else FORCE + 2] += share * (-m[FORCE_N] if k < 4 else m[FORCE_N])
        m[USED_KG] += share * dt_s * m[FLOW_KG_S]
        m[LEFT_KG] = max(0.0, m[LEFT_KG] - share * dt_s * m[FLOW_KG_S])
    if leaking:
        m[LEAKED_S] += dt_s
        m[LATCHED] = 1.0 if m[LEAKED_S] >= LATCH_AFTER_S else 0.0


@compiled
def close(m: Memory) -> None:
    """All valves closed, nothing waiting."""
    for place in range(ON, ON + 8):
        m[place] = 0.0
    for place in range(CARRY, FORCE + 3):
        m[place] = 0.0


class Thrusters:
    """The thrusters' memory, mode and faults. Torque and force are means over the control period, body axes."""

    READINGS: ClassVar[Mapping[str, int]] = {"rcs.hydrazine_kg": LEFT_KG}

    def __init__(self, config: SpacecraftConfig) -> None:
        self.memory: Memory = np.zeros(SIZE)
        m = self.memory
        m[WORKS : WORKS + 8] = m[POWERED] = 1.0
        m[SIGNS : SIGNS + 24] = np.ravel(_SIGNS)
        m[FORCE_N], m[LEVER_M] = config.thruster_N, config.thruster_lever_m
        m[MINIMUM_S], m[LEFT_KG] = config.thruster_minimum_s, config.hydrazine_kg
        m[FLOW_KG_S] = config.thruster_N / (config.thruster_specific_impulse_s * STANDARD_GRAVITY_M_S2)

    def __repr__(self) -> str:
        return f"Thrusters({self.mode}, {self.used_kg:.4f} kg used)"

    @property
    def mode(self) -> str:
        """`x_for_y` or `z_for_y`: which four turn the spacecraft about Y."""
        return MODES[int(self.memory[Z_FOR_Y])]

    @property
    def used_kg(self) -> float:
        """Hydrazine used."""
        return float(self.memory[USED_KG])

    def select(self, mode: str) -> str | None:
        """Choose the mode; impulses that wait are dropped."""
        self.memory[Z_FOR_Y] = float(MODES.index(mode))
        close(self.memory)
        return None

    def telemetry(self) -> dict[str, str]:
        """Mode and latch valve. The thrusters' valves have no sensors: a closed one shows in the attitude."""
        return {"rcs.mode": self.mode, "rcs.latch": "closed" if self.memory[LATCHED] else "open"}

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`closed_`, `open_` and a thruster of `NAMES`: its valve does not open, or does not close."""
        del parameters
        kind, _, name = mode.partition("_")
        if kind not in ("closed", "open") or name not in NAMES:
            refuse_fault(self, mode)
        if kind == "closed":
            self.memory[WORKS + NAMES.index(name)] = 0.0 if active else 1.0
        else:
            self.memory[STUCK_OPEN + NAMES.index(name)] = 1.0 if active else 0.0
            self.memory[LEAKS] = float(self.memory[STUCK_OPEN : STUCK_OPEN + 8].any())
            if not self.memory[LEAKS]:
                close(self.memory)
