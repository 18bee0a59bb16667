"""Bindings say exactly what is wrong with them; the journal takes plain data and nothing else."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from executive.activities import decided
from executive.bindings import Activity, Bindings, Finish, Maintained, Standby
from executive.conditions import Condition
from executive.errors import BindingsError, JournalError
from executive.journal import Journal
from executive.protection import Monitor, Recovery, Response, Step
from executive.sends import Conclusion, Confirmation, Send
from planner.plan import PlanToken
from tests.executive.scripted import RESET, bindings

READY = Condition("camera.state", "==", "ready")
DONE = Conclusion("done", "it is done")
WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "no end": (
        lambda: Activity("A.turn", contingent=True),
        "activity 'A.turn'.finish: a contingent activity needs the conditions that are its end, found none",
    ),
    "an end too many": (
        lambda: Activity("A.hold", finish=Finish((READY,))),
        "activity 'A.hold'.finish: only a contingent activity ends by itself, and this one is not",
    ),
    "an empty end": (
        lambda: Activity("A.turn", contingent=True, finish=Finish(())),
        "activity 'A.turn'.finish.conditions: expected at least one condition, found none",
    ),
    "unknown parameter of a command": (
        lambda: Activity("A.turn", ("target",), start=(Send("go", {"to": "$goal"}),)),
        r"activity 'A.turn'.start command 'go': unknown parameter '\$goal', expected \$object, \$target",
    ),
    "unknown parameter of a stop": (
        lambda: Activity("A.turn", stop=(Send("halt", {"to": "$goal"}),)),
        r"activity 'A.turn'.stop command 'halt': unknown parameter '\$goal', expected \$object",
    ),
    "unknown parameter of a condition": (
        lambda: Activity("A.turn", started=Confirmation((Condition("a", "==", "$goal"),))),
        r"activity 'A.turn'.started: unknown parameter '\$goal'",
    ),
    "unknown parameter of a lock": (
        lambda: Activity("A.turn", maintained=(Maintained("m", (Condition("a", "==", "$goal"),)),)),
        r"activity 'A.turn'.maintained 'm': unknown parameter '\$goal'",
    ),
    "an empty lock": (
        lambda: Activity("A.turn", maintained=(Maintained("m", ()),)),
        "activity 'A.turn'.maintained 'm'.conditions: expected at least one, found none",
    ),
    "a channel as argument": (
        lambda: Activity("A.turn", start=(Send("go", {"to": "@other"}),)),
        r"activity 'A.turn'.start command 'go': an argument is a value or a '\$parameter', found '@other'",
    ),
    "no time": (
        lambda: Activity("A.turn", started=Confirmation(within=0)),
        "activity 'A.turn'.started.within: expected a whole number of seconds or times of at least 1, found 0",
    ),
    "negative retries": (
        lambda: Activity("A.turn", ended=Confirmation(retries=-1)),
        "activity 'A.turn'.ended.retries: .* at least 0, found -1",
    ),
    "never to be seen": (
        lambda: Activity("A.turn", started=Confirmation((READY,), within=5, persistence=5)),
        "activity 'A.turn'.started: a persistence of 5 s can never be seen within 5 s",
    ),
    "a monitor of nothing": (
        lambda: Monitor("m", (), 0, DONE),
        "monitor 'm'.conditions: expected at least one condition, found none",
    ),
    "a monitor without a start": (
        lambda: Monitor("m", (Condition("a", "changed_by", 1),), 0, DONE),
        "monitor 'm'.conditions: 'changed_by' compares with the start of an activity",
    ),
    "a monitor with a parameter": (
        lambda: Monitor("m", (Condition("a", "==", "$x"),), 0, DONE),
        r"monitor 'm'.conditions: unknown parameter '\$x', expected no parameter",
    ),
    "a response without time": (
        lambda: Response("r", (Recovery("wait", (Step(()),), 0),)),
        "response to 'r'.recoveries 'wait'.within: .* at least 1, found 0",
    ),
    "standby without proof": (
        lambda: Standby((), Confirmation()),
        "standby.confirmation.conditions: expected what says that standby is reached, found none",
    ),
    "two of one predicate": (
        lambda: Bindings((Activity("A.x"), Activity("A.x")), bindings().standby, bindings().state),
        "bindings.activities: expected one activity for 'A.x', found 2",
    ),
    "two monitors of one name": (
        lambda: bindings(RESET, RESET),
        "bindings.monitors: expected one monitor 'camera-stuck', found 2",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_errors_are_exact(case: str) -> None:
    make, message = WRONG[case]
    with pytest.raises(BindingsError, match=message):
        make()


def test_every_channel_that_is_needed_is_subscribed_to() -> None:
    bound = bindings(Monitor("m", (Condition("bus.volts", "<", "@bus.limit"),), 0, DONE))
    assert bound.channels() == {
        "acs.mode",
        "acs.settled",
        "acs.target",
        "bus.limit",
        "bus.volts",
        "camera.images",
        "camera.state",
    }
    assert replace(bound, observed=("extra",)).channels() - bound.channels() == {"extra"}


def test_of_an_undecided_parameter_the_first_value_is_taken() -> None:
    parameters = {"a": ("x", "y"), "b": {"min": 3, "max": 9}, "c": {"min": None, "max": 9}, "d": 4, "e": {}}
    token = PlanToken("t1", "cam", "mode", "C.p", parameters, (0, 0), (1, 1), (1, 1))
    assert decided(token) == {"object": "cam", "a": "x", "b": 3, "c": 9, "d": 4, "e": 0.0}


def test_journal_lines_are_sorted_compact_and_flushed(tmp_path: Path) -> None:
    path = tmp_path / "journal.jsonl"
    with Journal.create(path) as journal:
        journal.write(3, "goal", {"status": "achieved", "id": "g", "reason": None})
        assert path.read_text() == '{"event":"goal","id":"g","reason":null,"status":"achieved","t":3}\n'
        journal.write(4, "standby.left")
    assert [json.loads(line)["t"] for line in path.read_text().splitlines()] == [3, 4]
    with pytest.raises(JournalError, match="journal entry 'late' at 5 s: the journal is closed"):
        journal.write(5, "late")


def test_a_journal_never_overwrites_another(tmp_path: Path) -> None:
    (tmp_path / "journal.jsonl").write_text("old\n")
    with pytest.raises(JournalError, match=r"journal.jsonl: File exists"):
        Journal.create(tmp_path / "journal.jsonl")
    assert (tmp_path / "journal.jsonl").read_text() == "old\n"


@pytest.mark.parametrize("value", [float("nan"), float("inf"), object(), {1, 2}])
def test_what_is_not_plain_data_is_refused(value: object) -> None:
    stream = io.StringIO()
    with pytest.raises(JournalError, match="journal entry 'x' at 1 s"):
        Journal(stream).write(1, "x", {"value": value})
    assert stream.getvalue() == ""
