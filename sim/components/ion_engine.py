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

from numpy.random import Generator

from sim.components.hooks import refuse_fault
from sim.config import SpacecraftConfig

STANDARD_GRAVITY_M_S2 = 9.80665
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


class IonEngine:
    """States standby, starting, ready, thrusting, stopping. Thrust and power hold for the next `step`."""

    def __init__(self, config: SpacecraftConfig, generator: Generator) -> None:
        self._config = config
        self._generator = generator
        self._left_s = 0.0
        self._start_blocked = False
        self._point: ThrottlePoint | None = None
        self._idle_power_W = {
            "standby": 0.0,
            "starting": config.engine_starting_W,
            "ready": config.engine_ready_W,
            "thrusting": 0.0,
            "stopping": config.engine_stopping_W,
        }
        self.state = "standby"
        self.xenon_used_kg = 0.0
        self.thrust_seconds = 0.0

    def __repr__(self) -> str:
        return f"IonEngine({self.state}, level {self.level})"

    @property
    def busy(self) -> bool:
        """Time changes something: thrusting, starting or stopping."""
        return self.state not in ("standby", "ready")

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
        return self._config.xenon_kg - self.xenon_used_kg

    def start(self) -> str | None:
        """Heat the cathodes and light the discharge: standby -> starting -> ready."""
        if self.state != "standby":
            return f"ips.start needs state standby, found {self.state}"
        self.state = "starting"
        self._left_s = float(self._generator.uniform(*self._config.engine_start_s))
        return None

    def thrust(self, level: int) -> str | None:
        """High voltage on at a throttle level; also changes the level while thrusting."""
        if self.state not in ("ready", "thrusting"):
            return f"ips.thrust needs state ready or thrusting, found {self.state}"
        if self.xenon_kg <= 0.0:
            return "ips.thrust needs xenon, found none left"
        self._point = THROTTLE_TABLE[level]
        self.state = "thrusting"
        return None

    def idle(self) -> str | None:
        """High voltage off, discharge kept: thrusting -> ready."""
        if self.state != "thrusting":
            return f"ips.idle needs state thrusting, found {self.state}"
        self._point = None
        self.state = "ready"
        return None

    def stop(self) -> str | None:
        """Shut down from starting, ready or thrusting: -> stopping -> standby."""
        if self.state in ("standby", "stopping"):
            return f"ips.stop needs state starting, ready or thrusting, found {self.state}"
        self._point = None
        self.state = "stopping"
        self._left_s = float(self._generator.uniform(*self._config.engine_stop_s))
        return None

    def trip(self) -> None:
        """The bus gave way: everything off at once."""
        self._point = None
        self.state = "standby"

    def step(self, dt_s: float) -> None:
        """Let `dt_s` pass in the present state."""
        if self._point is not None:
            self.thrust_seconds += dt_s
            self.xenon_used_kg += self._point.flow_kg_s * dt_s
            if self.xenon_kg <= 0.0:
                self.xenon_used_kg = self._config.xenon_kg
                self.idle()
        elif self.state == "starting" and not self._start_blocked:
            self._left_s -= dt_s
            if self._left_s <= 0.0:
                self.state = "ready"
        elif self.state == "stopping":
            self._left_s -= dt_s
            if self._left_s <= 0.0:
                self.state = "standby"

    def telemetry(self) -> dict[str, float | int | str]:
        """State, what it gives and takes, and what it has used."""
        return {
            "ips.state": self.state,
            "ips.level": self.level,
            "ips.thrust_N": self.thrust_N,
            "ips.power_W": self.power_W,
            "ips.xenon_kg": self.xenon_kg,
            "ips.thrust_seconds": self.thrust_seconds,
        }

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`start_blocked`: the discharge does not light, starting never ends. `recycle`: thrusting breaks off, once."""
        del parameters
        if mode == "recycle":
            if active and self._point is not None:
                self.idle()
        elif mode == "start_blocked":
            self._start_blocked = active
        else:
            refuse_fault(self, mode)
