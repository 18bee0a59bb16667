"""Planning: the paper's examples, what goals, facts and states mean, goals that are dropped and why."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

import pytest

from planner.constraints.standard import STANDARD
from planner.domains import Interval
from planner.errors import ModelError, ProblemError
from planner.language.builder import ModelBuilder
from planner.model.manager import ModelManager
from planner.plan import FlexiblePlan, PlanConstraint, PlanToken
from planner.planning import plan
from planner.problem import Goal, PlanningResult, Problem, TokenPattern
from planner.search.outcome import Limits
from tests.planner.domains_small import camera_model, rover_model


@dataclass(frozen=True)
class NotGood:
    """A complaint that does not say what is to blame."""

    text: str
    tokens: tuple[str, ...] = ()
    constraints: tuple[PlanConstraint, ...] = ()


def solved(result: PlanningResult) -> FlexiblePlan:
    assert result.plan is not None, result.reason
    assert not result.dropped, result.dropped
    return result.plan


def only(plan: FlexiblePlan, predicate: str) -> PlanToken:
    (found,) = (t for t in plan.hosts() if t.predicate == predicate)
    return found


def tied(plan: FlexiblePlan, from_: str, to: str) -> bool:
    """Whether the plan ties two timepoints at distance 0."""
    return any({c.from_, c.to} == {from_, to} and (c.min, c.max) == (0, 0) for c in plan.constraints)


# The paper's examples


def picture_of(asteroid: str, priority: int = 0, **times: tuple[int | None, int | None]) -> Goal:
    return Goal(asteroid, TokenPattern("Camera.picture", parameters={"asteroid": asteroid}, **times), priority)


def test_figure_2_a_picture_and_what_it_needs() -> None:
    found = solved(plan(camera_model(), Problem((0, 100), goals=(picture_of("Ida", start=(20, 30)),))))
    picture, off, point = (only(found, p) for p in ("Camera.picture", "Engine.off", "Attitude.pointAt"))
    assert point.parameters == {"asteroid": "Ida"}
    before, after = (t for t in found.hosts() if t.predicate == "Camera.ready")
    camera = next(line for line in found.timelines if line.object == "camera")
    assert [slot[0] for slot in camera.slots] == [before.id, picture.id, after.id]
    assert tied(found, f"{before.id}.end", f"{picture.id}.start")
    assert tied(found, f"{picture.id}.end", f"{after.id}.start")
    for holder in (off, point):
        pairs = {(c.from_, c.to, c.min, c.max) for c in found.constraints}
        assert (f"{holder.id}.start", f"{picture.id}.start", 0, None) in pairs
        assert (f"{picture.id}.end", f"{holder.id}.end", 0, None) in pairs
    # Who required what: the picture, all of it.
    assert set(found.supported_by(picture.id)) == {before.id, after.id, off.id, point.id}
    assert found.supports(off.id) == found.supports(before.id) == (picture.id,)
    assert found.supports(picture.id) == found.supported_by(off.id) == ()
    assert picture.start == (20, 30)
    assert picture.duration == (3, 6)


def test_figure_1_activities_of_engine_camera_and_attitude() -> None:
    """The engine thrusts, then is off while the attitude turns, points, and the camera takes its pictures."""
    state = (
        TokenPattern("Engine.thrust", end=(10, 40)),
        TokenPattern("Attitude.pointAt", parameters={"asteroid": "Gaspra"}),
    )
    goals = (picture_of("Gaspra"), picture_of("Ida"))
    found = solved(plan(camera_model(), Problem((0, 120), state=state, goals=goals)))
    engine, camera, attitude = (
        [found.token(slot[0]).predicate.split(".")[1] for slot in line.slots] for line in found.timelines
    )
    assert engine[0] == "thrust"
    assert set(engine[1:]) == {"off"}
    assert camera.count("picture") == 2
    assert attitude.count("pointAt") >= 2
    thrust = only(found, "Engine.thrust")
    assert all(t.start[0] is not None and t.start[0] >= 10 for t in found.hosts() if t.predicate == "Camera.picture")
    assert thrust.end == (10, 40)


def test_before_10_20() -> None:
    builder = ModelBuilder("distance", STANDARD)
    one, two = builder.timeline("One"), builder.timeline("Two")
    later = two.predicate("later", duration=(2, 2))
    with one.predicate("first", duration=(3, 3)).requires() as this:
        this.before(later, bounds=(10, 20))
    builder.object("one", "One")
    builder.object("two", "Two")
    goal = Goal("g", TokenPattern("One.first", start=(4, 4)))
    found = solved(plan(builder.finish(), Problem((0, 100), goals=(goal,))))
    assert only(found, "Two.later").start == (17, 27)


def recorder(maximum: int) -> ModelManager:
    """The paper's data recorder: record(s, r, d, e) with s + r * d = e."""
    builder = ModelBuilder("recorder", STANDARD)
    amount, rate = Interval(0, maximum), Interval(1, 5)
    line = builder.timeline("Recorder")
    record = line.predicate("record", {"s": amount, "r": rate, "d": Interval(1, 50), "e": amount}, duration=(1, 50))
    with record.parameters_satisfy() as this:
        this.require(this.s + this.r * this.d == this.e)
        this.require(this.d == this.duration)
    builder.object("recorder", "Recorder")
    return builder.finish()


