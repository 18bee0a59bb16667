"""Golden transcripts: scripted environments, and the executive's whole story of each."""
# ruff: noqa: E501

from __future__ import annotations

from executive.records import Settings
from planner.problem import PlanningResult, Problem
from tests.executive.scripted import (
    AT_START,
    RESET,
    STUCK,
    TUMBLES,
    Reaction,
    ScriptedPlant,
    bindings,
    fly,
    goals,
    image,
    layout,
    planner,
    reactions,
    transcript,
    turn,
)

TWO = goals("vesta", "ceres")


def test_nominal() -> None:
    run = fly(ScriptedPlant(AT_START, reactions()))
    assert (
        transcript(run)
        == """\
  0 run.started horizon=[0, 120]
  0 standby.entered reason=initial
  0 command.sent arguments={} id=1 name=safe.standby token=standby
  1 plan.requested attempt=1 budget=5 reason=initial
  6 plan.adopted handover=6 plan=plan-01 reason=initial tokens=6
  6 standby.left
  6 token.started t1 Attitude.holding(earth)
  6 token.started t2 Camera.idle()
  6 token.finished t1 Attitude.holding(earth) on_time
  6 token.started t4 Attitude.turning(vesta)
  6 command.sent arguments={target: vesta} id=2 name=acs.turn token=t4
  7 token.confirmed t4 Attitude.turning(vesta)
 16 token.finished t4 Attitude.turning(vesta) on_time
 16 token.finished t2 Camera.idle() on_time
 16 token.started t3 Camera.imaging(vesta)
 16 command.sent arguments={target: vesta} id=3 name=camera.image token=t3
 16 token.started t5 Attitude.holding(vesta)
 17 token.confirmed t3 Camera.imaging(vesta)
 20 command.sent arguments={} id=4 name=camera.close token=t3
 20 token.started t6 Camera.idle()
 21 token.finished t3 Camera.imaging(vesta) on_time
 21 goal id=image-vesta reason=None status=achieved
120 run.finished outcome=completed
"""
    )


def test_an_activity_that_ends_before_its_shortest_duration_is_a_violation() -> None:
    run = fly(ScriptedPlant(AT_START, reactions(turn=[turn(3), turn(10)])))
    assert (
        transcript(run, 7, 16)
        == """\
  7 token.confirmed t4 Attitude.turning(vesta)
  9 violation detail=ended after 3 s, expected at least 5 s kind=early
  9 token.failed t4 Attitude.turning(vesta) early: ended after 3 s, expected at least 5 s
  9 token.aborted t2 Camera.idle()
  9 standby.entered reason=early: ended after 3 s, expected at least 5 s
  9 command.sent arguments={} id=3 name=safe.standby token=standby
 11 plan.requested attempt=1 budget=5 reason=early: ended after 3 s, expected at least 5 s
 16 plan.adopted handover=16 plan=plan-02 reason=early: ended after 3 s, expected at least 5 s tokens=6
 16 standby.left
 16 token.started t1 Attitude.holding(earth)
 16 token.started t2 Camera.idle()
 16 token.finished t1 Attitude.holding(earth) on_time
 16 token.started t4 Attitude.turning(vesta)
 16 command.sent arguments={target: vesta} id=4 name=acs.turn token=t4
"""
    )


def test_an_early_end_that_lasts_is_held_until_it_may_be() -> None:
    run = fly(ScriptedPlant(AT_START, reactions(turn=[turn(3)])), bindings(hold_early=True))
    assert (
        transcript(run, 7, 12)
        == """\
  7 token.confirmed t4 Attitude.turning(vesta)
 11 token.finished t4 Attitude.turning(vesta) on_time
 11 token.finished t2 Camera.idle() on_time
 11 token.started t3 Camera.imaging(vesta)
 11 command.sent arguments={target: vesta} id=3 name=camera.image token=t3
 11 token.started t5 Attitude.holding(vesta)
 12 token.confirmed t3 Camera.imaging(vesta)
"""
    )


