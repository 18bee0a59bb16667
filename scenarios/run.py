"""A scenario end to end: planner, executive and spacecraft on one clock, and a run folder that tells what happened."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from executive.executive import Executive
from executive.journal import Journal, LineStream
from executive.network import PlanNetwork, conflict_of
from executive.port import Plant, TelemetryValue
from executive.records import AdoptedPlan, Settings
from executive.resume import Continuation, planner_of
from executive.sequencer import Sequencer
from planner.files import write_whole
from planner.plan import FlexiblePlan
from planner.planning import plan
from planner.problem import Planner, PlanningResult, Problem
from planner.search.outcome import Limits
from planner.temporal.controllability import check
from scenarios.bridge import SpacecraftPlant
from scenarios.config import FaultSection, Scenario
from scenarios.ds1.bindings import BINDINGS, PLAN_NEXT
from scenarios.ds1.capability import capability_of
from scenarios.ds1.domain import build_model
from scenarios.ds1.protection import ENDING_COMMANDS
from scenarios.errors import RunBrokenError, ScenarioError
from scenarios.faults import own_faults
from scenarios.flight_rules import RuleWatch
from scenarios.folder import JOURNAL, PLANS, RECORDING, SUMMARY, OverheardStream, kept, new_stream
from scenarios.judging import violations_of
from scenarios.observer import Observer, Unobserved
from scenarios.summary import summarize, unmet
from scenarios.words import Reasons
from sim import Spacecraft

PROGRESS_PERIOD_S = 600
_DOING = {"plan.requested": "planning", "standby.entered": "standby"}
PLANNING_LIMITS = Limits(max_steps=20_000, max_seconds=math.inf)
"""Steps only: what the wall clock says must not change what a seed gives."""


@dataclass(frozen=True, slots=True)
class RunOptions:
    """What a run is given besides its scenario. `images`: record pictures (from outside: with offscreen OpenGL)."""

    seed: int = 0
    faults: tuple[FaultSection, ...] = ()
    images: bool = True


@dataclass(frozen=True, slots=True)
class Listener:
    """Who follows a run. `progress`: told the simulation second and what is going on; `warn`: a line for a person.

    `check`: called every second, and may end the run by raising.
    """

    progress: Callable[[int, str], None] = lambda second, doing: None
    warn: Callable[[str], None] = lambda text: None
    check: Callable[[], None] = lambda: None


def run(scenario: Scenario, options: RunOptions, folder: Path, listener: Listener | None = None) -> dict[str, Any]:
    """Fly a scenario into an empty run folder; returns the summary that is also written there."""
    return Flight(scenario, options).fly(folder, listener or Listener())


class Flight:
    """A scenario ready to fly: all that can be wrong with it has been found, and nothing has been written.

    ModelError or ConfigurationError for hardware that cannot be planned for or faults that cannot be injected.
    """

    def __init__(self, scenario: Scenario, options: RunOptions) -> None:
        self.scenario = scenario
        self.options = options
        self.started = perf_counter()
        config = scenario.spacecraft_config()
        self.spacecraft = Spacecraft(config, options.seed)
        self.plant = SpacecraftPlant(self.spacecraft, BINDINGS.channels())
        self.port: Plant = self.plant
        if (hang_bug := scenario.executive.hang_bug) is not None:
            self.port = Sequencer(self.plant, options.seed, hang_bug, ENDING_COMMANDS)
        self.model = build_model(capability_of(config, scenario.horizon, scenario.deliberation))
        self._check_given_plan()
        self.rules = RuleWatch()
        self.plans: tuple[AdoptedPlan, ...] = ()
        self.pending_faults = sorted(options.faults, key=lambda fault: fault.at)
        for fault in options.faults:
            self.spacecraft.inject(fault.name, fault.at, fault.until, fault.parameters)

    def fly(self, folder: Path, listener: Listener, resume: bool = False) -> dict[str, Any]:
        """Fly it, once, into an empty run folder. Whatever ends the run, the folder stays readable.

        RunBrokenError when the disk does not take what is written.

        `resume`: the folder holds a run that was broken off. It is flown again from its start, on the answers that its
        journal holds, until the journal ends, and then goes on; ResumeError when it comes out differently.
        """
        summary = self._flown(RunLog(self, folder, listener, resume), listener)
        with kept(folder / SUMMARY):
            write_whole(folder / SUMMARY, json.dumps(summary, indent=1) + "\n")
        return summary

    def fly_unrecorded(self) -> dict[str, Any]:
        """Fly it, once, and leave nothing behind but the summary: no journal, no recording, no plan files."""
        return self._flown(RunLog(self, None, Listener(), False), Listener())

    def _flown(self, log: RunLog, listener: Listener) -> dict[str, Any]:
        try:
            for second in range(self.scenario.horizon + 1):
                self.tell_faults(second, log.journal)
                log.executive.step()
                self.rules.look(second, self.plant.telemetry, self.plant.on_bus)
                log.look(second, self.plant.telemetry)
                listener.check()
                if second % PROGRESS_PERIOD_S == 0:
                    listener.progress(second, log.doing)
            log.executive.finish()
            log.check_caught_up()
        except BaseException:
            with suppress(RunBrokenError):  # what ended the run says more than what closing its files says of it
                log.close()
            raise
        log.close()
        self.plans = log.executive.plans
        return self.summary(log)

    def think(self, problem: Problem) -> PlanningResult:
        """The planner as the executive calls it: only dynamically controllable plans are good.

        With a plan from the ground there is no planner aboard: the plan is there at its own time, and no other.
        """
        given = self.scenario.plan
        if given is not None:
            if given.horizon == problem.horizon:
                return PlanningResult(given)
            return PlanningResult(None, reason="no planner is aboard: the plan came from the ground")
        return plan(self.model, problem, PLANNING_LIMITS, conflict_of)

    def _check_given_plan(self) -> None:
        given = self.scenario.plan
        if given is None:
            return
        where = f"{self.scenario.name}: plan"
        for violation in violations_of(given, self.scenario):
            raise ScenarioError(f"{where}: {violation.kind}: {violation.explanation}")
        if not is_controllable(given):
            raise ScenarioError(f"{where}: it is not dynamically controllable")

    def tell_faults(self, second: int, journal: Journal) -> None:
        """Journal the scripted faults that begin now, before the executive's own step."""
        while self.pending_faults and self.pending_faults[0].at <= second:
            fault = self.pending_faults.pop(0)
            journal.write(second, "fault.injected", {"name": fault.name})

    def summary(self, log: RunLog) -> dict[str, Any]:
        """The content of `summary.json`."""
        wall = perf_counter() - self.started
        summary = summarize(
            self.scenario,
            self.options.seed,
            self.options.faults,
            log.executive,
            self.rules.violations(),
            log.reasons,
            wall,
        )
        options = self.options
        by_itself = bool(options.faults) and options.faults == own_faults(self.scenario, options.seed)
        summary["unmet"] = unmet(summary, self.scenario, by_itself)
        summary["sim"]["physics_steps"] = self.spacecraft.physics_steps
        size = 0 if log.folder is None else (log.folder / RECORDING).stat().st_size
        summary["recording"] = {"bytes": size, "images": log.observer.images}
        return summary


