"""Flying a run again from its journal alone, and comparing the two journals byte for byte.

What was observed, acknowledged, asked for and answered is taken from the journal; everything else is decided again.
Neither the plant nor the planner is needed, only the bindings that the run was flown with.
"""

from __future__ import annotations

import io
from collections.abc import Collection
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

from executive.bindings import Bindings
from executive.executive import Executive
from executive.history import History, RecordedPlanner, RecordedPlant
from executive.journal import Journal

OUTSIDE = frozenset({"fault.injected", "fault.cleared"})
"""Entries that a scenario writes into the journal of its executive; they decide nothing."""


@dataclass(frozen=True, slots=True)
class Difference:
    """The first line (from 1) at which the journals part, as recorded and as it came out; None: no such line."""

    line: int
    recorded: str | None
    replayed: str | None


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """`identical`: every line that there is came out again. `finished`: the run had come to its end, and no line more.

    `lines`: compared. A run that was killed is identical as far as its journal goes.
    """

    identical: bool
    finished: bool
    lines: int
    first_difference: Difference | None


def replay(journal: Path, bindings: Bindings, outside: Collection[str] = OUTSIDE) -> ReplayResult:
    """Fly the run of that journal file again. JournalError for what is no journal.

    `outside`: the events that others than the executive wrote; they are left out of the comparison.
    """
    return replay_history(History.load(journal), bindings, outside)


def replay_history(history: History, bindings: Bindings, outside: Collection[str] = OUTSIDE) -> ReplayResult:
    """`replay` of a journal that has been read."""
    pairs = zip(history.lines, history.entries, strict=True)
    numbered = [(n, line) for n, (line, entry) in enumerate(pairs, 1) if entry["event"] not in outside]
    again = flown_again(history, bindings).splitlines()
    if not history.is_finished:
        again = again[: len(numbered)]
    difference = None
    for recorded, replayed in zip_longest(numbered, again):
        if recorded is None or recorded[1] != replayed:
            line, text = (len(history.lines) + 1, None) if recorded is None else recorded
            difference = Difference(line, text, replayed)
            break
    return ReplayResult(difference is None, history.is_finished, len(numbered), difference)


def flown_again(history: History, bindings: Bindings) -> str:
    """The journal that comes out when the executive decides everything again, up to the last second of the history."""
    if history.start is None or history.last is None:
        return ""
    stream = io.StringIO()
    answers = RecordedPlanner(history, None, None)
    executive = Executive(
        RecordedPlant(history),
        bindings,
        answers.plan,
        history.goals(),
        history.horizon(),
        Journal(stream),
        answers.settings(history.settings()),
    )
    given = history.goals_given()
    while executive.now < history.last:
        for goal in given.get(executive.now + 1, ()):
            executive.add_goal(goal)
        executive.step()
    if history.is_finished:
        executive.finish()
    return stream.getvalue()
