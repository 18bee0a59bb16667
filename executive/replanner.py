"""State, unfinished goals and a deliberation budget become a problem, and a plan that may be handed over.

Planning takes time on the simulation clock: the new plan's horizon starts when the budget is over. Only a plan whose
tokens can be executed and that is dynamically controllable comes back; everything else is a failure with its reason.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace

from executive.bindings import Bindings
from executive.conclusions import Conclusions
from executive.errors import JournalError, RecordedError
from executive.inputs import Answer, answer_from_json, answer_to_json
from executive.journal import Journal
from executive.network import PlanNetwork, loose
from executive.records import Settings
from planner.errors import NetworkFormatError
from planner.plan import FlexiblePlan
from planner.problem import Goal, Planner, PlanningResult, Problem, TokenPattern
from planner.temporal.controllability import DispatchableNetwork, check

PLANNING_PRIORITY = 1_000_000
"""Of the goal to plan the next horizon: above any goal of a mission."""


@dataclass(frozen=True, slots=True)
class Request:
    """What a plan is wanted for: from `state` at `handover` to `end` (seconds), asked for `now`.

    `failures`: how many plannings for this have failed in a row before.
    """

    now: int
    handover: int
    end: int
    state: tuple[TokenPattern, ...]
    goals: tuple[Goal, ...]
    failures: int = 0


@dataclass(frozen=True)
class Ready:
    """A plan to be handed over at `handover` if the state is then still `state`.

    `considered`: the goals that were known when it was asked for.
    """

    result: PlanningResult
    network: PlanNetwork
    dispatchable: DispatchableNetwork
    state: tuple[TokenPattern, ...]
    handover: int
    charged: int
    withheld: tuple[str, ...]
    considered: frozenset[str]

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
    """Asks the planner and writes down its answer. What an overrun taught is kept: a longer budget (seconds)."""

    def __init__(
        self, planner: Planner, bindings: Bindings, settings: Settings, conclusions: Conclusions, journal: Journal
    ) -> None:
        self._planner = planner
        self._conclusions = conclusions
        self._bindings = bindings
        self._settings = settings
        self._journal = journal
        self.budget = settings.budget

    def plan(self, request: Request) -> Ready | Failed:
        """Plan from a state for goals. The plan comes `budget` after the request at the latest, or not at all."""
        asked, withheld = self._relaxed(request.goals, request.failures)
        horizon = (request.handover, request.end)
        told = (*self._settings.facts, *self._conclusions.facts)
        facts = tuple(fact for fact in told if _concerns(fact, horizon))
        goals = (*self._planning_goal(request), *asked)
        answer = self._ask(Problem(horizon, request.state, facts, goals), request)
        if isinstance(answer, Failed):
            return answer
        result, charged = answer.result, answer.charged
        known = request.now + charged
        if answer.raised is not None:
            return Failed(f"the planner raised {answer.raised}", known, charged)
        if charged > self.budget:
            return Failed(f"the planner took {charged} s, its budget was {self.budget} s", known, charged)
        if result.plan is None:
            return Failed(result.reason or "the planner found no plan and gave no reason", known, charged)
        judged = self._judge(result.plan, request.handover)
        if isinstance(judged, str):
            return Failed(judged, known, charged)
        considered = frozenset(goal.id for goal in request.goals)
        return Ready(result, *judged, request.state, request.handover, charged, withheld, considered)

    def learn(self, failed: Failed) -> None:
        """A planner that has overrun its budget gets that much the next time."""
        self.budget = max(self.budget, failed.charged)

    def delay(self, failures: int) -> int:
        """How long to wait after that many failures in a row."""
        return int(min(self._settings.retry_delay * 2 ** min(failures - 1, 16), self._settings.longest_delay))

    def _ask(self, problem: Problem, request: Request) -> Answer | Failed:
        """The planner's answer as the journal has it: what is executed is what was written down."""
        raised = None
        try:
            result = self._planner(problem)
        except RecordedError as recorded:
            result, raised = PlanningResult(None), str(recorded)
        except Exception as error:  # whatever the planner does, the executive goes on
            result, raised = PlanningResult(None), f"{type(error).__name__}: {error}"
        charged = self.budget
        if raised is None and self._settings.deliberation is not None:
            charged = self._settings.deliberation(result)
        try:
            content = answer_to_json(Answer(result, raised, charged))
            self._journal.write(request.now, "plan.answered", content)
            answer = answer_from_json(json.loads(json.dumps(content, sort_keys=True)))
        except JournalError as error:
            return Failed(f"the planner's answer cannot be written down: {error}", request.now + charged, charged)
        return replace(answer, result=replace(answer.result, statistics=result.statistics))

    def _planning_goal(self, request: Request) -> tuple[Goal, ...]:
        """In a horizon that ends at a waypoint the next one is planned for; that comes before all else.

        There is to be time for a second try before the waypoint, where the horizon is long enough.
        """
        pattern, end = self._settings.plan_next, request.end
        if pattern is None or end not in self._settings.waypoints:
            return ()
        spacious = end - request.handover >= 3 * self.budget
        return (next_horizon_goal(pattern, end, end - self.budget if spacious else end),)

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


def next_horizon_goal(pattern: TokenPattern, waypoint: int, latest: int) -> Goal:
    """The goal of a plan up to a waypoint that what follows it is planned by `latest` (seconds)."""
    return Goal(f"plan-next-{waypoint}", replace(pattern, end=(None, latest)), PLANNING_PRIORITY)


def _concerns(fact: TokenPattern, horizon: tuple[int, int]) -> bool:
    """Whether a fact may be about the horizon at all: neither over before it nor yet to come after it."""
    over, coming = fact.end[1], fact.start[0]
    return (over is None or over > horizon[0]) and (coming is None or coming < horizon[1])


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
