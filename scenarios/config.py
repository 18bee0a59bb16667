"""Scenario files: TOML, validated; unknown keys are errors, and every complaint names the file and the field."""

from __future__ import annotations

import datetime
import re
import tomllib
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from planner.errors import PlanFormatError, nearest
from planner.plan import FlexiblePlan
from planner.problem import Goal, TokenPattern
from scenarios.errors import ScenarioError
from scenarios.hardware import hardware_of
from scenarios.times import seconds_of
from sim import FAULTS, ConfigurationError, FaultRate, SpacecraftConfig
from sim.faults import FaultSchedule

LONGEST_S = 366 * 86_400
"""The longest horizon: far beyond any run that is flown second by second, far below what the planner can count."""
Seconds = Annotated[int, BeforeValidator(seconds_of), Field(ge=0, le=LONGEST_S)]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Scalar = str | int | float | bool
_EPOCH_YEARS = (1950, 2200)


def _instant(value: object) -> datetime.datetime:
    """A date and time of TOML; without an offset it is UTC."""
    if not isinstance(value, datetime.datetime):
        raise ValueError("expected a date and time such as 1999-05-19T00:00:00Z")
    instant = value if value.tzinfo is not None else value.replace(tzinfo=datetime.UTC)
    first, last = _EPOCH_YEARS
    if not first <= instant.year < last:
        raise ValueError(f"expected a year from {first} to {last - 1}")
    return instant


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


class GoalSection(_Section):
    """A goal: a token inside `window` (start, end; seconds or 3h20m) that lasts at least `lasting`."""

    id: str = Field(min_length=1)
    predicate: str
    parameters: dict[str, Scalar | tuple[Scalar, ...]] = {}
    window: tuple[Seconds, Seconds]
    lasting: Seconds | None = None
    priority: Annotated[int, Field(strict=True, ge=-1000, le=1000)] = 0

    @model_validator(mode="after")
    def _times_fit(self) -> GoalSection:
        start, end = self.window
        if start >= end:
            raise ValueError(f"window: expected a start before the end, found {[start, end]}")
        if self.lasting is not None and self.lasting > end - start:
            raise ValueError(f"lasting: expected at most the window's {end - start} s, found {self.lasting} s")
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
    parameters: dict[str, Number] = {}

    @model_validator(mode="after")
    def _is_known(self) -> FaultSection:
        if self.name not in FAULTS:
            raise ValueError(f"name: there is no fault named {self.name!r}{nearest(self.name, FAULTS)}")
        try:
            FaultSchedule({}).add(self.name, self.at, self.until, self.parameters)
        except ConfigurationError as error:
            raise ValueError(str(error)) from error
        return self


class FaultRateSection(_Section):
    """A fault that comes by chance: mean time between, ranges of its parameters and of how long it lasts."""

    name: str
    mean_between: Seconds = Field(gt=0)
    parameters: dict[str, tuple[Number, Number]] = {}
    lasting: tuple[Seconds, Seconds] | None = None

    @model_validator(mode="after")
    def _is_known(self) -> FaultRateSection:
        if self.name not in FAULTS:
            raise ValueError(f"name: there is no fault named {self.name!r}{nearest(self.name, FAULTS)}")
        try:
            self.rate()
        except ConfigurationError as error:
            raise ValueError(str(error)) from error
        return self

    def rate(self) -> FaultRate:
        """The rate as the simulator draws from it."""
        return FaultRate(self.name, self.mean_between, self.parameters, self.lasting)


class ExpectSection(_Section):
    """What the scenario promises at the least, without faults and with its own.

    `replans`: how often its own faults force another plan, at most. `recoveries`: how many of them are recovered from,
    or worked around, in the same plan, at least. `achieved`: goals that are reached in spite of its own faults.
    """

    nominal: Literal["completed", "degraded"] = "completed"
    faulted: Literal["completed", "degraded", "standby"] = "degraded"
    replans: Annotated[int, Field(strict=True, ge=0)] | None = None
    recoveries: Annotated[int, Field(strict=True, ge=0)] = 0
    achieved: tuple[str, ...] = ()


class ExecutiveSection(_Section):
    """The executive's own software. `hang_bug`: with the missed signal of 18 May 1999 between it and the bus, or with
    the same two tasks mended; without it nothing is between them.
    """

    hang_bug: bool | None = None


