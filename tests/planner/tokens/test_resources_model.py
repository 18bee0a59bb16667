"""The resource classes of the model: what their members and predicates mean, and what is said when they are wrong."""

from __future__ import annotations

from typing import Any

import pytest

from planner.constraints.network import Inconsistency
from planner.constraints.standard import STANDARD
from planner.database import PlanDatabase
from planner.domains import Interval
from planner.errors import ModelError
from planner.language.builder import ModelBuilder
from planner.model.manager import ModelManager
from planner.planning import describe, plan
from planner.problem import Goal, Problem, TokenPattern
from planner.search.decisions import Activate
from planner.tokens.resources import Band
from planner.tokens.resources.steps import Steps
from planner.tokens.token import Token

HORIZON = (0, 100)


def model(cls: str, members: dict[str, Any]) -> ModelManager:
    builder = ModelBuilder("one resource", STANDARD)
    builder.object("thing", cls, members)
    return builder.finish()


class Bench:
    """A resource, and tokens on it one after the other."""

    def __init__(self, cls: str, members: dict[str, Any]) -> None:
        self.cls = cls
        self.database = PlanDatabase(model(cls, members), HORIZON)
        ((self.thing, self.resource),) = self.database.tokens.resources.items()

    def add(self, predicate: str, name: str, quantity: float | None, *times: Any) -> Token:
        parameters = {} if quantity is None else {"quantity": quantity}
        token = self.database.state(TokenPattern(f"{self.cls}.{predicate}", None, parameters, *times), name, "goal")
        Activate(token, self.thing).apply(self.database)
        return token


def test_steps() -> None:
    steps = Steps.parse([(0, 5), (10, 2), (20, 7)], "here")
    assert [steps.at(t) for t in (-5, 0, 9, 10, 19, 20, 99)] == [5, 5, 5, 2, 2, 7, 7]
    assert Steps.parse(3, "here").at(17) == 3
    difference = steps.minus(Steps.parse([(0, 1), (15, 2)], "here"))
    assert [difference.at(t) for t in (0, 10, 14, 15, 20)] == [4, 1, 1, 0, 5]
    assert steps.stretch(12, lambda value: value < 3) == (10, 20)
    assert steps.stretch(12, lambda value: value < 6) == (float("-inf"), 20)
    assert steps.stretch(25, lambda value: value > 3) == (20, float("inf"))


@pytest.mark.parametrize(
    "wrong", ["five", [], [(0, 1), (0, 2)], [(5, 1), (3, 2)], [(0, 1), (1.5, 2)], [1, 2], True, None]
)
def test_steps_that_are_none(wrong: Any) -> None:
    with pytest.raises(ModelError, match=r"thing, member 'capacity': expected a number, or \(tick, value\) pairs"):
        Bench("Reusable", {"capacity": wrong})


