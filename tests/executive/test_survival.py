"""Replay and resume: a journal is enough to fly a run again, and to take it up again wherever it was cut."""

from __future__ import annotations

import io
import json
import random
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from executive.errors import JournalError, ResumeError
from executive.executive import Executive
from executive.history import History
from executive.journal import Journal
from executive.port import Command, Observation
from executive.records import Settings
from executive.replay import Difference, replay, replay_history
from executive.resume import Continuation, planner_of, resume
from planner.problem import PlanningResult, Problem
from tests.executive.scripted import (
    AT_START,
    RESET,
    TUMBLES,
    Reaction,
    ScriptedPlant,
    bindings,
    fly,
    goals,
    planner,
    reactions,
    turn,
)

HORIZON = (0, 200)
SETTINGS = Settings("survival", 7, budget=5, retry_delay=10, deliberation=lambda result: 3)
BINDINGS = bindings(RESET, TUMBLES)
LATE_GOAL = replace(goals("pallas")[0], id="image-pallas")


def eventful_plant() -> ScriptedPlant:
    """Resets that help at the second try, a refusal, a tumble that costs the plan."""
    table = reactions(
        reset=[Reaction(), Reaction(1, {"camera.state": "ready"})],
        turn=[turn(10), turn(13), turn(7)],
        image=[
            Reaction(answer=False),
            *(
                Reaction(1, {"camera.state": "exposing"}, then=((4, {"camera.state": "ready", "camera.images": n}),))
                for n in range(1, 9)
            ),
        ],
    )
    return ScriptedPlant(AT_START, table, {24: {"camera.state": "stuck"}, 60: {"acs.mode": "tumble"}})


class Moody:
    """A planner that raises, then finds nothing, then plans; it counts how often it was asked."""

    def __init__(self) -> None:
        self.asked = 0

    def __call__(self, problem: Problem) -> PlanningResult:
        self.asked += 1
        if problem.horizon[0] < 7:
            raise ValueError("out of memory")
        if problem.horizon[0] < 22:
            return PlanningResult(None, reason="nothing found")
        return planner(problem)


def go_on(executive: Executive) -> None:
    """To the end, with a goal that comes in on the way."""
    while executive.now < HORIZON[1]:
        if executive.now + 1 == 90:
            executive.add_goal(LATE_GOAL)
        executive.step()
    executive.finish()


def flown() -> tuple[bytes, list[Command], Executive]:
    plant = eventful_plant()
    run = fly(plant, BINDINGS, Moody(), goals("vesta", "ceres"), HORIZON, SETTINGS, go_on)
    return run.text.encode(), plant.sent, run.executive


JOURNAL, SENT, FLOWN = flown()


def resumed(path: Path, plant: ScriptedPlant, moody: Moody) -> Executive:
    with Continuation(path) as stream:
        executive = resume(stream, plant, BINDINGS, moody, goals("vesta", "ceres"), HORIZON, SETTINGS)
        go_on(executive)
    return executive


# -- replay ------------------------------------------------------------------------------------------------------------


def test_the_run_is_eventful() -> None:
    events = {json.loads(line)["event"] for line in JOURNAL.decode().splitlines()}
    assert {"fault.response", "plan.failed", "plan.adopted", "goal.given", "command.timeout"} - events <= {
        "command.timeout"
    }
    assert len(FLOWN.plans) >= 2
    assert FLOWN.outcome == "completed"


def test_a_journal_alone_gives_the_same_journal(tmp_path: Path) -> None:
    path = tmp_path / "journal.jsonl"
    path.write_bytes(JOURNAL)
    result = replay(path, BINDINGS)
    assert result.identical, result.first_difference
    assert result.finished
    assert result.lines == JOURNAL.count(b"\n")


def test_what_others_wrote_is_left_out_of_the_comparison() -> None:
    lines = JOURNAL.splitlines(keepends=True)
    lines[3:3] = [b'{"event":"fault.injected","name":"stuck","t":1}\n']
    result = replay_history(History.of(b"".join(lines)), BINDINGS)
    assert (result.identical, result.lines) == (True, len(lines) - 1)


