"""Pointing with the torques of four reaction wheels: `Spacecraft-Attitude-v0`."""

from __future__ import annotations

import math
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from sim.assembly import load_assembly
from sim.components.wheels import Wheels
from sim.config import SpacecraftConfig
from sim.environment import Environment
from sim.errors import ConfigurationError
from sim.physics import Physics
from sim.quaternion import Quaternion, Vector, about, conjugate, multiply, unit
from sim.rendering import Renderer

RATE_BOUND_RAD_S = 0.05
"""Faster than this counts as tumbling and ends the episode; the scale of the observed rate."""
_FRAME_PIXELS = 256


class AttitudeEnvironment(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """Turn the spacecraft from a random attitude to the one that points the antenna at the Earth, and hold it.

    Action (4,): motor torques of the wheels in shares of the limit, -1 to 1, held for `seconds_per_step`. Wheels at
    their speed limit take no more.

    Observation (11,), each within -1 to 1: error quaternion w, x, y, z (target to body, w not below 0), angular rate in
    body axes over 0.05 rad/s, wheel speeds over their limit. It is the truth, without noise.

    Reward a step: minus the error angle in half turns, minus 0.02 times the mean square of the action; 100 when error
    and rate have stayed under the configuration's settling thresholds for its hold time, which ends the episode; -100
    for tumbling, which ends it too. `options` of `reset`: `angle_rad`, the size of the initial error, instead of a
    random one of up to half a turn.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012 - Gymnasium declares it an instance variable

    def __init__(
        self, render_mode: str | None = None, config: SpacecraftConfig | None = None, seconds_per_step: int = 2
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            raise ConfigurationError(f"render_mode: expected rgb_array or None, found {render_mode!r}")
        if seconds_per_step < 1:
            raise ConfigurationError(f"seconds_per_step: expected at least 1, found {seconds_per_step}")
        self.render_mode = render_mode
        self._config = config or SpacecraftConfig()
        self._seconds = seconds_per_step
        self._assembly = load_assembly(self._config.time_step_s)
        self._sky = Environment(self._config)
        self._target_IB = self._sky.target_attitude_IB(self._sky.earth, 0.0)
        self._renderer: Renderer | None = None
        self._physics: Physics | None = None
        self._wheels = self._new_wheels([0.0] * 4)
        self._held_s = 0
        self._wing_rad = 0.0
        self.action_space = spaces.Box(-1.0, 1.0, (4,), np.float32)
        self.observation_space = spaces.Box(-1.0, 1.0, (11,), np.float32)

    def __repr__(self) -> str:
        return f"AttitudeEnvironment({self._physics!r})"

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """A new episode; bitwise the same for the same seed and options."""
        super().reset(seed=seed)
        chosen = options or {}
        if unknown := sorted(set(chosen) - {"angle_rad"}):
            raise ConfigurationError(f"reset options: expected angle_rad, found {', '.join(unknown)}")
        generator = self.np_random
        x, y, z = generator.standard_normal(3).tolist()
        drawn_rad = float(generator.uniform(0.05, math.pi))
        angle_rad = float(chosen.get("angle_rad", drawn_rad))
        spread = self._config.wheel_initial_speed_rad_s
        speeds = generator.uniform(-spread, spread, 4).tolist()
        attitude_IB = multiply(self._target_IB, about(unit((x, y, z)), angle_rad))
        self._physics = Physics(self._assembly, attitude_IB, speeds)
        self._wing_rad = float(generator.uniform(-math.pi, math.pi))
        self._physics.place_wings(self._wing_rad)
        self._wheels = self._new_wheels(speeds)
        self._held_s = 0
        return self._observe(), self._info()

    def step(self, action: NDArray[np.float32]) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Hold the torques for `seconds_per_step`; an action outside its bounds is cut to them, NaN is refused."""
        physics = self._flying()
        shares = np.clip(np.asarray(action, dtype=np.float64), -1.0, 1.0).tolist()
        if len(shares) != 4 or not math.isfinite(sum(shares)):
            raise ConfigurationError(f"action: expected 4 finite torques, found {action}")
        wanted = [share * self._config.wheel_torque_limit_Nm for share in shares]
        steps = round(1.0 / self._config.time_step_s)
        for _ in range(self._seconds):
            torques = self._wheels.limited(1.0, wanted)
            physics.advance(steps, [*torques, self._wing_rad, self._wing_rad], (0.0, 0.0, 0.0))
            self._wheels.observe(physics.wheel_speeds_rad_s)
            self._held_s = self._held_s + 1 if self._on_target() else 0
        settled = self._held_s >= self._config.settle_hold_s
        tumbling = max(map(abs, physics.rate_B)) > RATE_BOUND_RAD_S
        effort = sum(share * share for share in shares) / 4.0
        reward = -self._error()[1] / math.pi - 0.02 * effort + (100.0 if settled else -100.0 if tumbling else 0.0)
        return self._observe(), reward, settled or tumbling, False, self._info()

    def render(self) -> NDArray[np.uint8] | None:
        """The spacecraft from outside (256, 256, 3); None without a render mode. `RenderingUnavailable` without GL."""
        if self.render_mode is None:
            return None
        pose = self._flying().scratch()
        if self._renderer is None:
            self._renderer = Renderer(self._assembly.model, self._sky)
        return self._renderer.render(pose, _FRAME_PIXELS, _FRAME_PIXELS, time_s=0.0, thrusting=False)

    def close(self) -> None:
        """Give back the renderer."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def _new_wheels(self, speeds: list[float]) -> Wheels:
        config, assembly = self._config, self._assembly
        return Wheels(
            assembly.wheel_axes_B,
            assembly.wheel_inertia_kg_m2,
            config.wheel_torque_limit_Nm,
            config.wheel_speed_limit_rad_s,
            speeds,
        )

    def _flying(self) -> Physics:
        if self._physics is None:
            raise ConfigurationError("Spacecraft-Attitude-v0: expected a reset before the first step or picture")
        return self._physics

    def _error(self) -> tuple[Quaternion, float]:
        w, x, y, z = multiply(conjugate(self._target_IB), self._flying().attitude_IB)
        if w < 0.0:
            w, x, y, z = -w, -x, -y, -z
        return (w, x, y, z), 2.0 * math.atan2(math.sqrt(x * x + y * y + z * z), w)

    def _on_target(self) -> bool:
        rate: Vector = self._flying().rate_B
        slow = math.hypot(*rate) <= self._config.settle_rate_rad_s
        return slow and self._error()[1] <= self._config.settle_error_rad

    def _observe(self) -> NDArray[np.float32]:
        physics = self._flying()
        limit = self._config.wheel_speed_limit_rad_s
        rates = [rate / RATE_BOUND_RAD_S for rate in physics.rate_B]
        speeds = [speed / limit for speed in physics.wheel_speeds_rad_s]
        return np.clip(np.array([*self._error()[0], *rates, *speeds], dtype=np.float32), -1.0, 1.0)

    def _info(self) -> dict[str, Any]:
        return {"error_rad": self._error()[1], "held_s": self._held_s}