@pytest.mark.parametrize(
    ("cls", "members", "message"),
    [
        ("Reusable", {}, "object thing of class Reusable: a resource needs a value for its member 'capacity'"),
        ("Reservoir", {"level_max": 3}, "needs a value for its member 'initial'"),
        ("Reusable", {"capacity": 5, "level_min": 6}, "expected a level of 6 to inf to begin with, found 5"),
        ("Reservoir", {"initial": ((0, 1), (2, 2))}, "expected a number as its member 'initial'"),
        ("Reusable", {"capacity": ((0, 5), (9, 1)), "level_min": 2}, "level of 2 to inf from tick 9 on, found 1"),
        ("Reusable", {"capacity": 5, "profile": "envelop"}, "found 'envelop'; did you mean envelope"),
    ],
)
def test_members_that_mean_nothing(cls: str, members: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        Bench(cls, members)


def test_levels_of_a_reservoir() -> None:
    bench = Bench("Reservoir", {"initial": 10, "level_max": 20})
    bench.add("consume", "drain", 4, (10, 20))
    bench.add("produce", "fill", 6, (15, 15))
    assert bench.resource.envelope() == [
        Band(float("-inf"), 10, 10),
        Band(10, 6, 10),
        Band(15, 12, 16),
        Band(20, 12, 12),
    ]
    assert bench.resource.grounded() == [Band(float("-inf"), 10, 10), Band(10, 6, 6), Band(15, 12, 12)]
    assert bench.resource.clash() is None


def test_levels_where_the_capacity_steps() -> None:
    bench = Bench("Reusable", {"capacity": ((0, 5), (20, 3))})
    bench.add("uses", "use", 2, (10, 10), (30, 30))
    levels = [(b.start, b.lowest) for b in bench.resource.envelope()]
    assert levels == [(float("-inf"), 5), (10, 3), (20, 1), (30, 3)]


def test_what_is_given_back_at_a_tick_can_be_taken_at_it() -> None:
    bench = Bench("Unary", {})
    bench.add("use", "one", None, (0, 0), (5, 5))
    bench.add("use", "two", None, (5, 5), (9, 9))
    assert bench.resource.clash() is None
    with pytest.raises(Inconsistency):
        bench.add("use", "three", None, (4, 4), (6, 6))


def test_a_grounded_resource_judges_the_earliest_schedule_only() -> None:
    verdicts = []
    for profile in ("envelope", "grounded"):
        bench = Bench("Reusable", {"capacity": 3, "profile": profile})
        bench.add("uses", "one", 2, (0, 50), (None, None), (5, 5))
        bench.add("uses", "two", 2, (10, 50), (None, None), (5, 5))
        verdicts.append(bench.resource.clash() is not None)
    assert verdicts == [True, False]


def test_a_grounded_resource_looks_again_when_earliest_times_move() -> None:
    bench = Bench("Reusable", {"capacity": 3, "profile": "grounded"})
    one = bench.add("uses", "one", 2, (0, 50), (None, None), (5, 20))
    bench.add("uses", "two", 2, (10, 50), (None, None), (5, 5))
    assert bench.resource.clash() is None
    bench.database.network.restrict(one.end, Interval(12, 100), "later")
    bench.database.network.propagate()
    assert bench.resource.clash() is not None


def test_a_clash_reads_well_and_names_the_tokens() -> None:
    bench = Bench("Reusable", {"capacity": 3})
    bench.add("uses", "one", 2, (0, 50), (None, None), (5, 5))
    bench.add("uses", "two", 2, (10, 50), (None, None), (5, 5))
    text = "thing (capacity 3): 4 may be in use at 10, there are 3: one uses 2, two uses 2"
    assert repr(bench.resource.clash()) == text
    tank = Bench("Reservoir", {"initial": 2, "level_max": 5})
    tank.add("consume", "drain", 3, (10, 20))
    text = "thing (level 0 to 5): the level may fall to -1 at 10, at least 0 are required: drain consumes 3"
    assert repr(tank.resource.clash()) == text


def test_an_inconsistency_names_the_tokens() -> None:
    bench = Bench("Reusable", {"capacity": 3})
    bench.add("uses", "one", 2, (0, 0), (9, 9))
    with pytest.raises(Inconsistency) as caught:
        bench.add("uses", "two", 2, (4, 4), (6, 6))
    told = describe(bench.database.network.explain(caught.value))
    assert "thing (capacity 3)" in told
    assert "one" in told
    assert "two" in told


def test_a_use_is_kept_out_of_where_it_does_not_fit() -> None:
    bench = Bench("Reusable", {"capacity": ((0, 4), (60, 1))})
    bench.add("uses", "long", 3, (10, 10), (30, 30))
    late = bench.add("uses", "late", 2, (8, 100), (None, None), (5, 20))
    assert (late.start.domain.lower, late.end.domain.upper) == (30, 60)
    early = bench.add("uses", "early", 2, (3, 25), (None, None), (5, 5))
    assert (early.start.domain.lower, early.start.domain.upper) == (3, 5)


def test_rates_and_sums() -> None:
    bench = Bench("Reservoir", {"initial": 0, "production_rate_max": 3, "production_max": 6})
    bench.add("produce", "one", 2, (0, 10))
    two = bench.add("produce", "two", 2, (5, 10))
    assert "may be produced at 5, at most 3 are allowed at one tick" in repr(bench.resource.clash())
    (first, second) = [*bench.resource.clash().remedies()][:2]  # type: ignore[union-attr]
    assert {first.gap, second.gap} == {1}
    free = bench.add("produce", "three", None, (20, 20))
    assert free.parameters["quantity"].domain.upper == 2
    with pytest.raises(Inconsistency) as caught:
        bench.add("produce", "four", 3, (30, 30))
    assert "7 may be produced in all, at most 6 are allowed" in describe(bench.database.network.explain(caught.value))
    assert two.start.domain.lower == 5


def worker_model(uses: str) -> ModelManager:
    """Workers that each draw from one of two supplies through the constraint `uses`."""
    builder = ModelBuilder("workers", STANDARD)
    worker = builder.timeline("Worker")
    work = worker.predicate("work", {"supply": "CBReusable"}, duration=(4, 4))
    with work.requires() as this:
        this.constrain("uses", *(getattr(this, name) for name in uses.split()), this.start, this.end)
    for number in range(3):
        builder.object(f"worker{number}", "Worker")
    for number in range(2):
        builder.object(f"supply{number}", "CBReusable", {"capacity": 6})
    return builder.finish()


def test_the_constraint_uses() -> None:
    """Six ticks, three pieces of work of four, two supplies that each take one at a time: only two fit."""
    goals = tuple(Goal(f"g{n}", TokenPattern("Worker.work", f"worker{n}", {}, (0, None), (None, 6))) for n in range(3))
    builder = worker_model("supply duration")
    result = plan(builder, Problem((0, 6), goals=goals[:2]))
    assert result.plan is not None
    assert not result.dropped
    assert len({t.parameters["supply"] for t in result.plan.tokens}) == 2
    result = plan(builder, Problem((0, 6), goals=goals))
    assert [d.id for d in result.dropped] == ["g2"]


def test_the_constraint_uses_wants_a_reusable_resource() -> None:
    builder = ModelBuilder("workers", STANDARD)
    work = builder.timeline("Worker").predicate("work", {"tank": "Reservoir"})
    with work.requires() as this:
        this.constrain("uses", this.tank, this.duration, this.start, this.end)
    builder.object("worker", "Worker")
    builder.object("tank", "Reservoir", {"initial": 3})
    goal = Goal("g", TokenPattern("Worker.work"))
    with pytest.raises(ModelError, match="tank is a reservoir, expected a reusable resource"):
        plan(builder.finish(), Problem((0, 6), goals=(goal,)))


def test_a_predicate_of_a_reservoir_is_production_or_consumption() -> None:
    builder = ModelBuilder("tanks", STANDARD)
    builder.manager.add_class("Tank", "Reservoir")
    builder.manager.add_predicate("Tank", "leak", (), attribute="level")
    builder.object("tank", "Tank", {"initial": 3})
    goal = Goal("g", TokenPattern("Tank.leak"))
    with pytest.raises(ModelError, match="expected a predicate of"):
        plan(builder.finish(), Problem((0, 6), goals=(goal,)))


def test_a_reservoir_is_filled_before_it_is_drained() -> None:
    goals = [
        Goal("drain", TokenPattern("Reservoir.consume", None, {"quantity": 8}, (0, None), (None, 50))),
        Goal("fill", TokenPattern("Reservoir.produce", None, {"quantity": 5}, (0, None), (None, 50))),
        Goal("more", TokenPattern("Reservoir.produce", None, {"quantity": 4}, (0, None), (None, 50))),
    ]
    result = plan(model("Reservoir", {"initial": 4, "level_max": 10}), Problem((0, 50), goals=tuple(goals)))
    assert result.plan is not None
    assert not result.dropped
    times = {t.goal: t.id for t in result.plan.tokens}
    orders = {(c.from_, c.to) for c in result.plan.constraints if c.why.startswith("order")}
    assert (f"{times['fill']}.start", f"{times['drain']}.start") in orders or (
        f"{times['more']}.start",
        f"{times['drain']}.start",
    ) in orders
    short = plan(model("Reservoir", {"initial": 1, "level_max": 10}), Problem((0, 50), goals=tuple(goals[:2])))
    assert [d.id for d in short.dropped] == ["drain"] or [d.id for d in short.dropped] == ["fill"]
    assert "thing (level 0 to 10)" in short.dropped[0].reason


def test_what_a_limit_forbids_for_a_while_comes_after_it() -> None:
    """Three of four can only be drained once no reserve is asked for any more."""
    members = {"initial": 4, "level_min": ((0, 0), (10, 3), (20, 0)), "level_max": 9}
    drain = Goal("drain", TokenPattern("Reservoir.consume", None, {"quantity": 3}, (5, 30)))
    result = plan(model("Reservoir", members), Problem((0, 50), goals=(drain,)))
    assert result.plan is not None
    assert [t.start for t in result.plan.tokens] == [(20, 30)]