def test_an_activity_that_never_ends_is_caught_at_its_deadline() -> None:
    run = fly(ScriptedPlant(AT_START, reactions(turn=[turn(4000), turn(10)])))
    assert (
        transcript(run, 7, 33)
        == """\
  7 token.confirmed t4 Attitude.turning(vesta)
 26 violation detail=not ended after 20 s: expected acs.mode == hold, found turn kind=late
 26 token.failed t4 Attitude.turning(vesta) late: not ended after 20 s: expected acs.mode == hold, found turn
 26 token.aborted t2 Camera.idle()
 26 standby.entered reason=late: not ended after 20 s: expected acs.mode == hold, found turn
 26 command.sent arguments={} id=3 name=safe.standby token=standby
 28 plan.requested attempt=1 budget=5 reason=late: not ended after 20 s: expected acs.mode == hold, found turn
 33 plan.adopted handover=33 plan=plan-02 reason=late: not ended after 20 s: expected acs.mode == hold, found turn tokens=6
 33 standby.left
 33 token.started t1 Attitude.holding(earth)
 33 token.started t2 Camera.idle()
 33 token.finished t1 Attitude.holding(earth) on_time
 33 token.started t4 Attitude.turning(vesta)
 33 command.sent arguments={target: vesta} id=4 name=acs.turn token=t4
"""
    )


def test_refused_until_no_retry_is_left() -> None:
    run = fly(ScriptedPlant(AT_START, reactions(image=[Reaction(answer=False)])))
    assert (
        transcript(run, 16)
        == """\
 16 token.finished t4 Attitude.turning(vesta) on_time
 16 token.finished t2 Camera.idle() on_time
 16 token.started t3 Camera.imaging(vesta)
 16 command.sent arguments={target: vesta} id=3 name=camera.image token=t3
 16 token.started t5 Attitude.holding(vesta)
 17 command.sent arguments={target: vesta} id=4 name=camera.image token=t3
 18 violation detail=start: camera.image refused after 2 tries: refused by script kind=refused
 18 fault.detected diagnosis=camera dead monitor=refused
 18 fault.response monitor=refused response=replan
 18 token.aborted t5 Attitude.holding(vesta)
 18 token.failed t3 Camera.imaging(vesta) refused: start: camera.image refused after 2 tries: refused by script
 18 command.sent arguments={} id=5 name=camera.halt token=t3
 18 standby.entered reason=the camera does not take images any more (refused: start: camera.image refused after 2 tries: refused by script)
 18 command.sent arguments={} id=6 name=safe.standby token=standby
 20 plan.requested attempt=1 budget=5 reason=the camera does not take images any more (refused: start: camera.image refused after 2 tries: refused by script)
 25 plan.adopted handover=25 plan=plan-02 reason=the camera does not take images any more (refused: start: camera.image refused after 2 tries: refused by script) tokens=2
 25 goal id=image-vesta reason=unreachable: the camera is dead status=dropped
 25 standby.left
 25 token.started t1 Attitude.holding(earth)
 25 token.started t2 Camera.dead()
120 run.finished outcome=degraded
"""
    )


def test_a_lost_command_is_repeated() -> None:
    run = fly(ScriptedPlant(AT_START, reactions(image=[Reaction(answer=None), image(4, 1)])))
    assert (
        transcript(run, 16)
        == """\
 16 token.finished t4 Attitude.turning(vesta) on_time
 16 token.finished t2 Camera.idle() on_time
 16 token.started t3 Camera.imaging(vesta)
 16 command.sent arguments={target: vesta} id=3 name=camera.image token=t3
 16 token.started t5 Attitude.holding(vesta)
 19 command.timeout id=3
 19 command.sent arguments={target: vesta} id=4 name=camera.image token=t3
 20 token.confirmed t3 Camera.imaging(vesta)
 23 command.sent arguments={} id=5 name=camera.close token=t3
 23 token.started t6 Camera.idle()
 24 token.finished t3 Camera.imaging(vesta) on_time
 24 goal id=image-vesta reason=None status=achieved
120 run.finished outcome=completed
"""
    )


