"""The judge: plans that are right pass, and each way of making one wrong is named for what it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from planner.checker import Violation, check
from planner.constraints.standard import STANDARD
from planner.language.builder import ModelBuilder
from planner.model.manager import ModelManager
from planner.plan import FlexiblePlan, PlanConstraint, PlanTimeline, PlanToken
from planner.planning import plan as make_plan
from planner.problem import Goal, Problem, TokenPattern
from scenarios.ds1.domain import Capability, build_model

HOUR = 3600
TARGETS = ("earth", "thrust_a", "asteroid_a", "asteroid_b")


@cache
def ds1() -> tuple[ModelManager, Problem, FlexiblePlan]:
    """Two images' worth of asteroids, a thrust and a downlink on the project's own domain."""
    turns = {(a, b): (300, 900) for a in TARGETS for b in TARGETS}
    capability = Capability(
        TARGETS,
        turns,
        {90: 2100, 48: 1300, 6: 500},
        2100,
        (600, 1202),
        (60, 242),
        200,
        (600, 902),
        150,
        (50, 72),
        60,
        (1, 60),
        2500,
    )
    model = build_model(capability)
    goals = (
        Goal("nav", TokenPattern("Navigation.session", parameters={"target": "asteroid_a"}, start=(5400, None))),
        Goal("thrust", TokenPattern("Engine.thrust", parameters={"heading": "thrust_a"}, duration=(3600, None))),
        Goal("downlink", TokenPattern("Radio.downlink", start=(8 * HOUR, None), duration=(1800, None))),
    )
    state = (
        TokenPattern("Attitude.point", parameters={"target": "earth"}),
        TokenPattern("Engine.standby"),
        TokenPattern("Engine.works"),
        TokenPattern("Camera.off"),
        TokenPattern("Camera.switchedOff"),
    )
    problem = Problem((0, 12 * HOUR), state, (), goals)
    found = make_plan(model, problem).plan
    assert found is not None
    return model, problem, found


def kinds(violations: tuple[Violation, ...]) -> set[str]:
    return {v.kind for v in violations}


def with_token(plan: FlexiblePlan, token_id: str, **changes: Any) -> FlexiblePlan:
    """The plan with one token changed, alone of its slot."""
    return replace(plan, tokens=tuple(replace(t, **changes) if t.id == token_id else t for t in plan.tokens))


def with_slot(plan: FlexiblePlan, token_id: str, **changes: Any) -> FlexiblePlan:
    """The plan with all tokens of a slot changed alike."""
    group = next(s for t in plan.timelines for s in t.slots if token_id in s)
    for member in group:
        plan = with_token(plan, member, **changes)
    return plan


def without(plan: FlexiblePlan, *token_ids: str) -> FlexiblePlan:
    """The plan without those tokens, their places and their constraints, and with what is then left of bounds."""
    timelines = tuple(
        replace(t, slots=tuple(s for slot in t.slots if (s := tuple(i for i in slot if i not in token_ids))))
        for t in plan.timelines
    )
    constraints = tuple(
        c for c in plan.constraints if not {c.from_.partition(".")[0], c.to.partition(".")[0]} & set(token_ids)
    )
    tokens = tuple(
        replace(t, master=None if t.master in token_ids else t.master) for t in plan.tokens if t.id not in token_ids
    )
    return replace(plan, tokens=tokens, timelines=timelines, constraints=constraints)


def hosts(plan: FlexiblePlan, predicate: str) -> list[PlanToken]:
    return [t for t in plan.hosts() if t.predicate == predicate]


def slot_of(plan: FlexiblePlan, token_id: str) -> tuple[str, ...]:
    return next(s for t in plan.timelines for s in t.slots if token_id in s)


def test_the_ds1_plan_is_accepted_with_its_problem_and_alone() -> None:
    model, problem, plan = ds1()
    assert check(plan, model, problem) == ()
    assert check(plan, model) == ()
    assert check(FlexiblePlan.from_json(plan.to_json()), model, problem) == ()


# Mutations: each takes a valid plan and breaks one thing.


def drop_a_turn(plan: FlexiblePlan) -> FlexiblePlan:
    return without(plan, *slot_of(plan, hosts(plan, "Attitude.turn")[0].id))


def drop_an_image(plan: FlexiblePlan) -> FlexiblePlan:
    return without(plan, *slot_of(plan, hosts(plan, "Camera.takeImage")[1].id))


def drop_a_state(plan: FlexiblePlan) -> FlexiblePlan:
    token = next(t for t in plan.tokens if t.predicate == "Engine.standby" and t.master is None)
    return without(plan, *slot_of(plan, token.id))


def drop_a_goal(plan: FlexiblePlan) -> FlexiblePlan:
    return without(plan, next(t.id for t in plan.tokens if t.goal == "nav"))


def invent_a_fact(plan: FlexiblePlan) -> FlexiblePlan:
    return with_token(plan, hosts(plan, "Engine.startUp")[0].id, fact=True)


def take_out_of_its_slot(plan: FlexiblePlan) -> FlexiblePlan:
    timelines = tuple(replace(t, slots=tuple(slot[:1] for slot in t.slots)) for t in plan.timelines)
    return replace(plan, timelines=timelines)


def codesignate_strangers(plan: FlexiblePlan) -> FlexiblePlan:
    first, *rest = plan.timelines
    a, b, *others = first.slots
    return replace(plan, timelines=(replace(first, slots=((*a, *b), *others)), *rest))


def swap_slots(plan: FlexiblePlan) -> FlexiblePlan:
    first, *rest = plan.timelines
    a, b, *others = first.slots
    return replace(plan, timelines=(replace(first, slots=(b, a, *others)), *rest))


def empty_slot(plan: FlexiblePlan) -> FlexiblePlan:
    first, *rest = plan.timelines
    return replace(plan, timelines=(replace(first, slots=((), *first.slots)), *rest))


def wrong_timeline(plan: FlexiblePlan) -> FlexiblePlan:
    first, second, *rest = plan.timelines
    slots = (*second.slots, first.slots[0])
    return replace(plan, timelines=(replace(first, slots=first.slots[1:]), replace(second, slots=slots), *rest))


def widen_a_bound(plan: FlexiblePlan) -> FlexiblePlan:
    token = hosts(plan, "Attitude.turn")[0]
    assert token.end[0] is not None
    return with_slot(plan, token.id, end=(token.end[0] - 1, token.end[1]))


def tighten_a_bound(plan: FlexiblePlan) -> FlexiblePlan:
    token = hosts(plan, "Attitude.turn")[0]
    assert token.end[0] is not None
    return with_slot(plan, token.id, end=(token.end[0] + 1, token.end[1]))


def widen_one_of_a_slot(plan: FlexiblePlan) -> FlexiblePlan:
    token = plan.token(slot_of(plan, hosts(plan, "Attitude.turn")[0].id)[1])
    return with_token(plan, token.id, end=(token.end[0], None))


def beyond_the_declared_duration(plan: FlexiblePlan) -> FlexiblePlan:
    return with_slot(plan, hosts(plan, "Camera.ready")[0].id, duration=(0, None))


def remove_an_order(plan: FlexiblePlan) -> FlexiblePlan:
    """Without the constraint between the first two sessions or images only their own order is lost."""
    camera = next(t for t in plan.timelines if (t.object, t.attribute) == ("attitude", "mode"))
    first, second = f"{camera.slots[0][0]}.end", f"{camera.slots[1][0]}.start"
    kept = tuple(c for c in plan.constraints if {c.from_, c.to} != {first, second})
    assert len(kept) < len(plan.constraints)
    return replace(plan, constraints=kept)


def overlap_two_turns(plan: FlexiblePlan) -> FlexiblePlan:
    """All that holds the second turn after the first one is taken away."""
    first, second = hosts(plan, "Attitude.turn")[:2]
    kept = tuple(c for c in plan.constraints if not {f"{second.id}.start", f"{second.id}.end"} & {c.from_, c.to})
    return replace(with_slot(plan, second.id, start=first.start, end=first.end), constraints=kept)


def impossible_times(plan: FlexiblePlan) -> FlexiblePlan:
    first, second = hosts(plan, "Attitude.turn")[:2]
    return replace(
        plan, constraints=(*plan.constraints, PlanConstraint(f"{second.id}.end", f"{first.id}.start", 1, None, "test"))
    )


def change_a_target(plan: FlexiblePlan) -> FlexiblePlan:
    token = hosts(plan, "Attitude.turn")[0]
    return with_slot(plan, token.id, parameters={**token.parameters, "target": "asteroid_b"})


def turn_in_place(plan: FlexiblePlan) -> FlexiblePlan:
    token = hosts(plan, "Attitude.turn")[0]
    return with_slot(plan, token.id, parameters={**token.parameters, "target": token.parameters["origin"]})


def unknown_target(plan: FlexiblePlan) -> FlexiblePlan:
    token = hosts(plan, "Attitude.turn")[0]
    return with_slot(plan, token.id, parameters={**token.parameters, "target": "pluto"})


def undecided_target(plan: FlexiblePlan) -> FlexiblePlan:
    token = hosts(plan, "Attitude.turn")[0]
    return with_slot(plan, token.id, parameters={**token.parameters, "target": ("earth", "asteroid_a")})


def missing_parameter(plan: FlexiblePlan) -> FlexiblePlan:
    return with_slot(plan, hosts(plan, "Attitude.turn")[0].id, parameters={"target": "earth"})


def unknown_predicate(plan: FlexiblePlan) -> FlexiblePlan:
    return with_slot(plan, hosts(plan, "Attitude.turn")[0].id, predicate="Attitude.tumble")


def unknown_object(plan: FlexiblePlan) -> FlexiblePlan:
    return with_slot(plan, hosts(plan, "Attitude.turn")[0].id, object="hull")


def less_power_for_the_engine(plan: FlexiblePlan) -> FlexiblePlan:
    thrust = hosts(plan, "Engine.thrust")[0]
    used = next(t for t in plan.tokens if t.predicate == "Reusable.uses" and t.master in slot_of(plan, thrust.id))
    return with_token(plan, used.id, parameters={"quantity": 100.0})


def too_much_power(plan: FlexiblePlan) -> FlexiblePlan:
    """One more use of all the power there is, at a time of the executive's choosing: nothing orders it."""
    extra = PlanToken(
        "extra",
        "power",
        "level",
        "Reusable.uses",
        {"quantity": 2100.0},
        (0, None),
        (1, None),
        (1, None),
        master=hosts(plan, "Camera.warmUp")[0].id,
    )
    return replace(plan, tokens=(*plan.tokens, extra))


