"""Deep Space 1's fault protection, flown: the cases of May 1999 and what else it is for. Nothing is recorded."""

from __future__ import annotations

import io
import json
from dataclasses import dataclass
from typing import Any

from executive.executive import Executive
from executive.journal import Journal
from executive.records import Settings
from scenarios.config import FaultSection, parse
from scenarios.ds1.bindings import BINDINGS, PLAN_NEXT
from scenarios.ds1.protection import (
    ARRAYS_WEAK,
    ENGINE_FAILED,
    ENGINE_TRIPPED,
    IMAGE_LOST,
    LPE_DEAD,
    LPE_HUNG,
    NEB1_STATUS_FALSE,
    NEB2_OFF,
    RECORDER_STUCK,
    UNSTEADY,
    WHEELS_LOST,
    X_THRUSTER_CLOSED,
)
from scenarios.flight_rules import RuleViolation
from scenarios.run import Flight, RunOptions

SHORT = """
name = "short"
summary = "one thrust, and one downlink after it"
horizon = "3h"
deliberation = "2m"

[[goals]]
id = "thrust"
predicate = "Engine.thrust"
parameters = { heading = "thrust_a", level = 48 }
window = ["10m", "2h30m"]
lasting = "40m"
priority = 2

[[goals]]
id = "downlink"
predicate = "Radio.downlink"
window = ["2h10m", "3h"]
lasting = "5m"
priority = 1
"""
ON_THRUSTERS = SHORT + '[spacecraft]\ninitial_actuators = "thrusters"\n'


@dataclass(frozen=True)
class Story:
    """What a run left behind."""

    executive: Executive
    entries: list[dict[str, Any]]
    telemetry: dict[str, Any]
    broken_rules: tuple[RuleViolation, ...]

    def sent(self, prefix: str) -> list[tuple[int, str]]:
        """The commands on the bus whose names begin so, with their seconds."""
        entries = [e for e in self.entries if e["event"] == "command.sent" and e["name"].startswith(prefix)]
        return [(e["t"], e["name"]) for e in entries]

    def of(self, event: str) -> list[dict[str, Any]]:
        return [e for e in self.entries if e["event"] == event]

    @property
    def goals(self) -> dict[str, str]:
        return {goal.id: goal.status for goal in self.executive.goals}

    @property
    def diagnoses(self) -> list[tuple[int, str | None, tuple[str, ...], bool]]:
        """Detected when, as what, answered by what, and whether it was recovered from."""
        return [(f.detected, f.diagnosis, f.responses, f.recovered is not None) for f in self.executive.faults]


def fly(text: str, **faults: int) -> Story:
    """Fly a scenario with these faults (underscores for dashes) from these seconds on."""
    scenario = parse(text, "short.toml")
    sections = tuple(FaultSection(name=name.replace("_", "-"), at=at) for name, at in faults.items())
    flight = Flight(scenario, RunOptions(seed=3, faults=sections))
    stream = io.StringIO()
    settings = Settings(budget=scenario.deliberation, waypoints=scenario.waypoints, plan_next=PLAN_NEXT)
    executive = Executive(
        flight.port,
        BINDINGS,
        flight.think,
        [goal.goal() for goal in scenario.goals],
        (0, scenario.horizon),
        Journal(stream),
        settings,
    )
    for second in range(scenario.horizon + 1):
        executive.step()
        flight.rules.look(second, flight.plant.telemetry, flight.plant.on_bus)
    executive.finish()
    entries = [json.loads(line) for line in stream.getvalue().splitlines()]
    return Story(executive, entries, dict(flight.plant.telemetry), flight.rules.violations())


def completed_in_one_plan(story: Story) -> None:
    assert story.executive.outcome == "completed"
    assert len(story.executive.plans) == 1
    assert story.executive.dispatch.violations == {}
    assert story.broken_rules == ()


def test_a_hung_terminal_is_reset_and_a_lying_sensor_is_not_believed() -> None:
    """21 May 1999, both at once: 42 s of silence, then the diagnosis, one reset, and no other plan."""
    story = fly(SHORT, lpe_terminal_hung=4000, neb1_status_false=4010)
    by_name = {diagnosis: rest for seen, diagnosis, *rest in story.diagnoses}
    seen_at = {diagnosis: seen for seen, diagnosis, *_ in story.diagnoses}
    assert by_name[NEB1_STATUS_FALSE.name] == [("veto neb1.status, believe on",), False]
    assert seen_at[NEB1_STATUS_FALSE.name] == 4016
    assert by_name[LPE_HUNG.name] == [("reset the terminal",), True]
    seen = seen_at[LPE_HUNG.name]
    asked = max(t for t, _ in story.sent("lpe.status") if t <= seen - 42)
    assert seen == asked + 42
    assert story.sent("terminal.reset") == [(seen, "terminal.reset")]
    assert story.executive.conclusions == {NEB1_STATUS_FALSE.name}
    completed_in_one_plan(story)


