"""The plan against its problem: horizon, state and facts as they are, goals achieved or admittedly dropped."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from planner.checker.network import told, unbounded
from planner.checker.view import Slot, View, value_of
from planner.checker.violations import Violation
from planner.domains import Domain, Interval
from planner.plan import Bounds, PlanToken
from planner.problem import ANY, Problem, TokenPattern

Matches = dict[str, tuple[PlanToken, TokenPattern]]
"""By token, the pattern of the problem's state or facts that it stands for."""


def check_goals(view: View, problem: Problem, dropped: Collection[str]) -> Iterator[Violation]:
    """Each goal is there, within its pattern and the horizon, unless it is listed as dropped."""
    if view.plan.horizon != problem.horizon:
        text = f"the plan's horizon is {list(view.plan.horizon)}, the problem's {list(problem.horizon)}"
        yield Violation("horizon", text)
    tokens: dict[str, list[PlanToken]] = {}
    for token in view.plan.tokens:
        if token.goal is not None:
            tokens.setdefault(token.goal, []).append(token)
    for goal in problem.goals:
        found = tokens.pop(goal.id, [])
        if len(found) > 1:
            text = f"goal {goal.id} is claimed by {len(found)} tokens"
            yield Violation("goal", text, tuple(t.id for t in found))
        if not found and goal.id not in dropped:
            yield Violation("goal", f"goal {goal.id} ({goal.token.predicate}) is not in the plan")
        for token in found:
            for obstacle in _differences(view, token, goal.token):
                yield Violation("goal", f"{told(token)} is not what goal {goal.id} asks for: {obstacle}", (token.id,))
            slot = view.slot_of(token.id)
            earliest, latest = view.range_of(slot, "start")[0], view.range_of(slot, "end")[1]
            if earliest < problem.horizon[0] or latest > problem.horizon[1]:
                text = f"{told(token)}, for goal {goal.id}, need not lie within the horizon {list(problem.horizon)}"
                yield Violation("goal", text, (token.id,))
    for unknown, found in tokens.items():
        text = f"{', '.join(map(told, found))}: the problem has no goal {unknown}"
        yield Violation("goal", text, tuple(t.id for t in found))


def match_statements(view: View, problem: Problem) -> tuple[Matches, list[Violation]]:
    """The tokens that stand for the problem's state and facts, each for one, and what is missing or made up."""
    values = [t for t in view.plan.tokens if t.allowed is None]
    given = [t for t in values if t.fact or (t.master is None and t.goal is None)]
    patterns = [(p, False) for p in problem.state] + [(p, True) for p in problem.facts]
    fits = [
        [
            n
            for n, token in enumerate(given)
            if token.fact == fact and not _differences(view, token, _placed(p, problem))
        ]
        for p, fact in patterns
    ]
    owner: dict[int, int] = {}
    violations = []
    for number, (pattern, fact) in enumerate(patterns):
        if not _assign(number, fits, owner, set()):
            what = "fact" if fact else "state"
            near = [t for t in given if t.predicate == pattern.predicate and t.fact == fact]
            reasons = [f"{told(t)}: {_differences(view, t, _placed(pattern, problem)) or ['taken']}" for t in near]
            text = f"{what} {pattern.predicate} {dict(pattern.parameters)} of the problem is not in the plan"
            tail = f" ({'; '.join(reasons)})" if reasons else ""
            violations.append(Violation("state", text + tail, tuple(t.id for t in near)))
    for n, token in enumerate(given):
        if n not in owner:
            text = f"{told(token)} is given as true, which the problem does not state"
            violations.append(Violation("state", text, (token.id,)))
    return {given[n].id: (given[n], patterns[number][0]) for n, number in owner.items()}, violations


def _placed(pattern: TokenPattern, problem: Problem) -> TokenPattern:
    """A pattern of the state or facts: without a start of its own it begins with the horizon."""
    if pattern.start != ANY:
        return pattern
    opening = problem.horizon[0]
    return TokenPattern(
        pattern.predicate, pattern.object, pattern.parameters, (opening, opening), pattern.end, pattern.duration
    )


def _assign(number: int, fits: Sequence[Sequence[int]], owner: dict[int, int], tried: set[int]) -> bool:
    """Give a pattern a token of its own, moving others where that helps (an augmenting path)."""
    for n in fits[number]:
        if n not in tried:
            tried.add(n)
            if n not in owner or _assign(owner[n], fits, owner, tried):
                owner[n] = number
                return True
    return False


def _differences(view: View, token: PlanToken, pattern: TokenPattern) -> list[str]:
    """Where a token is not what a pattern allows, in every schedule."""
    found = []
    predicate = view.model.predicate_named(pattern.predicate)
    if token.predicate != predicate.full_name:
        return [f"it is a {token.predicate}, expected {pattern.predicate}"]
    thing = view.model.object_named(token.object)
    cls = pattern.predicate.partition(".")[0]
    if not view.model.is_subclass(thing.cls, cls):
        found.append(f"object {token.object} is no {cls}")
    if pattern.object is not None and token.object != pattern.object:
        found.append(f"object is {token.object}, expected {pattern.object}")
    slot = view.slot_of(token.id)
    for name, allowed in pattern.parameters.items():
        values = allowed if isinstance(allowed, tuple) else (allowed,)
        declared = {p.name: view.model.domain_of(p.type) for p in predicate.parameters}
        if name not in declared or not _among(slot.values[name], values, declared[name]):
            found.append(f"{name} is {token.parameters.get(name)!r}, expected {' or '.join(map(repr, values))}")
    for which, bounds in (("start", pattern.start), ("end", pattern.end), ("duration", pattern.duration)):
        if not _inside(view, slot, which, bounds):
            found.append(f"{which} is not within {list(bounds)} in every schedule")
    return found


def _among(value: Domain, allowed: Sequence[object], declared: Domain) -> bool:
    """Whether a parameter has one of the allowed values; a set of numbers stands for their range, as in planning."""
    if isinstance(declared, Interval):
        numbers = [v for v in allowed if isinstance(v, int | float)]
        return bool(numbers) and min(numbers) <= value.value <= max(numbers)
    return any((one := value_of(declared, v)) is not None and one == value for v in allowed)


def _inside(view: View, slot: Slot, which: str, bounds: Bounds) -> bool:
    if bounds == ANY:
        return True
    lower, upper = unbounded(bounds)
    start, end = view.network.point(slot.id, "start"), view.network.point(slot.id, "end")
    if which == "duration":
        return view.network.within(start, end, lower, upper)
    return view.network.within(0, start if which == "start" else end, lower, upper)