def test_unconfirmed_although_acknowledged() -> None:
    run = fly(ScriptedPlant(AT_START, reactions(image=[Reaction()])))
    assert (
        transcript(run, 19, 29)
        == """\
 19 command.timeout id=3
 19 command.sent arguments={target: vesta} id=4 name=camera.image token=t3
 22 command.timeout id=4
 22 violation detail=start: camera.image not confirmed within 3 s, 2 tries: expected camera.state == exposing, found ready kind=unconfirmed
 22 fault.detected diagnosis=camera dead monitor=unconfirmed
 22 fault.response monitor=unconfirmed response=replan
 22 token.aborted t5 Attitude.holding(vesta)
 22 token.failed t3 Camera.imaging(vesta) unconfirmed: start: camera.image not confirmed within 3 s, 2 tries: expected camera.state == exposing, found ready
 22 command.sent arguments={} id=5 name=camera.halt token=t3
 22 standby.entered reason=the camera does not take images any more (unconfirmed: start: camera.image not confirmed within 3 s, 2 tries: expected camera.state == exposing, found ready)
 22 command.sent arguments={} id=6 name=safe.standby token=standby
 24 plan.requested attempt=1 budget=5 reason=the camera does not take images any more (unconfirmed: start: camera.image not confirmed within 3 s, 2 tries: expected camera.state == exposing, found ready)
 29 plan.adopted handover=29 plan=plan-02 reason=the camera does not take images any more (unconfirmed: start: camera.image not confirmed within 3 s, 2 tries: expected camera.state == exposing, found ready) tokens=2
 29 goal id=image-vesta reason=unreachable: the camera is dead status=dropped
 29 standby.left
 29 token.started t1 Attitude.holding(earth)
 29 token.started t2 Camera.dead()
"""
    )


def test_a_lock_is_broken() -> None:
    events = {18: {"acs.settled": False}}
    run = fly(ScriptedPlant(AT_START, reactions(), events))
    assert (
        transcript(run, 17, 26)
        == """\
 17 token.confirmed t3 Camera.imaging(vesta)
 19 violation detail='pointing': expected acs.settled == True, found False kind=lock
 19 token.failed t5 Attitude.holding(vesta) lock: 'pointing': expected acs.settled == True, found False
 19 token.aborted t3 Camera.imaging(vesta)
 19 command.sent arguments={} id=4 name=camera.halt token=t3
 19 standby.entered reason=lock: 'pointing': expected acs.settled == True, found False
 19 command.sent arguments={} id=5 name=safe.standby token=standby
 21 plan.requested attempt=1 budget=5 reason=lock: 'pointing': expected acs.settled == True, found False
 26 plan.adopted handover=26 plan=plan-02 reason=lock: 'pointing': expected acs.settled == True, found False tokens=6
 26 standby.left
 26 token.started t1 Attitude.holding(earth)
 26 token.started t2 Camera.idle()
 26 token.finished t1 Attitude.holding(earth) on_time
 26 token.started t4 Attitude.turning(vesta)
 26 command.sent arguments={target: vesta} id=6 name=acs.turn token=t4
"""
    )


def test_fault_standby_replan_goals_kept_and_dropped() -> None:
    events = {24: {"camera.state": "stuck"}}
    run = fly(ScriptedPlant(AT_START, reactions(), events), bindings(STUCK), wanted=TWO)
    assert (
        transcript(run, 20)
        == """\
 20 command.sent arguments={} id=4 name=camera.close token=t3
 20 token.finished t5 Attitude.holding(vesta) on_time
 20 token.started t6 Camera.idle()
 20 token.started t8 Attitude.turning(ceres)
 20 command.sent arguments={target: ceres} id=5 name=acs.turn token=t8
 21 token.finished t3 Camera.imaging(vesta) on_time
 21 token.confirmed t8 Attitude.turning(ceres)
 21 goal id=image-vesta reason=None status=achieved
 26 fault.detected diagnosis=camera dead monitor=camera-stuck
 26 violation detail=camera-stuck: the camera does not take images any more kind=fault
 26 fault.response monitor=camera-stuck response=replan
 26 token.aborted t8 Attitude.turning(ceres)
 26 token.aborted t6 Camera.idle()
 26 standby.entered reason=the camera does not take images any more (fault: camera-stuck)
 26 command.sent arguments={} id=6 name=safe.standby token=standby
 28 plan.requested attempt=1 budget=5 reason=the camera does not take images any more (fault: camera-stuck)
 33 plan.adopted handover=33 plan=plan-02 reason=the camera does not take images any more (fault: camera-stuck) tokens=2
 33 goal id=image-ceres reason=unreachable: the camera is dead status=dropped
 33 standby.left
 33 token.started t1 Attitude.holding(earth)
 33 token.started t2 Camera.dead()
120 run.finished outcome=degraded
"""
    )


