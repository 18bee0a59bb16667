"""The independent judge of a plan against its model and its problem.

It shares no code with the managers and the search that make plans: it has its own temporal network, its own reading of
configuration constraints, its own view of resources.

    view.py, violations.py   the plan beside its model; what can be wrong
    structure.py             names, places, codesignation
    network.py, temporal.py  schedules, bounds, order, what is nature's
    expressions.py, requirements.py, witnesses.py, boundary.py, configuration.py, nature.py   configuration constraints
    steps.py, transactions.py, uses.py   limits over time; what is taken and given
    closure.py, levels.py, resources.py   levels, rates and sums in every schedule
    limits.py                constraint tokens
    statement.py             the problem: horizon, state, facts, goals
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from planner.checker.configuration import check_configurations
from planner.checker.limits import check_limits, check_stated_limits
from planner.checker.nature import declared_duration
from planner.checker.network import PlanNetwork, told
from planner.checker.statement import Matches, check_goals, match_statements
from planner.checker.structure import check_codesignation, check_names, check_places, check_tokens, limits_of, slots_of
from planner.checker.temporal import (
    check_bounds,
    check_consistency,
    check_contingent,
    check_durations,
    check_order,
)
from planner.checker.uses import Choice, check_all_resources
from planner.checker.view import Slot, View, variables_of
from planner.checker.violations import Kind, Violation
from planner.domains import Interval
from planner.model.manager import ModelManager
from planner.plan import FlexiblePlan
from planner.problem import DroppedGoal, Problem

__all__ = ["Kind", "Violation", "check"]


def check(
    plan: FlexiblePlan,
    model: ModelManager,
    problem: Problem | None = None,
    dropped: Iterable[str | DroppedGoal] = (),
) -> tuple[Violation, ...]:
    """Every requirement that a plan breaks; empty when it is valid.

    Without a problem, what the plan gives as state and facts is taken as given. `dropped`: goals that the plan need not
    have. A plan whose structure is unsound is judged no further; neither is one that has no schedule. ModelError when
    the model itself means nothing (a rule that names what is not there).
    """
    if found := [*check_names(plan, model)]:
        return tuple(found)
    if found := [*check_tokens(plan, model)]:
        return tuple(found)
    if found := [*check_places(plan, model)]:
        return tuple(found)
    slots = slots_of(plan, model)
    found = [*check_codesignation(slots)]
    limits = limits_of(plan, model)
    hosts = {token.id: slot.id for slot in slots.values() for token in slot.tokens}
    network = PlanNetwork(plan, hosts | {limit: limit for limit in limits})
    if network.conflict:
        return (*found, *check_consistency(network))
    variables, wrong = variables_of(plan, model)
    found += [Violation("parameter", text) for text in wrong]
    view = View(plan, model, slots, network, limits, variables)
    matches: Matches = {}
    if problem is not None:
        matches, unmatched = match_statements(view, problem)
        names = {goal if isinstance(goal, str) else goal.id for goal in dropped}
        found += [*unmatched, *check_goals(view, problem, names), *check_stated_limits(view, problem)]
    found += [*check_bounds(view), *check_durations(view), *check_order(view), *check_limits(view)]
    found += _check_nature(view, problem, matches)
    uses: list[Choice] = []
    found += [*_check_exogenous(view), *check_configurations(view, uses)]
    # What is used can be told where every rule is satisfied in some way.
    found += check_all_resources(view, [choice for choice in uses if choice.ways])
    return tuple(found)


def _check_nature(view: View, problem: Problem | None, matches: Matches) -> Iterator[Violation]:
    """Contingent tokens, with what the problem states of activities that are under way."""
    goals = {goal.id: goal.token for goal in problem.goals} if problem else {}
    declared: dict[str, tuple[float, float]] = {}
    flags: dict[str, bool] = {}
    for slot in view.slots.values():
        if problem is None and slot.stated:
            # Only the problem knows how long what is under way still takes, and whether that is nature's.
            flags[slot.id] = slot.host.contingent
            continue
        stated = [matches[i][1] for i in slot.ids if i in matches]
        stated += [goals[t.goal] for t in slot.tokens if t.goal in goals and goals[t.goal].contingent is not None]
        overridden = [pattern.contingent for pattern in stated if pattern.contingent is not None]
        flags[slot.id] = overridden[0] if overridden else slot.predicate.contingent
        if flags[slot.id]:
            duration = Interval(*slot.predicate.duration)
            for pattern in stated:
                lower, upper = pattern.duration
                duration = duration.bounded(
                    duration.lower if lower is None else lower, duration.upper if upper is None else upper
                )
            declared[slot.id] = declared_duration(view, slot, duration)
    yield from check_contingent(view, declared, flags)


def _check_exogenous(view: View) -> Iterator[Violation]:
    """What no plan brings about is only where the problem states it."""
    for slot in view.slots.values():
        if slot.predicate.exogenous and not _is_given(slot):
            text = f"{told(slot.host)}: no plan brings about {slot.predicate.full_name}, and nothing states it"
            yield Violation("exogenous", text, slot.ids, (slot.object.name,))


def _is_given(slot: Slot) -> bool:
    return bool(slot.stated) or slot.is_fact
