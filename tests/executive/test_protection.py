"""Fault protection: monitor, conclusion and response, each on its own and together, on a pump that can go wrong.

The plan: the pump runs for 20 s from second 8 on, then the plan lasts. Whatever is not said fails the run's outcome.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from executive.bindings import MODE, Activity, Bindings, Maintained, Standby
from executive.conditions import Condition, Telemetry
from executive.monitor import Diagnoser, Finding
from executive.port import TelemetryValue
from executive.protection import Monitor, Probe, Recovery, Response, Step, concluded_channel, probe_channel
from executive.records import Settings
from executive.sends import Conclusion, Confirmation, Send
from planner.problem import Goal, PlanningResult, Problem, TokenPattern
from tests.executive.scripted import Draft, Reaction, Run, ScriptedPlant, fly

ON, OFF = Condition("pump", "==", "on"), Condition("pump", "==", "off")
TRIPPED = Conclusion("pump tripped", "the pump stopped by itself")
DEAF = Conclusion("pump deaf", "the pump's terminal does not answer")
WORN = Conclusion("pump worn", "the pump takes commands and does not run")
LOST = Conclusion("pump lost", "the pump is not to be relied on")
WRONG = Conclusion("bus sensor wrong", "the bus sensor says off, and the bus is on")
DOWN = Conclusion("bus down", "the bus has no power")
RUN = Activity(
    "Pump.run",
    parameters=("rate",),
    start=(Send("pump.on", {"rate": "$rate"}),),
    started=Confirmation((ON,), within=4, retries=1, conclusion=WORN, unanswered=DEAF),
    end=(Send("pump.off"),),
    ended=Confirmation((OFF,), within=4),
    maintained=(
        Maintained("running", (ON,), 1, conclusion=TRIPPED, made_up=True),
        Maintained("power", (Condition("bus", "==", "on"),), 3),
    ),
    stop=(Send("pump.off"),),
)
AGAIN = Recovery("switch it on", (Step((Send("pump.on", {"rate": "$rate"}),), Confirmation((ON,), within=3)),), 2)
RESET = Recovery("reset", (Step((Send("reset"),)),), within=2)
FINE: dict[str, TelemetryValue] = {"safe": True, "pump": "off", "bus": "on", "amps": 1.0, "tracker": "on"}
STARTS, STOPS = Reaction(1, {"pump": "on"}), Reaction(1, {"pump": "off"})
DEAD_SILENCE = Reaction(answer=None)


def draft(most: int | None = None, start: int = 6) -> Draft:
    plan = Draft((start, 100))
    plan.token(("pump", "mode"), "Pump.rest", (2, 2))
    plan.token(("pump", "mode"), "Pump.run", (20, most), {"rate": 7}, goal="pumped", master="t1")
    plan.token(("pump", "mode"), "Pump.rest", master="t1")
    return plan


def pump(
    responses: Sequence[Response] = (),
    monitors: Sequence[Monitor] = (),
    events: Mapping[int, Mapping[str, TelemetryValue]] | None = None,
    most: int | None = None,
    probes: Sequence[Probe] = (),
    diagnosers: Sequence[Diagnoser] = (),
    problems: list[Problem] | None = None,
    reactions: Mapping[str, Sequence[Reaction]] | None = None,
    standby: Standby | None = None,
) -> Run:
    """One run: the pump's plan, whenever one is asked for."""
    bindings = Bindings(
        (RUN,),
        standby or Standby((), Confirmation((Condition("safe", "==", True),))),
        lambda telemetry, conclusions: (),
        monitors=tuple(monitors),
        responses=tuple(responses),
        probes=tuple(probes),
    )

    def plan(problem: Problem) -> PlanningResult:
        if problems is not None:
            problems.append(problem)
        return PlanningResult(draft(most, problem.horizon[0]).plan())

    table: dict[str, Sequence[Reaction]] = {
        "pump.on": [STARTS],
        "pump.off": [STOPS],
        "reset": [Reaction()],
        "valve": [Reaction()],
        "ping": [Reaction()],
    }
    plant = ScriptedPlant(FINE, table | dict(reactions or {}), events)
    goal = Goal("pumped", TokenPattern("Pump.run", duration=(20, None)))
    return fly(plant, bindings, plan, (goal,), (0, 100), Settings(budget=5), diagnosers=tuple(diagnosers))


def sent(run: Run) -> list[tuple[object, object]]:
    return [(e["t"], e["name"]) for e in run.told("command.sent")]


def told(run: Run) -> list[tuple[object, ...]]:
    """What was detected, answered and recovered from."""
    rows: list[tuple[object, ...]] = []
    for entry in run.entries:
        if entry["event"] == "fault.detected":
            rows.append((entry["t"], "detected", entry["diagnosis"]))
        elif entry["event"] == "fault.response":
            rows.append((entry["t"], "response", entry["response"]))
        elif entry["event"] == "fault.recovered":
            rows.append((entry["t"], "cured" if entry["cured"] else "worked around"))
    return rows


