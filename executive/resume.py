"""Taking a run up again after it was killed at any instant: its journal goes on as if nothing had happened.

A simulated plant dies with its run, but given the same commands at the same times it repeats itself. So the run is
flown again from its start: the executive decides again, each entry that the journal already has must come out again
and is not written twice, the planner is not asked what it has answered, and the commands that bring the plant back to
where it was are those of the journal. From the journal's end on the run goes on with nothing lost and nothing twice.
"""

from __future__ import annotations

from collections.abc import Iterable
from io import TextIOBase
from pathlib import Path
from typing import BinaryIO

from executive.bindings import Bindings
from executive.errors import JournalError, ResumeError
from executive.executive import Executive
from executive.history import History, RecordedPlanner
from executive.journal import Journal
from executive.port import Plant
from executive.records import Settings
from planner.problem import Goal, Planner


class Continuation(TextIOBase):
    """The stream of a journal that goes on: lines that the file has are compared, those beyond them are appended.

    ResumeError when a line departs from the file's. `catching_up`: the end of the file has not been reached yet.
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.history = History.load(path)
        self._path = path
        self._compared = 0
        self._file = _open_at_end(path, sum(len(line.encode()) + 1 for line in self.history.lines))

    @property
    def catching_up(self) -> bool:
        """Whether the journal still knows better what comes next."""
        return self._compared < len(self.history.lines)

    def check_caught_up(self) -> None:
        """ResumeError if there are lines left that did not come out again."""
        if self.catching_up:
            missing = self.history.lines[self._compared]
            raise ResumeError(f"{self._path}:{self._compared + 1}: the run did not come to this again: {missing}")

    def write(self, text: str, /) -> int:
        """One line with its end."""
        if self.catching_up:
            expected = self.history.lines[self._compared]
            self._compared += 1
            if text != expected + "\n":
                raise ResumeError(
                    f"{self._path}:{self._compared}: the run does not repeat itself: expected {expected}, "
                    f"found {text.rstrip()}"
                )
        else:
            self._file.write(text.encode())
            self._file.flush()
        return len(text)

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()


def resume(
    stream: Continuation,
    plant: Plant,
    bindings: Bindings,
    planner: Planner,
    goals: Iterable[Goal],
    horizon: tuple[int, int],
    settings: Settings | None = None,
) -> Executive:
    """The executive of a killed run, brought to the last second of its journal; `plant` starts anew and comes along.

    All but the stream is what the run was started with. ResumeError when the run comes out differently. Goals that came
    in are in the journal; what others wrote into it (a scenario's faults) must be written again by whoever does so:
    they use `planner_of` and an executive of their own instead, and step it themselves.
    """
    answers, priced = planner_of(stream.history, planner, settings)
    executive = Executive(plant, bindings, answers.plan, goals, horizon, Journal(stream), priced)
    given = stream.history.goals_given()
    last = stream.history.last
    while last is not None and executive.now < last:
        for goal in given.get(executive.now + 1, ()):
            executive.add_goal(goal)
        executive.step()
    if stream.history.is_finished:
        executive.finish()
    stream.check_caught_up()
    return executive


def planner_of(
    history: History, planner: Planner, settings: Settings | None = None
) -> tuple[RecordedPlanner, Settings]:
    """The planner that answers what is in the journal as it did then, and the settings that charge for it likewise."""
    chosen = settings or Settings()
    recorded = RecordedPlanner(history, planner, chosen.deliberation)
    return recorded, recorded.settings(chosen)


def _open_at_end(path: Path, length: int) -> BinaryIO:
    """The file without the line that was being written when the run was killed."""
    try:
        file = path.open("r+b")
        file.truncate(length)
        file.seek(length)
    except OSError as error:
        raise JournalError(f"{path}: {error.strerror}") from error
    return file
