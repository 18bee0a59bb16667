"""A scenario end to end: planner, executive and spacecraft on one clock, and a run folder that tells what happened."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from executive.executive import Executive
from executive.journal import Journal
from executive.network import PlanNetwork
from executive.records import Settings
from planner.plan import FlexiblePlan
from planner.planning import plan
from planner.problem import PlanningResult, Problem
from planner.search.chronological import Limits
from planner.temporal.controllability import check
from scenarios.bridge import SpacecraftPlant
from scenarios.config import FaultSection, Scenario
from scenarios.ds1.bindings import BINDINGS
from scenarios.ds1.capability import capability_of
from scenarios.ds1.domain import build_model
from scenarios.flight_rules import RuleWatch
from scenarios.folder import JOURNAL, PLANS, RECORDING, SUMMARY, OverheardStream
from scenarios.observer import Observer
from scenarios.summary import summarize
from sim import Spacecraft

PLANNING_LIMITS = Limits(max_steps=20_000, max_seconds=20.0)


@dataclass(frozen=True, slots=True)
class RunOptions:
    """What a run is given besides its scenario. `images`: render the cameras (needs offscreen OpenGL)."""

    seed: int = 0
    faults: tuple[FaultSection, ...] = ()
    images: bool = True


def run(scenario: Scenario, options: RunOptions, folder: Path, progress: Callable[[int], None]) -> dict[str, Any]:
    """Fly a scenario into an empty run folder; returns the summary that is also written there.

    `progress` is told the simulation second now and then. Whatever ends the run, the folder stays readable.
    """
    return _Run(scenario, options, folder).fly(progress)


class _Run:
    def __init__(self, scenario: Scenario, options: RunOptions, folder: Path) -> None:
        self.scenario = scenario
        self.options = options
        self.folder = folder
        self.started = perf_counter()
        config = scenario.spacecraft_config()
        self.spacecraft = Spacecraft(config, options.seed)
        self.plant = SpacecraftPlant(self.spacecraft, BINDINGS.channels())
        self.model = build_model(capability_of(config))
        self.rules = RuleWatch()
        self.observer = Observer(scenario, self.spacecraft, folder / RECORDING, options.images)
        self.journal_stream = OverheardStream(folder / JOURNAL, self.overhear)
        self.journal = Journal(self.journal_stream)
        self.saved_plans = 0
        self.pending_faults = sorted(options.faults, key=lambda fault: fault.at)
        for fault in options.faults:
            self.spacecraft.inject(fault.name, fault.at, fault.until, fault.parameters)
        settings = Settings(scenario=scenario.name, seed=options.seed, budget=scenario.deliberation)
        goals = [goal.goal() for goal in scenario.goals]
        horizon = (0, scenario.horizon)
        self.executive = Executive(self.plant, BINDINGS, self.think, goals, horizon, self.journal, settings)

    def fly(self, progress: Callable[[int], None]) -> dict[str, Any]:
        try:
            for second in range(self.scenario.horizon + 1):
                self.tell_faults(second)
                self.executive.step()
                self.rules.look(second, self.plant.telemetry)
                self.observer.look(second, self.plant.telemetry)
                if second % 600 == 0:
                    progress(second)
            self.executive.finish()
        finally:
            self.observer.close()
            self.journal_stream.close()
        return self.write_summary()

    def think(self, problem: Problem) -> PlanningResult:
        """The planner as the executive calls it: only dynamically controllable plans are good."""
        return plan(self.model, problem, PLANNING_LIMITS, is_controllable)

    def overhear(self, entry: dict[str, Any]) -> None:
        """What the journal says, told to the recording; a plan is saved when it is adopted."""
        self.observer.event(entry)
        if entry["event"] == "plan.adopted":
            adopted = self.executive.plans[-1]
            adopted.plan.save(self.folder / PLANS / f"{adopted.id}.json")
            self.observer.plan(adopted.id, adopted.plan, adopted.handover)

    def tell_faults(self, second: int) -> None:
        """Journal the scripted faults that begin now, before the executive's own step."""
        while self.pending_faults and self.pending_faults[0].at <= second:
            fault = self.pending_faults.pop(0)
            self.journal.write(second, "fault.injected", {"name": fault.name})

    def write_summary(self) -> dict[str, Any]:
        wall = perf_counter() - self.started
        summary = summarize(
            self.scenario, self.options.seed, self.options.faults, self.executive, self.rules.violations(), wall
        )
        summary["sim"]["physics_steps"] = self.spacecraft.physics_steps
        summary["recording"] = {
            "bytes": (self.folder / RECORDING).stat().st_size,
            "images": self.observer.images,
        }
        (self.folder / SUMMARY).write_text(json.dumps(summary, indent=1) + "\n", encoding="utf-8")
        return summary


def is_controllable(candidate: FlexiblePlan) -> bool:
    """Whether some strategy keeps the plan whatever durations nature chooses."""
    return check(PlanNetwork.of(candidate).stnu).controllable


def faults_of(scenario: Scenario, wanted: Sequence[FaultSection] | None) -> tuple[FaultSection, ...]:
    """The faults of a run: those wanted, or else the scenario's own."""
    return tuple(scenario.faults if wanted is None else wanted)