# -- monitors ----------------------------------------------------------------------------------------------------------

WITNESSES = (Condition("amps", ">", 0.1), Condition("tracker", "==", "on"))
SENSOR = Monitor("sensor", (Condition("bus", "==", "off"),), 1, WRONG, votes=WITNESSES, needed=2)
POWER = Monitor(
    "power",
    (Condition("bus", "==", "off"),),
    1,
    DOWN,
    votes=(Condition("amps", "<=", 0.1), Condition("tracker", "!=", "on")),
    needed=1,
)
IGNORED = Response(WRONG.name, vetoes={"bus": "on"}, replan="never")


def test_a_sensor_that_two_others_contradict_is_not_believed() -> None:
    """The lock on the bus would break at 18; by then the sensor has been outvoted. No command, no other plan."""
    run = pump([IGNORED], [SENSOR, POWER], {15: {"bus": "off"}})
    assert told(run) == [(16, "detected", WRONG.name), (16, "response", "veto bus, believe on")]
    assert [name for _, name in sent(run)] == ["pump.on", "pump.off"]
    assert run.executive.conclusions == {WRONG.name}
    assert len(run.executive.plans) == 1
    assert run.executive.outcome == "completed"


def test_a_sensor_that_one_other_confirms_is_believed() -> None:
    run = pump([IGNORED], [SENSOR, POWER], {15: {"bus": "off", "amps": 0.0}})
    assert told(run)[0] == (16, "detected", DOWN.name)
    assert run.executive.dispatch.violations["fault"] == 1


def test_a_vetoed_channel_of_which_nothing_is_known_is_not_there() -> None:
    blind = replace(IGNORED, vetoes={"bus": None})
    run = pump([blind], [SENSOR], {15: {"bus": "off"}})
    assert run.told("violation")[0]["kind"] == "lock"
    assert "found nothing" in str(run.told("violation")[0]["detail"])


def test_a_symptom_may_last_longer_than_its_evidence() -> None:
    """Once seen it is there until something else says that it is gone: nothing is tried twice."""
    monitor = Monitor("noise", (Condition("amps", ">", 5.0),), 1, DOWN, until=(Condition("amps", "<", 2.0),))
    events = {12: {"amps": 6.0}, 14: {"amps": 4.0}, 17: {"amps": 1.0}}
    run = pump([Response(DOWN.name, (replace(RESET, within=9),))], [monitor], events)
    assert told(run) == [(13, "detected", DOWN.name), (13, "response", "reset"), (17, "cured")]
    brief = pump([Response(DOWN.name, (replace(RESET, within=9),))], [replace(monitor, until=())], events)
    assert told(brief)[2] == (14, "cured")


def test_whoever_concludes_the_response_is_the_same() -> None:
    """A diagnoser that is no monitor: it is asked at every observation, and its finding is answered."""

    class Oracle:
        def update(self, telemetry: Telemetry, now: int) -> Iterable[Finding]:
            return [Finding("oracle", DOWN)] if 12 <= now < 16 else []

        def dues(self, now: int) -> Iterable[int]:
            return [12, 16] if now < 12 else [16]

    run = pump([Response(DOWN.name, (replace(RESET, within=9),))], diagnosers=[Oracle()])
    assert told(run) == [(12, "detected", DOWN.name), (12, "response", "reset"), (16, "cured")]
    assert [fault.monitor for fault in run.executive.faults] == ["oracle"]
    assert run.executive.outcome == "completed"


# -- probes ------------------------------------------------------------------------------------------------------------

PING = Probe("unit", Send("ping"), every=10, within=3)


def test_silence_is_telemetry() -> None:
    """Every ten seconds; a silent unit is asked again at once; what answers again is asked every ten seconds again."""
    silent = Monitor("unit", (Condition(probe_channel("unit"), "==", "silent"),), 4, DEAF)
    reset = Response(DEAF.name, (replace(RESET, within=4),), replan="never")
    table = {"ping": [Reaction(), DEAD_SILENCE, DEAD_SILENCE, DEAD_SILENCE, Reaction()]}
    run = pump([reset], [silent], probes=[PING], reactions=table)
    pings = [t for t, name in sent(run) if name == "ping"]
    assert pings[:7] == [0, 10, 13, 16, 19, 29, 39]
    assert told(run) == [(17, "detected", DEAF.name), (17, "response", "reset"), (20, "cured")]
    assert run.executive.outcome == "completed"


