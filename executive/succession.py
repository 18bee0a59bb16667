"""The plan that follows a plan in execution and is joined to it without standby: sought while the present one goes on.

It is planned from what the present plan will have running at the hand-over, and adopted only if that came true. One
that is too late, or that reality has overtaken, is thrown away; the present plan does not suffer from it.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from executive.execution import Execution
from executive.forecast import Forecast
from executive.goals import GoalBook
from executive.journal import Journal
from executive.replanner import Failed, Ready, Replanner, Request

Status = Literal["none", "asked", "ready", "failed"]

# A plan for a goal that came in is sought so often; then the goal waits for the next plan.
_TRIES_FOR_A_GOAL = 3


class Succession:
    """One search for the plan after `execution`. Times are seconds.

    `joins_at`: the waypoint where the next horizon begins; None: as soon as possible within the present horizon, which
    is how goals that came in get into the plan. `end`: of the plan sought. `attempts`, `charged`: so far.
    """

    def __init__(
        self,
        execution: Execution,
        reason: str,
        joins_at: int | None,
        end: int,
        replanner: Replanner,
        goals: GoalBook,
        journal: Journal,
        now: int,
    ) -> None:
        self.reason = reason
        self.joins_at = joins_at
        self.requested: int | None = now
        self.attempts = self.charged = self.failures = 0
        self.is_over = False
        self._execution = execution
        self._end = end
        self._replanner = replanner
        self._goals = goals
        self._journal = journal
        self._pending: Ready | Failed | None = None
        self._forecast: Forecast | None = None
        self._asked_at = self._retry_at = now
        self._waits_until = now

    def status(self, now: int) -> Status:
        """What may be said of the latest request by now: a planner that overruns its budget has failed by then."""
        if self._pending is None:
            return "asked" if self.attempts == 0 and not self.is_over else "failed"
        if now < self._waits_until:
            return "asked"
        return "ready" if isinstance(self._pending, Ready) else "failed"

    def pursue(self, now: int) -> None:
        """Take note of a failure; ask when it is time."""
        if isinstance(self._pending, Failed) and now >= self._pending.known:
            self._replanner.learn(self._pending)
            self._fail(self._pending.reason, now)
        if self._pending is None and not self.is_over and now >= self._retry_at:
            self._request(now)

    def plan_to_join(self, now: int) -> Ready | None:
        """The plan to adopt now, if the state is as foretold; if not, it is thrown away."""
        if not isinstance(self._pending, Ready) or now < self._pending.handover or self._forecast is None:
            return None
        difference = self._execution.departs(self._forecast)
        if difference is None:
            return self._pending
        self._fail(f"the state at hand-over differs: {difference}", now)
        return None

    def give_up(self, reason: str, now: int) -> None:
        """Seek no longer."""
        if not self.is_over and self._pending is not None:
            self._journal.write(now, "plan.failed", {"reason": reason})
        self._pending, self.is_over = None, True
        self._execution.hold(None)

    def dues(self) -> Iterable[int]:
        """The seconds at which waiting alone changes something."""
        if self.is_over:
            return
        if self._pending is None:
            yield self._retry_at
            return
        yield self._waits_until
        yield self._pending.handover if isinstance(self._pending, Ready) else self._pending.known

    def _request(self, now: int) -> None:
        budget = self._replanner.budget
        if self.joins_at is not None and now + budget > self.joins_at:
            self.is_over = True
            self._journal.write(
                now, "plan.failed", {"reason": f"no time is left before the waypoint {self.joins_at} s"}
            )
            return
        forecast = self._execution.foresee(None if self.joins_at is not None else now + budget)
        self.attempts += 1
        if isinstance(forecast, str):
            self._fail(f"the state at hand-over cannot be told: {forecast}", now)
            return
        handover = forecast.handover
        entry = {"reason": self.reason, "attempt": self.attempts, "budget": budget, "handover": handover}
        self._journal.write(now, "plan.requested", entry)
        served = self._execution.goals_until(None if self.joins_at is not None else forecast)
        goals = tuple(goal for goal in self._goals.unfinished(self._end) if goal.id not in served)
        self._forecast, self._asked_at = forecast, now
        # For a goal that came in nothing is withheld: without it the plan in execution is as good as another.
        relaxing = self.failures if self.joins_at is not None else 0
        self._pending = self._replanner.plan(Request(now, handover, self._end, forecast.state, goals, relaxing))
        self.charged += self._pending.charged
        self._waits_until = now + min(self._pending.charged, budget)
        if self.joins_at is None and isinstance(self._pending, Ready):
            self._execution.hold(forecast)

    def _fail(self, reason: str, now: int) -> None:
        self._pending = self._forecast = None
        self._execution.hold(None)
        self.failures += 1
        self._journal.write(now, "plan.failed", {"reason": reason})
        self._retry_at = now + self._replanner.delay(self.failures)
        if self.joins_at is None and self.failures >= _TRIES_FOR_A_GOAL:
            self.is_over = True