def test_a_dead_terminal_is_reset_twice_and_then_left_alone() -> None:
    story = fly(SHORT, lpe_terminal_dead=4000)
    assert len(story.sent("terminal.reset")) == 2
    assert story.executive.conclusions == {LPE_DEAD.name}
    (concluded,) = [e["t"] for e in story.of("fault.detected") if e["diagnosis"] == LPE_DEAD.name]
    assert [t for t, _ in story.sent("lpe.") if t > concluded] == []
    completed_in_one_plan(story)


def test_a_thruster_that_stays_closed_is_worked_around_by_the_other_mode() -> None:
    """During thrust: it is broken off for as long as steering is lost, lit again, and the time is made up for."""
    story = fly(ON_THRUSTERS, thruster_bx_closed=2000)
    first, second, *_ = story.diagnoses
    assert first[1:] == (X_THRUSTER_CLOSED.name, ("thrust off, steer by the z-thrusters about Y",), True)
    assert second[1:] == (ENGINE_TRIPPED.name, ("light it again",), True)
    assert [name for _, name in story.sent("rcs.")] == ["rcs.mode"]
    assert story.telemetry["rcs.mode"] == "z_for_y"
    assert story.telemetry["ips.thrust_seconds"] >= 2400
    assert X_THRUSTER_CLOSED.name in story.executive.conclusions
    completed_in_one_plan(story)


def test_a_thruster_that_stays_closed_shows_while_a_target_is_still_held() -> None:
    """Loosely, and within the limits of being settled: found before an exposure is smeared."""
    story = fly(ON_THRUSTERS, thruster_bx_closed=6600)
    [found] = story.of("fault.detected")
    assert (found["monitor"], found["diagnosis"]) == ("loose under x_for_y", X_THRUSTER_CLOSED.name)
    assert 6660 <= found["t"] < 6800
    completed_in_one_plan(story)
    assert fly(ON_THRUSTERS).of("fault.detected") == []


def test_where_neither_mode_of_the_thrusters_holds_the_wheels_do() -> None:
    """One thruster of either kind is gone: the second mode is given up as the first was."""
    story = fly(ON_THRUSTERS, thruster_bx_closed=2000, thruster_az_closed=2600)
    unsteady = [rest for _, *rest in story.diagnoses if rest[0] == UNSTEADY.name]
    assert unsteady == [[UNSTEADY.name, ("steer by the wheels",), True]]
    assert story.telemetry["acs.actuators"] == "wheels"


def test_an_engine_that_breaks_off_is_lit_again_and_the_goal_has_its_time() -> None:
    story = fly(SHORT, ips_recycle=2400)
    (fault,) = story.diagnoses
    assert fault[1:] == (ENGINE_TRIPPED.name, ("light it again",), True)
    assert story.telemetry["ips.thrust_seconds"] >= 2400
    completed_in_one_plan(story)


def test_an_engine_that_does_not_confirm_gets_no_more_commands() -> None:
    """The start did happen, its confirmation was lost: the thrust is dropped for that reason, the rest is done."""
    story = fly(SHORT, ips_confirmation_lost=60)
    (fault,) = story.diagnoses
    assert fault[1] == ENGINE_FAILED.name
    assert [name for _, name in story.sent("ips.")] == ["ips.start"]
    assert [e["name"] for e in story.of("command.withheld")] == ["ips.stop"]
    assert story.telemetry["ips.state"] == "ready"
    assert story.goals == {"thrust": "dropped", "downlink": "achieved"}
    assert story.executive.outcome == "degraded"
    assert any(token.predicate == "Engine.failed" for token in story.executive.plans[-1].plan.tokens)
    assert story.broken_rules == ()


def test_a_bus_without_power_is_told_from_a_hung_terminal() -> None:
    """Status and current agree: no reset of what hangs behind it, no command to the engine, and the rest is done."""
    story = fly(SHORT, neb2_off=60)
    assert [(seen, what) for seen, what, *_ in story.diagnoses] == [(66, NEB2_OFF.name)]
    assert story.sent("ips.") == story.sent("terminal.") == []
    assert story.goals == {"thrust": "dropped", "downlink": "achieved"}


def test_a_hung_engine_terminal_is_reset_and_the_command_sent_again() -> None:
    story = fly(SHORT, ips_terminal_hung=60)
    assert [name for _, name in story.sent("ips.")][:2] == ["ips.start", "ips.start"]
    assert [name for _, name in story.sent("terminal.")] == ["terminal.reset"]
    completed_in_one_plan(story)


def test_the_hang_of_18_may_1999() -> None:
    """With the missed signal the engine's stop never goes out: seen at its deadline, and the sequencer is restarted."""
    story = fly(SHORT + "[executive]\nhang_bug = true\n")
    (fault,) = story.diagnoses
    assert fault[2] == ("reset the terminal", "restart the command sequencer")
    assert fault[3]
    (stop, again) = story.sent("ips.stop")
    assert fault[0] == stop[0] + 5
    assert again[0] == stop[0] + 11
    completed_in_one_plan(story)
    mended = fly(SHORT + "[executive]\nhang_bug = false\n")
    assert mended.diagnoses == []
    completed_in_one_plan(mended)