class RunLog:
    """The executive of a flight and what is written down of it: journal, plans, recording. No folder: nothing is."""

    def __init__(self, flight: Flight, folder: Path | None, listener: Listener, resume: bool) -> None:
        scenario, options = flight.scenario, flight.options
        self.folder = folder
        self.place = folder or Path()
        self.listener = listener
        self.reasons = Reasons()
        self.doing = "standby"
        self.observer: Observer | Unobserved = Unobserved(flight.spacecraft)
        if folder is not None:
            with kept(folder / RECORDING, 0):
                self.observer = Observer(scenario, flight.spacecraft, folder / RECORDING, options.images, listener.warn)
        settings = Settings(
            scenario=scenario.name,
            seed=options.seed,
            budget=scenario.deliberation,
            waypoints=scenario.waypoints,
            plan_next=PLAN_NEXT,
        )
        think: Planner = flight.think
        self.continuation = Continuation(folder / JOURNAL) if folder is not None and resume else None
        if self.continuation is not None:
            recorded, settings = planner_of(self.continuation.history, think, settings)
            think = recorded.plan
        self.stream = OverheardStream(self._open(), self.overhear, self.place / JOURNAL)
        self.journal = Journal(self.stream)
        goals = [goal.goal() for goal in scenario.goals]
        horizon = (0, scenario.horizon)
        self.executive = Executive(flight.port, BINDINGS, think, goals, horizon, self.journal, settings)

    def _open(self) -> LineStream:
        if self.folder is None:
            return io.StringIO()
        with kept(self.folder / JOURNAL, 0):
            return self.continuation or new_stream(self.folder / JOURNAL)

    def look(self, second: int, telemetry: Mapping[str, TelemetryValue]) -> None:
        """What the spacecraft tells this second, told to the recording."""
        with kept(self.place / RECORDING, second):
            self.observer.look(second, telemetry)

    def overhear(self, entry: dict[str, Any]) -> None:
        """What the journal says, told to the recording; a plan is saved when it is adopted."""
        self.reasons.tell(entry)
        with kept(self.place / RECORDING, entry["t"]):
            self.observer.event(entry)
        doing = _DOING.get(entry["event"])
        if entry["event"] == "plan.adopted":
            adopted = self.executive.plans[-1]
            doing = f"flying {adopted.id}"
            if self.folder is not None:
                path = self.folder / PLANS / f"{adopted.id}.json"
                with kept(path, entry["t"]):
                    adopted.plan.save(path)
            with kept(self.place / RECORDING, entry["t"]):
                self.observer.plan(adopted.id, adopted.plan, adopted.handover)
        if doing is not None:
            self.doing = doing
            self.listener.progress(entry["t"], doing)

    def check_caught_up(self) -> None:
        """ResumeError when a resumed run did not come to all that its journal says."""
        if self.continuation is not None:
            self.continuation.check_caught_up()

    def close(self) -> None:
        """End the recording and the journal."""
        try:
            with kept(self.place / RECORDING):
                self.observer.close()
        finally:
            self.stream.close()


def is_controllable(candidate: FlexiblePlan) -> bool:
    """Whether some strategy keeps the plan whatever durations nature chooses."""
    return check(PlanNetwork.of(candidate).stnu).controllable