def test_a_response_that_helps_saves_the_plan() -> None:
    events = {24: {"camera.state": "stuck"}}
    table = reactions(reset=[Reaction(), Reaction(1, {"camera.state": "ready"})])
    run = fly(ScriptedPlant(AT_START, table, events), bindings(RESET), wanted=TWO)
    assert (
        transcript(run, 23, 36)
        == """\
 26 fault.detected diagnosis=camera hung monitor=camera-stuck
 26 fault.response monitor=camera-stuck response=reset
 26 command.sent arguments={} id=6 name=camera.reset token=monitor camera-stuck
 30 fault.response monitor=camera-stuck response=reset
 30 command.sent arguments={} id=7 name=camera.reset token=monitor camera-stuck
 30 token.finished t8 Attitude.turning(ceres) on_time
 30 token.finished t6 Camera.idle() on_time
 30 token.started t7 Camera.imaging(ceres)
 30 command.sent arguments={target: ceres} id=8 name=camera.image token=t7
 30 token.started t9 Attitude.holding(ceres)
 31 fault.recovered cured=True diagnosis=camera hung monitor=camera-stuck
 31 token.confirmed t7 Camera.imaging(ceres)
 34 command.sent arguments={} id=9 name=camera.close token=t7
 34 token.started t10 Camera.idle()
 35 token.finished t7 Camera.imaging(ceres) on_time
 35 goal id=image-ceres reason=None status=achieved
"""
    )


def test_responses_that_do_not_help_lead_to_the_conclusion() -> None:
    events = {22: {"camera.state": "stuck"}}
    slow = reactions(reset=[Reaction()], turn=[turn(10), turn(20)])
    run = fly(ScriptedPlant(AT_START, slow, events), bindings(RESET), wanted=TWO)
    assert (
        transcript(run, 23, 39)
        == """\
 24 fault.detected diagnosis=camera hung monitor=camera-stuck
 24 fault.response monitor=camera-stuck response=reset
 24 command.sent arguments={} id=6 name=camera.reset token=monitor camera-stuck
 28 fault.response monitor=camera-stuck response=reset
 28 command.sent arguments={} id=7 name=camera.reset token=monitor camera-stuck
 32 fault.detected diagnosis=camera dead monitor=camera-stuck
 32 violation detail=camera-stuck: the camera does not take images any more kind=fault
 32 fault.response monitor=camera-stuck response=replan
 32 token.aborted t8 Attitude.turning(ceres)
 32 token.aborted t6 Camera.idle()
 32 standby.entered reason=the camera does not take images any more (fault: camera-stuck)
 32 command.sent arguments={} id=8 name=safe.standby token=standby
 34 plan.requested attempt=1 budget=5 reason=the camera does not take images any more (fault: camera-stuck)
 39 plan.adopted handover=39 plan=plan-02 reason=the camera does not take images any more (fault: camera-stuck) tokens=2
 39 goal id=image-ceres reason=unreachable: the camera is dead status=dropped
 39 standby.left
 39 token.started t1 Attitude.holding(earth)
 39 token.started t2 Camera.dead()
"""
    )


def test_two_faults_at_once() -> None:
    events = {24: {"camera.state": "stuck"}, 26: {"acs.mode": "tumble"}}
    run = fly(ScriptedPlant(AT_START, reactions(), events), bindings(STUCK, TUMBLES), wanted=TWO)
    assert (
        transcript(run, 23, 40)
        == """\
 26 fault.detected diagnosis=camera dead monitor=camera-stuck
 26 fault.detected diagnosis=wheel lost monitor=tumbling
 26 violation detail=camera-stuck: the camera does not take images any more kind=fault
 26 fault.response monitor=camera-stuck response=replan
 26 violation detail=tumbling: the attitude control gave up kind=fault
 26 fault.response monitor=tumbling response=replan
 26 token.aborted t8 Attitude.turning(ceres)
 26 token.aborted t6 Camera.idle()
 26 standby.entered reason=the camera does not take images any more (fault: camera-stuck); the attitude control gave up (fault: tumbling)
 26 command.sent arguments={} id=6 name=safe.standby token=standby
 28 plan.requested attempt=1 budget=5 reason=the camera does not take images any more (fault: camera-stuck); the attitude control gave up (fault: tumbling)
 33 plan.adopted handover=33 plan=plan-02 reason=the camera does not take images any more (fault: camera-stuck); the attitude control gave up (fault: tumbling) tokens=2
 33 goal id=image-ceres reason=unreachable: the camera is dead status=dropped
 33 standby.left
 33 token.started t1 Attitude.holding(earth)
 33 token.started t2 Camera.dead()
"""
    )


