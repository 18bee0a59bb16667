"""The ion propulsion system: start-up, throttle levels, thrust, xenon.

Throttle law: NSTAR's public range (0.5 to 2.3 kW into the power processor, 20 to 92 mN, 1,950 to 3,100 s), linear in
power; Deep Space 1's levels linear in power from level 6 at 500 W to level 90 at 2,100 W. Thrust over specific
impulse times standard gravity is the xenon flow. Start-up (cathode heating included) and shut-down take a time drawn
anew for each.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

import numpy as np
from numpy.random import Generator

from sim.components.hooks import refuse_fault
from sim.components.thermal import WarmUp
from sim.config import SpacecraftConfig
from sim.kernels import Memory, compiled

STANDARD_GRAVITY_M_S2 = 9.80665
BURNING, FLOW_KG_S, SECONDS, USED_KG, LEFT_KG = 0, 1, 2, 3, 4
SIZE = 5
LEVELS = (6, 27, 48, 69, 83, 90)
_POWER_W = (500.0, 2300.0)
_THRUST_N = (0.020, 0.092)
_ISP_S = (1950.0, 3100.0)


@dataclass(frozen=True, slots=True)
class ThrottlePoint:
    """What the engine takes and gives at one level."""

    level: int
    power_W: float
    thrust_N: float
    specific_impulse_s: float

    @property
    def flow_kg_s(self) -> float:
        """Xenon mass flow."""
        return self.thrust_N / (self.specific_impulse_s * STANDARD_GRAVITY_M_S2)


def throttle_point(level: int) -> ThrottlePoint:
    """The throttle law at a level (any number of the scale, the engine itself takes those of `LEVELS`)."""
    power_W = 500.0 + (level - 6) * 1600.0 / 84.0
    share = (power_W - _POWER_W[0]) / (_POWER_W[1] - _POWER_W[0])
    return ThrottlePoint(
        level,
        power_W,
        _THRUST_N[0] + share * (_THRUST_N[1] - _THRUST_N[0]),
        _ISP_S[0] + share * (_ISP_S[1] - _ISP_S[0]),
    )


THROTTLE_TABLE: Mapping[int, ThrottlePoint] = MappingProxyType({level: throttle_point(level) for level in LEVELS})


@compiled
def burn(m: Memory, dt_s: float) -> None:
    """Use xenon for `dt_s`, if thrusting."""
    if m[BURNING] != 0.0:
        m[SECONDS] += dt_s
        m[USED_KG] += m[FLOW_KG_S] * dt_s
        m[LEFT_KG] -= m[FLOW_KG_S] * dt_s
        if m[LEFT_KG] <= 0.0:
            m[USED_KG] += m[LEFT_KG]
            m[LEFT_KG] = 0.0


class IonEngine:
    """States standby, starting, ready, thrusting, stopping. Thrust and power hold for the next `step`.

    The flight loop burns the xenon of a thrusting engine itself; `step` is for it when `busy`.
    """

    READINGS: ClassVar[Mapping[str, int]] = {"ips.xenon_kg": LEFT_KG, "ips.thrust_seconds": SECONDS}

    def __init__(self, config: SpacecraftConfig, generator: Generator, cathode: WarmUp) -> None:
        self._config = config
        self._generator = generator
        self._cathode = cathode
        self._left_s = 0.0
        self._start_blocked = False
        self._after_recycle: ThrottlePoint | None = None
        self._point: ThrottlePoint | None = None
        self._idle_power_W = {
            "standby": 0.0,
            "starting": config.engine_starting_W,
            "ready": config.engine_ready_W,
            "thrusting": 0.0,
            "stopping": config.engine_stopping_W,
        }
        self.state = "standby"
        self.memory: Memory = np.zeros(SIZE)
        self.memory[LEFT_KG] = config.xenon_kg

    def __repr__(self) -> str:
        return f"IonEngine({self.state}, level {self.level})"

    @property
    def busy(self) -> bool:
        """Time changes its state: starting, stopping, or in a recycle that ends by itself."""
        return self.state in ("starting", "stopping") or self._after_recycle is not None

    @property
    def level(self) -> int:
        """Throttle level, 0 when not thrusting."""
        return self._point.level if self._point else 0

    @property
    def thrust_N(self) -> float:
        """Thrust along the body's +Z."""
        return self._point.thrust_N if self._point else 0.0

    @property
    def power_W(self) -> float:
        """Power drawn from the bus."""
        return self._point.power_W if self._point else self._idle_power_W[self.state]

    @property
    def xenon_kg(self) -> float:
        """Xenon left."""
        return float(self.memory[LEFT_KG])

    @property
    def xenon_used_kg(self) -> float:
        """Xenon used."""
        return float(self.memory[USED_KG])

    @property
    def thrust_seconds(self) -> float:
        """Time thrusting since the start."""
        return float(self.memory[SECONDS])

    def start(self) -> str | None:
        """Heat the cathodes and light the discharge: standby -> starting -> ready."""
        if self.state != "standby":
            return f"ips.start needs state standby, found {self.state}"
        self.state = "starting"
        self._cathode.switch_on()
        return None

    def thrust(self, level: int) -> str | None:
        """High voltage on at a throttle level; also changes the level while thrusting."""
        if self.state not in ("ready", "thrusting"):
            return f"ips.thrust needs state ready or thrusting, found {self.state}"
        if self.xenon_kg <= 0.0:
            return "ips.thrust needs xenon, found none left"
        if self._after_recycle is not None:
            self._after_recycle = THROTTLE_TABLE[level]
            return None
        self._feed(THROTTLE_TABLE[level])
        self.state = "thrusting"
        return None

    def idle(self) -> str | None:
        """High voltage off, discharge kept: thrusting -> ready."""
        if self.state != "thrusting" and self._after_recycle is None:
            return f"ips.idle needs state thrusting, found {self.state}"
        self._feed(None)
        self.state = "ready"
        return None

    def stop(self) -> str | None:
        """Shut down from starting, ready or thrusting: -> stopping -> standby."""
        if self.state in ("standby", "stopping"):
            return f"ips.stop needs state starting, ready or thrusting, found {self.state}"
        self._feed(None)
        self._cathode.switch_off()
        self.state = "stopping"
        self._left_s = float(self._generator.uniform(*self._config.engine_stop_s))
        return None

    def trip(self) -> None:
        """The bus gave way: everything off at once."""
        if self.state not in ("standby", "stopping"):
            self._cathode.switch_off()
        self._feed(None)
        self.state = "standby"

    def step(self, dt_s: float) -> None:
        """Let `dt_s` pass in the present state."""
        if self._point is not None:
            burn(self.memory, dt_s)
            self.notice()
        elif self.state == "starting" and not self._start_blocked:
            if self._cathode.step(dt_s, 1.0):
                self.state = "ready"
        elif self._after_recycle is not None:
            self._left_s -= dt_s
            if self._left_s <= 0.0:
                point = self._after_recycle
                self._feed(point)
                self.state = "thrusting"
        elif self.state == "stopping":
            self._left_s -= dt_s
            if self._left_s <= 0.0:
                self.state = "standby"

    def notice(self) -> None:
        """Without xenon the discharge goes out."""
        if self._point is not None and self.memory[LEFT_KG] <= 0.0:
            self.idle()

    def _feed(self, point: ThrottlePoint | None) -> None:
        self._point = point
        self._after_recycle = None
        self.memory[BURNING] = 0.0 if point is None else 1.0
        self.memory[FLOW_KG_S] = 0.0 if point is None else point.flow_kg_s

    def telemetry(self) -> dict[str, float | int | str]:
        """State, what it gives and takes; xenon and time are among the readings."""
        return {
            "ips.state": self.state,
            "ips.level": self.level,
            "ips.thrust_N": self.thrust_N,
            "ips.power_W": self.power_W,
        }

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`start_blocked`: the discharge does not light, starting never ends.

        `recycle`: thrusting breaks off. After `seconds`, if that is not 0, the high voltage comes back by itself, at
        the level that it had or that was commanded meanwhile.
        """
        if mode == "recycle":
            point = self._point
            if active and point is not None:
                self.idle()
                if parameters.get("seconds", 0.0) > 0.0:
                    self._after_recycle, self._left_s = point, parameters["seconds"]
        elif mode == "start_blocked":
            self._start_blocked = active
        else:
            refuse_fault(self, mode)
