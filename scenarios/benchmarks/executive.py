"""How fast the executive is: the controllability check, a dispatch decision, and the dispatcher's share of a run.

Plans and networks are from fixed seeds. A run is flown with the spacecraft's physics, since that is what its wall time
is spent on; it is also flown without, where only the executive's own work is left to compare with.
"""

from __future__ import annotations

import io
import random
import time
from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from executive.bindings import Activity, Bindings, Finish, Standby
from executive.conditions import Condition
from executive.dispatcher import prepare
from executive.executive import Executive
from executive.journal import Journal
from executive.network import PlanNetwork
from executive.port import Command, Observation, TelemetryValue
from executive.records import DispatchStatistics, Settings
from executive.sends import Confirmation, Send
from planner.plan import FlexiblePlan
from planner.problem import PlanningResult
from planner.temporal.controllability import check
from planner.temporal.stnu import Stnu
from scenarios.benchmarks.draft import Draft
from scenarios.benchmarks.stnu import best_ms, decision_us, lanes, tick_rows
from sim import Spacecraft, SpacecraftConfig

LANES, TOKENS_A_LANE = 25, 20
# All that happens but the origin, the begun tokens' starts, and the ends of the lanes' last tokens if they go on.
DONE = 2 * LANES * TOKENS_A_LANE - LANES
# With 500 tokens in four hours a spacecraft would be busy: a slew for so many activities.
ACTIVITIES_A_SLEW = 10
WORK_S = (420, 1680)
REPEATS = 3
"""Of so many runs the one with the least share counts: what else the machine does falls on a few calls by chance."""


