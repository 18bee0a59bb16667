"""Lanes of plan against execution: known answers, and properties against a slow oracle."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from scenarios.recording.lanes import EARLIEST, EXECUTED, LATEST, Block, Lane, TimelineLane
from scenarios.recording.style import Palette
from tests.scenarios import recorded_run as run
from tests.scenarios.recorded import HEADER, Recorded, event, labels, of_token, plan_of, small, token


def test_a_plan_is_drawn_only_while_it_is_in_force(tmp_path: Path) -> None:
    first = plan_of(token("a", "Off", (0, 0), (100, 150)), token("b", "Run", (100, 150), (900, 950)))
    second = plan_of(token("a", "Run", (300, 300), (400, 450)), token("b", "Off", (400, 450), (1000, 1000)))
    with small(tmp_path / "r.rrd") as recorder:
        recorder.plan("plan-01", first, 0)
        recorder.event(of_token(0, "token.started", "plan-01", "a", "Off"))
        recorder.event(of_token(120, "token.finished", "plan-01", "a", "Off", verdict="on_time"))
        recorder.event(of_token(120, "token.started", "plan-01", "b", "Run"))
        recorder.event(event(200, "plan.adopted", plan="plan-02", handover=300, reason="", tokens=2))
        recorder.plan("plan-02", second, 300)
        recorder.event(of_token(430, "token.finished", "plan-02", "a", "Run", verdict="on_time"))
        recorder.event(of_token(430, "token.started", "plan-02", "b", "Off"))
        recorder.event(event(1000, "run.finished", outcome="completed"))
    rows = Recorded(tmp_path / "r.rrd").lane("/mission/1_sc.mode")
    assert [(t, labels(states)) for t, states in rows] == [
        (0, ["plan:Off", "Off", "plan:Off"]),
        (100, ["plan:Run", "Off", "plan:Off"]),
        (120, ["plan:Run", "Run", "plan:Off"]),
        (150, ["plan:Run", "Run", "plan:Run"]),
        (300, ["plan:Run", "Run", "plan:Run"]),  # the same words, of the second plan's tokens
        (400, ["plan:Off", "Run", "plan:Run"]),
        (430, ["plan:Off", "Off", "plan:Run"]),
        (450, ["plan:Off", "Off", "plan:Off"]),
        (1000, ["", "", ""]),
    ]
    assert "plan-01" in rows[3][1][EARLIEST]
    assert "plan-02" in rows[4][1][EARLIEST]


def test_gaps_unbounded_times_and_tokens_past_the_horizon(tmp_path: Path) -> None:
    plan = plan_of(
        token("a", "Off", (0, 0), (100, 110)),
        token("b", "Run", (200, 250), (300, None)),
        token("c", "Wait", (300, None), (1500, None)),
    )
    with small(tmp_path / "r.rrd") as recorder:
        recorder.plan("plan-01", plan, 0)
        recorder.telemetry(500, {}, run.UNIT)
    rows = Recorded(tmp_path / "r.rrd").lane("/mission/1_sc.mode")
    assert [(t, labels(states)) for t, states in rows] == [
        (0, ["plan:Off", "", "plan:Off"]),
        (100, ["", "", "plan:Off"]),
        (110, ["", "", ""]),
        (200, ["plan:Run", "", ""]),
        (250, ["plan:Run", "", "plan:Run"]),
        (300, ["plan:Wait", "", "plan:Run"]),
        (500, ["", "", ""]),
    ]


def test_failed_and_aborted_tokens_stay_until_something_else_starts(tmp_path: Path) -> None:
    with small(tmp_path / "r.rrd") as recorder:
        recorder.plan("plan-01", plan_of(token("a", "Off", (0, 0), (1000, 1000))), 0)
        recorder.event(of_token(10, "token.started", "plan-01", "a", "Turn"))
        recorder.event(of_token(20, "token.failed", "plan-01", "a", "Turn", reason="stuck"))
        recorder.event(of_token(30, "token.started", "plan-01", "b", "Hold"))
        recorder.event(of_token(35, "token.finished", "plan-01", "a", "Turn", verdict="late"))
        recorder.event(of_token(40, "token.aborted", "plan-01", "b", "Hold"))
        recorder.event(event(50, "run.finished", outcome="failed"))
    rows = Recorded(tmp_path / "r.rrd").lane("/mission/1_sc.mode")
    executed = [(t, labels(states)[EXECUTED]) for t, states in rows]
    assert executed == [(0, ""), (10, "Turn"), (20, "failed:Turn"), (30, "Hold"), (40, "aborted:Hold"), (50, "")]


def test_standby_ends_the_plan(tmp_path: Path) -> None:
    with small(tmp_path / "r.rrd") as recorder:
        plan = plan_of(token("a", "Off", (0, 0), (500, 500)), token("b", "Run", (500, 500), (900, 900)))
        recorder.plan("plan-01", plan, 0)
        recorder.event(event(100, "plan.requested", reason="why", attempt=1, budget=60))
        recorder.event(event(160, "plan.failed", reason="nothing fits"))
        recorder.event(event(160, "standby.entered", reason="no plan"))
        recorder.event(event(700, "standby.left"))
        recorder.telemetry(800, {}, run.UNIT)
    read = Recorded(tmp_path / "r.rrd")
    assert [t for t, _ in read.lane("/mission/1_sc.mode")] == [0, 160]
    header = [(t, states[:2]) for t, states in read.lane(HEADER)]
    assert header == [
        (0, ["in_force:plan-01", ""]),
        (100, ["in_force:plan-01", "planner:planning: why"]),
        (160, ["standby:no plan", "planner:no plan: nothing fits"]),
        (700, ["", "planner:no plan: nothing fits"]),
        (800, ["", ""]),
    ]


_moves = st.lists(
    st.tuples(st.sampled_from(["put", "withdraw", "write"]), st.integers(0, 9), st.integers(0, 1), st.integers(0, 2)),
    max_size=30,
)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(_moves)
def test_a_lane_shows_what_was_put_last(moves: list[tuple[str, int, int, int]]) -> None:
    """Against an oracle that keeps every line as a table second by second; time never goes back."""
    lane, now, end = Lane("/x", 2), 0, 200
    table = [[""] * end for _ in range(2)]
    pending: list[tuple[int, int, int, str]] = []
    rows: dict[int, list[str]] = {}
    for number, (what, ahead, line_, value) in enumerate(moves):
        name = ("", "a", "b")[value]
        if what == "put":
            lane.put(now + ahead, line_, Block(name, name, 0xFF) if name else None)
            pending.append((now + ahead, number, line_, name))
        elif what == "withdraw":
            lane.withdraw(now + ahead, line_)
            pending = [p for p in pending if p[2] != line_ or p[0] < now + ahead]
        else:
            now += ahead
            rows.update(_new_rows(rows, lane.due(now)))
    rows.update(_new_rows(rows, lane.due(end)))
    for time, _, line_, name in sorted(pending):
        table[line_][time:] = [name] * (end - time)
    times = list(rows)
    assert times == sorted(times)
    assert all(rows[a] != rows[b] for a, b in pairwise(times))
    shown = ["", ""]
    for second in range(end):
        shown = rows.get(second, shown)
        assert shown == [table[0][second], table[1][second]]


def _new_rows(old: dict[int, list[str]], new: dict[int, list[str]]) -> dict[int, list[str]]:
    assert not set(old) & set(new), "a second has two rows"
    return new


_spans = st.lists(st.tuples(st.integers(0, 60), st.integers(0, 30), st.booleans()), min_size=1, max_size=6)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.lists(st.tuples(st.integers(0, 80), _spans), min_size=1, max_size=4))
def test_planned_lines_belong_to_the_plan_in_force(plans: list[tuple[int, list[tuple[int, int, bool]]]]) -> None:
    """Whatever the bounds, in order or not: monotone rows, each of the plan in force, tokens in their order."""
    timeline = TimelineLane("/x", Palette())
    handover, rows, handovers = 0, {}, []
    for number, (gap, spans) in enumerate(plans):
        handover += gap
        handovers.append((handover, f"p{number}"))
        rows.update(timeline.lane.due(handover))
        tokens, start = [], max(0, handover - 40)
        for i, (length, slack, unbounded) in enumerate(spans):
            upper = None if unbounded and i == len(spans) - 1 else start + slack
            end = start + length, None if upper is None else upper + length
            tokens.append(token(f"{i}", "Run", (start, upper), end))
            start += length
        timeline.plan(tokens, f"p{number}", handover)
    rows.update(timeline.lane.due(10_000))
    assert list(rows) == sorted(rows)
    last: dict[tuple[str, int], int] = {}
    for time, states in rows.items():
        in_force = [plan for since, plan in handovers if since <= time][-1]
        for which in (EARLIEST, LATEST):
            if states[which]:
                plan, index = states[which].rpartition("#")[2].split(".")
                assert plan == in_force
                assert int(index) >= last.get((plan, which), 0)
                last[plan, which] = int(index)


def test_a_time_that_is_written_is_not_written_again() -> None:
    lane = Lane("/x", 1)
    lane.put(5, 0, Block("a", "a", 0xFF))
    assert lane.due(6) == {5: ["a"]}
    lane.put(3, 0, Block("b", "b", 0xFF))
    assert lane.due(10) == {6: ["b"]}
