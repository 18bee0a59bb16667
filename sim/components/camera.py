"""MICAS, the camera: switched on it warms up, then exposes on command; the whole spacecraft aims it.

A frame is good when the target stayed within the pointing limit and the spacecraft within the smear rate all through
the exposure, and the target was found in it (see `sim.navigation`). Good or not, it is read out and goes to the
recorder.
"""

from __future__ import annotations

from collections.abc import Mapping

from numpy.random import Generator

from sim.components.hooks import refuse_fault
from sim.components.thermal import WarmUp
from sim.config import SpacecraftConfig


class Camera:
    """States off, warming, ready, exposing (read-out included). The switch is on or off whatever the bus delivers."""

    def __init__(self, config: SpacecraftConfig, generator: Generator, warm_up: WarmUp) -> None:
        self._config = config
        self._generator = generator
        self._warm_up = warm_up
        self._left_s = 0.0
        self._readout_s = 0.0
        self._good = False
        self._stuck_on = False
        self._warmup_factor = 1.0
        self._powered = True
        self.exposed_s = 0.0
        self.target = ""
        self.switch_on = False
        self.state = "off"
        self.images = 0

    def __repr__(self) -> str:
        return f"Camera({self.state}, {self.images} images)"

    @property
    def power_W(self) -> float:
        """Power drawn from the bus: heaters while warming, electronics otherwise."""
        if self.state == "off":
            return 0.0
        return self._config.camera_warming_W if self.state == "warming" else self._config.camera_on_W

    @property
    def busy(self) -> bool:
        """Time changes something: warming or exposing."""
        return self.state in ("warming", "exposing")

    @property
    def shutter_open(self) -> bool:
        """Light is being collected: pointing counts."""
        return self.state == "exposing" and self._left_s > 0.0

    def power(self, on: bool) -> str | None:
        """Throw the power switch. A switch stuck on takes the command and stays where it is."""
        if not on and self._stuck_on:
            return None
        if on != self.switch_on:
            self.switch_on = on
            self._follow_switch()
        return None

    def expose(self, target: str, seconds: float) -> str | None:
        """Open the shutter for `seconds`, then read out. `target` says of what the frame should be."""
        if self.state != "ready":
            return f"micas.expose needs state ready, found {self.state}"
        if not 0.0 < seconds <= self._config.camera_exposure_limit_s:
            limit = self._config.camera_exposure_limit_s
            return f"micas.expose.seconds: expected more than 0 and at most {limit:g}, found {seconds:g}"
        self.state = "exposing"
        self.target = target
        self._left_s = self.exposed_s = seconds
        self._readout_s = float(self._generator.uniform(*self._config.camera_readout_s))
        self._good = True
        return None

    def supply(self, powered: bool) -> None:
        """The bus delivers or does not; coming back it warms up anew if the switch is on."""
        if powered != self._powered:
            self._powered = powered
            self._follow_switch()

    def watch(self, pointing_error_rad: float, rate_rad_s: float) -> None:
        """What the optics see while the shutter is open."""
        config = self._config
        if pointing_error_rad > config.camera_pointing_error_rad or rate_rad_s > config.camera_smear_rate_rad_s:
            self._good = False

    def step(self, dt_s: float) -> bool | None:
        """Let `dt_s` pass; True or False when a frame has just been read out, good or not, else None."""
        if self.state == "warming":
            if self._warm_up.step(dt_s, self._warmup_factor):
                self.state = "ready"
        elif self.state == "exposing":
            if self._left_s > 0.0:
                self._left_s -= dt_s
            else:
                self._readout_s -= dt_s
                if self._readout_s <= 0.0:
                    self.state = "ready"
                    return self._good
        return None

    def telemetry(self) -> dict[str, float | int | str]:
        """Switch, state, good images so far, power."""
        return {
            "micas.switch": "on" if self.switch_on else "off",
            "micas.state": self.state,
            "micas.images": self.images,
            "micas.power_W": self.power_W,
        }

    def set_fault(self, mode: str, active: bool, parameters: Mapping[str, float]) -> None:
        """`stuck_on`: the switch does not go off any more. `slow_warmup`: warming takes `factor` times as long."""
        if mode == "stuck_on":
            self._stuck_on = active
        elif mode == "slow_warmup":
            self._warmup_factor = parameters["factor"] if active else 1.0
        else:
            refuse_fault(self, mode)

    def _follow_switch(self) -> None:
        if self.switch_on and self._powered:
            self.state = "warming"
            self._warm_up.switch_on()
        else:
            if self.state != "off":
                self._warm_up.switch_off()
            self.state = "off"
            self._left_s = 0.0
