"""Plans that follow one another without standby: the next horizon, and goals that come in while a plan executes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from executive.bindings import Activity, Bindings
from executive.conditions import Telemetry
from executive.errors import ExecutiveError
from executive.executive import Executive
from executive.history import History
from executive.port import Acknowledgement, Observation
from executive.protection import Response
from executive.records import Settings
from executive.replay import replay_history
from executive.sends import Confirmation, Send
from planner.plan import Bounds, PlanConstraint, PlanTimeline, PlanToken
from planner.problem import DroppedGoal, Goal, Planner, PlanningResult, Problem, TokenPattern
from tests.executive.scripted import (
    AT_START,
    DEAD,
    STUCK,
    TUMBLES,
    Reaction,
    Run,
    ScriptedPlant,
    bindings,
    fly,
    goals,
    image,
    layout,
    planner,
    reactions,
    state,
    transcript,
    turn,
)

ASKING = TokenPattern("Planner.planNext", "planner")
PLAIN = Settings("scripted", 1, budget=5, retry_delay=10)
STAGED = replace(PLAIN, waypoints=(60,), plan_next=ASKING)


def with_planner(telemetry: Telemetry, conclusions: frozenset[str]) -> tuple[TokenPattern, ...]:
    return (*state(telemetry, conclusions), TokenPattern("Planner.idle", "planner"))


def bound() -> Bindings:
    return replace(bindings(TUMBLES), state=with_planner)


def in_window(name: str, opens: int, closes: int) -> Goal:
    pattern = TokenPattern("Camera.imaging", "camera", start=(opens, None), end=(None, closes))
    return Goal(f"image-{name}", pattern, priority=1)


BOTH = (in_window("vesta", 0, 60), in_window("ceres", 60, 120))


def brings(goal: Goal, at: int) -> Callable[[Executive], None]:
    def step(executive: Executive) -> None:
        executive.run_until(at - 1)
        executive.add_goal(goal)
        executive.run_until(10_000)

    return step


def check_replay(run: Run, bindings: Bindings) -> None:
    result = replay_history(History.of(run.text.encode()), bindings)
    assert result.identical, result.first_difference


# -- the next horizon --------------------------------------------------------------------------------------------------


def test_two_horizons_joined() -> None:
    run = fly(ScriptedPlant(AT_START, reactions()), bound(), wanted=BOTH, settings=STAGED)
    check_replay(run, bound())
    assert (
        transcript(run, 6)
        == """\
  6 plan.adopted handover=6 plan=plan-01 reason=initial tokens=9
  6 standby.left
  6 token.started t1 Attitude.holding(earth)
  6 token.started t2 Camera.idle()
  6 token.started t3 Planner.idle()
  6 token.finished t1 Attitude.holding(earth) on_time
  6 token.finished t3 Planner.idle() on_time
  6 token.started t7 Attitude.turning(vesta)
  6 command.sent arguments={target: vesta} id=2 name=acs.turn token=t7
  6 token.started t4 Planner.planNext()
  6 plan.requested attempt=1 budget=5 handover=60 reason=next horizon from 60 s
  7 token.confirmed t7 Attitude.turning(vesta)
 11 token.finished t4 Planner.planNext() on_time
 11 token.started t5 Planner.idle()
 16 token.finished t7 Attitude.turning(vesta) on_time
 16 token.finished t2 Camera.idle() on_time
 16 token.started t6 Camera.imaging(vesta)
 16 command.sent arguments={target: vesta} id=3 name=camera.image token=t6
 16 token.started t8 Attitude.holding(vesta)
 17 token.confirmed t6 Camera.imaging(vesta)
 20 command.sent arguments={} id=4 name=camera.close token=t6
 20 token.started t9 Camera.idle()
 21 token.finished t6 Camera.imaging(vesta) on_time
 21 goal id=image-vesta reason=None status=achieved
 60 plan.adopted handover=60 plan=plan-02 reason=next horizon from 60 s tokens=7
 60 token.started t1 Attitude.holding(vesta)
 60 token.started t2 Camera.idle()
 60 token.started t3 Planner.idle()
 60 token.finished t1 Attitude.holding(vesta) on_time
 60 token.started t5 Attitude.turning(ceres)
 60 command.sent arguments={target: ceres} id=5 name=acs.turn token=t5
 61 token.confirmed t5 Attitude.turning(ceres)
 70 token.finished t5 Attitude.turning(ceres) on_time
 70 token.finished t2 Camera.idle() on_time
 70 token.started t4 Camera.imaging(ceres)
 70 command.sent arguments={target: ceres} id=6 name=camera.image token=t4
 70 token.started t6 Attitude.holding(ceres)
 71 token.confirmed t4 Camera.imaging(ceres)
 74 command.sent arguments={} id=7 name=camera.close token=t4
 74 token.started t7 Camera.idle()
 75 token.finished t4 Camera.imaging(ceres) on_time
 75 goal id=image-ceres reason=None status=achieved