def more_than_there_is(plan: FlexiblePlan) -> FlexiblePlan:
    used = next(t for t in plan.tokens if t.predicate == "Reusable.uses")
    return with_token(plan, used.id, parameters={"quantity": 2101.0})


def shorten_nature(plan: FlexiblePlan) -> FlexiblePlan:
    return with_slot(plan, hosts(plan, "Camera.warmUp")[0].id, duration=(600, 900))


def deny_nature(plan: FlexiblePlan) -> FlexiblePlan:
    return with_slot(plan, hosts(plan, "Camera.warmUp")[0].id, contingent=False)


def invoke_nature(plan: FlexiblePlan) -> FlexiblePlan:
    return with_slot(plan, hosts(plan, "Camera.ready")[0].id, contingent=True, duration=(1, 10))


def constrain_nature(plan: FlexiblePlan) -> FlexiblePlan:
    token = hosts(plan, "Camera.warmUp")[0]
    narrow = PlanConstraint(f"{token.id}.end", f"{token.id}.start", -700, None, "test")
    return replace(plan, constraints=(*plan.constraints, narrow))


def another_horizon(plan: FlexiblePlan) -> FlexiblePlan:
    return replace(plan, horizon=(0, 13 * HOUR))


def break_the_camera(plan: FlexiblePlan) -> FlexiblePlan:
    return with_slot(plan, hosts(plan, "Camera.switchedOn")[0].id, predicate="Camera.stuckOn")


