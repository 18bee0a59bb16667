"""A watch on the executive's own progress, so that nothing in it can wait for ever or run on the spot.

What once stopped a spacecraft's executive was a signal missed between two of its threads: each then waited for the
other (Havelund, Lowry and Penix, "Formal analysis of a space-craft controller using SPIN", IEEE TSE 27(8), 2001). This
executive has one thread and waits for nothing: each step computes from what is known. What is left to go wrong is
watched here: an instant that never comes to rest, and a plan in which nothing can happen any more.
"""

from __future__ import annotations

from executive.execution import Execution
from executive.monitor import Violation

# Rounds of recover, replan and dispatch within one second; each gives a plan up or adopts one, so three are usual.
_MOST_ROUNDS = 20


class Watchdog:
    """Counts the rounds of an instant, and looks for plans that have come to a stop."""

    def __init__(self, most_rounds: int = _MOST_ROUNDS) -> None:
        self._most_rounds = most_rounds
        self._instant = -1
        self._rounds = 0

    def is_spinning(self, now: int) -> bool:
        """Called once a round: whether the instant has had too many, and the rest must wait for the next second."""
        if now != self._instant:
            self._instant, self._rounds = now, 0
        self._rounds += 1
        return self._rounds > self._most_rounds

    def stalled(self, execution: Execution) -> list[Violation]:
        """The violation that a plan is in which nothing is running, nothing may begin, and not everything is over."""
        waiting = execution.stuck()
        if not waiting:
            return []
        return [Violation("stalled", f"nothing can happen any more, and still to come are {', '.join(waiting)}")]
