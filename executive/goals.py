"""Where every goal stands, from the first time it was asked for to the end of the run."""

from __future__ import annotations

from collections.abc import Iterable

from executive.journal import Journal
from executive.records import GoalRecord, GoalStatus
from planner.problem import DroppedGoal, Goal


class GoalBook:
    """Where every goal stands. What is achieved or dropped stays so; every change is journalled."""

    def __init__(self, goals: Iterable[Goal], journal: Journal) -> None:
        self._goals = tuple(goals)
        self._journal = journal
        self._records = {goal.id: GoalRecord(goal.id) for goal in self._goals}
        self._last_words: dict[str, str] = {}
        self._failed: dict[str, int] = {}

    @property
    def records(self) -> tuple[GoalRecord, ...]:
        """All goals in the order given."""
        return tuple(self._records.values())

    def add(self, goal: Goal) -> None:
        """One goal more, as open as the others; nothing for one that is known."""
        if goal.id not in self._records:
            self._goals = (*self._goals, goal)
            self._records[goal.id] = GoalRecord(goal.id)

    def unfinished(self, before: int | None = None) -> tuple[Goal, ...]:
        """The goals neither achieved nor dropped, without those that can only begin at `before` (seconds) or later."""
        return tuple(
            goal
            for goal in self._goals
            if self._records[goal.id].status == "open" and (before is None or (goal.token.start[0] or 0) < before)
        )

    def least(self, goal_id: str) -> int:
        """How long a goal's token has to last at least (seconds); 0 for a goal that is not known."""
        return next((goal.token.duration[0] or 0 for goal in self._goals if goal.id == goal_id), 0)

    def left(self, dropped: Iterable[DroppedGoal], now: int, until: int | None) -> None:
        """What a plan leaves out: settled, unless nothing was decided, or what comes after `until` may still reach it.

        `until`: the end of the plan's horizon when another follows, else None.
        """
        latest = {goal.id: goal.token.end[1] for goal in self._goals}
        for goal in dropped:
            last = latest.get(goal.id)
            if goal.kind == "undecided":
                self.left_out(goal.id, f"undecided: {goal.reason}")
            elif until is None or (last is not None and last <= until):
                self.dropped(goal.id, now, f"{goal.kind}: {goal.reason}")
            else:
                self.left_out(goal.id, f"{goal.kind} before {until} s: {goal.reason}")

    def achieved(self, goal_id: str, now: int) -> None:
        """A token of the goal is over, proven."""
        self._settle(goal_id, "achieved", now, None)

    def dropped(self, goal_id: str, now: int, reason: str) -> None:
        """The planner left it out for good."""
        self._settle(goal_id, "dropped", now, reason)

    def failed(self, goal_id: str, now: int, reason: str, limit: int) -> None:
        """A token that served the goal failed; for the `limit`th time, the goal is not tried again."""
        self._failed[goal_id] = self._failed.get(goal_id, 0) + 1
        if self._failed[goal_id] >= limit:
            self.dropped(goal_id, now, f"unreachable: failed {limit} times, the last time {reason}")

    def left_out(self, goal_id: str, reason: str) -> None:
        """The plan in execution does without it; the next may not. Said if the goal is missed in the end."""
        self._last_words[goal_id] = reason

    def missed(self, now: int) -> None:
        """The run is over: what is open now is missed."""
        for goal in self.unfinished():
            reason = self._last_words.get(goal.id, "not achieved before the end of the run")
            self._settle(goal.id, "missed", now, reason)

    def _settle(self, goal_id: str, status: GoalStatus, now: int, reason: str | None) -> None:
        record = self._records.get(goal_id)
        if record is None or record.status != "open":
            return
        self._records[goal_id] = GoalRecord(goal_id, status, now, reason)
        self._journal.write(now, "goal", {"id": goal_id, "status": status, "reason": reason})
