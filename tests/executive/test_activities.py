"""Corners of a token's life: proofs of ends, late proofs of starts, deadlines to the second, what holds already."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace

import pytest

from executive.bindings import Activity, Bindings, Finish, Maintained, Standby
from executive.conditions import Condition
from executive.goals import GoalBook
from executive.journal import Journal
from executive.port import TelemetryValue
from executive.protection import Monitor, Response
from executive.records import Settings
from executive.sends import Conclusion, Confirmation, Send
from planner.plan import Bounds
from planner.problem import Goal, PlanningResult, Problem, TokenPattern
from tests.executive.scripted import (
    AT_START,
    DEAD,
    STUCK,
    Draft,
    Reaction,
    Run,
    ScriptedPlant,
    bindings,
    fly,
    goals,
    planner,
    reactions,
    turn,
)

SAFE = Standby((), Confirmation((Condition("safe", "==", True),)))
HEATER_ON = Condition("heater", "==", "on")
HEATER_OFF = Condition("heater", "==", "off")
HEAT = Activity(
    "Heater.heat",
    start=(Send("on"),),
    started=Confirmation((HEATER_ON,), within=4, retries=1),
    end=(Send("off"),),
    ended=Confirmation((HEATER_OFF,), within=4, retries=1, conclusion=Conclusion("heater stuck", "it does not go off")),
    stop=(Send("off"),),
)


def heating(duration: Bounds = (10, 10), contingent: bool = False) -> Draft:
    draft = Draft((6, 100))
    draft.token(("heater", "mode"), "Heater.cold", (2, 2))
    token = draft.token(("heater", "mode"), "Heater.heat", duration, contingent=contingent, goal="warm")
    draft.token(("heater", "mode"), "Heater.cold", master=token)
    return draft


def heat(
    on: Sequence[Reaction],
    off: Sequence[Reaction],
    activity: Activity = HEAT,
    draft: Draft | None = None,
    monitors: tuple[Monitor, ...] = (),
    responses: tuple[Response, ...] = (),
    more: dict[str, TelemetryValue] | None = None,
) -> Run:
    """One plan, and none after it."""
    plans = [PlanningResult((draft or heating()).plan())]
    return fly(
        ScriptedPlant({"safe": True, "heater": "off", **(more or {})}, {"on": on, "off": off}),
        Bindings((activity,), SAFE, lambda telemetry, conclusions: (), monitors=monitors, responses=responses),
        lambda problem: plans.pop() if plans else PlanningResult(None, reason="no more"),
        (Goal("warm", TokenPattern("Heater.heat")),),
        (0, 60),
        Settings(budget=5),
    )


ON, OFF = Reaction(2, {"heater": "on"}), Reaction(1, {"heater": "off"})


def story(run: Run) -> list[tuple[object, object]]:
    events = run.told("token.started", "token.confirmed", "token.finished", "token.failed", "token.aborted", "goal")
    return [
        (e["t"], f"{e['event']} {e.get('token', e.get('status'))}")
        for e in events
        if e.get("token") not in ("t1", "t3")
    ]


def test_a_token_is_over_when_its_end_is_proven_but_ended_when_it_ended() -> None:
    run = heat([ON], [Reaction(3, {"heater": "off"})])
    assert story(run) == [
        (8, "token.started t2"),
        (10, "token.confirmed t2"),
        (21, "token.finished t2"),
        (21, "goal achieved"),
    ]
    (finished,) = (e for e in run.told("token.finished") if e["token"] == "t2")
    assert finished["ended"] == 18
    assert finished["verdict"] == "on_time"


def test_an_end_that_is_not_proven_fails_the_token_and_draws_its_conclusion() -> None:
    run = heat([ON], [Reaction()])
    assert story(run)[2:] == [(26, "token.failed t2"), (60, "goal missed")]
    assert run.executive.conclusions == {"heater stuck"}
    assert [e["id"] for e in run.told("command.timeout")] == [2, 3]


def test_the_end_goes_out_on_time_even_if_the_start_is_not_proven_and_the_start_is_not_repeated() -> None:
    late = heat([Reaction(3, {"heater": "on"})], [Reaction(4, {"heater": "off"})], draft=heating((2, 2)))
    assert story(late) == [
        (8, "token.started t2"),
        (11, "token.confirmed t2"),
        (14, "token.finished t2"),
        (14, "goal achieved"),
    ]
    never = heat([Reaction()], [OFF], draft=heating((2, 2)))
    assert [e["name"] for e in never.told("command.sent")] == ["on", "off", "off"]  # start, end, safe stop
    assert story(never)[1:] == [(12, "token.failed t2"), (60, "goal missed")]


def test_without_conditions_the_acknowledgement_is_the_proof() -> None:
    plain = replace(HEAT, started=Confirmation(within=3), ended=Confirmation(within=3))
    assert story(heat([Reaction()], [Reaction()], plain))[1:3] == [(9, "token.confirmed t2"), (19, "token.finished t2")]
    dead = heat([Reaction(answer=None)], [Reaction()], plain)
    assert story(dead)[1:2] == [(11, "token.failed t2")]
    assert "on not confirmed within 3 s, 1 try: no acknowledgement" in dead.text


NATURAL = Activity(
    "Heater.heat",
    contingent=True,
    start=(Send("on"),),
    started=Confirmation((HEATER_ON,), 4),
    finish=Finish((HEATER_OFF,)),
)


@pytest.mark.parametrize(("ends_after", "violations"), [(4, {"early": 1}), (5, {}), (9, {}), (10, {"late": 1})])
def test_bounds_of_what_nature_decides_are_kept_to_the_second(ends_after: int, violations: dict[str, int]) -> None:
    on = Reaction(1, {"heater": "on"}, then=((ends_after, {"heater": "off"}),))
    run = heat([on], [], NATURAL, heating((5, 9), contingent=True))
    assert run.executive.dispatch.violations == violations
    if violations == {"late": 1}:
        assert story(run)[2] == (17, "token.failed t2")  # at the deadline itself, not a second later


def test_an_end_counts_only_after_the_start_is_proven() -> None:
    """The heater is off before it is on; that is not its end."""
    on = Reaction(3, {"heater": "on"}, then=((7, {"heater": "off"}),))
    run = heat([on], [], NATURAL, heating((5, 9), contingent=True))
    assert story(run)[2] == (15, "token.finished t2")


def test_persistence_of_an_end() -> None:
    """A glitch is not the end; the end is seen as late as its persistence."""
    glitch = ((5, {"heater": "off"}), (6, {"heater": "on"}), (7, {"heater": "off"}))
    persistent = replace(NATURAL, finish=Finish((HEATER_OFF,), persistence=2))
    run = heat([Reaction(1, {"heater": "on"}, then=glitch)], [], persistent, heating((5, 12), contingent=True))
    assert story(run)[2] == (17, "token.finished t2")


def test_what_holds_already_is_not_started_again_but_kept_and_ended() -> None:
    draft = Draft((6, 100))
    draft.token(("heater", "mode"), "Heater.heat", (5, 9), contingent=True)
    draft.token(("heater", "mode"), "Heater.cold", master="t1")
    locked = replace(NATURAL, maintained=(Maintained("power", (Condition("bus", "==", "on"),)),))
    plant_goes_off = {"heater": "on", "bus": "on"}
    run = heat([], [], locked, draft, more=plant_goes_off)
    assert run.told("command.sent") == []
    assert run.executive.dispatch.violations == {"late": 1}
    assert [e["t"] for e in run.told("token.failed")] == [15]
    broken = heat([], [], locked, draft, more={"heater": "on", "bus": "off"})
    assert broken.executive.dispatch.violations == {"lock": 1}


def test_a_monitor_that_does_not_replan_only_concludes() -> None:
    """A sensor found wrong is ignored from then on; the plan goes on."""
    wrong = Monitor("bus-sensor", (Condition("bus", "==", "off"), HEATER_ON), 1, Conclusion("bus sensor wrong", "x"))
    ignored = Response("bus sensor wrong", vetoes={"bus": "on"}, replan="never")
    run = heat([ON], [OFF], monitors=(wrong,), responses=(ignored,), more={"bus": "off"})
    assert run.executive.conclusions == {"bus sensor wrong"}
    assert [(f.detected, f.diagnosis) for f in run.executive.faults] == [(11, "bus sensor wrong")]
    assert len(run.executive.plans) == 1
    assert run.executive.outcome == "completed"


def test_a_conclusion_is_drawn_once_and_reaches_the_next_state() -> None:
    asked: list[frozenset[str]] = []

    def state(telemetry: object, conclusions: frozenset[str]) -> tuple[TokenPattern, ...]:
        asked.append(conclusions)
        return (TokenPattern("Attitude.holding", "acs", {"target": "earth"}), TokenPattern("Camera.idle", "camera"))

    bound = replace(bindings(STUCK, replace(STUCK, name="same")), state=state)
    events = {24: {"camera.state": "stuck"}}
    run = fly(ScriptedPlant(AT_START, reactions(), events), bound, wanted=goals("vesta", "ceres"), horizon=(0, 40))
    assert asked[0] == frozenset()
    assert asked[-1] == {DEAD.name}
    assert len(run.told("fault.detected")) == 1


def test_facts_and_the_remaining_horizon_are_in_every_problem() -> None:
    problems: list[Problem] = []
    fact = TokenPattern("Sun.eclipse", start=(30, 30), end=(40, 40))

    def remember(problem: Problem) -> PlanningResult:
        problems.append(problem)
        return planner(problem)

    settings = Settings(budget=5, facts=(fact,))
    fly(ScriptedPlant(AT_START, reactions(turn=[turn(1), turn(10)])), plan=remember, settings=settings)
    assert [(p.horizon, p.facts) for p in problems] == [((6, 120), (fact,)), ((14, 120), (fact,))]


def test_at_one_instant_what_was_running_ends_before_anything_starts() -> None:
    """Whatever the order of timelines and slots: the heater goes off before the lamp goes on."""
    lamp = Activity("Lamp.light", start=(Send("light"),))
    draft = Draft((6, 100))
    draft.token(("lamp", "mode"), "Lamp.dark")
    lit = draft.token(("lamp", "mode"), "Lamp.light", (5, 5), master="t1")
    for number, duration in enumerate(((1, 1), (1, 1))):
        draft.token(("heater", "mode"), "Heater.cold", duration, master=None if number == 0 else "t1")
    heated = draft.token(("heater", "mode"), "Heater.heat", (10, 10), goal="warm")
    draft.at(f"{heated}.end", f"{lit}.start", 0, 0, "then")
    plant = ScriptedPlant({"safe": True, "heater": "off"}, {"on": [ON], "off": [OFF], "light": [Reaction()]})
    fly(
        plant,
        Bindings((HEAT, lamp), SAFE, lambda telemetry, conclusions: ()),
        lambda problem: PlanningResult(draft.plan()),
        (),
        (0, 40),
        Settings(budget=5),
    )
    assert [command.name for command in plant.sent] == ["on", "off", "light"]


def test_what_is_achieved_or_dropped_stays_so() -> None:
    stream = io.StringIO()
    book = GoalBook(goals("a", "b"), Journal(stream))
    book.achieved("image-a", 3)
    book.dropped("image-b", 4, "outbid: x")
    book.dropped("image-a", 5, "unreachable: y")
    book.achieved("image-b", 6)
    book.achieved("stranger", 6)
    book.missed(7)
    assert [(r.id, r.status, r.time, r.reason) for r in book.records] == [
        ("image-a", "achieved", 3, None),
        ("image-b", "dropped", 4, "outbid: x"),
    ]
    assert stream.getvalue().count("\n") == 2