class Workshop:
    """A plant on which every activity lasts as long as was drawn for it; a spacecraft may fly along and slew."""

    def __init__(self, durations: Mapping[str, int], spacecraft: Spacecraft | None) -> None:
        self._durations = durations
        self._spacecraft = spacecraft
        self._ends: dict[int, list[str]] = {}
        self._changes: dict[str, TelemetryValue] = {"safe": True, **{f"busy.{name}": False for name in durations}}
        self._now = self._begun = 0

    def send(self, command: Command) -> None:
        """Begin an activity."""
        name = str(command.arguments["name"])
        self._changes[f"busy.{name}"] = True
        self._ends.setdefault(self._now + self._durations[name], []).append(name)
        self._begun += 1
        if self._spacecraft is not None and self._begun % ACTIVITIES_A_SLEW == 0:
            targets = tuple(self._spacecraft.environment.targets)
            self._spacecraft.send("acs.point", {"target": targets[self._begun // ACTIVITIES_A_SLEW % len(targets)]})

    def advance(self, until: int) -> Observation:
        """One second of everything."""
        if self._spacecraft is not None and until > 0:
            self._spacecraft.advance(until)
            self._spacecraft.telemetry()
        self._now = until
        for name in self._ends.pop(until, ()):
            self._changes[f"busy.{name}"] = False
        changes, self._changes = self._changes, {}
        return Observation(until, changes)


def big_plan(seed: int = 1) -> tuple[FlexiblePlan, dict[str, int]]:
    """A controllable plan of 500 tokens, half of them contingent, with links between lanes; and what nature decides."""
    rng = random.Random(seed)
    draft = Draft((2, 40000))
    durations: dict[str, int] = {}
    rows: list[list[str]] = []
    for lane in range(LANES):
        line, row, first = (f"lane{lane}", "work"), list[str](), None
        for number in range(TOKENS_A_LANE // 2):
            rest = draft.token(line, "Work.rest", master=first)
            first = first or rest
            name = f"w{lane}x{number}"
            least = rng.randint(*WORK_S)
            durations[name] = rng.randint(least, least + 60)
            row.append(draft.token(line, f"Work.{name}", (least, least + 60), contingent=True, master=first))
        rows.append(row)
    for number in range(TOKENS_A_LANE // 2 - 1):
        for before, after in pairwise(rows):
            draft.at(f"{before[number]}.end", f"{after[number + 1]}.start", 0, None, "in order")
            if rng.random() < 0.3:
                draft.at(f"{before[number]}.start", f"{after[number]}.start", -2800, 2800, "close together")
    return draft.plan(), durations


def bindings_of(names: Mapping[str, int]) -> Bindings:
    """One activity a name; it is over when it is not busy any more."""
    safe = Condition("safe", "==", True)
    return Bindings(
        tuple(
            Activity(
                f"Work.{name}",
                contingent=True,
                start=(Send("go", {"name": name}),),
                started=Confirmation((safe,), within=2),
                finish=Finish((Condition(f"busy.{name}", "==", False),)),
            )
            for name in names
        ),
        Standby((), Confirmation((safe,))),
        lambda telemetry, conclusions: (),
    )


def flown(plan: FlexiblePlan, durations: Mapping[str, int], physics: bool) -> tuple[DispatchStatistics, float, int]:
    """The plan executed until its last activity is over: statistics, wall seconds, simulated seconds."""
    spacecraft = Spacecraft(SpacecraftConfig(), 1) if physics else None
    executive = Executive(
        Workshop(durations, spacecraft),
        bindings_of(durations),
        lambda problem: PlanningResult(plan),
        (),
        (0, plan.horizon[1]),
        Journal(io.StringIO()),
        Settings(budget=1),
    )
    begin = time.perf_counter()
    while executive.dispatch.timepoints < DONE and executive.now < plan.horizon[1]:
        executive.run_until(executive.now + 60)
    wall_s = time.perf_counter() - begin
    if spacecraft is not None:
        spacecraft.close()
    assert not executive.dispatch.violations
    assert len(executive.plans) == 1
    return executive.dispatch, wall_s, executive.now


def run_figures() -> dict[str, object]:
    """The dispatcher in a run of 500 tokens, with and without the spacecraft's physics."""
    plan, durations = big_plan()
    assert len(plan.tokens) == LANES * TOKENS_A_LANE
    assert check(PlanNetwork.of(plan).stnu).controllable
    figures: dict[str, object] = {"tokens": len(plan.tokens)}
    for name, physics in (("with_physics", True), ("executive_alone", False)):
        runs = (flown(plan, durations, physics) for _ in range(REPEATS))
        statistics, wall_s, seconds = min(runs, key=lambda run: sum(run[0].latencies) / run[1])
        spent_s = sum(statistics.latencies)
        figures[name] = {
            "simulated_s": seconds,
            "wall_s": round(wall_s, 3),
            "timepoints": statistics.timepoints,
            "dispatcher_s": round(spent_s, 4),
            "dispatcher_share_percent": round(100 * spent_s / wall_s, 3),
        }
    return figures


def measure() -> dict[str, object]:
    """All figures. Times in milliseconds and microseconds, as the names say; networks of 160 and 1000 timepoints."""
    small, large = lanes(161, 80), lanes(1001, 100)
    rows = tick_rows(small)
    check(small)  # compiled code is loaded at the first call
    prepare()
    decisions, events = decision_us(large)
    return {
        "dc_check_ms": best_ms(lambda: check(large), 10),
        "dc_check_limit_ms": 300,
        "estnu_build_and_check_160_ms": best_ms(lambda: check(Stnu.from_ticks(small.timepoints, rows)), 100),
        "estnu_build_and_check_160_limit_ms": 2,
        "decision_us_p50": float(np.percentile(decisions, 50)),
        "decision_us_p99": float(np.percentile(decisions, 99)),
        "decision_limit_us_p99": 1000,
        "event_us_p50": float(np.percentile(events, 50)),
        "event_us_p99": float(np.percentile(events, 99)),
        "run_of_500_tokens": run_figures(),
        "dispatcher_share_limit_percent": 1,
    }