def test_a_fault_while_the_planner_thinks_is_planned_for_again() -> None:
    events = {24: {"acs.mode": "tumble"}, 27: {"camera.state": "stuck"}}
    run = fly(ScriptedPlant(AT_START, reactions(), events), bindings(STUCK, TUMBLES), wanted=TWO)
    assert (
        transcript(run, 23, 40)
        == """\
 24 fault.detected diagnosis=wheel lost monitor=tumbling
 24 violation detail=tumbling: the attitude control gave up kind=fault
 24 fault.response monitor=tumbling response=replan
 24 token.aborted t8 Attitude.turning(ceres)
 24 token.aborted t6 Camera.idle()
 24 standby.entered reason=the attitude control gave up (fault: tumbling)
 24 command.sent arguments={} id=6 name=safe.standby token=standby
 26 plan.requested attempt=1 budget=5 reason=the attitude control gave up (fault: tumbling)
 29 fault.detected diagnosis=camera dead monitor=camera-stuck
 29 violation detail=camera-stuck: the camera does not take images any more kind=fault
 29 fault.response monitor=camera-stuck response=replan
 31 plan.failed reason=the state at hand-over differs: expected camera Camera.idle(); found camera Camera.dead()
 31 plan.requested attempt=2 budget=5 reason=the attitude control gave up (fault: tumbling)
 36 plan.adopted handover=36 plan=plan-02 reason=the attitude control gave up (fault: tumbling) tokens=2
 36 goal id=image-ceres reason=unreachable: the camera is dead status=dropped
 36 standby.left
 36 token.started t1 Attitude.holding(earth)
 36 token.started t2 Camera.dead()
"""
    )


def test_standby_is_repeated_until_telemetry_confirms_it() -> None:
    table = reactions(standby=[Reaction(), Reaction(2, {"acs.target": "earth"})])
    run = fly(ScriptedPlant({**AT_START, "acs.target": "mars"}, table))
    assert (
        transcript(run, 0, 20)
        == """\
  0 run.started horizon=[0, 120]
  0 standby.entered reason=initial
  0 command.sent arguments={} id=1 name=safe.standby token=standby
 10 command.timeout id=1
 10 command.sent arguments={} id=2 name=safe.standby token=standby
 10 violation detail=safe.standby not confirmed within 10 s, 1 try: expected acs.target == earth, found mars kind=standby
 12 plan.requested attempt=1 budget=5 reason=initial
 17 plan.adopted handover=17 plan=plan-01 reason=initial tokens=6
 17 standby.left
 17 token.started t1 Attitude.holding(earth)
 17 token.started t2 Camera.idle()
 17 token.finished t1 Attitude.holding(earth) on_time
 17 token.started t4 Attitude.turning(vesta)
 17 command.sent arguments={target: vesta} id=3 name=acs.turn token=t4
 18 token.confirmed t4 Attitude.turning(vesta)
"""
    )


def test_a_planner_that_fails_once() -> None:
    answers = [PlanningResult(None, reason="no plan in 10 steps")]
    run = fly(ScriptedPlant(AT_START, reactions()), plan=lambda problem: answers.pop() if answers else planner(problem))
    assert (
        transcript(run, 0, 22)
        == """\
  0 run.started horizon=[0, 120]
  0 standby.entered reason=initial
  0 command.sent arguments={} id=1 name=safe.standby token=standby
  1 plan.requested attempt=1 budget=5 reason=initial
  6 plan.failed reason=no plan in 10 steps
 16 plan.requested attempt=2 budget=5 reason=initial
 21 plan.adopted handover=21 plan=plan-01 reason=initial tokens=6
 21 standby.left
 21 token.started t1 Attitude.holding(earth)
 21 token.started t2 Camera.idle()
 21 token.finished t1 Attitude.holding(earth) on_time
 21 token.started t4 Attitude.turning(vesta)
 21 command.sent arguments={target: vesta} id=2 name=acs.turn token=t4
 22 token.confirmed t4 Attitude.turning(vesta)
"""
    )