120 run.finished outcome=completed
"""
    )


def test_the_next_plan_is_late() -> None:
    """The planner would take 70 s: at the waypoint nothing is there, and standby follows."""
    late = replace(STAGED, deliberation=lambda result: 70 if result.plan and result.plan.horizon[0] == 60 else 3)
    run = fly(ScriptedPlant(AT_START, reactions()), bound(), wanted=BOTH, settings=late)
    check_replay(run, bound())
    assert (
        transcript(run, 11)
        == """\
 11 token.finished t4 Planner.planNext() on_time
 11 token.started t5 Planner.idle()
 16 token.finished t7 Attitude.turning(vesta) on_time
 16 token.finished t2 Camera.idle() on_time
 16 token.started t6 Camera.imaging(vesta)
 16 command.sent arguments={target: vesta} id=3 name=camera.image token=t6
 16 token.started t8 Attitude.holding(vesta)
 17 token.confirmed t6 Camera.imaging(vesta)
 20 command.sent arguments={} id=4 name=camera.close token=t6
 20 token.started t9 Camera.idle()
 21 token.finished t6 Camera.imaging(vesta) on_time
 21 goal id=image-vesta reason=None status=achieved
 60 plan.failed reason=it is not there at the end of the horizon
 60 token.aborted t9 Camera.idle()
 60 token.aborted t8 Attitude.holding(vesta)
 60 token.aborted t5 Planner.idle()
 60 standby.entered reason=the plan's horizon is over and the next plan is not there
 60 command.sent arguments={} id=5 name=safe.standby token=standby
 62 plan.requested attempt=1 budget=5 reason=the plan's horizon is over and the next plan is not there
 67 plan.adopted handover=67 plan=plan-02 reason=the plan's horizon is over and the next plan is not there tokens=7
 67 standby.left
 67 token.started t1 Attitude.holding(earth)
 67 token.started t2 Camera.idle()
 67 token.started t3 Planner.idle()
 67 token.finished t1 Attitude.holding(earth) on_time
 67 token.started t5 Attitude.turning(ceres)
 67 command.sent arguments={target: ceres} id=6 name=acs.turn token=t5
 68 token.confirmed t5 Attitude.turning(ceres)
 77 token.finished t5 Attitude.turning(ceres) on_time
 77 token.finished t2 Camera.idle() on_time
 77 token.started t4 Camera.imaging(ceres)
 77 command.sent arguments={target: ceres} id=7 name=camera.image token=t4
 77 token.started t6 Attitude.holding(ceres)
 78 token.confirmed t4 Camera.imaging(ceres)
 81 command.sent arguments={} id=8 name=camera.close token=t4
 81 token.started t7 Camera.idle()
 82 token.finished t4 Camera.imaging(ceres) on_time
 82 goal id=image-ceres reason=None status=achieved
