"""Planning: a model and a problem in, a flexible plan or an explained failure out."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

from planner.constraints.network import Inconsistency, Owner
from planner.database import PlanDatabase
from planner.errors import ModelError, ProblemError, nearest
from planner.extraction import extract
from planner.model.manager import ModelManager
from planner.plan import FlexiblePlan
from planner.problem import DroppedGoal, Goal, PlanningResult, Problem, SearchStatistics
from planner.repair import Complaint, refusal_of
from planner.search.engines import ENGINES, Engine
from planner.search.hints import Hints
from planner.search.outcome import Limits, Outcome, Refusal

Acceptance = Callable[[FlexiblePlan], Complaint | None]
"""Judges a complete plan beyond the model, for example whether it is dynamically controllable: None when it is good."""


_STATED = re.compile(r"\b(?:state|fact) \d+ \(([^()]+)\)")
_SUBGOAL = re.compile(r"/(\w+|\.\.\.)")


@dataclass(slots=True)
class _Attempt:
    plan: FlexiblePlan | None
    reason: str
    decided: bool


def plan(
    model: ModelManager,
    problem: Problem,
    limits: Limits | None = None,
    accept: Acceptance | None = None,
    engine: str = "portfolio",
    hints: Hints | None = None,
) -> PlanningResult:
    """Plan for as many goals as can be achieved together, the higher priority first.

    All goals at once if possible. Otherwise each goal in order of priority is kept if a plan with it and those kept
    before exists, and dropped with the reason if not. `limits` are those of each attempt, `engine` one of
    `planner.search.engines`, `hints` the order in which it tries. ProblemError for a problem that means nothing
    or an engine that there is not, ModelError for a model that is not closed, HintsError for hints for another model.
    """
    if engine not in ENGINES:
        raise ProblemError(f"engine: expected one of {', '.join(ENGINES)}, found {engine!r}{nearest(engine, ENGINES)}")
    return _Planning(model, problem, limits or Limits(), accept, ENGINES[engine], hints).solve()


class _Planning:
    def __init__(
        self,
        model: ModelManager,
        problem: Problem,
        limits: Limits,
        accept: Acceptance | None,
        engine: Engine,
        hints: Hints | None,
    ) -> None:
        self.model = model
        self.hints = None if hints is None else hints.of_model(model)
        self.engine = engine
        self.problem = problem
        self.limits = limits
        self.accept = accept
        self.statistics = SearchStatistics()
        if not model.is_closed:
            raise ModelError(f"model {model.name}: expected to be closed to new objects before planning")
        start, end = problem.horizon
        if start >= end:
            raise ProblemError(f"horizon: expected a start before the end, found [{start} {end}]")
        if len({goal.id for goal in problem.goals}) != len(problem.goals):
            raise ProblemError(f"goals: identifiers repeat in {[goal.id for goal in problem.goals]}")

    def solve(self) -> PlanningResult:
        everything = self.attempt(self.problem.goals)
        if everything.plan is not None:
            return PlanningResult(everything.plan, statistics=self.statistics)
        if not self.problem.goals:
            return PlanningResult(None, reason=everything.reason, statistics=self.statistics)
        best = self.attempt(())
        if best.plan is None:
            reason = f"even without goals: {best.reason}"
            return PlanningResult(None, reason=reason, statistics=self.statistics)
        kept: list[Goal] = []
        dropped: list[DroppedGoal] = []
        for goal in sorted(self.problem.goals, key=lambda g: -g.priority):
            with_it = self.attempt([*kept, goal])
            if with_it.plan is not None:
                kept.append(goal)
                best = with_it
            else:
                dropped.append(self.why_dropped(goal, kept, with_it))
        return PlanningResult(best.plan, tuple(dropped), statistics=self.statistics)

    def why_dropped(self, goal: Goal, kept: Sequence[Goal], failure: _Attempt) -> DroppedGoal:
        alone = self.attempt([goal]) if kept else failure
        if alone.plan is not None:
            beside = ", ".join(g.id for g in kept)
            reason = f"not beside {beside}: {failure.reason}"
            return DroppedGoal(goal.id, "outbid" if failure.decided else "undecided", reason)
        return DroppedGoal(goal.id, "unreachable" if alone.decided else "undecided", alone.reason)

    def attempt(self, goals: Sequence[Goal]) -> _Attempt:
        started = perf_counter()
        database = PlanDatabase(self.model, self.problem.horizon)
        outcome = Outcome()
        accepted: list[FlexiblePlan] = []
        try:
            self.set_up(database, goals)
            outcome = self.engine.search(database, self.limits, self._acceptance(accepted), describe, self.hints)
        except Inconsistency as inconsistency:
            outcome.exhausted = True
            outcome.conflict = 0, describe(database.network.explain(inconsistency))
        before = self.statistics
        self.statistics = replace(
            before,
            steps=before.steps + outcome.steps,
            backtracks=before.backtracks + outcome.backtracks,
            solve_seconds=before.solve_seconds + perf_counter() - started,
        )
        if outcome.complete:
            return _Attempt(accepted[-1], "", True)
        return _Attempt(None, _reason(outcome), outcome.exhausted)

    def set_up(self, database: PlanDatabase, goals: Sequence[Goal]) -> None:
        for number, pattern in enumerate(self.problem.state):
            database.state(pattern, f"state {number + 1} ({pattern.predicate})", "state")
        for number, pattern in enumerate(self.problem.facts):
            database.state(pattern, f"fact {number + 1} ({pattern.predicate})", "fact")
        for number, constraint in enumerate(self.problem.constraints):
            database.confine(constraint, f"constraint {number + 1} ({constraint.attribute})")
        for goal in goals:
            database.state(goal.token, goal.id, "goal")
        database.network.propagate()

    def _acceptance(self, accepted: list[FlexiblePlan]) -> Callable[[PlanDatabase], Refusal | None]:
        def judge(database: PlanDatabase) -> Refusal | None:
            found = extract(database)
            complaint = None if self.accept is None else self.accept(found)
            if complaint is not None:
                return refusal_of(database, complaint)
            accepted.append(found)
            return None

        return judge


def describe(owners: Sequence[Owner]) -> str:
    """An explanation in a line: what cannot all be. What only follows from something named goes without saying."""
    named = list(dict.fromkeys(map(str, owners)))
    roots = [name for name in named if not any(name.endswith(f" of {other}") for other in named)]
    words = ["the horizon" if name == "horizon" else _plain(name) for name in roots][:8]
    words = [word for word in words if not any(word in other for other in words if other != word)]
    if len(words) > 1 and any(": " in word for word in words):  # a clash of resources tells its own story
        words = [word for word in words if word != "the horizon"]
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else "".join(words) or "the given bounds"


def _plain(name: str) -> str:
    """A name without numbers: a stated token by its predicate, a subgoal by what it serves."""
    return _STATED.sub(r"\1 at the start", _SUBGOAL.sub("", name))


def _reason(outcome: Outcome) -> str:
    verdict = "no plan exists" if outcome.exhausted else f"no plan found in {outcome.steps} steps"
    if outcome.refusal is not None:
        return f"{verdict} that is good enough; the latest was refused: {outcome.refusal}"
    return verdict if outcome.conflict is None else f"{verdict}; in conflict: {outcome.conflict[1]}"