def test_a_planner_that_raises() -> None:
    failures = [ValueError("off by one")]

    def raising(problem: Problem) -> PlanningResult:
        if failures:
            raise failures.pop()
        return planner(problem)

    run = fly(ScriptedPlant(AT_START, reactions()), plan=raising)
    assert (
        transcript(run, 0, 22)
        == """\
  0 run.started horizon=[0, 120]
  0 standby.entered reason=initial
  0 command.sent arguments={} id=1 name=safe.standby token=standby
  1 plan.requested attempt=1 budget=5 reason=initial
  6 plan.failed reason=the planner raised ValueError: off by one
 16 plan.requested attempt=2 budget=5 reason=initial
 21 plan.adopted handover=21 plan=plan-01 reason=initial tokens=6
 21 standby.left
 21 token.started t1 Attitude.holding(earth)
 21 token.started t2 Camera.idle()
 21 token.finished t1 Attitude.holding(earth) on_time
 21 token.started t4 Attitude.turning(vesta)
 21 command.sent arguments={target: vesta} id=2 name=acs.turn token=t4
 22 token.confirmed t4 Attitude.turning(vesta)
"""
    )


def test_a_planner_that_overruns_gets_more_time() -> None:
    settings = Settings("scripted", 1, budget=5, retry_delay=10, deliberation=lambda result: 8)
    run = fly(ScriptedPlant(AT_START, reactions()), settings=settings)
    assert (
        transcript(run, 0, 27)
        == """\
  0 run.started horizon=[0, 120]
  0 standby.entered reason=initial
  0 command.sent arguments={} id=1 name=safe.standby token=standby
  1 plan.requested attempt=1 budget=5 reason=initial
  9 plan.failed reason=the planner took 8 s, its budget was 5 s
 19 plan.requested attempt=2 budget=8 reason=initial
 27 plan.adopted handover=27 plan=plan-01 reason=initial tokens=6
 27 standby.left
 27 token.started t1 Attitude.holding(earth)
 27 token.started t2 Camera.idle()
 27 token.finished t1 Attitude.holding(earth) on_time
 27 token.started t4 Attitude.turning(vesta)
 27 command.sent arguments={target: vesta} id=2 name=acs.turn token=t4
"""
    )


def test_a_plan_that_is_not_controllable_is_not_executed() -> None:
    def careless(problem: Problem) -> PlanningResult:
        first = problem.horizon[0] < 10
        return PlanningResult(layout(problem, latest_end=4) if first else layout(problem))

    run = fly(ScriptedPlant(AT_START, reactions()), plan=careless)
    assert (
        transcript(run, 0, 22)
        == """\
  0 run.started horizon=[0, 120]
  0 standby.entered reason=initial
  0 command.sent arguments={} id=1 name=safe.standby token=standby
  1 plan.requested attempt=1 budget=5 reason=initial
  6 plan.failed reason=the plan is not dynamically controllable: duration of camera.mode Camera.imaging, decided by nature: start of Camera.imaging (t3) to end of Camera.imaging (t3) in [3, 8]; image-vesta while holding: start of Attitude.holding (t5) to start of Camera.imaging (t3) in [0, any]; image-vesta soon: start of Attitude.holding (t5) to end of Camera.imaging (t3) in [any, 4]
 16 plan.requested attempt=2 budget=5 reason=initial
 21 plan.adopted handover=21 plan=plan-01 reason=initial tokens=6
 21 standby.left
 21 token.started t1 Attitude.holding(earth)
 21 token.started t2 Camera.idle()
 21 token.finished t1 Attitude.holding(earth) on_time
 21 token.started t4 Attitude.turning(vesta)
 21 command.sent arguments={target: vesta} id=2 name=acs.turn token=t4
 22 token.confirmed t4 Attitude.turning(vesta)
"""
    )