@pytest.mark.parametrize(
    "event", ["observation", "command.acknowledged", "plan.answered", "goal.given", "command.sent"]
)
def test_a_journal_that_was_tampered_with_is_not_reproduced(event: str) -> None:
    lines = JOURNAL.decode().splitlines(keepends=True)
    numbers = [n for n, line in enumerate(lines) if json.loads(line)["event"] == event]
    refused = [n for n in numbers if '"accepted":false' in lines[n]]
    number = refused[0] if refused else numbers[len(numbers) // 2]
    gone = lines[number]
    result = replay_history(History.of("".join(lines[:number] + lines[number + 1 :]).encode()), BINDINGS)
    assert not result.identical, gone


def test_the_first_difference_is_told() -> None:
    lines = JOURNAL.decode().splitlines()
    number = next(n for n, line in enumerate(lines) if json.loads(line)["event"] == "command.sent")
    changed = lines[number].replace("safe.standby", "safe.stand")
    lines[number] = changed
    result = replay_history(History.of("".join(line + "\n" for line in lines).encode()), BINDINGS)
    assert result.first_difference == Difference(number + 1, changed, changed.replace("safe.stand", "safe.standby"))


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, len(JOURNAL)))
def test_a_journal_cut_anywhere_is_replayed_as_far_as_it_goes(length: int) -> None:
    result = replay_history(History.of(JOURNAL[:length]), BINDINGS)
    assert result.identical, result.first_difference
    assert result.lines == JOURNAL[:length].count(b"\n")
    assert result.finished is (length == len(JOURNAL))


def test_what_is_no_journal_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(JournalError, match="No such file"):
        replay(tmp_path / "none.jsonl", BINDINGS)
    with pytest.raises(JournalError, match="journal:2: not a line of JSON"):
        History.of(b'{"event":"a","t":1}\n{"ev\n{"event":"a","t":1}\n')
    with pytest.raises(JournalError, match="journal:1: expected an object with 't' and 'event'"):
        History.of(b"[1]\n")


def test_no_wall_clock_value_is_ever_written() -> None:
    """The planner's seconds and the decisions' latencies differ from run to run; the journal does not."""

    def slow(problem: Problem) -> PlanningResult:
        time.sleep(0.002)
        result = planner(problem)
        return replace(result, statistics=replace(result.statistics, solve_seconds=time.perf_counter()))

    runs = [fly(ScriptedPlant(AT_START, reactions()), plan=plan) for plan in (planner, slow, slow)]
    assert len({run.text for run in runs}) == 1
    assert runs[1].executive.plans[0].statistics.solve_seconds > 0
    assert all(isinstance(entry["t"], int) for entry in runs[0].entries)


def test_what_the_planner_was_charged_is_part_of_the_record(tmp_path: Path) -> None:
    """Deliberation that was measured differs from run to run; flown again, it costs what it cost."""
    measured = iter(range(2, 100))
    run = fly(
        eventful_plant(),
        BINDINGS,
        planner,
        goals("vesta", "ceres"),
        HORIZON,
        replace(SETTINGS, deliberation=lambda result: next(measured)),
    )
    assert [p.deliberation_charged for p in run.executive.plans][:2] == [2, 3]
    assert replay_history(History.of(run.text.encode()), BINDINGS).identical
    path = tmp_path / "journal.jsonl"
    path.write_bytes(run.text.encode()[: run.text.index('"plan-02"')])
    dearer = replace(SETTINGS, deliberation=lambda result: 5)
    with Continuation(path) as stream:
        executive = resume(stream, eventful_plant(), BINDINGS, planner, goals("vesta", "ceres"), HORIZON, dearer)
        executive.run_until(HORIZON[1])
    assert [p.deliberation_charged for p in executive.plans][:2] == [2, 3]


# -- resume ------------------------------------------------------------------------------------------------------------


def test_killed_at_fifty_random_instants(tmp_path: Path) -> None:
    """Cut at any byte: the same final journal, the same commands once each, no question to the planner twice."""
    rng = random.Random(5)
    asked_in_all = JOURNAL.count(b'"event":"plan.answered"')
    for number, length in enumerate([0, 1, len(JOURNAL) - 1, len(JOURNAL), *rng.sample(range(len(JOURNAL)), 50)]):
        path = tmp_path / f"{number}.jsonl"
        path.write_bytes(JOURNAL[:length])
        plant, moody = eventful_plant(), Moody()
        executive = resumed(path, plant, moody)
        assert path.read_bytes() == JOURNAL, f"cut at byte {length}"
        assert plant.sent == SENT
        complete = JOURNAL[: JOURNAL[:length].rfind(b"\n") + 1]
        assert moody.asked == asked_in_all - complete.count(b'"event":"plan.answered"')
        assert executive.goals == FLOWN.goals
        assert executive.outcome == FLOWN.outcome


