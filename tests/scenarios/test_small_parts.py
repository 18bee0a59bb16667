"""Times, words and boards."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenarios.config import parse
from scenarios.errors import ScenarioError
from scenarios.faults import chosen_faults
from scenarios.recording.boards import HeaderLane
from scenarios.run_story import RunStory
from scenarios.times import clock, seconds_of
from scenarios.words import Reasons, in_words, most_like


@settings(max_examples=200, derandomize=True)
@given(st.integers(0, 10**9 - 1))
def test_a_clock_reads_back(seconds: int) -> None:
    assert seconds_of(clock(seconds)) == seconds
    assert seconds_of(f"{seconds}s") == seconds
    hours, rest = divmod(seconds, 3600)
    assert seconds_of(f"{hours}h{rest // 60}m{rest % 60}s") == seconds


@pytest.mark.parametrize("text", ["", " ", "h", "3h20", "1:2", "00:61", "3 hours", "-3", "1.5h", None, True, 2.0, []])
def test_what_is_no_time(text: object) -> None:
    if text == "3h20":
        assert seconds_of(text) == 3 * 3600 + 20
        return
    with pytest.raises(ValueError, match="expected seconds or a time"):
        seconds_of(text)


def test_a_plan_is_given_up_for_what_was_concluded_then() -> None:
    reasons, raw = Reasons(), "unconfirmed: start: x not confirmed"
    reasons.tell({"t": 4, "event": "fault.detected", "text": "something older"})
    reasons.tell({"t": 5, "event": "standby.entered", "reason": "late: not ended after 9 s"})
    reasons.tell({"t": 9, "event": "fault.detected", "text": "the switch is stuck"})
    reasons.tell({"t": 9, "event": "standby.entered", "reason": raw})
    assert reasons.say(raw) == "the switch is stuck"
    assert reasons.say("late: not ended after 9 s") == "something took too long: not ended after 9 s"
    assert in_words("initial") == "the first plan"
    assert in_words("whatever: it was") == "whatever: it was"
    assert in_words("next horizon from 259200 s") == "next horizon from 3d 00:00:00"
    assert in_words("too much, at 3600: a uses 150") == "too much, at 01:00:00: a uses 150"
    failed = {"t": 9, "event": "token.failed", "reason": "unconfirmed: whatever"}
    assert reasons.retold(failed)["reason"] == "the switch is stuck"
    assert reasons.retold(failed | {"t": 10})["reason"] == "a command had no effect: whatever"
    assert reasons.waits("initial") == "waiting for the first plan"


def test_a_fault_is_handled_once_a_plan_that_knew_of_it_takes_over() -> None:
    header, unseen = HeaderLane(), ("c", "c: not yet detected")
    header.fault_injected(10, "a")
    header.fault_injected(11, "b")
    header.fault_injected(12, "c")
    header.fault_detected(20, "a", "a is broken")
    header.requested(21, "a is broken")
    header.fault_detected(22, "b", "b is broken")
    header.handed_over(30, "plan-02")
    assert header.faults() == [("a", "a: handled by plan-02"), ("b", "b: detected, b is broken"), unseen]
    header.requested(31, "b is broken")
    header.handed_over(40, "plan-03")
    assert header.faults() == [("a", "a: handled by plan-02"), ("b", "b: handled by plan-03"), unseen]


def test_several_faults_keep_their_lines_from_injection_to_recovery() -> None:
    header = HeaderLane()
    header.fault_injected(10, "lpe-terminal-hung")
    header.fault_injected(20, "micas-stuck-on")
    assert header.fault_detected(30, "unconfirmed", "micas.switch stuck_on") == "micas-stuck-on"
    assert header.fault_detected(31, "lpe.silent", "LPE terminal is silent") == "lpe-terminal-hung"
    header.fault_answered(32, "lpe.silent", "reset LPE")
    header.fault_answered(33, "unconfirmed", "replan")
    header.fault_recovered(40, "lpe.silent", cured=True)
    assert header.faults() == [
        ("lpe-terminal-hung", "lpe-terminal-hung: handled by reset LPE"),
        ("micas-stuck-on", "micas-stuck-on: detected, micas.switch stuck_on; replan"),
    ]
    header.fault_cleared(50, "lpe-terminal-hung")
    header.fault_injected(60, "lpe-terminal-hung")
    rows = header.each_fault.due(100)
    assert rows[10][0] == "lpe-terminal-hung: not yet detected"
    assert rows[40][0] == "lpe-terminal-hung: handled by reset LPE"
    assert rows[50] == ["", "micas-stuck-on: detected, micas.switch stuck_on; replan"]
    assert rows[60][0] == "lpe-terminal-hung: not yet detected"


def test_what_is_detected_is_matched_by_the_words_it_shares() -> None:
    assert most_like(["neb1-status-false", "micas-stuck-on"], "micas.switch stuck_on") == "micas-stuck-on"
    assert most_like(["a", "b"], "nothing in common", None) == "a"
    assert most_like([], "anything") is None


def test_faults_at_rates_are_drawn_from_the_seed() -> None:
    text = """
name = "chance"
summary = "s"
horizon = "3d"
[[fault_rates]]
name = "ips-recycle"
mean_between = "14h24m"
parameters = { seconds = [60, 240] }
[[fault_rates]]
name = "star-tracker-fails"
mean_between = "1d"
lasting = ["10m", "20m"]
"""
    scenario = parse(text, "chance.toml")
    drawn = chosen_faults(scenario, None, seed=3)
    assert {fault.name for fault in drawn} == {"ips-recycle", "star-tracker-fails"}
    assert drawn == chosen_faults(scenario, None, seed=3)
    assert drawn != chosen_faults(scenario, None, seed=4)
    assert chosen_faults(scenario, []) == ()
    with pytest.raises(ScenarioError, match=r"chance.toml: fault_rates\[0\].*expected parameters seconds"):
        parse(text.replace("seconds =", "minutes ="), "chance.toml")


def test_a_token_that_a_joining_plan_takes_over_ends_under_its_new_name() -> None:
    place = {"object": "engine", "attribute": "mode", "predicate": "Engine.standby", "parameters": {}}
    entries = [
        {"t": 0, "event": "token.started", "plan": "plan-01", "token": "t9", **place},
        {"t": 50, "event": "token.finished", "plan": "plan-02", "token": "t2", "ended": 50, **place},
        {"t": 60, "event": "token.started", "plan": "plan-02", "token": "t3", **place},
    ]
    story = RunStory(entries, {}, {}, (0, 100), 100)
    done = [(stretch.start, stretch.end, stretch.state) for _, stretch in story._done()]
    assert done == [(0, 50, "finished"), (60, 100, "running")]


def test_a_token_that_goes_on_under_the_next_plan_is_drawn_once_at_a_time() -> None:
    place = {"object": "engine", "attribute": "mode", "predicate": "Engine.standby", "parameters": {}}
    entries = [
        {"t": 0, "event": "token.started", "plan": "plan-01", "token": "t9", **place},
        {"t": 40, "event": "token.started", "plan": "plan-02", "token": "t1", "continues": "plan-01/t9", **place},
        {"t": 50, "event": "token.finished", "plan": "plan-02", "token": "t1", "ended": 50, **place},
    ]
    story = RunStory(entries, {}, {}, (0, 100), 100)
    assert [(stretch.start, stretch.end) for _, stretch in story._done()] == [(0, 40), (40, 50)]