def test_arrays_that_give_less_stop_the_thrust_and_the_next_plan_has_less_power() -> None:
    """A fifth is missing at full throttle: found in a minute, the rest of the day is thrust at a level that is fed."""
    story = fly(SHORT.replace(", level = 48", "").replace("2h30m", "2h45m"), array_degraded=2400)
    (fault,) = story.diagnoses
    assert fault[:2] == (2460, ARRAYS_WEAK[1950].name)
    stopped = next(t for t, name in story.sent("ips.") if name == "ips.stop")
    assert stopped == 2460
    first, second = (
        {int(token.parameters["level"]) for token in adopted.plan.tokens if token.predicate == "Engine.thrust"}
        for adopted in story.executive.plans
    )
    assert max(second) < max(first)
    (weak,) = (token for token in story.executive.plans[-1].plan.tokens if token.predicate == "Arrays.weak")
    assert weak.parameters["given"] == 1950
    assert story.goals == {"thrust": "achieved", "downlink": "achieved"}
    assert story.telemetry["battery.soc"] > 0.9
    assert story.broken_rules == ()


def test_arrays_that_give_less_where_it_suffices_are_let_be() -> None:
    story = fly(SHORT, array_degraded=2400)
    assert story.diagnoses == []
    completed_in_one_plan(story)


def test_where_the_wheels_do_not_hold_the_thrusters_do() -> None:
    """A wheel fails while the engine's gimbals steer: found once the wheels have to, and the thrusters take over."""
    story = fly(SHORT, wheel_4_fails=2400)
    first = story.diagnoses[0]
    assert first[1] == WHEELS_LOST.name
    assert first[3]
    assert WHEELS_LOST.name in story.executive.conclusions
    assert story.telemetry["acs.actuators"] == "thrusters"
    assert story.goals == {"thrust": "achieved", "downlink": "achieved"}
    completed_in_one_plan(story)


IMAGING = """
name = "imaging"
summary = "two sessions, and one downlink after them"
horizon = "4h"
deliberation = "2m"

[[goals]]
id = "downlink"
predicate = "Radio.downlink"
window = ["3h10m", "4h"]
lasting = "5m"
priority = 1
""" + "".join(
    f"""
[[goals]]
id = "session-{letter}"
predicate = "Navigation.session"
parameters = {{ target = "asteroid_{letter}" }}
window = ["30m", "3h10m"]
priority = 5
"""
    for letter in "ab"
)


def test_a_recorder_that_takes_no_images_ends_the_imaging() -> None:
    """One image lost may be chance and is tried again; after the second the sessions are unreachable at once."""
    story = fly(IMAGING, recorder_stuck=60)
    assert [what for _, what, *_ in story.diagnoses] == [IMAGE_LOST.name, RECORDER_STUCK.name]
    assert len(story.sent("micas.expose")) == 2
    assert story.goals == {"downlink": "achieved", "session-a": "dropped", "session-b": "dropped"}
    for goal in story.executive.goals:
        assert goal.status == "achieved" or (goal.reason or "").startswith("unreachable")
    last = story.executive.plans[-1]
    assert last.reason.startswith(RECORDER_STUCK.text)
    assert last.statistics.steps < 1000
    assert {token.predicate for token in last.plan.tokens if token.object == "camera"} == {"Camera.retired"}
    assert story.telemetry["micas.switch"] == "off"
    assert story.broken_rules == ()


def test_a_camera_without_its_bus_is_not_planned_with() -> None:
    """The relay of NEB2 opens: one other plan, without images, and nothing is tried in vain."""
    story = fly(IMAGING, neb2_off=1000)
    assert NEB2_OFF.name in story.executive.conclusions
    assert story.goals == {"downlink": "achieved", "session-a": "dropped", "session-b": "dropped"}
    assert len(story.executive.plans) == 2
    assert {token.predicate for token in story.executive.plans[-1].plan.tokens if token.object == "camera"} == {
        "Camera.retired"
    }
    assert story.broken_rules == ()


def test_two_horizons_join_without_a_gap() -> None:
    """The plan says when the next is asked for; at the waypoint it takes over what is running, without standby."""
    later = SHORT.replace('deliberation = "2m"', 'deliberation = "2m"\nwaypoints = ["1h50m"]')
    later = later.replace('window = ["10m", "2h30m"]', 'window = ["10m", "1h50m"]')
    story = fly(later, lpe_terminal_hung=6500)
    first, second = story.executive.plans
    assert (first.plan.horizon[1], second.handover, second.plan.horizon) == (6600, 6600, (6600, 10800))
    assert second.joined
    assert second.requested == 6600 - 2 * 120 - 2
    assert len(story.of("standby.entered")) == 1
    assert story.goals == {"thrust": "achieved", "downlink": "achieved"}
    assert any("continues" in e for e in story.of("token.started") if e["t"] == 6600)
