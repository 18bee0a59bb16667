"""Scenario files: TOML, validated; unknown keys are errors, and every complaint names the file and the field."""

from __future__ import annotations

import datetime
import tomllib
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from planner.errors import nearest
from planner.problem import Goal, TokenPattern
from scenarios.errors import ScenarioError
from scenarios.times import seconds_of
from sim import FAULTS, ConfigurationError, SpacecraftConfig

Seconds = Annotated[int, BeforeValidator(seconds_of)]
Scalar = str | int | float | bool


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class GoalSection(_Section):
    """A goal: a token inside `window` (start, end; seconds or 3h20m) that lasts at least `lasting`."""

    id: str = Field(min_length=1)
    predicate: str
    parameters: dict[str, Scalar | tuple[Scalar, ...]] = {}
    window: tuple[Seconds, Seconds]
    lasting: Seconds | None = None
    priority: int = 0

    @model_validator(mode="after")
    def _window_in_order(self) -> GoalSection:
        if self.window[0] >= self.window[1]:
            raise ValueError(f"window: expected a start before the end, found {list(self.window)}")
        return self

    def goal(self) -> Goal:
        """The goal as the planner takes it."""
        pattern = TokenPattern(
            self.predicate,
            parameters=dict(self.parameters),
            start=(self.window[0], None),
            end=(None, self.window[1]),
            duration=(self.lasting, None),
        )
        return Goal(self.id, pattern, self.priority)


class FaultSection(_Section):
    """A fault that the scenario injects: its time, when it ends by itself (never, if not given), its parameters."""

    name: str
    at: Seconds
    until: Seconds | None = None
    parameters: dict[str, float] = {}

    @model_validator(mode="after")
    def _is_known(self) -> FaultSection:
        if self.name not in FAULTS:
            raise ValueError(f"name: there is no fault named {self.name!r}{nearest(self.name, FAULTS)}")
        return self


class ExpectSection(_Section):
    """The least outcome that the scenario promises, without faults and with its own."""

    nominal: Literal["completed", "degraded"] = "completed"
    faulted: Literal["completed", "degraded", "standby"] = "degraded"


class Scenario(_Section):
    """A scenario file. `horizon`: its length. `deliberation`: what a plan costs in simulation time."""

    name: str = Field(min_length=1)
    summary: str
    domain: Literal["ds1"] = "ds1"
    epoch: datetime.datetime = datetime.datetime(1999, 5, 19, tzinfo=datetime.UTC)
    horizon: Seconds = Field(gt=0)
    deliberation: Seconds = Field(default=685, gt=0)
    expect: ExpectSection = ExpectSection()
    spacecraft: dict[str, Any] = {}
    goals: tuple[GoalSection, ...] = ()
    faults: tuple[FaultSection, ...] = ()

    @model_validator(mode="after")
    def _is_whole(self) -> Scenario:
        ids = [goal.id for goal in self.goals]
        for goal_id in ids:
            if ids.count(goal_id) > 1:
                raise ValueError(f"goals: two goals have the id {goal_id!r}")
        for fault in self.faults:
            if fault.at >= self.horizon:
                raise ValueError(f"faults: {fault.name} at {fault.at} s lies after the horizon of {self.horizon} s")
        self.spacecraft_config()
        return self

    def spacecraft_config(self) -> SpacecraftConfig:
        """The hardware's configuration: its defaults with the scenario's changes; ValueError names a wrong field."""
        known = SpacecraftConfig.__dataclass_fields__
        for name in self.spacecraft:
            if name not in known or name == "targets":
                raise ValueError(f"spacecraft: there is no field {name!r}{nearest(name, known)}")
        values = {n: tuple(v) if isinstance(v, list) else v for n, v in self.spacecraft.items()}
        try:
            return SpacecraftConfig(**values)
        except (ConfigurationError, TypeError) as error:
            raise ValueError(f"spacecraft: {error}") from error


def built_in() -> dict[str, Traversable]:
    """The scenario files that come with the project, by name."""
    folder = files("scenarios")
    return {p.name.removesuffix(".toml"): p for p in sorted(folder.iterdir(), key=lambda p: p.name) if p.name.endswith(".toml")}


def load(name_or_path: str) -> Scenario:
    """A built-in scenario by name, or one from a `.toml` file; ScenarioError says where it is wrong."""
    if name_or_path.endswith(".toml"):
        path = Path(name_or_path)
        try:
            return parse(path.read_text(encoding="utf-8"), name_or_path)
        except OSError as error:
            raise ScenarioError(f"{name_or_path}: {error.strerror}") from error
        except UnicodeDecodeError as error:
            raise ScenarioError(f"{name_or_path}: not UTF-8 text at byte {error.start}") from error
    known = built_in()
    if name_or_path not in known:
        hint = nearest(name_or_path, known) or f"; there are {', '.join(known)}, or give a .toml file"
        raise ScenarioError(f"there is no scenario named {name_or_path!r}{hint}")
    return parse(known[name_or_path].read_text(encoding="utf-8"), known[name_or_path].name)


def parse(text: str, where: str) -> Scenario:
    """The scenario of a TOML text; ScenarioError lists every wrong field."""
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{where}: {error}") from error
    try:
        return Scenario.model_validate(content)
    except ValidationError as error:
        raise ScenarioError("\n".join(f"{where}: {_complaint(e)}" for e in error.errors())) from error


def _complaint(error: Any) -> str:
    place = ".".join(f"[{p}]" if isinstance(p, int) else str(p) for p in error["loc"]).replace(".[", "[")
    found = "" if error["type"] in ("missing", "value_error", "extra_forbidden") else f", found {error['input']!r}"
    text = "unknown key" if error["type"] == "extra_forbidden" else error["msg"].removeprefix("Value error, ")
    return f"{place}: {text}{found}" if place else f"{text}{found}"