120 run.finished outcome=completed
"""
    )


def test_a_planner_that_fails_is_asked_again_before_the_waypoint() -> None:
    answers = [PlanningResult(None, reason="nothing found in 10 steps")]

    def moody(problem: Problem) -> PlanningResult:
        return answers.pop() if problem.horizon[0] == 60 and answers else planner(problem)

    run = fly(ScriptedPlant(AT_START, reactions()), bound(), moody, BOTH, settings=STAGED)
    failed = [(e["t"], e["reason"]) for e in run.told("plan.failed")]
    assert failed == [(11, "nothing found in 10 steps")]
    assert [e["t"] for e in run.told("plan.requested")] == [1, 6, 21]
    assert [p.handover for p in run.executive.plans] == [6, 60]
    assert run.executive.plans[1].attempts == 2
    assert run.executive.outcome == "completed"
    assert len(run.told("standby.entered")) == 1


def test_what_is_not_over_at_the_waypoint_spoils_the_next_plan() -> None:
    """The image was to be over by then and is not: the state planned for is not there, so standby."""
    slow = partial(layout, exposure=(3, 40))
    plant = ScriptedPlant(AT_START, reactions(turn=[turn(6)], image=[image(30, 1), image(4, 1), image(4, 2)]))
    settings = replace(STAGED, waypoints=(36,))
    run = fly(plant, bound(), lambda p: PlanningResult(slow(p)), (in_window("vesta", 0, 120),), settings=settings)
    assert [(e["t"], e["reason"]) for e in run.told("plan.failed")] == [
        (36, "the state at hand-over differs: expected Camera.idle (t9) to be running on camera.mode")
    ]
    assert [(p.handover, p.reason) for p in run.executive.plans][1] == (
        43,
        "the plan's horizon is over and the next plan is not there",
    )
    assert run.executive.outcome == "completed"


def test_what_runs_across_the_waypoint_is_not_foretold() -> None:
    """A plan whose last token is nature's to end: whether it is over at the waypoint nobody knows."""

    def open_end(problem: Problem) -> PlanningResult:
        plan = layout(problem)
        lines = tuple(
            replace(line, slots=line.slots[:-1]) if (line.object, problem.horizon[1]) == ("camera", 60) else line
            for line in plan.timelines
        )
        return PlanningResult(replace(plan, timelines=lines))

    run = fly(ScriptedPlant(AT_START, reactions()), bound(), open_end, BOTH, settings=STAGED)
    first = run.told("plan.failed")[0]
    assert (first["t"], first["reason"]) == (
        6,
        "the state at hand-over cannot be told: camera Camera.imaging (t6) may or may not be over at 60 s",
    )
    assert run.executive.outcome == "completed"


def test_a_violation_ends_the_search_for_the_next_plan() -> None:
    plant = ScriptedPlant(AT_START, reactions(), {9: {"acs.mode": "tumble"}})
    run = fly(plant, bound(), wanted=BOTH, settings=STAGED)
    assert [(e["t"], e["reason"]) for e in run.told("plan.failed")] == [
        (9, "the plan that it was to follow has been given up")
    ]
    assert [p.plan.horizon for p in run.executive.plans] == [(6, 60), (16, 60), (60, 120)]
    assert run.executive.outcome == "completed"


def test_what_was_concluded_since_spoils_the_next_plan() -> None:
    """A conclusion that does not cost the plan in execution still was not known to the planner."""
    quiet = (Response(DEAD.name, replan="next"),)
    with_quiet = replace(bindings(STUCK, responses=quiet), state=with_planner)
    plant = ScriptedPlant(AT_START, reactions(), {30: {"camera.state": "stuck"}})
    run = fly(plant, with_quiet, wanted=BOTH, settings=STAGED)
    reasons = [str(e["reason"]) for e in run.told("plan.failed")]
    assert reasons == ["what has been concluded since was not planned for"]
    assert [g.status for g in run.executive.goals] == ["achieved", "dropped"]
    assert "the camera is dead" in str(run.executive.goals[1].reason)