def point_elsewhere(plan: FlexiblePlan) -> FlexiblePlan:
    """The images' constraint that they lie within the pointing is taken away."""
    image = hosts(plan, "Camera.takeImage")[0]
    session = next(t for t in plan.tokens if t.goal == "nav")
    near = {f"{t.id}.{w}" for t in [image, session] for w in ("start", "end")}
    attitude = {f"{t.id}.{w}" for t in plan.hosts() if t.object == "attitude" for w in ("start", "end")}
    kept = tuple(c for c in plan.constraints if not ({c.from_, c.to} & near and {c.from_, c.to} & attitude))
    return replace(plan, constraints=kept)


MUTATIONS: list[tuple[Callable[[FlexiblePlan], FlexiblePlan], str]] = [
    (drop_a_turn, "configuration"),
    (drop_an_image, "configuration"),
    (drop_a_state, "state"),
    (drop_a_goal, "goal"),
    (invent_a_fact, "state"),
    (take_out_of_its_slot, "structure"),
    (codesignate_strangers, "codesignation"),
    (swap_slots, "order"),
    (empty_slot, "structure"),
    (wrong_timeline, "structure"),
    (widen_a_bound, "bounds"),
    (tighten_a_bound, "bounds"),
    (widen_one_of_a_slot, "codesignation"),
    (beyond_the_declared_duration, "duration"),
    (remove_an_order, "order"),
    (remove_an_order, "configuration"),
    (overlap_two_turns, "order"),
    (impossible_times, "inconsistent"),
    (change_a_target, "configuration"),
    (turn_in_place, "configuration"),
    (unknown_target, "parameter"),
    (undecided_target, "parameter"),
    (missing_parameter, "parameter"),
    (unknown_predicate, "structure"),
    (unknown_object, "structure"),
    (less_power_for_the_engine, "configuration"),
    (too_much_power, "resource"),
    (more_than_there_is, "resource"),
    (shorten_nature, "contingent"),
    (deny_nature, "contingent"),
    (invoke_nature, "contingent"),
    (constrain_nature, "contingent"),
    (another_horizon, "horizon"),
    (break_the_camera, "exogenous"),
    (point_elsewhere, "configuration"),
]


