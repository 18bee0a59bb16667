"""The judge against oracles and against the planner on random cases."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from planner.checker import check
from planner.checker.network import PlanNetwork
from planner.constraints.standard import STANDARD
from planner.language.builder import ModelBuilder
from planner.model.manager import ModelManager
from planner.plan import FlexiblePlan, PlanConstraint, PlanToken
from planner.planning import plan as make_plan
from planner.problem import ConstraintPattern, Goal, Problem, TokenPattern
from planner.search.outcome import Limits

BOUNDED = settings(
    max_examples=150,
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
FEWER = settings(BOUNDED, max_examples=80)


def loose_tokens(count: int) -> tuple[PlanToken, ...]:
    return tuple(
        PlanToken(f"t{n}", "power", "level", "Reusable.uses", {"quantity": 1.0}, (0, 60), (0, 60), (1, None))
        for n in range(count)
    )


@st.composite
def networks(draw: st.DrawFn) -> FlexiblePlan:
    """A few tokens within [0, 60] and random distances between their timepoints."""
    tokens = loose_tokens(draw(st.integers(1, 4)))
    points = [f"{t.id}.{which}" for t in tokens for which in ("start", "end")]
    constraints = []
    for _ in range(draw(st.integers(0, 8))):
        lower = draw(st.one_of(st.none(), st.integers(-20, 20)))
        upper = draw(st.one_of(st.none(), st.integers(-20, 30)))
        constraints.append(
            PlanConstraint(draw(st.sampled_from(points)), draw(st.sampled_from(points)), lower, upper, "random")
        )
    return FlexiblePlan("m", (0, 60), ("power",), (), tokens, tuple(constraints))


def closure(plan: FlexiblePlan, index: dict[str, int]) -> list[list[float]] | None:
    """All distances by Floyd and Warshall, or None when the network has no schedule."""
    size = len(index)
    far = [[0.0 if a == b else math.inf for b in range(size)] for a in range(size)]

    def add(a: int, b: int, lower: float | None, upper: float | None) -> None:
        far[a][b] = min(far[a][b], math.inf if upper is None else upper)
        far[b][a] = min(far[b][a], math.inf if lower is None else -lower)

    for token in plan.tokens:
        start, end = index[f"{token.id}.start"], index[f"{token.id}.end"]
        add(0, start, *token.start)
        add(0, end, *token.end)
        add(start, end, *token.duration)
    for c in plan.constraints:
        add(index[c.from_], index[c.to], c.min, c.max)
    for m, a, b in product(range(size), repeat=3):
        far[a][b] = min(far[a][b], far[a][m] + far[m][b])
    return None if any(far[a][a] < 0 for a in range(size)) else far


@BOUNDED
@given(networks())
def test_the_network_agrees_with_all_pairs_shortest_paths(plan: FlexiblePlan) -> None:
    network = PlanNetwork(plan, {t.id: t.id for t in plan.tokens})
    far = closure(plan, network.index)
    assert (far is None) == bool(network.conflict)
    if far is None:
        return
    for a, b in product(range(network.size), repeat=2):
        assert network.distance(a, b) == far[a][b]
        for limit in (far[a][b] - 1, far[a][b], far[a][b] + 1):
            assert network.at_most(a, b, limit) == (far[a][b] <= limit)
        stretched, shrunk = network.stretched(a, b), network.shrunk(a, b)
        for schedule in (network.earliest, network.latest, stretched, shrunk):
            assert schedule[0] == 0
            assert all(schedule[q] - schedule[p] <= far[p][q] for p, q in product(range(network.size), repeat=2))
        assert stretched[b] - stretched[a] == far[a][b]
        assert shrunk[b] - shrunk[a] == -far[b][a]
        assert network.lower[a] == -far[a][0]
        assert network.upper[a] == far[0][a]


def test_without_bounds_nothing_is_entailed() -> None:
    tokens = tuple(replace(t, start=(None, None), end=(None, None)) for t in loose_tokens(2))
    network = PlanNetwork(FlexiblePlan("m", (0, 9), ("power",), (), tokens, ()), {"t0": "t0", "t1": "t1"})
    a, b = network.point("t0", "end"), network.point("t1", "start")
    assert not network.at_most(a, b, 10**6)
    assert not network.at_most(b, a, 10**6)
    assert network.span(a, b) == (-math.inf, math.inf)
    assert network.at_most(a, network.point("t0", "start"), -1)


# Resources against every schedule.


@st.composite
def uses(draw: st.DrawFn) -> tuple[int, FlexiblePlan]:
    """Up to four uses within a short time, some of them ordered, and a capacity."""
    tokens = []
    for n in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, 3))
        length = draw(st.integers(1, 2))
        shift = draw(st.integers(0, 2))
        quantity = {"quantity": float(draw(st.integers(1, 3)))}
        times = (start, start + shift), (start + length, start + shift + length), (length, length)
        tokens.append(PlanToken(f"t{n}", "power", "level", "Reusable.uses", quantity, *times, master="t0"))
    constraints = []
    for a, b in product(range(len(tokens)), repeat=2):
        if a != b and draw(st.integers(0, 3)) == 0:
            lower = draw(st.integers(-2, 1))
            constraints.append(PlanConstraint(f"t{a}.start", f"t{b}.start", lower, None, "random"))
    plan = FlexiblePlan("power", (0, 20), ("power",), (), tuple(tokens), tuple(constraints))
    return draw(st.integers(1, 6)), plan


def highest_use(plan: FlexiblePlan) -> float | None:
    """The most that any schedule uses at one time, by trying all; None without a schedule."""
    best: float | None = None
    for starts in product(*(range(int(t.start[0] or 0), int(t.start[1] or 0) + 1) for t in plan.tokens)):
        at = {f"{t.id}.start": s for t, s in zip(plan.tokens, starts, strict=True)}
        if any(at[c.to] - at[c.from_] < (c.min or 0) for c in plan.constraints):
            continue
        for moment in range(8):
            level = 0.0
            for token, start in zip(plan.tokens, starts, strict=True):
                quantity = token.parameters["quantity"]
                assert isinstance(quantity, float)
                level += quantity if start <= moment < start + int(token.duration[0] or 0) else 0
            best = max(best or 0.0, level)
    return best


@BOUNDED
@given(uses())
def test_resource_judgement_is_exact(case: tuple[int, FlexiblePlan]) -> None:
    capacity, plan = case
    model = ModelBuilder("power", STANDARD)
    model.object("power", "Reusable", {"capacity": capacity})
    found = {v.kind for v in check(plan, model.finish())} - {"bounds"}
    most = highest_use(plan)
    if most is None:
        assert found == {"inconsistent"}
    else:
        assert ("resource" in found) == (most > capacity)


# Plans of the planner.


@st.composite
def domains(draw: st.DrawFn) -> tuple[ModelManager, Problem]:
    """A mode machine with transitions, a worker that needs modes and power, and goals for the worker."""
    model = ModelBuilder("random", STANDARD)
    place = model.enumeration("Place", ["a", "b", "c"])
    mover, worker = model.timeline("Mover"), model.timeline("Worker")
    at = mover.predicate("at", {"place": place})
    fastest = draw(st.integers(1, 4))
    go = mover.predicate(
        "go",
        {"origin": place, "target": place},
        duration=(fastest, fastest + draw(st.integers(0, 3))),
        contingent=draw(st.booleans()),
    )
    work = worker.predicate("work", {"place": place}, duration=(1, draw(st.integers(1, 6))))
    rest = worker.predicate("rest")
    uses_power = worker.predicate_of("Reusable", "uses")
    consume, produce = (worker.predicate_of("Reservoir", name) for name in ("consume", "produce"))
    power = model.object(
        "power", "Reusable", {"capacity": draw(st.sampled_from([2, 3, 4, ((0, 4), (15, 2), (25, 4))]))}
    )
    tank = draw(st.booleans())
    with at.requires() as this:
        this.met_by(go, target=this.place)
        this.meets(go, origin=this.place)
    with go.requires() as this:
        this.require(this.origin != this.target)
        this.met_by(at, place=this.origin)
        this.meets(at, place=this.target)
    with work.requires() as this:
        relation = draw(st.sampled_from(["contained_by", "starts_during", "ends_during", "after", "parallels"]))
        this.relation(relation, at, place=this.place)
        if draw(st.booleans()):
            this.equals(uses_power, quantity=draw(st.integers(1, 3)))
        if draw(st.booleans()):
            with this.when(this.place == "b") as then:
                then.before(rest, bounds=(0, draw(st.integers(0, 5))))
        if draw(st.booleans()):
            with this.either() as options:
                with options.alternative() as one:
                    one.meets(rest)
                with options.alternative() as other:
                    other.met_by(rest)
        if draw(st.booleans()):
            this.constrain("leq", this.duration, draw(st.integers(1, 6)))
        if draw(st.integers(0, 3)) == 0:
            with this.either() as loads:
                for load in draw(st.lists(st.integers(1, 3), min_size=1, max_size=2)):
                    with loads.alternative() as one:
                        one.constrain("uses", power, load, one.start, one.end)
        if tank:
            this.relation("ends", consume, quantity=draw(st.integers(1, 2)))
        if draw(st.integers(0, 2)) == 0:
            allowed = [at.where(place=this.place), go] if draw(st.booleans()) else [at.where(place=["a", "b"])]
            this.constraint_token(draw(st.sampled_from(["equals", "contained_by", "starts", "meets"])), allowed)
    with rest.requires() as this:
        if tank:
            this.relation("ends", produce, quantity=draw(st.integers(1, 2)))
        if draw(st.integers(0, 2)) == 0:
            this.throughout(at.where(place=["b", "c"]), go)
    for name in ("Mover", "Worker"):
        model.object(name.lower(), name)
    if draw(st.booleans()):
        model.object("second", "Worker")
    if tank:
        least = draw(st.sampled_from([0, ((0, 0), (20, 1))]))
        limits = {"initial": draw(st.integers(1, 4)), "level_min": least, "level_max": draw(st.integers(4, 6))}
        rates = draw(st.sampled_from([{}, {"consumption_rate_max": 2}, {"production_max": 3}, {"consumption_max": 4}]))
        model.object("tank", "Reservoir", {**limits, **rates})
    goals = []
    for n in range(draw(st.integers(1, 4))):
        start = draw(st.one_of(st.none(), st.integers(0, 20)))
        end = draw(st.one_of(st.none(), st.integers(15, 40)))
        target = draw(st.sampled_from("abc"))
        goals.append(Goal(f"g{n}", TokenPattern("Worker.work", None, {"place": target}, (start, None), (None, end)), n))
    state = (TokenPattern("Mover.at", parameters={"place": draw(st.sampled_from("abc"))}),)
    facts = (TokenPattern("Worker.rest", "worker", duration=(1, 3)),) if draw(st.booleans()) else ()
    kept = ConstraintPattern(
        "Mover.state", (TokenPattern("Mover.at", parameters={"place": ("a", "b")}),), None, (9, 12), (14, 20)
    )
    constraints = (kept,) if draw(st.integers(0, 3)) == 0 else ()
    return model.finish(), Problem((0, 40), state, facts, tuple(goals), constraints)


@FEWER
@given(domains())
def test_plans_of_the_planner_are_accepted(case: tuple[ModelManager, Problem]) -> None:
    model, problem = case
    result = make_plan(model, problem, Limits(max_steps=150))
    if result.plan is not None:
        assert check(result.plan, model, problem, result.dropped) == ()
        assert check(result.plan, model) == ()


@FEWER
@given(domains(), st.data())
def test_a_plan_without_one_of_its_constraints_is_accepted_only_if_it_is_implied(
    case: tuple[ModelManager, Problem], data: st.DataObject
) -> None:
    """Whatever is left out, what is still accepted allows no more schedules than before."""
    model, problem = case
    result = make_plan(model, problem, Limits(max_steps=150))
    if result.plan is None or not result.plan.constraints:
        return
    left_out = data.draw(st.sampled_from(result.plan.constraints))
    weaker = replace(result.plan, constraints=tuple(c for c in result.plan.constraints if c is not left_out))
    if check(weaker, model, problem, result.dropped) == ():
        hosts = {i: slot[0] for t in weaker.timelines for slot in t.slots for i in slot}
        whole = {t.id: hosts.get(t.id, t.id) for t in weaker.tokens}
        before, after = PlanNetwork(result.plan, whole), PlanNetwork(weaker, whole)
        assert before.lower == after.lower
        assert before.upper == after.upper