def test_goals_of_a_later_horizon_are_not_dropped_by_an_earlier_one() -> None:
    """A planner that cannot do it now says unreachable; that is final only when no horizon follows."""

    def unable(problem: Problem) -> PlanningResult:
        if problem.horizon[1] > 60:
            return planner(problem)
        mission = tuple(goal for goal in problem.goals if goal.token.predicate == "Camera.imaging")
        kept = tuple(goal for goal in problem.goals if goal not in mission)
        dropped = tuple(DroppedGoal(goal.id, "unreachable", "not yet") for goal in mission)
        return PlanningResult(layout(replace(problem, goals=kept)), dropped)

    wanted = (in_window("vesta", 0, 60), replace(goals("ceres")[0]))
    run = fly(ScriptedPlant(AT_START, reactions()), bound(), unable, wanted, settings=STAGED)
    assert [(g.status, g.reason) for g in run.executive.goals] == [
        ("dropped", "unreachable: not yet"),
        ("achieved", None),
    ]


def test_without_the_token_a_horizon_ends_in_standby() -> None:
    run = fly(ScriptedPlant(AT_START, reactions()), bound(), wanted=BOTH, settings=replace(STAGED, plan_next=None))
    assert [p.handover for p in run.executive.plans] == [6, 67]
    assert [e["t"] for e in run.told("standby.entered")] == [0, 60]
    assert run.executive.outcome == "completed"


def test_waypoints_are_checked() -> None:
    with pytest.raises(ExecutiveError, match=r"settings.waypoints: expected ascending seconds, found \[60, 60\]"):
        Settings(waypoints=(60, 60))


# -- a goal comes in ---------------------------------------------------------------------------------------------------


def test_a_goal_arrives_mid_plan() -> None:
    """The turn under way may last until 26 s; until then nothing new begins, then the new plan has both images."""
    run = fly(ScriptedPlant(AT_START, reactions()), wanted=goals("vesta"), step=brings(goals("ceres")[0], 12))
    check_replay(run, bindings())
    assert (
        transcript(run, 6)
        == """\
  6 plan.adopted handover=6 plan=plan-01 reason=initial tokens=6
  6 standby.left
  6 token.started t1 Attitude.holding(earth)
  6 token.started t2 Camera.idle()
  6 token.finished t1 Attitude.holding(earth) on_time
  6 token.started t4 Attitude.turning(vesta)
  6 command.sent arguments={target: vesta} id=2 name=acs.turn token=t4
  7 token.confirmed t4 Attitude.turning(vesta)
 12 goal.given id=image-ceres
 12 plan.requested attempt=1 budget=5 handover=26 reason=new goal: image-ceres
 16 token.finished t4 Attitude.turning(vesta) on_time
 16 token.started t5 Attitude.holding(vesta)
 26 plan.adopted handover=26 plan=plan-02 reason=new goal: image-ceres tokens=10
 26 token.started t1 Attitude.holding(vesta)
 26 token.started t2 Camera.idle()
 26 token.finished t1 Attitude.holding(vesta) on_time
 26 token.started t4 Attitude.turning(vesta)
 26 command.sent arguments={target: vesta} id=3 name=acs.turn token=t4
 27 token.confirmed t4 Attitude.turning(vesta)
 36 token.finished t4 Attitude.turning(vesta) on_time
 36 token.finished t2 Camera.idle() on_time
 36 token.started t3 Camera.imaging(vesta)
 36 command.sent arguments={target: vesta} id=4 name=camera.image token=t3
 36 token.started t5 Attitude.holding(vesta)
 37 token.confirmed t3 Camera.imaging(vesta)
 40 command.sent arguments={} id=5 name=camera.close token=t3
 40 token.finished t5 Attitude.holding(vesta) on_time
 40 token.started t6 Camera.idle()
 40 token.started t8 Attitude.turning(ceres)
 40 command.sent arguments={target: ceres} id=6 name=acs.turn token=t8
 41 token.finished t3 Camera.imaging(vesta) on_time
 41 token.confirmed t8 Attitude.turning(ceres)
 41 goal id=image-vesta reason=None status=achieved
 50 token.finished t8 Attitude.turning(ceres) on_time
 50 token.finished t6 Camera.idle() on_time
 50 token.started t7 Camera.imaging(ceres)
 50 command.sent arguments={target: ceres} id=7 name=camera.image token=t7
 50 token.started t9 Attitude.holding(ceres)
 51 token.confirmed t7 Camera.imaging(ceres)
 54 command.sent arguments={} id=8 name=camera.close token=t7
 54 token.started t10 Camera.idle()
 55 token.finished t7 Camera.imaging(ceres) on_time
 55 goal id=image-ceres reason=None status=achieved
120 run.finished outcome=completed
"""
    )


