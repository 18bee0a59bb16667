"""The plans that a run has executed, in order, and what each leaves out."""

from __future__ import annotations

from typing import Protocol

from executive.goals import GoalBook
from executive.journal import Journal
from executive.records import AdoptedPlan
from executive.replanner import Ready


class Search(Protocol):
    """What led to a plan, from standby or while another was executed."""

    reason: str
    requested: int | None
    attempts: int
    failures: int
    charged: int


class Adoptions:
    """Takes plans into force. `run_end`: the second at which the run ends."""

    def __init__(self, goals: GoalBook, journal: Journal, run_end: int) -> None:
        self._goals = goals
        self._journal = journal
        self._run_end = run_end
        self._plans: list[AdoptedPlan] = []

    @property
    def plans(self) -> tuple[AdoptedPlan, ...]:
        """All so far."""
        return tuple(self._plans)

    def adopt(self, ready: Ready, search: Search, now: int, *, joined: bool) -> str:
        """Record a plan, and what becomes of the goals that it leaves out; returns its name."""
        assert search.requested is not None
        plan_id = f"plan-{len(self._plans) + 1:02d}"
        self._plans.append(
            AdoptedPlan(
                plan_id,
                ready.plan,
                search.reason,
                search.requested,
                now,
                search.attempts,
                search.charged,
                ready.result.statistics,
                joined,
            )
        )
        entry = {"plan": plan_id, "handover": now, "reason": search.reason, "tokens": len(ready.plan.tokens)}
        self._journal.write(now, "plan.adopted", entry)
        end = ready.plan.horizon[1]
        self._goals.left(ready.result.dropped, now, end if end < self._run_end else None)
        for goal_id in ready.withheld:
            self._goals.left_out(goal_id, f"withheld from {plan_id} after {search.failures} failed plannings")
        return plan_id
