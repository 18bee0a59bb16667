"""The power buses and their relays: NEB1, NEB1-S and NEB2, and the switch PASM with the unit behind it.

Behind NEB1 hangs the star tracker, behind NEB1-S the thrusters' drive, behind NEB2 the electronics of ion engine and
camera and PASM, which feeds the terminal LPE. Each relay and PASM report a status, each bus a current: a status sensor
can be wrong while the current and the units behind show that power flows.
"""

from __future__ import annotations

from collections.abc import Mapping

from sim.components.hooks import refuse_fault

BUSES = ("neb1", "neb1s", "neb2")
_VOLTAGE_V = 28.0
# Assumption: what hangs on each bus all the time, watts; part of the base load.
_STANDING_W = {"neb1": 12.0, "neb1s": 10.0, "neb2": 20.0}
LPE_W = 5.0


class Switchboard:
    """Relays closed at the start, PASM off."""

    def __init__(self) -> None:
        self._open: set[str] = set()
        self._false_status: dict[str, str] = {}
        self._switched_W = 0.0
        self.pasm_on = False

    def __repr__(self) -> str:
        return f"Switchboard(open: {', '.join(sorted(self._open)) or 'none'}; PASM {'on' if self.pasm_on else 'off'})"

    def fed(self, bus: str) -> bool:
        """Whether the bus has power."""
        return bus not in self._open

    @property
    def lpe_fed(self) -> bool:
        """Whether the terminal behind PASM has power."""
        return self.pasm_on and self.fed("neb2")

    @property
    def power_W(self) -> float:
        """Drawn beyond the base load."""
        return LPE_W if self.lpe_fed else 0.0

    def power(self, on: bool) -> str | None:
        """Throw PASM."""
        self.pasm_on = on
        return None

    def carry(self, camera_W: float) -> None:
        """What the camera draws from NEB2."""
        self._switched_W = camera_W

    def telemetry(self) -> dict[str, float | str]:
        """What the sensors report."""
        values: dict[str, float | str] = {}
        for bus in BUSES:
            fed = bus not in self._open
            values[f"{bus}.status"] = self._false_status.get(bus) or ("on" if fed else "off")
            load_W = _STANDING_W[bus] + (self._switched_W + self.power_W if bus == "neb2" else 0.0)
            values[f"{bus}.current_A"] = load_W / _VOLTAGE_V if fed else 0.0
        values["pasm.switch"] = self._false_status.get("pasm") or ("on" if self.pasm_on else "off")
        return values

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`open_BUS`: its relay is open. `false_on_X`, `false_off_X`: the status sensor of a bus or PASM says so."""
        del parameters
        kind, _, name = mode.rpartition("_")
        if kind == "open" and name in BUSES:
            (self._open.add if active else self._open.discard)(name)
        elif kind in ("false_on", "false_off") and name in (*BUSES, "pasm"):
            if active:
                self._false_status[name] = kind.removeprefix("false_")
            else:
                self._false_status.pop(name, None)
        else:
            refuse_fault(self, mode)