@pytest.mark.parametrize(("mutate", "kind"), MUTATIONS, ids=lambda v: v if isinstance(v, str) else v.__name__)
def test_a_mutation_of_a_valid_plan_is_refused(mutate: Callable[[FlexiblePlan], FlexiblePlan], kind: str) -> None:
    model, problem, plan = ds1()
    violations = check(mutate(plan), model, problem)
    assert kind in kinds(violations), "\n".join(map(str, violations))
    for violation in violations:
        assert violation.explanation
        # What tokens do wrong is told of them by name.
        assert violation.tokens or violation.kind in ("structure", "horizon", "goal", "state")
        assert not violation.tokens or any(token in violation.explanation for token in violation.tokens)


def test_each_host_of_the_ds1_plan_is_needed() -> None:
    """Leaving out any one slot between the first and the last of a timeline is noticed."""
    model, problem, plan = ds1()
    for timeline in plan.timelines:
        for slot in timeline.slots[:-1]:
            assert check(without(plan, *slot), model, problem), plan.token(slot[0])


def test_each_written_bound_matters() -> None:
    model, problem, plan = ds1()
    for host in plan.hosts():
        for which in ("start", "end"):
            lower, upper = getattr(host, which)
            wider = with_slot(plan, host.id, **{which: (lower - 1, upper)})
            assert kinds(check(wider, model, problem)) == {"bounds"} or host.start[0] == 0


def test_a_goal_may_be_listed_as_dropped() -> None:
    model, problem, plan = ds1()
    more = replace(problem, goals=(*problem.goals, Goal("more", TokenPattern("Radio.downlink"))))
    assert kinds(check(plan, model, more)) == {"goal"}
    assert check(plan, model, more, dropped=["more"]) == ()


@pytest.mark.parametrize(
    "pattern",
    [
        TokenPattern("Navigation.session", parameters={"target": "asteroid_b"}),
        TokenPattern("Navigation.session", start=(11 * HOUR, None)),
        TokenPattern("Navigation.session", end=(None, 6 * HOUR)),
        TokenPattern("Navigation.session", duration=(100000, None)),
        TokenPattern("Navigation.session", object="radio"),
        TokenPattern("Radio.downlink"),
    ],
)
def test_a_goal_outside_its_pattern_is_refused(pattern: TokenPattern) -> None:
    model, problem, plan = ds1()
    goals = tuple(replace(g, token=pattern) if g.id == "nav" else g for g in problem.goals)
    assert kinds(check(plan, model, replace(problem, goals=goals))) == {"goal"}


