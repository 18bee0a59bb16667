"""Planning: a model and a problem in, a flexible plan or an explained failure out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

from planner.constraints.network import Inconsistency, Owner
from planner.database import PlanDatabase
from planner.errors import ProblemError
from planner.extraction import extract
from planner.model.manager import ModelManager
from planner.plan import FlexiblePlan
from planner.problem import DroppedGoal, Goal, PlanningResult, Problem, SearchStatistics
from planner.search.chronological import Limits, Outcome, search

Acceptance = Callable[[FlexiblePlan], bool]
"""Judges a complete plan beyond the model, for example whether it is dynamically controllable."""


@dataclass(slots=True)
class _Attempt:
    plan: FlexiblePlan | None
    reason: str
    decided: bool


def plan(
    model: ModelManager, problem: Problem, limits: Limits | None = None, accept: Acceptance | None = None
) -> PlanningResult:
    """Plan for as many goals as can be achieved together, the higher priority first.

    All goals at once if possible. Otherwise each goal in order of priority is kept if a plan with it and those kept
    before exists, and dropped with the reason if not. ProblemError for a problem that means nothing.
    """
    return _Planning(model, problem, limits or Limits(), accept).solve()


class _Planning:
    def __init__(self, model: ModelManager, problem: Problem, limits: Limits, accept: Acceptance | None) -> None:
        self.model = model
        self.problem = problem
        self.limits = limits
        self.accept = accept
        self.statistics = SearchStatistics()
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
            return DroppedGoal(goal.id, "outbid", f"not beside {beside}: {failure.reason}")
        kind = "unreachable" if alone.decided else "undecided"
        return DroppedGoal(goal.id, kind, alone.reason)

    def attempt(self, goals: Sequence[Goal]) -> _Attempt:
        started = perf_counter()
        database = PlanDatabase(self.model, self.problem.horizon)
        outcome = Outcome()
        accepted: list[FlexiblePlan] = []
        try:
            self.set_up(database, goals)
            outcome = search(database, self.limits, self._acceptance(accepted), describe)
        except Inconsistency as inconsistency:
            outcome.exhausted = True
            outcome.conflicts[describe(database.network.explain(inconsistency))] = 1
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
        for goal in goals:
            database.state(goal.token, goal.id, "goal")
        database.network.propagate()

    def _acceptance(self, accepted: list[FlexiblePlan]) -> Callable[[PlanDatabase], bool]:
        def judge(database: PlanDatabase) -> bool:
            found = extract(database)
            if self.accept is not None and not self.accept(found):
                return False
            accepted.append(found)
            return True

        return judge


def describe(owners: Sequence[Owner]) -> str:
    """An explanation in a line: who asked for what cannot be together."""
    named = dict.fromkeys(owner if isinstance(owner, str) else repr(owner) for owner in owners)
    return "; ".join(list(named)[:8]) or "the given bounds"


def _reason(outcome: Outcome) -> str:
    verdict = "no plan exists" if outcome.exhausted else f"no plan found in {outcome.steps} steps"
    if not outcome.conflicts:
        return verdict
    common = max(outcome.conflicts, key=lambda text: outcome.conflicts[text])
    return f"{verdict}; in conflict: {common}"