def test_a_probe_asks_only_while_it_makes_sense() -> None:
    only = replace(PING, while_=(ON,))
    run = pump(probes=[only])
    assert [t for t, name in sent(run) if name == "ping"] == [9, 19]
    failed = Response(DOWN.name, forbids=("pi",), replan="never")
    events = {12: {"amps": 9.0}}
    gone = pump([failed], [Monitor("m", (Condition("amps", ">", 5.0),), 0, DOWN)], events, probes=[PING])
    assert [t for t, name in sent(gone) if name == "ping"] == [0, 10]


# -- recoveries --------------------------------------------------------------------------------------------------------


def test_a_lost_lock_is_restored_with_the_tokens_own_parameters_and_the_time_is_made_up_for() -> None:
    """On from 9, off at 15, on again at 18: three seconds later than planned the pump has run for twenty."""
    run = pump([Response(TRIPPED.name, (AGAIN,))], events={15: {"pump": "off"}})
    assert told(run) == [
        (16, "detected", TRIPPED.name),
        (16, "response", "switch it on"),
        (17, "cured"),
    ]
    assert [e["arguments"] for e in run.told("command.sent")][1] == {"rate": 7}
    assert run.times()["t2.end"] == 8 + 20 + 2
    assert run.executive.conclusions == frozenset()
    assert run.executive.outcome == "completed"
    assert len(run.executive.plans) == 1


def test_what_the_plan_has_no_time_to_make_up_for_is_planned_anew() -> None:
    run = pump([Response(TRIPPED.name, (AGAIN,))], events={15: {"pump": "off"}}, most=21)
    assert run.executive.dispatch.violations == {"short": 1}
    assert "it has to end by 29 s" in str(run.told("violation")[0]["detail"])
    assert len(run.executive.plans) == 2
    assert run.executive.outcome == "completed"


def test_a_lock_that_nothing_restores_is_a_violation_with_what_is_concluded_in_the_end() -> None:
    response = Response(TRIPPED.name, (replace(AGAIN, attempts=2),), otherwise=LOST)
    table = {"pump.on": [STARTS, Reaction(), Reaction(), STARTS]}
    run = pump([response], events={15: {"pump": "off"}}, reactions=table)
    assert told(run)[:5] == [
        (16, "detected", TRIPPED.name),
        (16, "response", "switch it on"),
        (19, "response", "switch it on"),
        (22, "detected", LOST.name),
        (22, "response", "replan"),
    ]
    assert [f.diagnosis for f in run.executive.faults] == [LOST.name]
    assert run.executive.dispatch.violations == {"lock": 1}


def test_no_answer_and_no_effect_are_two_things() -> None:
    """What is not answered is recovered from and sent again; what is answered and does nothing has another response."""
    responses = [Response(DEAF.name, (RESET,))]
    silent = pump(responses, reactions={"pump.on": [DEAD_SILENCE, DEAD_SILENCE, STARTS]})
    assert told(silent) == [(16, "detected", DEAF.name), (16, "response", "reset"), (18, "cured")]
    assert [(t, name) for t, name in sent(silent)][:4] == [
        (8, "pump.on"),
        (12, "pump.on"),
        (16, "reset"),
        (17, "pump.on"),
    ]
    assert silent.executive.outcome == "completed"
    useless = pump(responses, reactions={"pump.on": [Reaction(), Reaction(), STARTS]})
    assert told(useless) == [(16, "detected", WORN.name), (16, "response", "replan")]


def test_steps_go_one_after_another_and_only_when_proven() -> None:
    valve = Step((Send("valve"),), Confirmation((Condition("amps", ">", 2.0),), within=4))
    both = Recovery("valve, then on", (valve, *AGAIN.steps), 2)
    table = {"valve": [Reaction(3, {"amps": 3.0})]}
    run = pump([Response(TRIPPED.name, (both,))], events={15: {"pump": "off"}}, reactions=table)
    assert sent(run)[1:3] == [(16, "valve"), (19, "pump.on")]
    assert told(run)[-1] == (20, "cured")
    stuck = pump([Response(TRIPPED.name, (both, AGAIN))], events={15: {"pump": "off"}})
    assert sent(stuck)[1:3] == [(16, "valve"), (20, "pump.on")]
    assert [row[2] for row in told(stuck) if row[1] == "response"] == ["valve, then on", "switch it on"]


def test_a_recovery_has_its_time_and_its_occasions() -> None:
    """`when` leaves recoveries out, also by what is concluded; `limit` counts over the run; then comes `otherwise`."""
    never = replace(AGAIN, name="never", when=(Condition("amps", ">", 5.0),))
    not_now = replace(AGAIN, name="not now", when=(Condition(concluded_channel(WRONG), "!=", True),))
    response = Response(TRIPPED.name, (never, not_now, AGAIN), limit=1, otherwise=LOST)
    trips = {12: {"bus": "off"}, 18: {"pump": "off"}, 24: {"pump": "off"}}
    run = pump([response, IGNORED], [SENSOR], trips)
    assert [row for row in told(run) if row[0] not in (13,)][:5] == [
        (19, "detected", TRIPPED.name),
        (19, "response", "switch it on"),
        (20, "cured"),
        (25, "detected", TRIPPED.name),
        (25, "detected", LOST.name),
    ]


