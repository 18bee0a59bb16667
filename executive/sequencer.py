"""The hang of 18 May 1999, to switch on and off: a command sequencer of two tasks that wake each other.

Each task compares the count of signals that it saw last with the event's own count; when they are equal it waits. In
the faulty program the comparison is made before the lock is taken, and a signal that comes in between is missed: both
tasks then sleep for ever, and no command goes out any more (Havelund, Lowry and Penix, "Formal analysis of a
space-craft controller using SPIN", IEEE TSE 27(8), 2001; Visser et al., "Model checking programs", ASE 10(2), 2003).
"""

from __future__ import annotations

import random
from collections.abc import Collection
from dataclasses import dataclass, replace

from executive.port import Acknowledgement, Command, Observation, Plant

RESTART = "sequencer.restart"
"""Starts the two tasks anew, from then on compared under the lock; by a line of its own, so that it always arrives."""
# Signals that the tasks exchange for one command that ends something: enough that the fault hardly ever stays hidden.
_SIGNALS = 400


@dataclass(frozen=True)
class Tasks:
    """Where the two tasks are. `at`: the next statement of each. `seen`, `counts`: of the two events, modulo 4."""

    at: tuple[str, str] = ("compare", "signal")
    seen: tuple[int, int] = (0, 0)
    counts: tuple[int, int] = (0, 0)

    def next(self, task: int, faulty: bool) -> Tasks | None:
        """One atomic statement of a task; None when it sleeps. Each awaits its own event and signals the other's."""
        match self.at[task]:
            case "compare":
                waits = self.seen[task] == self.counts[task]
                if waits and not faulty:
                    return self._to(task, "asleep")  # comparing and going to sleep is one step under the lock
                return self._to(task, "wait" if waits else "note")
            case "wait":
                return self._to(task, "asleep")
            case "note":
                noted = replace(self, seen=_with(self.seen, task, self.counts[task]))
                return noted._to(task, "signal")
            case "signal":
                other = 1 - task
                told = replace(self, counts=_with(self.counts, other, (self.counts[other] + 1) % 4))
                woken = told._to(other, "note") if self.at[other] == "asleep" else told
                return woken._to(task, "compare")
        return None

    def _to(self, task: int, statement: str) -> Tasks:
        return replace(self, at=(statement, self.at[1]) if task == 0 else (self.at[0], statement))


def _with(pair: tuple[int, int], place: int, value: int) -> tuple[int, int]:
    return (value, pair[1]) if place == 0 else (pair[0], value)


def exchange(rng: random.Random, signals: int, faulty: bool) -> bool:
    """Let the tasks exchange that many signals, in an order that chance decides; False when both sleep for ever."""
    tasks = Tasks()
    while signals:
        first = rng.randrange(2)
        moves = ((task, tasks.next(task, faulty)) for task in (first, 1 - first))
        moved = next(((task, after) for task, after in moves if after is not None), None)
        if moved is None:
            return False
        signals -= tasks.at[moved[0]] == "signal"
        tasks = moved[1]
    return True


class Sequencer:
    """A plant behind such a sequencer. The race is run for the commands in `racing`; once hung, none gets through."""

    def __init__(self, plant: Plant, seed: int, faulty: bool, racing: Collection[str]) -> None:
        self._plant = plant
        self._rng = random.Random(seed)
        self._faulty = faulty
        self._racing = frozenset(racing)
        self._answers: list[Acknowledgement] = []
        self.hung = False

    def __repr__(self) -> str:
        return f"Sequencer({'hung' if self.hung else 'running'}, {'faulty' if self._faulty else 'mended'})"

    def send(self, command: Command) -> None:
        """Pass a command on, unless the tasks sleep."""
        if command.name == RESTART:
            self.hung = self._faulty = False
            self._answers.append(Acknowledgement(command.id, True))
            return
        if not self.hung and command.name in self._racing:
            self.hung = not exchange(self._rng, _SIGNALS, self._faulty)
        if not self.hung:
            self._plant.send(command)

    def advance(self, until: int) -> Observation:
        """Let time pass; what was observed, and the sequencer's own answers."""
        seen = self._plant.advance(until)
        answers, self._answers = tuple(self._answers), []
        return replace(seen, acknowledgements=(*answers, *seen.acknowledgements))