def test_killed_again_while_it_catches_up_and_after(tmp_path: Path) -> None:
    path = tmp_path / "journal.jsonl"
    path.write_bytes(JOURNAL[: len(JOURNAL) // 3])
    for seconds in (2, 40, 55):
        with Continuation(path) as stream:
            executive = resume(stream, eventful_plant(), BINDINGS, Moody(), goals("vesta", "ceres"), HORIZON, SETTINGS)
            executive.run_until(min(executive.now + seconds, 85))
        with path.open("ab") as file:
            file.write(b'{"event":"obs')
    resumed(path, eventful_plant(), Moody())
    assert path.read_bytes() == JOURNAL


def test_a_plant_that_does_not_repeat_itself_is_noticed(tmp_path: Path) -> None:
    class Elsewhere(ScriptedPlant):
        def advance(self, until: int) -> Observation:
            seen = super().advance(until)
            return replace(seen, changes={**seen.changes, "acs.target": "mars"}) if until == 12 else seen

    path = tmp_path / "journal.jsonl"
    path.write_bytes(JOURNAL[: len(JOURNAL) // 2])
    with Continuation(path) as stream, pytest.raises(ResumeError, match="the run does not repeat itself: expected"):
        resume(stream, Elsewhere(AT_START, reactions()), BINDINGS, Moody(), goals("vesta", "ceres"), HORIZON, SETTINGS)
    assert path.read_bytes() == JOURNAL[: JOURNAL[: len(JOURNAL) // 2].rfind(b"\n") + 1]


def test_another_runs_journal_is_not_continued(tmp_path: Path) -> None:
    path = tmp_path / "journal.jsonl"
    path.write_bytes(JOURNAL[:5000])
    with Continuation(path) as stream, pytest.raises(ResumeError, match=r"journal\.jsonl:1: the run does not repeat"):
        resume(stream, eventful_plant(), BINDINGS, Moody(), goals("vesta"), HORIZON, SETTINGS)


def test_what_others_write_is_written_again(tmp_path: Path) -> None:
    """As a scenario does: entries of its own between the steps, an executive of its own, the recorded planner."""

    def fly_in(journal: Journal, history: History | None) -> None:
        answers, priced = planner_of(history or History.of(b""), planner, SETTINGS)
        executive = Executive(eventful_plant(), BINDINGS, answers.plan, goals("vesta"), HORIZON, journal, priced)
        while executive.now < HORIZON[1]:
            if executive.now + 1 in (0, 24, 60):
                journal.write(executive.now + 1, "fault.injected", {"name": "scripted"})
            executive.step()
        executive.finish()

    whole = io.StringIO()
    fly_in(Journal(whole), None)
    text = whole.getvalue().encode()
    assert replay_history(History.of(text), BINDINGS).identical
    for length in (0, 100, text.index(b'"scripted","t":24') + 30, len(text) // 2, len(text)):
        path = tmp_path / f"{length}.jsonl"
        path.write_bytes(text[:length])
        with Continuation(path) as stream:
            fly_in(Journal(stream), stream.history)
            stream.check_caught_up()
        assert path.read_bytes() == text


_CHILD = """
import sys, time
from pathlib import Path
from executive.journal import Journal
from executive.executive import Executive
from tests.executive import test_survival as t
executive = Executive(t.eventful_plant(), t.BINDINGS, t.Moody(), t.goals("vesta", "ceres"), t.HORIZON,
                      Journal.create(Path(sys.argv[1])), t.SETTINGS)
step = executive.step
def slowly():
    step()
    time.sleep(0.004)
executive.step = slowly
print("ready", flush=True)
t.go_on(executive)
"""


@pytest.mark.parametrize("delay", [0.0, 0.23, 0.61])
def test_a_killed_process_is_taken_up_again(tmp_path: Path, delay: float) -> None:
    path = tmp_path / "journal.jsonl"
    root = Path(__file__).parents[2]
    child = subprocess.Popen(
        [sys.executable, "-c", _CHILD, str(path)], cwd=root, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    assert child.stdout is not None
    with child.stdout as said:
        assert said.readline() == b"ready\n"
        time.sleep(delay)
        child.kill()
        assert child.wait() == -9
    assert len(path.read_bytes()) < len(JOURNAL)
    plant = eventful_plant()
    resumed(path, plant, Moody())
    assert path.read_bytes() == JOURNAL
    assert plant.sent == SENT
