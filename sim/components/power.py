"""Solar array, battery, and the bus between them.

The array gives its power at 1 AU over the square of the Sun's distance, times the cosine of the incidence. What the
loads take beyond that comes from the battery. When it is empty the bus is in undervoltage: all loads but the base are
shed until the battery is back at `RECOVERED_SOC`. The base load (avionics, wheels, heaters) is never shed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sim.components.hooks import refuse_fault
from sim.config import SpacecraftConfig
from sim.kernels import Memory, compiled

RECOVERED_SOC = 0.05

SOC, ARRAY_W, LOAD_W, UNDERVOLTAGE = 0, 1, 2, 3
ARRAY_FACTOR, NORMAL_W, BASE_W, SWITCHED_W = 4, 5, 6, 7
CAPACITY_J, CHARGE_LIMIT_W, EFFICIENCY = 8, 9, 10
MARGIN_W, TOO_COLD = 11, 12
SIZE = 13


@compiled
def observe(m: Memory, incidence_cosine: float) -> None:
    """What the array receives and the loads draw from now on."""
    m[ARRAY_W] = m[ARRAY_FACTOR] * m[NORMAL_W] * max(0.0, incidence_cosine)
    m[LOAD_W] = m[BASE_W] + m[SWITCHED_W]
    m[MARGIN_W] = m[ARRAY_W] - m[LOAD_W]


@compiled
def step(m: Memory, dt_s: float) -> None:
    """Charge or discharge for `dt_s` at the present balance."""
    margin_W = m[ARRAY_W] - m[LOAD_W]
    if margin_W >= 0.0:
        charge_W = 0.0 if m[TOO_COLD] != 0.0 else min(margin_W, m[CHARGE_LIMIT_W]) * m[EFFICIENCY]
        soc = m[SOC] + charge_W * dt_s / m[CAPACITY_J]
        m[SOC] = 1.0 if soc > 1.0 else soc
        if m[SOC] >= RECOVERED_SOC:
            m[UNDERVOLTAGE] = 0.0
    else:
        m[SOC] += margin_W * dt_s / m[CAPACITY_J]
        if m[SOC] <= 0.0:
            m[SOC] = 0.0
            m[UNDERVOLTAGE] = 1.0


class Power:
    """Balance of the bus. `array_W` and `load_W` are those of the step before."""

    READINGS: ClassVar[Mapping[str, int]] = {
        "power.array_W": ARRAY_W,
        "power.load_W": LOAD_W,
        "power.margin_W": MARGIN_W,
        "battery.soc": SOC,
    }

    def __init__(self, config: SpacecraftConfig) -> None:
        self.memory: Memory = np.zeros(SIZE)
        m = self.memory
        m[SOC], m[ARRAY_FACTOR] = config.battery_initial_soc, 1.0
        m[ARRAY_W] = m[NORMAL_W] = config.array_power_1au_W / config.sun_distance_au**2
        m[LOAD_W] = m[BASE_W] = config.base_load_W
        m[CAPACITY_J] = config.battery_capacity_Wh * 3600.0
        m[CHARGE_LIMIT_W], m[EFFICIENCY] = config.battery_charge_limit_W, config.battery_charge_efficiency

    def __repr__(self) -> str:
        return f"Power({self.array_W:.0f} W in, {self.load_W:.0f} W out, charge {self.soc:.2f})"

    @property
    def soc(self) -> float:
        """Charge of the battery, 0 to 1."""
        return float(self.memory[SOC])

    @property
    def array_W(self) -> float:
        """What the array can give."""
        return float(self.memory[ARRAY_W])

    @property
    def load_W(self) -> float:
        """What all loads draw."""
        return float(self.memory[LOAD_W])

    @property
    def undervoltage(self) -> bool:
        """The battery is empty, or was and is not back yet."""
        return bool(self.memory[UNDERVOLTAGE])

    def observe(self, incidence_cosine: float, switched_load_W: float) -> None:
        """What the array receives and the loads beyond the base draw from now on."""
        self.memory[SWITCHED_W] = switched_load_W
        observe(self.memory, incidence_cosine)

    def step(self, dt_s: float) -> None:
        """Charge or discharge for `dt_s` at the present balance."""
        step(self.memory, dt_s)

    def telemetry(self) -> dict[str, str]:
        """State of the bus; balance and battery are among the readings."""
        return {"power.bus": "undervoltage" if self.memory[UNDERVOLTAGE] else "nominal"}

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`array_loss`: the array gives `factor` of its power. `battery_loss`: the battery has `factor` of its size."""
        factor = parameters.get("factor", 1.0)
        if mode == "array_loss":
            self.memory[ARRAY_FACTOR] = factor if active else 1.0
        elif mode == "battery_loss":
            self.memory[CAPACITY_J] *= factor if active else 1.0 / factor
        else:
            refuse_fault(self, mode)
