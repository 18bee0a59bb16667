"""Temperatures of what has to be warm: camera, cathodes of the ion engine, battery, hydrazine tank.

Each is a node that relaxes to an equilibrium, T' = (T_eq - T) / tau: a heater and what is lost to space. A unit that
warms up is ready at its temperature and not before its electronics are; how cold it is when it is switched on is drawn,
or left from the last time. Time constant and heater follow from the span of durations in the configuration: from the
coldest equilibrium the warm-up takes the longest of them, from the warmest the shortest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.random import Generator

from sim.components.hooks import refuse_fault
from sim.config import SpacecraftConfig
from sim.kernels import Memory, compiled

CAMERA, CATHODE, BATTERY, TANK = 0, 1, 2, 3
NODES = 4
TEMPERATURE_C, EQUILIBRIUM_C, TAU_S = 0, NODES, 2 * NODES
SIZE = 3 * NODES

# Assumptions: coldest equilibrium and the temperature of being ready, degrees Celsius.
_SPANS_C = {CAMERA: (-30.0, 20.0), CATHODE: (-20.0, 1050.0)}
HEATED_C, HOUR_S = 15.0, 3600.0
UNHEATED_C = {BATTERY: -20.0, TANK: -15.0}
_SLOW_TAU_S = {BATTERY: 8.0 * HOUR_S, TANK: 6.0 * HOUR_S}
FREEZING_C = 3.0
"""Hydrazine does not flow below this: a degree over its freezing point."""
CHARGING_C = 0.0
"""The battery takes no charge below this."""


@compiled
def step(m: Memory, dt_s: float) -> None:
    """Relax for `dt_s`, exactly."""
    for k in range(NODES):
        left = math.exp(-dt_s / m[TAU_S + k])
        m[TEMPERATURE_C + k] = m[EQUILIBRIUM_C + k] + (m[TEMPERATURE_C + k] - m[EQUILIBRIUM_C + k]) * left


class Thermal:
    """The nodes' memory and the heaters of battery and tank, which run by themselves."""

    READINGS: ClassVar[Mapping[str, int]] = {
        "thermal.camera_C": TEMPERATURE_C + CAMERA,
        "thermal.cathode_C": TEMPERATURE_C + CATHODE,
        "thermal.battery_C": TEMPERATURE_C + BATTERY,
        "thermal.tank_C": TEMPERATURE_C + TANK,
    }

    def __init__(self, config: SpacecraftConfig, generator: Generator) -> None:
        self.memory: Memory = np.zeros(SIZE)
        for node, tau_s in _SLOW_TAU_S.items():
            self.memory[TEMPERATURE_C + node] = self.memory[EQUILIBRIUM_C + node] = HEATED_C
            self.memory[TAU_S + node] = tau_s
        self.camera = WarmUp(self, CAMERA, config.camera_warmup_s, generator)
        self.cathode = WarmUp(self, CATHODE, config.engine_start_s, generator)

    def __repr__(self) -> str:
        return f"Thermal({', '.join(f'{t:.1f}' for t in self.memory[:NODES])} C)"

    @property
    def tank_frozen(self) -> bool:
        """Hydrazine does not flow."""
        return bool(self.memory[TEMPERATURE_C + TANK] < FREEZING_C)

    @property
    def battery_cold(self) -> bool:
        """The battery takes no charge."""
        return bool(self.memory[TEMPERATURE_C + BATTERY] < CHARGING_C)

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`battery_unheated`, `tank_unheated`: that heater is off."""
        del parameters
        nodes = {"battery_unheated": BATTERY, "tank_unheated": TANK}
        if mode not in nodes:
            refuse_fault(self, mode)
        self.memory[EQUILIBRIUM_C + nodes[mode]] = UNHEATED_C[nodes[mode]] if active else HEATED_C


class WarmUp:
    """One node that is warmed up on command. A warm-up takes a time within `span_s` (shortest, longest; s)."""

    def __init__(self, thermal: Thermal, node: int, span_s: tuple[float, float], generator: Generator) -> None:
        self._thermal = thermal
        self._node = node
        self._generator = generator
        self._shortest_s, longest_s = span_s
        self._tau_s = 2.0 * longest_s
        self._coldest_C, self._ready_C = _SPANS_C[node]
        growth = math.exp(longest_s / self._tau_s)
        self._heater_C = (self._ready_C * growth - self._coldest_C) / (growth - 1.0)
        warming = (self._heater_C - self._ready_C) * math.exp(self._shortest_s / self._tau_s)
        self._warmest_C = self._heater_C - warming
        self._least_left_s = 0.0
        thermal.memory[TEMPERATURE_C + node] = self.switch_off()

    def __repr__(self) -> str:
        return f"WarmUp({self._thermal.memory[TEMPERATURE_C + self._node]:.1f} of {self._ready_C:.0f} C)"

    def switch_off(self) -> float:
        """Let it cool to what its surroundings are like this time, which is drawn; that equilibrium (degrees C)."""
        m = self._thermal.memory
        m[EQUILIBRIUM_C + self._node] = self._generator.uniform(self._coldest_C, self._warmest_C)
        m[TAU_S + self._node] = self._tau_s
        return float(m[EQUILIBRIUM_C + self._node])

    def switch_on(self) -> None:
        """Heat."""
        self._thermal.memory[EQUILIBRIUM_C + self._node] = self._heater_C
        self._least_left_s = self._shortest_s

    def step(self, dt_s: float, slowness: float) -> bool:
        """Whether it is ready after `dt_s` more; a slow one takes `slowness` times as long. Once ready it stays so."""
        m = self._thermal.memory
        self._least_left_s -= dt_s / slowness
        m[TAU_S + self._node] = self._tau_s * slowness
        if self._least_left_s > 1e-9 or m[TEMPERATURE_C + self._node] < self._ready_C - 1e-9:
            return False
        m[EQUILIBRIUM_C + self._node] = self._ready_C
        return True