def test_what_is_running_goes_on_as_the_remainder() -> None:
    """The image takes 20 to 40 s; at the hand-over 8 s of it are gone, and it is neither stopped nor begun again."""
    slow = partial(layout, exposure=(20, 40))
    asked: list[Problem] = []

    def remember(problem: Problem) -> PlanningResult:
        asked.append(problem)
        return PlanningResult(slow(problem))

    table = reactions(image=[image(25, 1), image(25, 2)])
    plant = ScriptedPlant(AT_START, table)
    run = fly(plant, plan=remember, wanted=goals("vesta"), step=brings(goals("ceres")[0], 19))
    check_replay(run, bindings())
    running = asked[1].state[1]
    assert (running.predicate, running.start, running.end) == ("Camera.imaging", (16, 16), (25, None))
    assert (running.duration, running.contingent) == ((20, 40), True)
    assert asked[1].horizon == (24, 120)
    assert [goal.id for goal in asked[1].goals] == ["image-ceres"]
    assert [c.name for c in plant.sent] == [
        "safe.standby",
        *("acs.turn", "camera.image", "camera.close") * 2,
    ]
    assert [(g.id, g.status, g.time) for g in run.executive.goals] == [
        ("image-vesta", "achieved", 42),
        ("image-ceres", "achieved", run.executive.goals[1].time),
    ]
    assert not run.executive.dispatch.violations


def test_a_remainder_that_never_ends_is_caught_at_its_own_deadline() -> None:
    slow = partial(layout, exposure=(20, 40))
    table = reactions(image=[image(4000, 1), image(25, 2)])
    run = fly(
        ScriptedPlant(AT_START, table),
        plan=lambda problem: PlanningResult(slow(problem)),
        wanted=goals("vesta"),
        step=brings(goals("ceres")[0], 19),
    )
    assert next((e["t"], e["kind"]) for e in run.told("violation")) == (56, "late")
    assert [p.handover for p in run.executive.plans][:2] == [6, 24]


def test_what_has_ended_is_still_proven_after_the_hand_over() -> None:
    """The image is over, its close command is not acknowledged yet when the next plan joins: the goal still counts."""
    activities = tuple(
        replace(a, ended=Confirmation(within=20)) if a.predicate == "Camera.imaging" else a
        for a in bindings().activities
    )
    patient = replace(bindings(), activities=activities)

    class Slow(ScriptedPlant):
        """Acknowledges the closing of the camera 6 s late."""

        kept: tuple[int, tuple[Acknowledgement, ...]] = (-1, ())

        def advance(self, until: int) -> Observation:
            seen = super().advance(until)
            mine = tuple(a for a in seen.acknowledgements if a.command_id == self.closing())
            if mine:
                self.kept = (until + 6, mine)
                seen = replace(seen, acknowledgements=tuple(a for a in seen.acknowledgements if a not in mine))
            if self.kept[0] == until:
                seen = replace(seen, acknowledgements=(*seen.acknowledgements, *self.kept[1]))
            return seen

        def closing(self) -> int:
            return next((c.id for c in self.sent if c.name == "camera.close"), -1)

    run = fly(Slow(AT_START, reactions()), patient, wanted=goals("vesta"), step=brings(goals("ceres")[0], 17))
    remnants = [e for e in run.told("token.finished") if str(e["token"]).startswith("plan-01/")]
    assert [(e["t"], e["plan"], e["token"]) for e in remnants] == [(27, "plan-02", "plan-01/t3")]
    assert run.executive.goals[0].time == 27
    assert run.executive.outcome == "completed"