def test_the_end_of_the_horizon_comes_before_the_goal() -> None:
    run = fly(ScriptedPlant(AT_START, reactions()), wanted=TWO, horizon=(0, 25))
    assert (
        transcript(run, 20)
        == """\
 20 command.sent arguments={} id=4 name=camera.close token=t3
 20 token.finished t5 Attitude.holding(vesta) on_time
 20 token.started t6 Camera.idle()
 20 token.started t8 Attitude.turning(ceres)
 20 command.sent arguments={target: ceres} id=5 name=acs.turn token=t8
 21 token.finished t3 Camera.imaging(vesta) on_time
 21 token.confirmed t8 Attitude.turning(ceres)
 21 goal id=image-vesta reason=None status=achieved
 25 goal id=image-ceres reason=not achieved before the end of the run status=missed
 25 run.finished outcome=failed
"""
    )


def test_no_time_is_left_to_plan() -> None:
    events = {31: {"acs.mode": "tumble"}}
    run = fly(ScriptedPlant(AT_START, reactions(), events), bindings(TUMBLES), wanted=TWO, horizon=(0, 35))
    assert (
        transcript(run, 29)
        == """\
 30 token.finished t8 Attitude.turning(ceres) on_time
 30 token.finished t6 Camera.idle() on_time
 30 token.started t7 Camera.imaging(ceres)
 30 command.sent arguments={target: ceres} id=6 name=camera.image token=t7
 30 token.started t9 Attitude.holding(ceres)
 31 fault.detected diagnosis=wheel lost monitor=tumbling
 31 token.confirmed t7 Camera.imaging(ceres)
 31 violation detail=tumbling: the attitude control gave up kind=fault
 31 fault.response monitor=tumbling response=replan
 31 token.aborted t9 Attitude.holding(ceres)
 31 token.aborted t7 Camera.imaging(ceres)
 31 command.sent arguments={} id=7 name=camera.halt token=t7
 31 standby.entered reason=the attitude control gave up (fault: tumbling)
 31 command.sent arguments={} id=8 name=safe.standby token=standby
 33 plan.failed reason=no time is left before the end of the horizon
 35 goal id=image-ceres reason=not achieved before the end of the run status=missed
 35 run.finished outcome=standby
"""
    )


def test_a_fault_during_recovery() -> None:
    """The camera is being reset when the attitude is lost: the plan goes, the recovery goes on and helps in standby."""
    events = {24: {"camera.state": "stuck"}, 28: {"acs.mode": "tumble"}}
    table = reactions(reset=[Reaction(), Reaction(1, {"camera.state": "ready"})])
    run = fly(ScriptedPlant(AT_START, table, events), bindings(RESET, TUMBLES), wanted=TWO)
    assert (
        transcript(run, 23, 46)
        == """\
 26 fault.detected diagnosis=camera hung monitor=camera-stuck
 26 fault.response monitor=camera-stuck response=reset
 26 command.sent arguments={} id=6 name=camera.reset token=monitor camera-stuck
 28 fault.detected diagnosis=wheel lost monitor=tumbling
 28 violation detail=tumbling: the attitude control gave up kind=fault
 28 fault.response monitor=tumbling response=replan
 28 token.aborted t8 Attitude.turning(ceres)
 28 token.aborted t6 Camera.idle()
 28 standby.entered reason=the attitude control gave up (fault: tumbling)
 28 command.sent arguments={} id=7 name=safe.standby token=standby
 30 fault.response monitor=camera-stuck response=reset
 30 command.sent arguments={} id=8 name=camera.reset token=monitor camera-stuck
 30 plan.requested attempt=1 budget=5 reason=the attitude control gave up (fault: tumbling)
 31 fault.recovered cured=True diagnosis=camera hung monitor=camera-stuck
 35 plan.adopted handover=35 plan=plan-02 reason=the attitude control gave up (fault: tumbling) tokens=6
 35 standby.left
 35 token.started t1 Attitude.holding(earth)
 35 token.started t2 Camera.idle()
 35 token.finished t1 Attitude.holding(earth) on_time
 35 token.started t4 Attitude.turning(ceres)
 35 command.sent arguments={target: ceres} id=9 name=acs.turn token=t4
 36 token.confirmed t4 Attitude.turning(ceres)
 45 token.finished t4 Attitude.turning(ceres) on_time
 45 token.finished t2 Camera.idle() on_time
 45 token.started t3 Camera.imaging(ceres)
 45 command.sent arguments={target: ceres} id=10 name=camera.image token=t3
 45 token.started t5 Attitude.holding(ceres)
 46 token.confirmed t3 Camera.imaging(ceres)
"""
    )