class Scenario(_Section):
    """A scenario file. `horizon`: its length. `deliberation`: what a plan costs in simulation time.

    `waypoints`: where one plan ends and the next begins. `plan`: made on the ground and sent up; then no planner is
    aboard. `fault_rates`: faults that come by chance, besides
    those of the file.
    """

    name: str = Field(min_length=1)
    summary: str
    domain: Literal["ds1"] = "ds1"
    epoch: Annotated[datetime.datetime, BeforeValidator(_instant)] = datetime.datetime(1999, 5, 19, tzinfo=datetime.UTC)
    horizon: Seconds = Field(gt=0)
    deliberation: Seconds = Field(default=685, gt=0)
    expect: ExpectSection = ExpectSection()
    executive: ExecutiveSection = ExecutiveSection()
    spacecraft: dict[str, Any] = {}
    waypoints: tuple[Seconds, ...] = ()
    plan: FlexiblePlan | None = None
    goals: tuple[GoalSection, ...] = ()
    faults: tuple[FaultSection, ...] = ()
    fault_rates: tuple[FaultRateSection, ...] = ()

    @model_validator(mode="after")
    def _is_whole(self) -> Scenario:
        ids = [goal.id for goal in self.goals]
        for number, goal in enumerate(self.goals):
            if ids.index(goal.id) < number:
                raise ValueError(f"goals[{number}].id: {goal.id!r} is already the id of goals[{ids.index(goal.id)}]")
            if goal.window[0] >= self.horizon:
                raise ValueError(
                    f"goals[{number}].window: expected a start before the horizon's end at {self.horizon} s, "
                    f"found {goal.window[0]} s"
                )
        for number, fault in enumerate(self.faults):
            if fault.at >= self.horizon:
                raise ValueError(
                    f"faults[{number}].at: expected less than the horizon of {self.horizon} s, found {fault.at} s"
                )
        for number, waypoint in enumerate(self.waypoints):
            before = self.waypoints[number - 1] if number else 0
            if not before < waypoint < self.horizon:
                raise ValueError(
                    f"waypoints[{number}]: expected ascending times before the horizon's end at {self.horizon} s, "
                    f"found {waypoint} s"
                )
        for name in self.expect.achieved:
            if name not in ids:
                raise ValueError(f"expect.achieved: there is no goal {name!r}{nearest(name, ids)}")
        self.spacecraft_config()
        return self

    def spacecraft_config(self) -> SpacecraftConfig:
        """The hardware's configuration: its defaults with the scenario's changes; ValueError names a wrong field."""
        return hardware_of(self.spacecraft)


def built_in() -> dict[str, Traversable]:
    """The scenario files that come with the project, by name."""
    folder = files("scenarios")
    return {
        p.name.removesuffix(".toml"): p
        for p in sorted(folder.iterdir(), key=lambda p: p.name)
        if p.name.endswith(".toml")
    }


def template_text() -> str:
    """A scenario to start one's own from, which says what every key means."""
    return (files("scenarios") / "examples" / "template.toml").read_text(encoding="utf-8")


def load(name_or_path: str) -> Scenario:
    """A built-in scenario by name, or one from a `.toml` file; ScenarioError says where it is wrong."""
    if name_or_path.endswith(".toml"):
        return _read(Path(name_or_path), name_or_path)
    known = built_in()
    if name_or_path not in known:
        hint = nearest(name_or_path, known) or f"; there are {', '.join(known)}, or give a .toml file"
        raise ScenarioError(f"there is no scenario named {name_or_path!r}{hint}")
    return _read(known[name_or_path], known[name_or_path].name)


def _read(file: Path | Traversable, where: str) -> Scenario:
    try:
        return parse(file.read_text(encoding="utf-8"), where, Path(str(file)).parent)
    except OSError as error:
        raise ScenarioError(f"{where}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ScenarioError(f"{where}: not UTF-8 text at byte {error.start}") from error


def parse(text: str, where: str, folder: Path = Path()) -> Scenario:
    """The scenario of a TOML text, every goal checked against the model; ScenarioError lists every wrong field.

    `folder`: where a plan's file is looked for.
    """
    from scenarios.goals import check_goals

    try:
        content = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # the second: lists in lists in lists
        raise ScenarioError(f"{where}: not TOML: {error}") from error
    if isinstance(content.get("plan"), str):
        content["plan"] = _given_plan(folder / content["plan"], where)
    try:
        scenario = Scenario.model_validate(content)
    except ValidationError as error:
        raise ScenarioError("\n".join(f"{where}: {_complaint(e)}" for e in error.errors())) from error
    check_goals(scenario, where)
    return scenario


def _given_plan(file: Path, where: str) -> FlexiblePlan:
    try:
        return FlexiblePlan.load(file)
    except PlanFormatError as error:
        raise ScenarioError(f"{where}: plan: {error}") from error


def _complaint(error: Any) -> str:
    place = ".".join(f"[{p}]" if isinstance(p, int) else str(p) for p in error["loc"]).replace(".[", "[")
    if error["type"] == "value_error":
        text = error["msg"].removeprefix("Value error, ")
        dot = "." if re.match(r"[\w\[\].]+: ", text) else ": "
        return f"{place}{dot}{text}" if place else text
    if error["type"] == "extra_forbidden":
        return f"{place}: unknown key"
    found = "" if error["type"] == "missing" else f", found {error['input']!r:.80}"
    return f"{place}: {error['msg'][:1].lower()}{error['msg'][1:]}{found}"
