"""What an executive is told at its start, and what it can say at its end; values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

from executive.errors import ExecutiveError
from planner.plan import FlexiblePlan
from planner.problem import PlanningResult, SearchStatistics, TokenPattern

Deliberation = Callable[[PlanningResult], int]
GoalStatus = Literal["open", "achieved", "dropped", "missed"]
Outcome = Literal["completed", "degraded", "standby", "failed"]


@dataclass(frozen=True, slots=True)
class Settings:
    """How an executive behaves. Times are seconds of simulation clock.

    `scenario`, `seed`: for the journal's first entry. `budget`: from the request of a plan to its hand-over.
    `deliberation`: the time that a planning result costs, at most `budget` or the plan comes too late; None charges the
    whole budget. `retry_delay`: from a failed planning to the next try, doubled with each further failure, at most
    `longest_delay`. `relax_after`: from this many failures in a row on, each withholds one more level of priority, the
    lowest first. `goal_attempts`: a goal whose tokens failed that often is dropped as unreachable. `facts`: of every
    problem (what the sky and the ground do).

    `waypoints`: where horizons end before the run does, ascending; each is planned for on its own, and the next while
    the present one executes. `plan_next`: the token whose execution is asking for the next plan (its binding is
    `bindings.plan_next`), stated in every problem that ends at a waypoint.
    """

    scenario: str = ""
    seed: int = 0
    budget: int = 60
    deliberation: Deliberation | None = None
    retry_delay: int = 60
    longest_delay: int = 3600
    relax_after: int = 2
    goal_attempts: int = 3
    facts: tuple[TokenPattern, ...] = ()
    waypoints: tuple[int, ...] = ()
    plan_next: TokenPattern | None = None

    def __post_init__(self) -> None:
        least = {"budget": 1, "retry_delay": 1, "longest_delay": 1, "relax_after": 1, "goal_attempts": 1}
        for name, smallest in least.items():
            value = getattr(self, name)
            if not isinstance(value, int) or value < smallest:
                raise ExecutiveError(
                    f"settings.{name}: expected a whole number of at least {smallest}, found {value!r}"
                )
        if any(later <= earlier for earlier, later in pairwise(self.waypoints)):
            raise ExecutiveError(f"settings.waypoints: expected ascending seconds, found {list(self.waypoints)}")

    def horizon_end(self, time: int, run_end: int) -> int:
        """Where the horizon that holds `time` (seconds) ends: the next waypoint, or the end of the run."""
        return next((waypoint for waypoint in self.waypoints if time < waypoint < run_end), run_end)


@dataclass(frozen=True, slots=True)
class GoalRecord:
    """Where a goal stands: when that was settled, and why."""

    id: str
    status: GoalStatus = "open"
    time: int | None = None
    reason: str | None = None


@dataclass(frozen=True, slots=True)
class AdoptedPlan:
    """A plan that was executed. `attempts`: plannings that it took. `deliberation_charged`: seconds of all of them.

    `joined`: it took over from the plan before without standby. `dynamically_controllable` is always true: no other
    plan is executed.
    """

    id: str
    plan: FlexiblePlan
    reason: str
    requested: int
    handover: int
    attempts: int
    deliberation_charged: int
    statistics: SearchStatistics
    joined: bool = False
    dynamically_controllable: bool = True


@dataclass(eq=False)
class DispatchStatistics:
    """Timepoints executed, violations by kind, and wall seconds of each call of the dispatcher.

    A call settles one instant: what nature did is propagated, or what is due is decided, performed and propagated.
    What the journal is told of it is not in it.
    """

    timepoints: int = 0
    violations: dict[str, int] = field(default_factory=dict)
    latencies: list[float] = field(default_factory=list)

    def count(self, kind: str) -> None:
        """One more violation of that kind."""
        self.violations[kind] = self.violations.get(kind, 0) + 1
