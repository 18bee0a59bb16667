"""A journal read back: what came from outside, by the second at which it came.

A run that was killed leaves at most its last line cut short; such a line never counts. Everything else that is not an
entry is an error, named by its line.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from executive.errors import JournalError, RecordedError
from executive.inputs import Answer, answer_from_json, goal_from_json, settings_from_json
from executive.port import Acknowledgement, Command, Observation, TelemetryValue
from executive.records import Deliberation, Settings
from planner.problem import Goal, Planner, PlanningResult, Problem

Entry = Mapping[str, Any]


@dataclass(frozen=True)
class History:
    """The complete lines of a journal, without their line ends, and the entries that they are."""

    lines: tuple[str, ...]
    entries: tuple[Entry, ...]

    @classmethod
    def load(cls, path: Path) -> History:
        """Read a journal file; JournalError says which line is not an entry."""
        try:
            content = path.read_bytes()
        except OSError as error:
            raise JournalError(f"{path}: {error.strerror}") from error
        return cls.of(content, str(path))

    @classmethod
    def of(cls, content: bytes, where: str = "journal") -> History:
        """The history in a journal's bytes. What follows the last line end was being written, and is left out."""
        lines, entries = [], []
        for number, raw in enumerate(content.split(b"\n")[:-1], 1):
            try:
                line = raw.decode()
                entry = json.loads(line)
            except (UnicodeDecodeError, json.JSONDecodeError) as error:
                raise JournalError(f"{where}:{number}: not a line of JSON: {error}") from error
            if not isinstance(entry, dict) or not isinstance(entry.get("t"), int) or "event" not in entry:
                raise JournalError(f"{where}:{number}: expected an object with 't' and 'event', found {line[:80]}")
            lines.append(line)
            entries.append(entry)
        return cls(tuple(lines), tuple(entries))

    @property
    def start(self) -> Entry | None:
        """What the run was started with; None if not even that was written."""
        return next((entry for entry in self.entries if entry["event"] == "run.started"), None)

    @property
    def is_finished(self) -> bool:
        """Whether the run came to its end."""
        return bool(self.entries) and self.entries[-1]["event"] == "run.finished"

    @property
    def last(self) -> int | None:
        """The last second of which there is an entry."""
        return self.entries[-1]["t"] if self.entries else None

    def of_event(self, event: str) -> Iterator[Entry]:
        """The entries of one kind, in order."""
        return (entry for entry in self.entries if entry["event"] == event)

    def goals(self) -> tuple[Goal, ...]:
        """The goals that the run was started with."""
        return tuple(goal_from_json(content) for content in _field(self.start, "goals"))

    def goals_given(self) -> dict[int, list[Goal]]:
        """The goals that came in later, by the second."""
        found: dict[int, list[Goal]] = {}
        for entry in self.of_event("goal.given"):
            found.setdefault(entry["t"], []).append(goal_from_json(entry))
        return found

    def horizon(self) -> tuple[int, int]:
        """The run's first and last second."""
        first, last = _field(self.start, "horizon")
        return first, last

    def settings(self) -> Settings:
        """The run's settings, without facts and the price of planning, which the answers hold."""
        start = self.start
        return settings_from_json(_field(start, "scenario"), _field(start, "seed"), _field(start, "settings"))

    def answers(self) -> tuple[Answer, ...]:
        """What the planner answered, in order."""
        return tuple(answer_from_json(entry) for entry in self.of_event("plan.answered"))


def _field(entry: Entry | None, name: str) -> Any:
    if entry is None or name not in entry:
        raise JournalError(f"journal: the entry 'run.started' with the field {name!r} is missing")
    return entry[name]


class RecordedPlant:
    """Says what a journal says was observed. Commands go nowhere: whoever compares the journals compares them."""

    def __init__(self, history: History) -> None:
        self._changes: dict[int, dict[str, TelemetryValue]] = {}
        self._answers: dict[int, list[Acknowledgement]] = {}
        for entry in history.entries:
            if entry["event"] == "observation":
                self._changes[entry["t"]] = entry["changes"]
            elif entry["event"] == "command.acknowledged":
                said = Acknowledgement(entry["id"], entry["accepted"], entry["reason"])
                self._answers.setdefault(entry["t"], []).append(said)

    def send(self, command: Command) -> None:
        """Nothing: the command was carried out in the run that is flown again."""

    def advance(self, until: int) -> Observation:
        """What was observed at that second."""
        return Observation(until, self._changes.get(until, {}), tuple(self._answers.get(until, ())))


class RecordedPlanner:
    """Answers as the journal says that the planner did; after its end asks the planner, if there is one.

    `plan` is the planner, `charge` the price of what it last answered (`Settings.deliberation`).
    """

    def __init__(self, history: History, planner: Planner | None, deliberation: Deliberation | None) -> None:
        self._recorded = deque(history.answers())
        self._planner = planner
        self._deliberation = deliberation
        self._charged: int | None = None

    def plan(self, problem: Problem) -> PlanningResult:
        """The next recorded answer, or the planner's own."""
        if self._recorded:
            answer = self._recorded.popleft()
            self._charged = answer.charged
            if answer.raised is not None:
                raise RecordedError(answer.raised)
            return answer.result
        self._charged = None
        if self._planner is None:
            raise RecordedError("the journal has no further answer of the planner")
        return self._planner(problem)

    def settings(self, settings: Settings) -> Settings:
        """The settings with recorded prices while there are recorded answers."""
        return replace(settings, deliberation=lambda result: self._charge(result, settings.budget))

    def _charge(self, result: PlanningResult, budget: int) -> int:
        if self._charged is not None:
            return self._charged
        return budget if self._deliberation is None else self._deliberation(result)