def test_the_recorder_predicate() -> None:
    parameters = {"s": 4, "e": 34}
    goal = Goal("g", TokenPattern("Recorder.record", parameters=parameters, duration=(None, 9)))
    token = only(solved(plan(recorder(100), Problem((0, 60), goals=(goal,)))), "Recorder.record")
    s, r, d, e = (token.parameters[name] for name in "srde")
    assert isinstance(s, int)
    assert isinstance(r, int)
    assert isinstance(d, int)
    assert s + r * d == e
    assert d <= 9
    assert token.duration == (d, d)


def test_a_recording_that_cannot_be() -> None:
    # 4 + r * d = 35 with r <= 5 and d <= 5 has no solution: 31 is prime.
    goal = Goal("g", TokenPattern("Recorder.record", parameters={"s": 4, "e": 35}, duration=(None, 5)))
    result = plan(recorder(100), Problem((0, 60), goals=(goal,)))
    assert [(d.id, d.kind) for d in result.dropped] == [("g", "unreachable")]


# Goals


def test_goals_that_cannot_both_be_are_dropped_by_priority() -> None:
    goals = (picture_of("Gaspra", 1, start=(20, 21), end=(23, 25)), picture_of("Ida", 2, start=(19, 22)))
    result = plan(camera_model(), Problem((0, 60), goals=goals))
    (dropped,) = result.dropped
    assert (dropped.id, dropped.kind) == ("Gaspra", "outbid")
    assert "not beside Ida" in dropped.reason
    assert result.plan is not None
    assert {t.goal for t in result.plan.tokens} == {None, "Ida"}


def test_a_goal_that_cannot_be_even_alone_is_unreachable() -> None:
    state = (TokenPattern("Engine.thrust", end=(30, 30)),)
    goals = (picture_of("Gaspra", 5, end=(None, 30)), picture_of("Ida"))
    result = plan(camera_model(), Problem((0, 80), state=state, goals=goals))
    (dropped,) = result.dropped
    assert (dropped.id, dropped.kind) == ("Gaspra", "unreachable")
    assert "no plan exists" in dropped.reason
    assert result.plan is not None
    assert {t.goal for t in result.plan.tokens} == {None, "Ida"}


def test_a_goal_that_the_limits_cut_off_is_undecided() -> None:
    result = plan(camera_model(), Problem((0, 80), goals=(picture_of("Ida"),)), Limits(max_steps=2))
    (dropped,) = result.dropped
    assert (dropped.id, dropped.kind) == ("Ida", "undecided")
    assert "no plan found in 2 steps" in dropped.reason


def test_goals_lie_inside_the_horizon() -> None:
    found = solved(plan(camera_model(), Problem((10, 40), goals=(picture_of("Ida"),))))
    picture = only(found, "Camera.picture")
    assert picture.start[0] == 10
    assert picture.end[1] == 40
    result = plan(camera_model(), Problem((10, 40), goals=(picture_of("Ida", start=(38, 50)),)))
    assert [d.kind for d in result.dropped] == ["unreachable"]


