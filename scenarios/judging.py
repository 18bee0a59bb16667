"""A plan of a run judged against its scenario, independently of the planner."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from executive.replanner import next_horizon_goal
from planner.checker import Violation, check
from planner.constraints.user import registry_with
from planner.language.nddl.builder import load
from planner.plan import FlexiblePlan, PlanToken
from planner.problem import Problem, TokenPattern
from scenarios.config import Scenario
from scenarios.ds1.bindings import PLAN_NEXT
from scenarios.goals import model_of


def violations_of(plan: FlexiblePlan, scenario: Scenario) -> tuple[Violation, ...]:
    """Every requirement that the plan breaks.

    A goal that the plan claims must be what the scenario asks for; a goal that it leaves out is not held against it,
    since plans are made in mid-run too, when goals are already achieved or dropped. The state from which such a plan
    starts is known to the plan alone and taken as given.
    """
    claimed = {token.goal for token in plan.tokens}
    ends = (*scenario.waypoints, scenario.horizon)
    goals = (
        *(goal.goal() for goal in scenario.goals),
        *(next_horizon_goal(PLAN_NEXT, waypoint, waypoint) for waypoint in scenario.waypoints),
    )
    values = [token for token in plan.tokens if token.allowed is None]
    state = tuple(_stated(token) for token in values if token.master is None and token.goal is None)
    end = plan.horizon[1] if plan.horizon[1] in ends else scenario.horizon
    problem = Problem((plan.horizon[0], end), state, goals=goals)
    dropped = [goal.id for goal in goals if goal.id not in claimed]
    return check(plan, model_of(scenario, scenario.name), problem, dropped)


def violations_against(
    plan: FlexiblePlan, model_file: Path, include: Sequence[Path] = (), procedures: Sequence[str] = ()
) -> tuple[Violation, ...]:
    """Every requirement of an NDDL model that the plan breaks; what its problem states is taken from the plan."""
    model, _, _ = load(model_file, registry_with(procedures), include)
    return check(plan, model)


def _stated(token: PlanToken) -> TokenPattern:
    decided = {name: value for name, value in token.parameters.items() if isinstance(value, str | int | float | bool)}
    return TokenPattern(token.predicate, token.object, decided, start=token.start)
