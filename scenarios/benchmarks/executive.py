"""How fast the executive is: the controllability check, a dispatch decision, and the dispatcher's share of a run.

Plans and networks are from fixed seeds. The share is that of all calls of the dispatcher, propagation in them, in the
wall time of the run. Three kinds of runs: as a user has it, which is a scenario through `scenarios.run` with rules,
journal, recording, pictures and planning; with the spacecraft's physics, but nothing recorded and no rule checked; and
with no spacecraft at all, where only the executive's own work is left to compare with.
"""

from __future__ import annotations

import io
import random
import tempfile
import time
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path

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
from scenarios.config import Scenario, load
from scenarios.folder import new_folder
from scenarios.run import RunOptions, run
from sim import Spacecraft, SpacecraftConfig

LANES, TOKENS_A_LANE = 25, 20
# All that happens but the origin, the begun tokens' starts, and the ends of the lanes' last tokens if they go on.
DONE = 2 * LANES * TOKENS_A_LANE - LANES
# With 500 tokens in four hours a spacecraft would be busy: a slew for so many activities.
ACTIVITIES_A_SLEW = 10
WORK_S = (420, 1680)
REPEATS = 5
"""Of so many runs the one with the least share is told, and the median: what else the machine does falls on a few
calls by chance.
"""
HALF_DAYS = 3
"""`opnav-12h` so many times in a row makes one plan of more than 500 tokens."""


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


def run_rows() -> list[dict[str, object]]:
    """The dispatcher's share of runs of a plan of 500 tokens, a row a kind of run."""
    plan, durations = big_plan()
    assert len(plan.tokens) == LANES * TOKENS_A_LANE
    assert check(PlanNetwork.of(plan).stnu).controllable
    rows = [real_run()]
    for name, physics in (("physics, unrecorded", True), ("executive alone", False)):
        runs = []
        for _ in range(REPEATS):
            statistics, wall_s, seconds = flown(plan, durations, physics)
            runs.append((sum(statistics.latencies), wall_s, statistics.timepoints, seconds))
        rows.append(_row(name, len(plan.tokens), runs))
    return rows


def real_run() -> dict[str, object]:
    """A scenario as the command flies it, of which one plan has 500 tokens."""
    scenario = long_opnav()
    with tempfile.TemporaryDirectory() as parent:
        summary = run(scenario, RunOptions(), new_folder(Path(parent, "run"), scenario.name))
    assert summary["outcome"] == "completed"
    dispatch = summary["dispatch"]
    runs = [(dispatch["wall_seconds"], summary["wall_seconds"], dispatch["timepoints"], summary["sim"]["sim_seconds"])]
    return _row("as a user has it", summary["plans"][0]["tokens"], runs)


def long_opnav() -> Scenario:
    """`opnav-12h` without its fault, several times over in one horizon."""
    once = load("opnav-12h")
    goals = [
        goal.model_copy(
            update={
                "id": f"{goal.id}-{number}",
                "window": (goal.window[0] + number * once.horizon, goal.window[1] + number * once.horizon),
            }
        )
        for number in range(HALF_DAYS)
        for goal in once.goals
    ]
    content = once.model_dump(exclude={"goals", "faults"}) | {
        "name": "opnav-long",
        "horizon": HALF_DAYS * once.horizon,
        "goals": [goal.model_dump() for goal in goals],
    }
    return Scenario.model_validate(content)


def _row(name: str, tokens: int, runs: Sequence[tuple[float, float, int, int]]) -> dict[str, object]:
    """`runs`: seconds in the dispatcher and of the run, timepoints, simulated seconds."""
    shares = sorted(100 * spent_s / wall_s for spent_s, wall_s, _, _ in runs)
    spent_s, wall_s, timepoints, seconds = min(runs, key=lambda run: run[0] / run[1])
    return {
        "run": name,
        "tokens": tokens,
        "timepoints": timepoints,
        "simulated_s": seconds,
        "wall_s": round(wall_s, 3),
        "dispatcher_s": round(spent_s, 4),
        "share_percent": round(shares[0], 3),
        "median_share_percent": round(shares[len(shares) // 2], 3),
        "runs": len(runs),
    }


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
        "dispatcher_share_limit_percent": 1,
        "runs_of_500_tokens": run_rows(),
    }