def test_a_goal_that_cannot_be_had_is_dropped_and_the_rest_goes_on() -> None:
    def unable(problem: Problem) -> PlanningResult:
        kept = tuple(goal for goal in problem.goals if goal.id != "image-ceres")
        dropped = tuple(DroppedGoal(g.id, "outbid", "no time") for g in problem.goals if g not in kept)
        return PlanningResult(layout(replace(problem, goals=kept)), dropped)

    run = fly(
        ScriptedPlant(AT_START, reactions()), plan=unable, wanted=goals("vesta"), step=brings(goals("ceres")[0], 12)
    )
    assert [(g.status, g.reason) for g in run.executive.goals] == [("achieved", None), ("dropped", "outbid: no time")]


@pytest.mark.parametrize(
    ("fails", "reason"),
    [
        (lambda problem: PlanningResult(None, reason="too much"), "too much"),
        (lambda problem: 1 / 0, "the planner raised ZeroDivisionError: division by zero"),
    ],
)
def test_a_planner_that_fails_leaves_the_plan_in_execution_alone(
    fails: Callable[[Problem], PlanningResult], reason: str
) -> None:
    def choosy(problem: Problem) -> PlanningResult:
        return fails(problem) if any(goal.id == "image-ceres" for goal in problem.goals) else planner(problem)

    run = fly(
        ScriptedPlant(AT_START, reactions()), plan=choosy, wanted=goals("vesta"), step=brings(goals("ceres")[0], 23)
    )
    assert [(e["t"], e["reason"]) for e in run.told("plan.failed")] == [(28, reason), (43, reason), (68, reason)]
    assert [g.status for g in run.executive.goals] == ["achieved", "missed"]
    assert len(run.told("standby.entered")) == 1
    check_replay(run, bindings())


def test_a_goal_that_arrives_in_standby_is_in_the_next_plan() -> None:
    for at, plans in ((0, 1), (1, 1), (3, 2)):
        run = fly(ScriptedPlant(AT_START, reactions()), wanted=goals("vesta"), step=brings(goals("ceres")[0], at))
        assert run.executive.outcome == "completed"
        assert len(run.executive.plans) == plans, at
        assert len(run.told("standby.entered")) == 1
        check_replay(run, bindings())


def test_a_known_goal_changes_nothing() -> None:
    run = fly(ScriptedPlant(AT_START, reactions()), wanted=goals("vesta"), step=brings(goals("vesta")[0], 12))
    assert len(run.executive.plans) == 1
    check_replay(run, bindings())


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    at=st.integers(0, 90),
    turns=st.lists(st.integers(5, 20), min_size=4, max_size=4),
    images=st.lists(st.integers(1, 20), min_size=4, max_size=4),
    exposure=st.sampled_from([(3, 40), (20, 40), (3, 22)]),
    budget=st.integers(1, 12),
)
def test_whenever_a_goal_arrives_nothing_is_violated(
    at: int, turns: list[int], images: list[int], exposure: Bounds, budget: int
) -> None:
    """Whatever nature does meanwhile: both images, no violation, no standby but the first, the same again in replay."""
    least, most = exposure
    assert least is not None
    assert most is not None
    taken = [min(most, max(least, seconds)) for seconds in images]
    table = reactions(turn=[turn(d) for d in turns], image=[image(d, n) for n, d in enumerate(taken, 1)])
    plan: Planner = lambda problem: PlanningResult(layout(problem, exposure=exposure))  # noqa: E731
    run = fly(
        ScriptedPlant(AT_START, table),
        plan=plan,
        wanted=goals("vesta"),
        horizon=(0, 300),
        settings=replace(PLAIN, budget=budget),
        step=brings(goals("ceres")[0], at),
    )
    assert not run.executive.dispatch.violations
    assert len(run.told("standby.entered")) == 1
    assert [g.status for g in run.executive.goals] == ["achieved", "achieved"]
    assert len([c for c in run.told("command.sent") if c["name"] == "camera.image"]) == 2
    check_replay(run, bindings())


# -- timelines with gaps, and what lasts to the end of a horizon -------------------------------------------------------

RADIO = ("radio", "mode")