def test_what_may_lie_outside_the_horizon_stays_out_of_the_plan() -> None:
    # The picture may fill the horizon to its ends, so neither neighbour has to be inside.
    goal = picture_of("Ida", start=(0, 0), end=(6, 6))
    found = solved(plan(camera_model(), Problem((0, 6), goals=(goal,))))
    assert {t.predicate for t in found.tokens} == {"Camera.picture", "Engine.off", "Attitude.pointAt"}
    inside = solved(plan(camera_model(), Problem((-2, 8), goals=(goal,))))
    assert [t.predicate for t in inside.tokens].count("Camera.ready") == 2


def test_an_acceptance_that_refuses_all_plans() -> None:
    seen: list[FlexiblePlan] = []

    def never(found: FlexiblePlan) -> NotGood:
        seen.append(found)
        return NotGood("never good")

    result = plan(camera_model(), Problem((0, 40)), accept=never)
    assert result.plan is None
    assert result.reason is not None
    assert result.reason.startswith("no plan exists")
    assert "never good" in result.reason
    assert len(seen) == 1


def test_an_acceptance_that_wants_another_plan() -> None:
    def ida_second(found: FlexiblePlan) -> NotGood | None:
        order = [t.goal for t in found.hosts() if t.predicate == "Camera.picture"]
        return None if order == ["Gaspra", "Ida"] else NotGood("Ida is first")

    goals = (picture_of("Ida"), picture_of("Gaspra"))
    found = solved(plan(camera_model(), Problem((0, 90), goals=goals), accept=ida_second))
    assert ida_second(found) is None


# What is given


def test_a_fact_seeks_no_support_and_a_state_does() -> None:
    pattern = TokenPattern("Camera.picture", parameters={"asteroid": "Ida"}, start=(5, 5))
    fact = solved(plan(camera_model(), Problem((0, 40), facts=(pattern,))))
    assert [(t.predicate, t.fact) for t in fact.tokens] == [("Camera.picture", True)]
    state = solved(plan(camera_model(), Problem((0, 40), state=(pattern,))))
    assert {t.predicate for t in state.tokens} >= {"Camera.picture", "Camera.ready", "Engine.off", "Attitude.pointAt"}


def test_a_goal_may_be_a_fact() -> None:
    fact = TokenPattern("Camera.picture", parameters={"asteroid": "Ida"}, start=(5, 5))
    found = solved(plan(camera_model(), Problem((0, 40), facts=(fact,), goals=(picture_of("Ida", end=(None, 9)),))))
    assert len(found.tokens) == 2
    ((slot,),) = (line.slots for line in found.timelines if line.slots)
    assert [found.token(i).goal for i in slot] == [None, "Ida"]


def test_a_state_begins_with_the_horizon() -> None:
    found = solved(plan(camera_model(), Problem((7, 40), state=(TokenPattern("Engine.off"),))))
    assert only(found, "Engine.off").start == (7, 7)
    earlier = solved(plan(camera_model(), Problem((7, 40), state=(TokenPattern("Engine.off", start=(-5, 2)),))))
    assert only(earlier, "Engine.off").start == (-5, 2)


SUN = TokenPattern("Light.sun", start=(30, 30), end=(50, 60))
DEEP = TokenPattern("Rover.sample", "rover1", {"site": "base", "deep": True}, start=(5, None))


def test_exogenous_tokens_are_hosted_by_what_is_given() -> None:
    problem = Problem((0, 80), facts=(SUN,), goals=(Goal("deep", DEEP),))
    found = solved(plan(rover_model(), problem))
    sample = next(t for t in found.tokens if t.goal == "deep")
    host = only(found, "Light.sun" if "Light.sun" in {t.predicate for t in found.hosts()} else "Light.lamp")
    assert host.predicate in ("Light.sun", "Light.lamp")
    assert sample.duration == (2, 3)


