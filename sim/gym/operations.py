"""Flying the mission by telecommand: `Spacecraft-Operations-v0`."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from sim.config import SpacecraftConfig, Target
from sim.dictionary import TELECOMMANDS, Argument, TelemetryValue
from sim.errors import ConfigurationError
from sim.spacecraft import Spacecraft
from sim.views import CAMERAS

EXPOSURE_S = 30.0
"""Every exposure of this environment."""
GOALS = ("image", "image", "image", "thrust", "thrust", "downlink")
"""The kinds of an episode's goals, in the order of the observation."""
_REFUSED, _UNDERVOLTAGE, _ACHIEVED = -0.01, -0.05, 1.0

_STATES: Mapping[str, tuple[str, ...]] = {
    "acs.state": ("slewing", "settled"),
    "ips.state": ("standby", "starting", "ready", "thrusting", "stopping"),
    "micas.state": ("off", "warming", "ready", "exposing"),
    "micas.switch": ("off", "on"),
    "radio.state": ("off", "on", "downlinking"),
    "power.bus": ("nominal", "undervoltage"),
}
_SCALES: Mapping[str, tuple[float, float]] = {
    "acs.error_rad": (0.0, 3.1416),
    "acs.rate_rad_s": (0.0, 0.01),
    "wheels.momentum_Nms": (0.0, 30.0),
    "ips.level": (0.0, 100.0),
    "ips.xenon_kg": (0.0, 100.0),
    "power.margin_W": (-3000.0, 3000.0),
    "battery.soc": (0.0, 1.0),
    "recorder.stored_Mbit": (0.0, 2000.0),
}


@dataclass(frozen=True, slots=True)
class Goal:
    """`amount` of a kind within a window of simulation time, for `weight` of reward.

    `image`: good images of `target`. `thrust`: seconds of thrust while pointing at `target`. `downlink`: megabits.
    """

    kind: str
    target: str
    amount: float
    start_s: float
    end_s: float
    weight: float
    done: float = 0.0

    @property
    def achieved(self) -> bool:
        """All of the amount is there."""
        return self.done >= self.amount


