"""Solar array, battery, and the bus between them.

The array gives its power at 1 AU over the square of the Sun's distance, times the cosine of the incidence. What the
loads take beyond that comes from the battery. When it is empty the bus is in undervoltage: all loads but the base are
shed until the battery is back at `RECOVERED_SOC`. The base load (avionics, wheels, heaters) is never shed.
"""

from __future__ import annotations

from collections.abc import Mapping

from sim.components.hooks import refuse_fault
from sim.config import SpacecraftConfig

RECOVERED_SOC = 0.05


class Power:
    """Balance of the bus. `array_W` and `load_W` are those of the step before."""

    def __init__(self, config: SpacecraftConfig) -> None:
        self._config = config
        self._capacity_J = config.battery_capacity_Wh * 3600.0
        self._normal_incidence_W = config.array_power_1au_W / config.sun_distance_au**2
        self._array_factor = 1.0
        self.soc = config.battery_initial_soc
        self.array_W = self._normal_incidence_W
        self.load_W = config.base_load_W
        self.undervoltage = False

    def __repr__(self) -> str:
        return f"Power({self.array_W:.0f} W in, {self.load_W:.0f} W out, charge {self.soc:.2f})"

    def observe(self, incidence_cosine: float, switched_load_W: float) -> None:
        """What the array receives and the loads beyond the base draw from now on."""
        self.array_W = self._array_factor * self._normal_incidence_W * max(0.0, incidence_cosine)
        self.load_W = self._config.base_load_W + switched_load_W

    def step(self, dt_s: float) -> None:
        """Charge or discharge for `dt_s` at the present balance."""
        margin_W = self.array_W - self.load_W
        if margin_W >= 0.0:
            charge_W = min(margin_W, self._config.battery_charge_limit_W) * self._config.battery_charge_efficiency
            self.soc = min(1.0, self.soc + charge_W * dt_s / self._capacity_J)
            if self.undervoltage and self.soc >= RECOVERED_SOC:
                self.undervoltage = False
        else:
            self.soc += margin_W * dt_s / self._capacity_J
            if self.soc <= 0.0:
                self.soc = 0.0
                self.undervoltage = True

    def telemetry(self) -> dict[str, float | str]:
        """The balance, the battery and the state of the bus."""
        return {
            "power.array_W": self.array_W,
            "power.load_W": self.load_W,
            "power.margin_W": self.array_W - self.load_W,
            "power.bus": "undervoltage" if self.undervoltage else "nominal",
            "battery.soc": self.soc,
        }

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`array_loss`: the array gives `factor` of its power."""
        if mode != "array_loss":
            refuse_fault(self, mode)
        self._array_factor = parameters["factor"] if active else 1.0
