"""The judge on resources: exact against every schedule, and a sentence for each way to break them."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import pytest

from planner.checker import Violation, check, levels, resources
from planner.checker.closure import bits, heaviest_closed_set
from planner.constraints.standard import STANDARD
from planner.errors import ModelError
from planner.language.builder import ModelBuilder, RuleBuilder
from planner.model.classes import ModelObject
from planner.model.manager import ModelManager
from planner.plan import Bounds, FlexiblePlan, PlanConstraint, PlanTimeline, PlanToken
from planner.planning import plan as make_plan
from planner.problem import Goal, Problem, TokenPattern
from tests.planner.tokens.resource_cases import HORIZON, Case, empty, keeps, random_case, schedules


def test_the_heaviest_closed_set_is_that_of_all_sets() -> None:
    rng = random.Random(4)
    for _ in range(300):
        size = rng.randint(1, 7)
        weights = [rng.choice([-2.5, -1, 0, 0.5, 1, 3]) for _ in range(size)]
        implied = _transitive([sum(1 << j for j in range(size) if j != i and rng.random() < 0.2) for i in range(size)])
        sets = [{i for i in range(size) if bits >> i & 1} for bits in range(1 << size)]
        closed = [s for s in sets if all(set(bits(implied[i])) <= s for i in s)]
        found = heaviest_closed_set(weights, implied)
        assert found in closed
        assert sum(weights[i] for i in found) == max(sum(weights[i] for i in s) for s in closed)


def _transitive(implied: list[int]) -> list[int]:
    for middle, i in product(range(len(implied)), repeat=2):
        if implied[i] >> middle & 1:
            implied[i] |= implied[middle]
    return [row & ~(1 << i) for i, row in enumerate(implied)]


# Against every schedule.


def plan_of(case: Case) -> FlexiblePlan:
    """A plan that allows just the schedules of a case, whose quantities are decided."""
    tokens = []
    for n, move in enumerate(case.moves):
        start = max(HORIZON[0], move.start[0]), min(HORIZON[1], move.start[1])
        predicate = f"{case.cls}.{move.predicate}"
        values = {"quantity": float(move.quantity[0])}
        ends = (HORIZON[0], HORIZON[1])
        tokens.append(PlanToken(f"t{n}", "thing", "level", predicate, values, start, ends, move.duration, goal=f"g{n}"))
    points = {(n, side): f"t{n}.{'end' if side else 'start'}" for n in range(len(tokens)) for side in (False, True)}
    constraints = tuple(
        PlanConstraint(points[a], points[b], int(least), None if most == math.inf else int(most), "case")
        for a, b, least, most in case.distances
    )
    return FlexiblePlan("case", HORIZON, ("thing",), (), tuple(tokens), constraints)


def disagreement(seed: int) -> str | None:
    """Where the judge and the enumeration of all schedules differ on a random case; None where they agree."""
    case = random_case(random.Random(seed), decided=True)
    if case.cls == "Reservoir" and seed % 5 < 2:
        further = ({"level_max": ((0, 9), (2, 5), (4, 7))}, {"level_max": 20, "production_max": 4})[seed % 5]
        case = replace(case, members={**case.members, **further})
    found = {v.kind for v in check(plan_of(case), empty(case).database.model)} - {"bounds"}
    every = list(schedules(case))
    wrong = "inconsistent" if not every else "" if all(keeps(case, s) for s in every) else "resource"
    expected = {wrong} if wrong else set()
    return None if found == expected else f"{case}: expected {expected}, found {found}"


def test_the_judgement_is_that_of_all_schedules() -> None:
    assert [wrong for seed in range(600) if (wrong := disagreement(seed))] == []


@pytest.mark.parametrize(
    ("owner", "name", "planted"),
    [
        (levels.Levels, "_no_later", lambda _, events: [0] * len(events)),
        (levels.Levels, "_no_later", lambda _, events: [(1 << len(events)) - 1 - (1 << n) for n in range(len(events))]),
        (levels, "_hot_runs", lambda *_: ()),
        (resources._Resource, "_rate", lambda *_: ()),
        (resources._Resource, "_sum", lambda *_: ()),
    ],
)
def test_a_planted_bug_is_seen(
    monkeypatch: pytest.MonkeyPatch, owner: Any, name: str, planted: Callable[..., object]
) -> None:
    monkeypatch.setattr(owner, name, planted)
    assert any(disagreement(seed) for seed in range(700))


# What it says.


def moving(
    cls: str, members: dict[str, Any], moves: list[tuple[str, float, Bounds]], lasting: int = 0, order: bool = False
) -> tuple[Violation, ...]:
    """The judgement on a plan with these (predicate, quantity, start bounds) on one object, in this order or none."""
    model = ModelBuilder("m", STANDARD)
    model.object("store", cls, members)
    tokens = []
    for n, (predicate, quantity, (low, high)) in enumerate(moves):
        assert low is not None
        assert high is not None
        times = (low, high), (low + lasting, high + lasting), (lasting, lasting)
        values = {"quantity": float(quantity)} if predicate != "use" else {}
        tokens.append(PlanToken(f"t{n}", "store", "level", f"{cls}.{predicate}", values, *times, goal=f"g{n}"))
    follow = [PlanConstraint(f"t{n}.start", f"t{n + 1}.start", 0, None, "order") for n in range(len(moves) - 1)]
    plan = FlexiblePlan("m", (0, 100), ("store",), (), tuple(tokens), tuple(follow) if order else ())
    return check(plan, model.finish())


BATTERY = {"initial": 5, "level_min": 2, "level_max": 8}


@pytest.mark.parametrize(
    ("found", "expected", "tokens"),
    [
        (
            moving("Reservoir", BATTERY, [("consume", 4, (10, 20))]),
            "the level of store may fall to 1 at tick 10, at least 2 is required: after t0 (store consume) 4",
            ("t0",),
        ),
        (
            moving("Reservoir", BATTERY, [("produce", 2, (0, 15)), ("consume", 4, (10, 20))]),
            "the level of store may fall to 1 at tick 10, at least 2 is required: after t1 (store consume) 4,"
            " before t0 (store produce) 2",
            ("t1", "t0"),
        ),
        (
            moving("Reservoir", BATTERY, [("produce", 2, (0, 15)), ("produce", 2, (10, 20))]),
            "the level of store may rise to 9 at tick 10, at most 8 is allowed: after t0 (store produce) 2, t1 (store"
            " produce) 2",
            ("t0", "t1"),
        ),
        (
            moving("Reservoir", {"initial": 5, "consumption_rate_max": 3}, [("consume", 2, (3, 5))] * 2),
            "store: 4 may be consumed at tick 3, at most 3 is allowed at one tick: t0 (store consume) 2, t1 (store"
            " consume) 2",
            ("t0", "t1"),
        ),
        (
            moving("Reservoir", {"initial": 5, "production_max": 3}, [("produce", 2, (3, 5))] * 2),
            "store: 4 is produced in all, at most 3 is allowed: t0 (store produce) 2, t1 (store produce) 2",
            ("t0", "t1"),
        ),
        (
            moving("Reusable", {"capacity": ((0, 5), (20, 3), (40, 5))}, [("uses", 4, (0, 25))], lasting=5),
            "store has 3 at tick 20, a schedule uses 4 at once: t0 (store uses) 4",
            ("t0",),
        ),
        (
            moving("Reusable", {"capacity": 9, "consumption_rate_max": 3}, [("uses", 2, (3, 5))] * 2, lasting=4),
            "store: 4 may be taken at tick 3, at most 3 is allowed at one tick: t0 (store uses) 2, t1 (store uses) 2",
            ("t0", "t1"),
        ),
        (
            moving("Unary", {}, [("use", 1, (3, 5)), ("use", 1, (4, 8))], lasting=2),
            "store has 1 at tick 4, a schedule uses 2 at once: t0 (store use) 1, t1 (store use) 1",
            ("t0", "t1"),
        ),
    ],
)
def test_each_violation_is_a_sentence_with_its_tokens(
    found: tuple[Violation, ...], expected: str, tokens: tuple[str, ...]
) -> None:
    assert [v.kind for v in found] == ["resource"]
    assert found[0].explanation == expected
    assert found[0].tokens == tokens


@pytest.mark.parametrize(
    "found",
    [
        moving("Reservoir", BATTERY, [("produce", 1, (0, 15)), ("consume", 4, (10, 20))], order=True),
        moving(
            "Reservoir", {"initial": 5, "consumption_rate_max": 3}, [("consume", 2, (3, 5)), ("consume", 2, (6, 8))]
        ),
        moving("Reusable", {"capacity": ((0, 5), (20, 3), (40, 5))}, [("uses", 4, (0, 15))], lasting=5),
        # In the schedule of earliest times the bottom is kept, in others not.
        moving("Reservoir", {**BATTERY, "profile": "grounded"}, [("produce", 2, (0, 15)), ("consume", 4, (10, 20))]),
    ],
)
def test_what_every_schedule_keeps_is_accepted(found: tuple[Violation, ...]) -> None:
    assert found == ()


def test_limits_that_mean_nothing_are_an_error() -> None:
    for members, message in (
        ({}, "object store: a resource needs a value for its member 'capacity'"),
        ({"capacity": ((5, 1), (2, 3))}, "member 'capacity': expected a number, or .tick, value. pairs in increasing"),
    ):
        with pytest.raises(ModelError, match=message):
            moving("Reusable", members, [("uses", 1, (0, 5))], lasting=2)


# The constraint `uses`.


State = Callable[[RuleBuilder, dict[str, ModelObject]], None]


def workshop(state: State, capacity: object = 3) -> ModelManager:
    model = ModelBuilder("workshop", STANDARD)
    worker = model.timeline("Worker")
    work = worker.predicate("work", {"load": "int"}, duration=(4, 4))
    things = {
        name: model.object(name, "CBReusable", {"capacity": capacity})
        for name, capacity in (("power", capacity), ("gas", 1))
    }
    for name in ("ann", "bob"):
        model.object(name, "Worker")
    with work.requires() as this:
        state(this, things)
    return model.finish()


def at_work(loads: tuple[int, int], starts: tuple[int, int] = (0, 2)) -> FlexiblePlan:
    """Two workers, each at work once."""
    tokens = tuple(
        PlanToken(f"t{n}", name, "state", "Worker.work", {"load": load}, (at, at), (at + 4, at + 4), (4, 4), goal=name)
        for n, (name, load, at) in enumerate(zip(("ann", "bob"), loads, starts, strict=True))
    )
    timelines = tuple(PlanTimeline(t.object, "state", ((t.id,),)) for t in tokens)
    return FlexiblePlan("workshop", (0, 20), ("power", "gas", "ann", "bob"), timelines, tokens, ())


def loaded(this: RuleBuilder, things: dict[str, ModelObject]) -> None:
    this.constrain("uses", things["power"], this.load, this.start, this.end)


def power_or_gas(this: RuleBuilder, things: dict[str, ModelObject]) -> None:
    with this.either() as either:
        for thing in things.values():
            with either.alternative() as way:
                way.constrain("uses", thing, way.load, way.start, way.end)


def test_a_use_by_a_constraint_counts() -> None:
    model = workshop(loaded)
    assert check(at_work((1, 2)), model) == ()
    assert check(at_work((2, 2), (0, 4)), model) == ()
    (found,) = check(at_work((2, 2)), model)
    assert str(found) == (
        "resource: power has 3 at tick 2, a schedule uses 4 at once: t0 (ann work) 2, t1 (bob work) 2"
    )
    assert check(at_work((2, 2)), workshop(loaded, capacity=((0, 3), (2, 4)))) == ()


def test_one_way_to_satisfy_each_rule_is_enough() -> None:
    model = workshop(power_or_gas)
    assert check(at_work((3, 1)), model) == ()
    assert check(at_work((1, 3)), model) == ()
    assert {v.kind for v in check(at_work((3, 2)), model)} == {"resource"}


def test_a_choice_is_sought_where_the_trouble_is() -> None:
    """Of 2 ** 12 choices twelve are right: those with one worker on the common one."""
    model = ModelBuilder("many", STANDARD)
    worker = model.timeline("Worker")
    work = worker.predicate("work", duration=(4, 4))
    common, own = (model.object(name, "CBReusable", {"capacity": size}) for name, size in (("common", 1), ("own", 11)))
    with work.requires() as this, this.either() as either:
        for thing in (common, own):
            with either.alternative() as way:
                way.constrain("uses", thing, 1, way.start, way.end)
    names = [f"w{n}" for n in range(12)]
    for name in names:
        model.object(name, "Worker")
    tokens = tuple(PlanToken(f"t{n}", n, "state", "Worker.work", {}, (0, 0), (4, 4), (4, 4), goal=n) for n in names)
    timelines = tuple(PlanTimeline(t.object, "state", ((t.id,),)) for t in tokens)
    plan = FlexiblePlan("many", (0, 20), ("common", "own", *names), timelines, tokens, ())
    manager = model.finish()
    assert check(plan, manager) == ()
    manager.objects["own"].members["capacity"] = 10
    assert {v.kind for v in check(plan, manager)} == {"resource"}


@pytest.mark.parametrize("state", [loaded, power_or_gas])
def test_plans_with_uses_are_judged_as_their_schedules_are(state: State) -> None:
    model = workshop(state)
    for loads in product((1, 2, 3), repeat=2):
        goals = tuple(
            Goal(name, TokenPattern("Worker.work", name, {"load": load}, (0, None), (None, 8)))
            for name, load in zip(("ann", "bob"), loads, strict=True)
        )
        result = make_plan(model, Problem((0, 20), goals=goals))
        assert result.plan is not None
        assert not result.dropped
        assert check(result.plan, model) == ()
        # Without the order that keeps the resource, the uses may overlap.
        free = tuple(replace(t, start=(0, 4), end=(4, 8)) for t in result.plan.tokens)
        loose = replace(result.plan, constraints=(), tokens=free)
        clash = sum(loads) > 3 and (state is loaded or 1 not in loads)
        assert {v.kind for v in check(loose, model)} == ({"resource"} if clash else set())
