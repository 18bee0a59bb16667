"""The built-in scenario end to end: what it promises without faults and with its own."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from planner.checker import check
from planner.plan import FlexiblePlan
from planner.problem import Problem
from scenarios.config import load
from scenarios.flight_rules import FLIGHT_RULES
from scenarios.goals import model_of
from scenarios.run import is_controllable
from tests.scenarios.commands import entries_of, remote_agent, small
from tests.scenarios.conftest import Flown

NUMBER = (int, float)
SUMMARY: dict[str, Any] = {
    "scenario": str,
    "seed": int,
    "outcome": str,
    "goals": [{"id": str, "status": str, "time": (int, None), "reason": (str, None)}],
    "plans": [
        {
            "id": str,
            "horizon": [int],
            "tokens": int,
            "timelines": int,
            "constraints": int,
            "steps": int,
            "solve_seconds": NUMBER,
            "deliberation_charged": int,
            "dynamically_controllable": bool,
            "reason": str,
        }
    ],
    "replans": int,
    "faults": [{"name": str, "injected": (int, None), "detected": (int, None), "diagnosis": (str, None)}],
    "dispatch": {
        "timepoints": int,
        "violations": int,
        "latency_us_p50": NUMBER,
        "latency_us_p99": NUMBER,
        "wall_seconds": NUMBER,
    },
    "flight_rules": {"checked": int, "violations": [{"rule": str, "start": int, "end": int}]},
    "sim": {"sim_seconds": int, "wall_seconds": NUMBER, "physics_steps": int, "realtime_factor": NUMBER},
    "recording": {"bytes": int, "images": int},
    "wall_seconds": NUMBER,
}


def conforms(value: Any, shape: Any, where: str = "summary") -> None:
    """Every field of the shape is there, and of its type."""
    if isinstance(shape, dict):
        assert isinstance(value, dict), where
        for name, inner in shape.items():
            assert name in value, f"{where}.{name}"
            conforms(value[name], inner, f"{where}.{name}")
    elif isinstance(shape, list):
        assert isinstance(value, list), where
        for item in value:
            conforms(item, shape[0], f"{where}[]")
    else:
        kinds = tuple(
            type(None) if kind is None else kind for kind in (shape if isinstance(shape, tuple) else (shape,))
        )
        assert isinstance(value, kinds), f"{where}: {value!r}"
        assert bool in kinds or not isinstance(value, bool), where


@pytest.fixture(params=["nominal", "faulted"])
def flown(request: pytest.FixtureRequest) -> Flown:
    """Both runs, for what holds of every run."""
    found = request.getfixturevalue(request.param)
    assert isinstance(found, Flown)
    return found


def plans_of(run: Path) -> list[FlexiblePlan]:
    return [FlexiblePlan.load(path) for path in sorted((run / "plans").iterdir())]


def test_without_faults_one_plan_completes(nominal: Flown) -> None:
    summary = nominal.summary
    assert nominal.answer.status == 0
    assert summary["outcome"] == "completed"
    assert len(summary["plans"]) == 1
    assert summary["replans"] == 0
    assert summary["faults"] == []
    assert summary["dispatch"]["violations"] == 0
    assert {goal["status"] for goal in summary["goals"]} == {"achieved"}
    for goal in load("opnav-12h").goals:
        achieved = next(g["time"] for g in summary["goals"] if g["id"] == goal.id)
        assert goal.window[0] <= achieved <= goal.window[1]


def test_the_stuck_switch_is_noticed_and_planned_around(faulted: Flown) -> None:
    summary = faulted.summary
    assert faulted.answer.status == 0
    assert summary["outcome"] == "degraded"
    assert len(summary["plans"]) == 2
    assert summary["replans"] == 1
    (fault,) = summary["faults"]
    assert fault["name"] == "micas-stuck-on"
    assert fault["injected"] == 4200 < fault["detected"]
    assert fault["diagnosis"] == "micas.switch stuck_on"
    assert fault["response"] == "replan"
    assert summary["plans"][1]["reason"] == "the camera's power switch does not go off"


def test_what_can_still_be_reached_is(faulted: Flown) -> None:
    goals = {goal["id"]: goal for goal in faulted.summary["goals"]}
    lost = goals.pop("thrust-full")
    assert {goal["status"] for goal in goals.values()} == {"achieved"}
    assert lost["status"] == "dropped"
    assert lost["reason"].startswith("unreachable: ")
    for cause in ("power", "Camera.stuckOn", "thrust-full"):
        assert cause in lost["reason"]
    assert "configuration constraint" not in lost["reason"]


def test_the_second_plan_has_the_camera_on_as_a_fact(faulted: Flown) -> None:
    first, second = plans_of(faulted.folder)
    assert not any(token.predicate == "Camera.stuckOn" for token in first.tokens)
    stuck = [t for t in second.hosts() if t.predicate == "Camera.stuckOn"]
    assert len(stuck) == 1
    assert stuck[0].start == (second.horizon[0], second.horizon[0])
    assert not any(t.predicate in ("Camera.off", "Camera.switchedOff") for t in second.tokens)
    levels = {t.parameters["level"] for t in second.tokens if t.predicate == "Engine.thrust"}
    assert levels == {83}


def test_the_summary_has_all_its_fields(flown: Flown) -> None:
    conforms(flown.summary, SUMMARY)
    assert json.loads((flown.folder / "summary.json").read_text()) == flown.summary
    assert flown.summary["sim"]["sim_seconds"] == 43_200
    assert flown.summary["flight_rules"] == {"checked": len(FLIGHT_RULES), "violations": []}
    assert flown.summary["recording"]["images"] == 0
    assert flown.summary["recording"]["bytes"] == (flown.folder / "run.rrd").stat().st_size


def test_the_journal_is_in_order_and_whole(flown: Flown) -> None:
    times = [entry["t"] for entry in flown.entries]
    assert times == sorted(times)
    assert flown.entries[0]["event"] == "run.started"
    assert flown.entries[-1] == {"t": 43_200, "event": "run.finished", "outcome": flown.summary["outcome"]}
    assert len(flown.of("plan.adopted")) == len(flown.summary["plans"])
    assert len(flown.of("timepoint.executed")) == flown.summary["dispatch"]["timepoints"]


def test_plans_are_controllable_and_pass_the_checker(flown: Flown) -> None:
    scenario = load("opnav-12h")
    model = model_of(scenario, "opnav-12h")
    told = [plan["id"] for plan in flown.summary["plans"]]
    assert told == sorted(path.stem for path in (flown.folder / "plans").iterdir())
    for plan, row in zip(plans_of(flown.folder), flown.summary["plans"], strict=True):
        assert is_controllable(plan)
        assert row["dynamically_controllable"]
        assert row["tokens"] == len(plan.tokens)
        assert list(plan.horizon) == row["horizon"]
        assert check(plan, model) == ()
    handovers = [entry["handover"] for entry in flown.of("plan.adopted")]
    assert [plan.horizon[0] for plan in plans_of(flown.folder)] == handovers


def test_the_checker_sees_a_goal_that_is_not_there(nominal: Flown) -> None:
    scenario = load("opnav-12h")
    goals = tuple(goal.goal() for goal in scenario.goals)
    (plan,) = plans_of(nominal.folder)
    without = Problem(plan.horizon, goals=goals[1:])
    found = check(plan, model_of(scenario, "opnav-12h"), without)
    assert any(v.kind == "goal" and goals[0].id in v.explanation for v in found)


def test_what_happens_stays_within_the_bounds_of_its_plan(flown: Flown) -> None:
    plans = {f"plan-{n:02d}": plan for n, plan in enumerate(plans_of(flown.folder), 1)}
    for name, plan in plans.items():
        started = {e["token"]: e["t"] for e in flown.of("token.started") if e["plan"] == name}
        ended = {e["token"]: e["ended"] for e in flown.of("token.finished") if e["plan"] == name}
        assert started
        for token_id, time in started.items():
            assert within(time, plan.token(token_id).start)
        for token_id, time in ended.items():
            token = plan.token(token_id)
            assert within(time, token.end)
            assert within(time - started[token_id], token.duration)


def within(value: int, bounds: tuple[int | None, int | None]) -> bool:
    lower, upper = bounds
    return (lower is None or lower <= value) and (upper is None or value <= upper)


def test_slow_turns_move_what_follows_them(tmp_path: Path) -> None:
    """The same plan with turns at full rate and at 98.5 % of it: other times, all within the plan's bounds."""
    fast, slow = tmp_path / "fast", tmp_path / "slow"
    scenario = small(
        tmp_path,
        ('name = "micas-stuck-on"\nat = "30m"', 'name = "slow-slew"\nat = 0\nparameters = { factor = 0.985 }'),
    )
    assert remote_agent("run", scenario, "--no-images", "--no-faults", "--out", fast).status == 0
    assert remote_agent("run", scenario, "--no-images", "--out", slow).status == 0
    assert (fast / "plans/plan-01.json").read_bytes() == (slow / "plans/plan-01.json").read_bytes()
    (plan,) = plans_of(slow)
    executed = [
        {e["timepoint"]: e["t"] for e in entries_of(run) if e["event"] == "timepoint.executed"} for run in (fast, slow)
    ]
    assert executed[0].keys() == executed[1].keys()
    for times in executed:
        for point, time in times.items():
            token, _, side = point.rpartition(".")
            assert within(time, getattr(plan.token(token), side))
    moved = {point for point in executed[0] if executed[1][point] > executed[0][point]}
    turns = {t.id for t in plan.hosts() if t.predicate == "Attitude.turn"}
    assert {f"{turn}.end" for turn in turns} <= moved
    assert any(point.rpartition(".")[0] not in turns for point in moved)
    assert not any(executed[1][point] < executed[0][point] - 60 for point in executed[0])