# The paper's Figure 2, by hand.


@cache
def figure_2() -> ModelManager:
    model = ModelBuilder("figure 2", STANDARD)
    asteroid = model.enumeration("Asteroid", ["Gaspra", "Ida"])
    engine, camera, attitude = (model.timeline(name) for name in ("Engine", "Camera", "Attitude"))
    off = engine.predicate("off")
    ready = camera.predicate("ready")
    picture = camera.predicate("picture", {"asteroid": asteroid})
    point_at = attitude.predicate("pointAt", {"asteroid": asteroid})
    for name in ("Engine", "Camera", "Attitude"):
        model.object(name.lower(), name)
    with picture.requires() as this:
        this.contained_by(off)
        this.contained_by(point_at, asteroid=this.asteroid)
        this.before(ready, bounds=(0, 0))
        this.after(ready, bounds=(0, 0))
    return model.finish()


def picture_plan(target: str = "Ida", within: tuple[int | None, int | None] = (0, None)) -> FlexiblePlan:
    """A picture between 20 and 40 of a horizon of 100, ready before and after, engine off, pointing from 10 to 50."""

    def token(i: str, thing: str, name: str, start: tuple[int, int], end: tuple[int, int], **values: str) -> PlanToken:
        return PlanToken(i, thing, "state", name, values, start, end, (1, None))

    tokens = (
        token("off", "engine", "Engine.off", (0, 0), (100, 100)),
        token("point", "attitude", "Attitude.pointAt", (10, 10), (50, 50), asteroid=target),
        token("before", "camera", "Camera.ready", (0, 0), (20, 39)),
        token("picture", "camera", "Camera.picture", (20, 39), (21, 40), asteroid="Ida"),
        token("after", "camera", "Camera.ready", (21, 40), (100, 100)),
    )
    constraints = (
        PlanConstraint("before.end", "picture.start", 0, 0, "after [0 0]"),
        PlanConstraint("picture.end", "after.start", 0, 0, "before [0 0]"),
        PlanConstraint("picture.end", "point.end", *within, "contained by pointAt"),
    )
    timelines = (
        PlanTimeline("engine", "state", (("off",),)),
        PlanTimeline("camera", "state", (("before",), ("picture",), ("after",))),
        PlanTimeline("attitude", "state", (("point",),)),
    )
    return FlexiblePlan("figure 2", (0, 100), ("engine", "camera", "attitude"), timelines, tokens, constraints)


def test_figure_2_by_hand() -> None:
    assert check(picture_plan(), figure_2()) == ()


def test_figure_2_pointing_elsewhere() -> None:
    violations = check(picture_plan("Gaspra"), figure_2())
    assert [v.kind for v in violations] == ["configuration"]
    assert violations[0].tokens == ("picture",)
    assert "{Gaspra}" in violations[0].explanation
    assert "{Ida}" in violations[0].explanation


def test_figure_2_a_gap_before_ready() -> None:
    plan = picture_plan()
    loose = replace(plan.constraints[1], max=None)
    loose_plan = replace(plan, constraints=(plan.constraints[0], loose, plan.constraints[2]))
    loose_plan = with_token(loose_plan, "after", start=(21, 99))
    assert kinds(check(loose_plan, figure_2())) == {"configuration"}


def test_a_relation_must_hold_in_every_schedule() -> None:
    """The picture may, but need not, lie within the pointing."""
    plan = picture_plan()
    shorter = with_token(plan, "point", end=(30, 30))
    free = replace(shorter, constraints=plan.constraints[:2])
    assert kinds(check(free, figure_2())) == {"configuration"}