class OperationsEnvironment(gymnasium.Env[NDArray[np.float32], np.int64]):
    """Command the spacecraft so that its goals come true in their windows.

    Action: number of a telecommand of `sim.dictionary` with arguments, as listed by `commands`; 0 sends nothing. Then
    `seconds_per_step` pass. Refused and unanswered commands cost a little, and so does an undervoltage bus.

    Observation (n,), each within 0 to 1: time over horizon, states of the units as one-hot groups, the target pointed
    at as one-hot, scaled telemetry, and for each of six goals its share done, whether its window is open, time to its
    start and end over the horizon, and its target as one-hot.

    Reward: for each goal its weight in proportion to the progress made inside its window, and 1 more when it is
    achieved. The episode ends when all are, and is cut off at the horizon. Goals, initial states and durations follow
    from the seed of `reset`; `options`: `faults`, a sequence of (name, at_s), injected at the start.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012 - Gymnasium declares it an instance variable

    def __init__(
        self,
        render_mode: str | None = None,
        config: SpacecraftConfig | None = None,
        seconds_per_step: int = 60,
        horizon_s: int = 43_200,
        camera: str = "chase",
    ) -> None:
        """`camera`: whose pictures are rendered, the spacecraft from outside or the science camera's (`micas`)."""
        if camera not in CAMERAS:
            raise ConfigurationError(f"camera: expected one of {', '.join(CAMERAS)}, found {camera!r}")
        if render_mode not in (None, "rgb_array"):
            raise ConfigurationError(f"render_mode: expected rgb_array or None, found {render_mode!r}")
        if seconds_per_step < 1 or horizon_s < seconds_per_step:
            raise ConfigurationError(
                "seconds_per_step, horizon_s: expected 1 or more, and a horizon not shorter, "
                f"found {seconds_per_step}, {horizon_s}"
            )
        self.render_mode = render_mode
        self._camera = camera
        self._config = config or SpacecraftConfig(camera_frames=False)
        self._seconds = seconds_per_step
        self._horizon_s = horizon_s
        self._names = tuple(target.name for target in self._config.targets)
        self.commands = command_table(self._config.targets)
        self._craft: Spacecraft | None = None
        self._telemetry: Mapping[str, TelemetryValue] = {}
        self._exposed = ""
        self.goals: tuple[Goal, ...] = ()
        self.action_space = spaces.Discrete(len(self.commands))
        groups = sum(map(len, _STATES.values())) + len(self._names)
        size = 1 + groups + len(_SCALES) + len(GOALS) * (4 + len(self._names))
        self.observation_space = spaces.Box(0.0, 1.0, (size,), np.float32)

    def __repr__(self) -> str:
        return f"OperationsEnvironment({self._craft!r})"

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """A new spacecraft with new goals; bitwise the same for the same seed and options."""
        super().reset(seed=seed)
        chosen = options or {}
        if unknown := sorted(set(chosen) - {"faults"}):
            raise ConfigurationError(f"reset options: expected faults, found {', '.join(unknown)}")
        self.close()
        self._craft = Spacecraft(self._config, int(self.np_random.integers(2**31)))
        for name, at_s in chosen.get("faults", ()):
            self._craft.inject(name, at_s)
        self.goals = tuple(self._draw(kind) for kind in GOALS)
        self._exposed = ""
        self._telemetry = self._craft.telemetry()
        return self._observe(), self._info(True)

    def step(self, action: np.int64) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Send the command and let `seconds_per_step` pass."""
        craft = self._flying()
        if not self.action_space.contains(np.int64(action)):
            raise ConfigurationError(f"action: expected 0 to {len(self.commands) - 1}, found {action}")
        accepted, reward = True, 0.0
        command = self.commands[int(action)]
        if command is not None:
            name, arguments = command
            answer = craft.send(name, arguments)
            accepted = answer is not None and answer.accepted
            reward += 0.0 if accepted else _REFUSED
            if accepted and name == "micas.expose":
                self._exposed = str(arguments["target"])
        before = self._telemetry
        craft.advance(min(craft.time + self._seconds, self._horizon_s))
        self._telemetry = craft.telemetry()
        reward += self._pursue(before)
        if self._telemetry["power.bus"] == "undervoltage":
            reward += _UNDERVOLTAGE
        done = all(goal.achieved for goal in self.goals)
        return self._observe(), reward, done, not done and craft.time >= self._horizon_s, self._info(accepted)

    def render(self) -> NDArray[np.uint8] | None:
        """What `camera` sees (256, 256, 3); None without a render mode. `chase` without GL: `RenderingUnavailable`."""
        return None if self.render_mode is None else self._flying().render(self._camera, 256, 256)

    def close(self) -> None:
        """Give back what the pictures hold."""
        if self._craft is not None:
            self._craft.close()

    def _flying(self) -> Spacecraft:
        if self._craft is None:
            raise ConfigurationError("Spacecraft-Operations-v0: expected a reset before the first step or picture")
        return self._craft

    def _draw(self, kind: str) -> Goal:
        generator, horizon = self.np_random, self._horizon_s
        start_s = float(generator.integers(0, horizon // 2))
        end_s = float(min(horizon, start_s + horizon / 4 + generator.integers(0, horizon // 4)))
        wanted = {"image": "asteroid", "thrust": "thrust", "downlink": "earth"}[kind]
        names = [target.name for target in self._config.targets if target.kind == wanted]
        if not names:
            raise ConfigurationError(f"targets: expected one of kind {wanted} for the goals, found none")
        amount = {"image": 2.0, "thrust": float(generator.integers(1200, 5400)), "downlink": 12.6}[kind]
        return Goal(kind, names[int(generator.integers(len(names)))], amount, start_s, end_s, 1.0)

    def _pursue(self, before: Mapping[str, TelemetryValue]) -> float:
        """Credit the step's progress to the goals whose windows are open; the reward for it."""
        now, time_s = self._telemetry, self._flying().time
        images = float(now["micas.images"]) - float(before["micas.images"])
        thrust_s = float(now["ips.thrust_seconds"]) - float(before["ips.thrust_seconds"])
        sent_Mbit = float(now["recorder.downlinked_Mbit"]) - float(before["recorder.downlinked_Mbit"])
        reward, goals = 0.0, []
        for goal in self.goals:
            gain = {
                "image": images if self._exposed == goal.target else 0.0,
                "thrust": thrust_s if now["acs.target"] == goal.target and now["acs.state"] == "settled" else 0.0,
                "downlink": sent_Mbit,
            }[goal.kind]
            if goal.achieved or not goal.start_s <= time_s <= goal.end_s or gain <= 0.0:
                goals.append(goal)
                continue
            new = replace(goal, done=min(goal.amount, goal.done + gain))
            reward += goal.weight * (new.done - goal.done) / goal.amount + (_ACHIEVED if new.achieved else 0.0)
            goals.append(new)
        self.goals = tuple(goals)
        return reward

    def _observe(self) -> NDArray[np.float32]:
        telemetry, time_s, horizon = self._telemetry, self._flying().time, self._horizon_s
        values = [time_s / horizon]
        for channel, states in _STATES.items():
            values += [float(telemetry[channel] == state) for state in states]
        values += [float(telemetry["acs.target"] == name) for name in self._names]
        values += [(float(telemetry[name]) - low) / (high - low) for name, (low, high) in _SCALES.items()]
        for goal in self.goals:
            opened = goal.start_s <= time_s <= goal.end_s
            values += [goal.done / goal.amount, float(opened)]
            values += [max(0.0, goal.start_s - time_s) / horizon, max(0.0, goal.end_s - time_s) / horizon]
            values += [float(goal.target == name) for name in self._names]
        return np.clip(np.array(values, dtype=np.float32), 0.0, 1.0)

    def _info(self, accepted: bool) -> dict[str, Any]:
        achieved = sum(goal.achieved for goal in self.goals)
        return {"time_s": self._flying().time, "accepted": accepted, "goals_achieved": achieved}


Command = tuple[str, Mapping[str, TelemetryValue]]


def command_table(targets: tuple[Target, ...]) -> tuple[Command | None, ...]:
    """Nothing, then every telecommand of the dictionary with every combination of arguments, in the table's order."""
    table: list[Command | None] = [None]
    for command in TELECOMMANDS.values():
        choices = [_choices(command.name, argument, targets) for argument in command.arguments]
        names = [argument.name for argument in command.arguments]
        table += [(command.name, dict(zip(names, values, strict=True))) for values in itertools.product(*choices)]
    return tuple(table)


def _choices(command: str, argument: Argument, targets: tuple[Target, ...]) -> tuple[TelemetryValue, ...]:
    if argument.choices:
        return argument.choices
    if argument.name == "target":
        return tuple(t.name for t in targets if command != "micas.expose" or t.kind == "asteroid")
    if argument.name == "seconds":
        return (EXPOSURE_S,)
    if argument.type == "bool":
        return (False, True)
    raise ConfigurationError(f"{command}.{argument.name}: expected choices to make actions of, found none")