def with_downlink(problem: Problem) -> PlanningResult:
    """The images, and one downlink on a timeline of its own that is empty before and after."""
    kept = tuple(goal for goal in problem.goals if goal.token.predicate != "Radio.downlink")
    state = tuple(pattern for pattern in problem.state if pattern.predicate != "Radio.downlink")
    plan = layout(replace(problem, goals=kept, state=state))
    given = [pattern for pattern in problem.state if pattern not in state]
    wanted = [goal for goal in problem.goals if goal not in kept]
    tokens, slots = list(plan.tokens), []
    if given:
        began = given[0].start[0]
        assert began is not None
        token = PlanToken("r0", *RADIO, "Radio.downlink", {}, (began, began), (problem.horizon[0], None), (8, 8))
        tokens, slots = [*tokens, token], [*slots, ("r0",)]
    for goal in wanted:
        token = PlanToken("r1", *RADIO, "Radio.downlink", {}, (30, None), (38, None), (8, 8), goal=goal.id)
        tokens, slots = [*tokens, token], [*slots, ("r1",)]
    lines = (*plan.timelines, PlanTimeline(*RADIO, tuple(slots)))
    return PlanningResult(replace(plan, tokens=tuple(tokens), timelines=lines))


@pytest.mark.parametrize("at", [8, 20, 27, 31, 45])
def test_a_timeline_may_be_empty_at_the_hand_over(at: int) -> None:
    """A goal comes in before, during and after the downlink, which happens once and takes its 8 s."""
    asked: list[Problem] = []

    def remember(problem: Problem) -> PlanningResult:
        asked.append(problem)
        return with_downlink(problem)

    wanted = (*goals("vesta"), Goal("downlink", TokenPattern("Radio.downlink")))
    run = fly(ScriptedPlant(AT_START, reactions()), plan=remember, wanted=wanted, step=brings(goals("ceres")[0], at))
    assert [g.status for g in run.executive.goals] == ["achieved"] * 3
    assert len(run.executive.plans) == 2
    assert len(run.told("standby.entered")) == 1
    running = [p for p in asked[1].state if p.predicate == "Radio.downlink"]
    assert [p.start for p in running] == ([(30, 30)] if at == 31 else [])
    downlink = next(g for g in run.executive.goals if g.id == "downlink")
    assert downlink.time is not None
    assert downlink.time == 38 if at >= 31 else downlink.time >= 38
    check_replay(run, bindings())


def test_what_must_be_followed_beyond_the_horizon_lasts_until_then() -> None:
    """The engine thrusts for a goal of 10 s; shutting it down lies beyond the waypoint. So it thrusts until then, and
    is stopped by its own stop command, since no plan goes on with it."""
    engine = Activity("Engine.thrusting", start=(Send("engine.on"),), stop=(Send("engine.off"),))
    plain = bound()
    thrusting = replace(plain, activities=(*plain.activities, engine))
    table = {**reactions(), "engine.on": [Reaction()], "engine.off": [Reaction()]}

    def thrust(problem: Problem) -> PlanningResult:
        if problem.horizon[1] > 60:
            return PlanningResult(layout(replace(problem, goals=())))
        plan = layout(replace(problem, goals=()))
        token = PlanToken("e1", "engine", "mode", "Engine.thrusting", {}, (10, 50), (20, 60), (10, None), goal="thrust")
        after = replace(token, id="e2", predicate="Engine.shuttingDown", goal=None, master="e1")
        lines = (*plan.timelines, PlanTimeline("engine", "mode", (("e1",),)))
        inside = PlanConstraint("origin", "e1.end", None, 60, "inside the horizon")
        constraints = (*plan.constraints, inside)
        tokens = (*plan.tokens, token)
        return PlanningResult(replace(plan, tokens=tokens, timelines=lines, constraints=constraints, boundary=(after,)))

    plant = ScriptedPlant(AT_START, table)
    wanted = (Goal("thrust", TokenPattern("Engine.thrusting")),)
    run = fly(plant, thrusting, thrust, wanted, settings=replace(STAGED, plan_next=None))
    sent = [(e["t"], e["name"]) for e in run.told("command.sent") if str(e["name"]).startswith("engine")]
    assert sent == [(10, "engine.on"), (60, "engine.off")]
    assert [(g.status, g.time) for g in run.executive.goals] == [("achieved", 60)]