@pytest.mark.parametrize(("ends_at", "accepted"), [(100, True), (99, False)])
def test_what_may_lie_outside_the_horizon_is_not_required(ends_at: int, accepted: bool) -> None:
    """The ready after a picture is required only if the picture must end before the horizon does."""
    plan = without(picture_plan(), "after")
    plan = replace(plan, constraints=plan.constraints[:1])
    plan = with_token(plan, "picture", end=(21, ends_at))
    plan = with_token(plan, "point", end=(100, 100))
    assert (check(plan, figure_2()) == ()) == accepted


# Relations over times that a plan leaves open.


def two_spans(second: tuple[int, int], tied: bool) -> tuple[ModelManager, FlexiblePlan]:
    """Two spans side by side that have to last equally long; tied to each other, they do."""
    model = ModelBuilder("spans", STANDARD)
    left, right = model.timeline("Left"), model.timeline("Right")
    a, b = left.predicate("span"), right.predicate("span")
    for name in ("Left", "Right"):
        model.object(name.lower(), name)
    with a.requires() as this:
        other = this.relation("starts", b)
        this.require(this.duration == other.duration)
    tokens = (
        PlanToken("a", "left", "state", "Left.span", {}, (5, 5), (6, 14), (1, 9)),
        PlanToken("b", "right", "state", "Right.span", {}, (5, 5), (5 + second[0], 5 + second[1]), second),
    )
    timelines = (PlanTimeline("left", "state", (("a",),)), PlanTimeline("right", "state", (("b",),)))
    ties = (PlanConstraint("a.end", "b.end", 0, 0, "tie"),) if tied else ()
    return model.finish(), FlexiblePlan("spans", (0, 100), ("left", "right"), timelines, tokens, ties)


@pytest.mark.parametrize(
    ("second", "tied", "accepted"), [((1, 9), True, True), ((1, 9), False, False), ((2, 9), False, False)]
)
def test_a_relation_between_open_durations_must_hold_in_every_schedule(
    second: tuple[int, int], tied: bool, accepted: bool
) -> None:
    model, plan = two_spans(second, tied)
    assert (check(plan, model) == ()) == accepted


# Nature's choice depends on what a token does, and on nothing else in the plan.


@pytest.mark.parametrize(("duration", "accepted"), [((320, 840), True), ((320, 900), False), ((330, 840), False)])
def test_a_contingent_duration_is_what_the_domain_declares_for_these_parameters(
    duration: tuple[int, int], accepted: bool
) -> None:
    model = ModelBuilder("turns", STANDARD)
    speed = model.enumeration("Slowness", [32, 84])
    body = model.timeline("Body")
    turn = body.predicate("turn", {"slowness": speed}, duration=(300, 900), contingent=True)
    model.object("body", "Body")
    with turn.requires() as this:
        this.constrain("leq", this.duration, this.slowness * 10)
        with this.when(this.slowness == 84) as slow:
            slow.constrain("leq", 320, this.duration)
        with this.when(this.slowness == 32) as fast:
            fast.constrain("leq", this.duration, 310)
    token = PlanToken("t", "body", "state", "Body.turn", {"slowness": 84}, (0, 0), duration, duration, contingent=True)
    timelines = (PlanTimeline("body", "state", (("t",),)),)
    plan = FlexiblePlan("turns", (0, 1000), ("body",), timelines, (replace(token, goal="g"),), ())
    assert ("contingent" in kinds(check(plan, model.finish()))) != accepted


def test_what_is_under_way_lasts_as_long_as_the_problem_says() -> None:
    model = ModelBuilder("remainder", STANDARD)
    model.timeline("Body").predicate("turn", duration=(300, 900), contingent=True)
    model.object("body", "Body")
    manager = model.finish()
    token = PlanToken("t", "body", "state", "Body.turn", {}, (-100, -100), (240, 320), (340, 420), contingent=True)
    timelines = (PlanTimeline("body", "state", (("t",),)),)
    plan = FlexiblePlan("remainder", (0, 1000), ("body",), timelines, (token,), ())
    stated = TokenPattern("Body.turn", start=(-100, -100), duration=(340, 420))
    assert check(plan, manager, Problem((0, 1000), (stated,))) == ()
    longer = replace(stated, duration=(340, 430))
    assert kinds(check(plan, manager, Problem((0, 1000), (longer,)))) == {"contingent"}