def test_exogenous_goals_need_a_fact() -> None:
    goal = Goal("sun", TokenPattern("Light.sun", start=(20, 40)))
    assert [d.kind for d in plan(rover_model(), Problem((0, 80), goals=(goal,))).dropped] == ["unreachable"]
    assert solved(plan(rover_model(), Problem((0, 80), facts=(SUN,), goals=(goal,))))


def test_an_undecided_fact_still_hosts() -> None:
    """A fact that may lie in several slots is placed before the goal that needs it looks for a host."""
    facts = (SUN, TokenPattern("Light.sun", start=(0, 70), duration=(3, 5)))
    goals = (
        Goal("one", TokenPattern("Light.sun", start=(30, 30))),
        Goal("two", TokenPattern("Light.sun", end=(0, 29))),
    )
    assert solved(plan(rover_model(), Problem((0, 80), facts=facts, goals=goals)))


# Errors and repetition


@pytest.mark.parametrize(
    ("pattern", "message"),
    [
        (TokenPattern("Camera.pictur"), "goal: class Camera has no predicate named 'pictur'; did you mean picture"),
        (TokenPattern("Camra.picture"), "goal: there is no class named 'Camra'; did you mean Camera"),
        (TokenPattern("picture"), "goal: expected a predicate as Class.predicate, found 'picture'"),
        (TokenPattern("Camera.picture", "camra"), "goal: there is no object named 'camra'; did you mean camera"),
        (TokenPattern("Camera.picture", "engine"), "goal: object engine has no predicate Camera.picture"),
        (TokenPattern("Camera.picture", parameters={"asteriod": "Ida"}), "no parameter 'asteriod'; did you mean aster"),
        (TokenPattern("Camera.picture", parameters={"asteroid": "Ide"}), "goal.asteroid: 'Ide' is not one of .* Ida"),
        (TokenPattern("Camera.picture", start=(5, 3)), r"goal.start: the bounds \[5 3\] are empty"),
    ],
)
def test_problems_that_mean_nothing(pattern: TokenPattern, message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        plan(camera_model(), Problem((0, 40), goals=(Goal("goal", pattern),)))


def test_a_horizon_and_goals_are_checked() -> None:
    with pytest.raises(ProblemError, match=r"horizon: expected a start before the end, found \[5 5\]"):
        plan(camera_model(), Problem((5, 5)))
    with pytest.raises(ProblemError, match="goals: identifiers repeat"):
        plan(camera_model(), Problem((0, 5), goals=(picture_of("Ida"), picture_of("Ida"))))


def test_a_model_must_be_closed() -> None:
    builder = ModelBuilder("open", STANDARD)
    with pytest.raises(ModelError, match="model open: expected to be closed"):
        plan(builder.manager, Problem((0, 5)))


def test_a_set_of_allowed_numbers_admits_nothing_between() -> None:
    parameters: dict[str, object] = {"s": 0, "r": 1, "e": (3, 9)}
    pattern = TokenPattern("Recorder.record", parameters=parameters, duration=(4, 50))  # type: ignore[arg-type]
    found = solved(plan(recorder(100), Problem((0, 60), goals=(Goal("g", pattern),))))
    assert only(found, "Recorder.record").parameters["e"] == 9


def test_the_same_problem_gives_the_same_plan_byte_for_byte() -> None:
    goals = (picture_of("Gaspra"), picture_of("Ida", start=(20, 60)))
    problem = Problem((0, 200), state=(TokenPattern("Engine.thrust"),), goals=goals)
    texts = {json.dumps(solved(plan(camera_model(), problem)).to_json()) for _ in range(3)}
    assert len(texts) == 1


def test_statistics_count_the_work_of_every_attempt() -> None:
    goals = (picture_of("Gaspra", 1, start=(20, 21), end=(23, 25)), picture_of("Ida", 2, start=(19, 22)))
    one = plan(camera_model(), Problem((0, 60), goals=goals[1:])).statistics
    both = plan(camera_model(), Problem((0, 60), goals=goals)).statistics
    assert both.steps > one.steps > 0
    assert both.backtracks > one.backtracks
    assert both.solve_seconds < math.inf
