"""State now, unfinished goals and a deliberation budget become a problem, and a plan that may be handed over.

Planning takes time on the simulation clock: the new plan's horizon starts when the budget is over. Only a plan whose
tokens can be executed and that is dynamically controllable comes back; everything else is a failure with its reason.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from executive.bindings import Bindings
from executive.journal import Journal
from executive.network import PlanNetwork, loose
from executive.records import GoalRecord, GoalStatus, Settings
from planner.errors import NetworkFormatError
from planner.plan import FlexiblePlan
from planner.problem import Goal, Planner, PlanningResult, Problem, TokenPattern
from planner.temporal.controllability import DispatchableNetwork, check


class GoalBook:
    """Where every goal stands. What is achieved or dropped stays so; every change is journalled."""

    def __init__(self, goals: Iterable[Goal], journal: Journal) -> None:
        self._goals = tuple(goals)
        self._journal = journal
        self._records = {goal.id: GoalRecord(goal.id) for goal in self._goals}
        self._last_words: dict[str, str] = {}
        self._failed: dict[str, int] = {}

    @property
    def records(self) -> tuple[GoalRecord, ...]:
        """All goals in the order given."""
        return tuple(self._records.values())

    def unfinished(self) -> tuple[Goal, ...]:
        """The goals neither achieved nor dropped."""
        return tuple(goal for goal in self._goals if self._records[goal.id].status == "open")

    def achieved(self, goal_id: str, now: int) -> None:
        """A token of the goal is over, proven."""
        self._settle(goal_id, "achieved", now, None)

    def dropped(self, goal_id: str, now: int, reason: str) -> None:
        """The planner left it out for good."""
        self._settle(goal_id, "dropped", now, reason)

    def failed(self, goal_id: str, now: int, reason: str, limit: int) -> None:
        """A token that served the goal failed; for the `limit`th time, the goal is not tried again."""
        self._failed[goal_id] = self._failed.get(goal_id, 0) + 1
        if self._failed[goal_id] >= limit:
            self.dropped(goal_id, now, f"unreachable: failed {limit} times, the last time {reason}")

    def left_out(self, goal_id: str, reason: str) -> None:
        """The plan in execution does without it; the next may not. Said if the goal is missed in the end."""
        self._last_words[goal_id] = reason

    def missed(self, now: int) -> None:
        """The run is over: what is open now is missed."""
        for goal in self.unfinished():
            reason = self._last_words.get(goal.id, "not achieved before the end of the run")
            self._settle(goal.id, "missed", now, reason)

    def _settle(self, goal_id: str, status: GoalStatus, now: int, reason: str | None) -> None:
        record = self._records.get(goal_id)
        if record is None or record.status != "open":
            return
        self._records[goal_id] = GoalRecord(goal_id, status, now, reason)
        self._journal.write(now, "goal", {"id": goal_id, "status": status, "reason": reason})


@dataclass(frozen=True)
class Ready:
    """A plan to be handed over at `handover` if the state is then still `state`."""

    result: PlanningResult
    network: PlanNetwork
    dispatchable: DispatchableNetwork
    state: tuple[TokenPattern, ...]
    handover: int
    charged: int
    withheld: tuple[str, ...]

    @property
    def plan(self) -> FlexiblePlan:
        """The plan itself."""
        return self.network.plan


@dataclass(frozen=True, slots=True)
class Failed:
    """No plan; known at `known`, for that reason."""

    reason: str
    known: int
    charged: int


class Replanner:
    """Asks the planner. Holds what earlier failures taught: a longer budget, goals to withhold. Times are seconds."""

    def __init__(self, planner: Planner, bindings: Bindings, settings: Settings, horizon_end: int) -> None:
        self._planner = planner
        self._bindings = bindings
        self._settings = settings
        self._horizon_end = horizon_end
        self.budget = settings.budget

    def is_too_late(self, now: int) -> bool:
        """No plan could be handed over before the end of the horizon."""
        return now + self.budget >= self._horizon_end

    def plan(self, now: int, state: tuple[TokenPattern, ...], goals: tuple[Goal, ...], failures: int) -> Ready | Failed:
        """Plan from that state for those goals. `failures`: how many plannings in a row have failed before."""
        asked, withheld = self._relaxed(goals, failures)
        handover = now + self.budget
        problem = Problem((handover, self._horizon_end), state, self._settings.facts, asked)
        try:
            result = self._planner(problem)
        except Exception as error:  # whatever the planner does, the executive goes on
            return Failed(f"the planner raised {type(error).__name__}: {error}", handover, self.budget)
        charged = self.budget if self._settings.deliberation is None else self._settings.deliberation(result)
        if charged > self.budget:
            reason = f"the planner took {charged} s, its budget was {self.budget} s"
            self.budget = charged
            return Failed(reason, now + charged, charged)
        if result.plan is None:
            return Failed(result.reason or "the planner found no plan and gave no reason", now + charged, charged)
        judged = self._judge(result.plan, handover)
        if isinstance(judged, str):
            return Failed(judged, now + charged, charged)
        network, dispatchable = judged
        return Ready(result, network, dispatchable, state, handover, charged, withheld)

    def delay(self, failures: int) -> int:
        """How long to wait after that many failures in a row."""
        return int(min(self._settings.retry_delay * 2 ** min(failures - 1, 16), self._settings.longest_delay))

    def _relaxed(self, goals: tuple[Goal, ...], failures: int) -> tuple[tuple[Goal, ...], tuple[str, ...]]:
        """The goals to ask for, and those withheld: one level of priority for each failure too many."""
        levels = sorted({goal.priority for goal in goals})
        excess = max(0, failures - self._settings.relax_after + 1)
        withheld = set(levels[:excess])
        kept = tuple(goal for goal in goals if goal.priority not in withheld)
        return kept, tuple(goal.id for goal in goals if goal.priority in withheld)

    def _judge(self, plan: FlexiblePlan, handover: int) -> tuple[PlanNetwork, DispatchableNetwork] | str:
        """The networks of a plan that may be executed, or why it may not."""
        if plan.horizon[0] != handover:
            return f"the plan starts at {plan.horizon[0]} s, the hand-over is at {handover} s"
        if (mismatch := unbound(plan, self._bindings)) is not None:
            return mismatch
        try:
            network = PlanNetwork.of(plan)
        except NetworkFormatError as error:
            return f"the plan is not a network: {error}"
        verdict = check(network.stnu)
        if verdict.network is None:
            return f"the plan is not dynamically controllable: {network.explain(verdict.conflict)}"
        return network, verdict.network


def unbound(plan: FlexiblePlan, bindings: Bindings) -> str | None:
    """Why the bindings cannot execute a plan; None when they can."""
    for token in plan.hosts():
        where = f"token {token.id} {token.predicate}"
        activity = bindings.activity(token.predicate)
        if token.contingent and (activity is None or activity.finish is None):
            return f"{where}: nature decides its duration, but no binding says how its end is seen"
        if activity is not None:
            for name in activity.parameters:
                if name not in token.parameters:
                    return f"{where}: its binding needs the parameter {name!r}, which the token does not have"
    for (token_id,) in loose(plan):
        if plan.token(token_id).contingent:
            return f"token {token_id}: nature decides its duration, but it is on no timeline, so nobody sees its end"
    return None