def test_a_recovery_does_not_break_what_is_to_be_maintained() -> None:
    """It waits until the lock is released; where the plan depends on the device, the plan goes first."""
    monitor = Monitor("noise", (Condition("amps", ">", 5.0),), 1, DOWN)
    rude = replace(RESET, within=60, disturbs=("bus",))
    patient = pump([Response(DOWN.name, (rude,), replan="never")], [monitor], {12: {"amps": 6.0}})
    assert told(patient) == [(13, "detected", DOWN.name), (29, "response", "reset")]
    assert len(patient.executive.plans) == 1
    urgent = pump([Response(DOWN.name, (rude,))], [monitor], {12: {"amps": 6.0}})
    assert told(urgent)[:3] == [
        (13, "detected", DOWN.name),
        (13, "response", "replan"),
        (14, "response", "reset"),
    ]
    polite = replace(rude, disturbs=("amps",))
    assert told(pump([Response(DOWN.name, (polite,))], [monitor], {12: {"amps": 6.0}}))[1] == (13, "response", "reset")


def test_what_a_recovery_restores_may_be_broken_meanwhile_and_what_it_masks_is_not_concluded() -> None:
    """The lock breaks while the monitor's own recovery works on it: no second case, no violation."""
    off = Monitor("off", (OFF, Condition(MODE, "==", "plan"), Condition("amps", ">", 5.0)), 0, DOWN)
    quiet = Monitor("other", (OFF, Condition("amps", ">", 4.0)), 2, WRONG)
    slow = Recovery("valve", (Step((Send("valve"),)),), within=9)
    response = Response(DOWN.name, (slow,), lasts=True, restores=("running",), masks=(WRONG.name,))
    table = {"valve": [Reaction(5, {"pump": "on"})]}
    events = {15: {"pump": "off", "amps": 6.0}, 25: {"amps": 1.0}}
    run = pump([response, IGNORED], [off, quiet], events, reactions=table)
    assert told(run) == [(15, "detected", DOWN.name), (15, "response", "valve"), (20, "worked around")]
    assert run.executive.conclusions == {DOWN.name}
    assert run.executive.outcome == "completed"
    bare = replace(response, restores=(), masks=())
    broken = pump([bare, IGNORED], [off, quiet], events, reactions=table)
    assert {TRIPPED.name, WRONG.name} <= {str(row[2]) for row in told(broken) if row[1] == "detected"}


def test_two_recoveries_go_on_at_once() -> None:
    monitor = Monitor("noise", (Condition("amps", ">", 5.0),), 1, DOWN)
    responses = [Response(DOWN.name, (replace(RESET, within=9),)), Response(TRIPPED.name, (AGAIN,))]
    table = {"reset": [Reaction(4, {"amps": 1.0})]}
    run = pump(responses, [monitor], {15: {"amps": 6.0, "pump": "off"}}, reactions=table)
    assert told(run) == [
        (16, "detected", DOWN.name),
        (16, "response", "reset"),
        (16, "detected", TRIPPED.name),
        (16, "response", "switch it on"),
        (17, "cured"),
        (20, "cured"),
    ]
    assert run.executive.outcome == "completed"


# -- a device that is marked as failed ---------------------------------------------------------------------------------


def test_a_failed_device_gets_no_more_commands_and_the_next_problem_knows_it() -> None:
    """Not even the command that would stop it. Standby does without it, and the planner is told."""
    fact = TokenPattern("Pump.lost", "pump")
    safe = Standby((), Confirmation((Condition("safe", "==", True), OFF), within=5))
    lost = Response(WORN.name, forbids=("pump.",), waives=("pump",), facts=(fact,))
    problems: list[Problem] = []
    table = {"pump.on": [Reaction(12, {"pump": "on"})]}
    run = pump([lost], problems=problems, reactions=table, standby=safe)
    assert [t for t, name in sent(run)] == [8, 12]
    withheld = run.told("command.withheld")
    assert (withheld[0]["t"], withheld[0]["name"], withheld[0]["reason"]) == (16, "pump.off", WORN.name)
    assert [problem.facts for problem in problems][:2] == [(), (fact,)]
    assert run.executive.plans[1].handover == 16 + 1 + 5
    assert run.executive.goals[0].status == "dropped"
    assert "not sent: pump worn" in str(run.executive.goals[0].reason)
