"""Reusable resources against brute force over schedules: never unsound, and a schedule found whenever there is one."""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterator

import pytest

from planner.constraints.standard import STANDARD
from planner.database import PlanDatabase
from planner.errors import ModelError
from planner.language.builder import ModelBuilder
from planner.model.manager import ModelManager
from planner.plan import ORIGIN, Bounds
from planner.planning import plan
from planner.problem import Goal, Problem, TokenPattern
from planner.search.outcome import Limits
from planner.tokens.resources import Clash, Resource

HORIZON = (0, 7)
CAPACITY = 3

Task = tuple[int, int, int, int]
"""Quantity, duration, earliest start, latest end."""


def model(capacity: int | None = CAPACITY) -> ModelManager:
    builder = ModelBuilder("machines", STANDARD)
    builder.object("power", "Reusable", {} if capacity is None else {"capacity": capacity})
    return builder.finish()


def problem(tasks: list[Task]) -> Problem:
    goals = [
        Goal(f"task{n}", TokenPattern("Reusable.uses", None, {"quantity": q}, (early, None), (None, late), (d, d)))
        for n, (q, d, early, late) in enumerate(tasks)
    ]
    return Problem(HORIZON, goals=tuple(goals))


def random_tasks(rng: random.Random) -> list[Task]:
    tasks = []
    for _ in range(rng.randint(2, 4)):
        duration, early = rng.randint(1, 4), rng.randint(0, 3)
        late = min(HORIZON[1], early + duration + rng.randint(0, 4))
        tasks.append((rng.randint(1, 3), duration, early, late))
    return tasks


def schedules(tasks: list[Task]) -> Iterator[tuple[int, ...]]:
    """Every choice of start times in the tasks' windows."""
    yield from itertools.product(*(range(early, late - d + 1) for _, d, early, late in tasks))


def fits(tasks: list[Task], starts: tuple[int, ...]) -> bool:
    return all(
        sum(q for (q, d, *_), s in zip(tasks, starts, strict=True) if s <= tick < s + d) <= CAPACITY
        for tick in range(*HORIZON)
    )


def unsound(seed: int) -> str | None:
    """What is wrong with the plan for random tasks; None when nothing is."""
    tasks = random_tasks(random.Random(seed))
    possible = any(fits(tasks, starts) for starts in schedules(tasks))
    result = plan(model(), problem(tasks), Limits(max_steps=2000))
    assert result.plan is not None
    if result.dropped or not possible:
        return None if possible == (not result.dropped) else f"{tasks}: possible is {possible}, {result.dropped}"
    ids = {t.goal: t.id for t in result.plan.tokens}
    allowed = 0
    for starts in schedules(tasks):
        at = {ORIGIN: 0}
        for n, (start, (_, d, *_)) in enumerate(zip(starts, tasks, strict=True)):
            at[f"{ids[f'task{n}']}.start"], at[f"{ids[f'task{n}']}.end"] = start, start + d
        if all(_within(at[c.to] - at[c.from_], (c.min, c.max)) for c in result.plan.constraints) and all(
            _within(at[f"{t.id}.start"], t.start) and _within(at[f"{t.id}.end"], t.end) for t in result.plan.tokens
        ):
            allowed += 1
            if not fits(tasks, starts):
                return f"{tasks}: the plan allows {starts}"
    return None if allowed else f"{tasks}: the plan has no schedule"


def _within(value: int, bounds: Bounds) -> bool:
    low, high = bounds
    return (low is None or low <= value) and (high is None or value <= high)


def test_every_schedule_of_every_plan_fits() -> None:
    assert [wrong for seed in range(250) if (wrong := unsound(seed))] == []


def test_a_blind_detection_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Resource, "clash", lambda resource: None)
    assert any(unsound(seed) for seed in range(60))


def test_a_clash_found_too_late_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = Resource.clash

    def only_pairs(resource: Resource) -> Clash | None:
        found = whole(resource)
        return found if found is not None and len(found.transactions) == 2 else None

    monkeypatch.setattr(Resource, "clash", only_pairs)
    assert any(unsound(seed) for seed in range(250))


def test_two_that_exceed_the_capacity_are_ordered() -> None:
    result = plan(model(), problem([(2, 3, 0, 7), (2, 3, 0, 7)]))
    assert result.plan is not None
    assert not result.dropped
    first, second = sorted(result.plan.tokens, key=lambda t: t.start[0] or 0)
    assert (f"{first.id}.end", f"{second.id}.start", 0, None) in {
        (c.from_, c.to, c.min, c.max) for c in result.plan.constraints
    }


def test_too_much_for_any_schedule_is_explained() -> None:
    result = plan(model(), problem([(2, 4, 0, 4), (2, 5, 0, 6)]))
    (dropped,) = result.dropped
    assert dropped.kind == "outbid"
    assert "power" in dropped.reason


def test_an_undecided_quantity_is_bounded_by_what_is_left() -> None:
    database = PlanDatabase(model(), HORIZON)
    tokens = [
        database.state(TokenPattern("Reusable.uses", None, {"quantity": 2}, (0, 0), (4, 4)), "certain", "goal"),
        database.state(TokenPattern("Reusable.uses", None, {}, (1, 1), (3, 3)), "free", "goal"),
    ]
    for token in tokens:
        database.tokens.activate(token, "test")
    database.network.propagate()
    assert tokens[1].parameters["quantity"].domain.upper == 1


def test_a_resource_needs_a_capacity() -> None:
    with pytest.raises(ModelError, match=r"a resource needs a value for its member 'capacity'"):
        PlanDatabase(model(None), HORIZON)
