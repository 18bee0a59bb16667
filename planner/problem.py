"""A planning problem and its answer, as values: what an executive gives to the planner and gets back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from planner.plan import Bounds, FlexiblePlan, Value

ANY: Bounds = (None, None)


@dataclass(frozen=True, slots=True)
class TokenPattern:
    """A token to be: predicate `"Class.predicate"`, object (None: any of the class), parameters that are restricted to
    a value or to a tuple of allowed values, and bounds in ticks on its times.

    `contingent` replaces what the domain says of the duration (a running activity's remainder); None leaves it.
    """

    predicate: str
    object: str | None = None
    parameters: Mapping[str, Value | tuple[Value, ...]] = field(default_factory=dict)
    start: Bounds = ANY
    end: Bounds = ANY
    duration: Bounds = ANY
    contingent: bool | None = None


@dataclass(frozen=True, slots=True)
class Goal:
    """A token that the plan should achieve. Of two goals that cannot both be, the higher priority stays."""

    id: str
    token: TokenPattern
    priority: int = 0


@dataclass(frozen=True, slots=True)
class Problem:
    """Horizon [start, end] in ticks; `state`: tokens that hold at its start, whose rules apply; `facts`: tokens that
    are true and seek no support; `goals`: to be achieved inside the horizon, dropped by priority when they cannot be.
    """

    horizon: tuple[int, int]
    state: tuple[TokenPattern, ...] = ()
    facts: tuple[TokenPattern, ...] = ()
    goals: tuple[Goal, ...] = ()


@dataclass(frozen=True, slots=True)
class DroppedGoal:
    """A goal that the plan leaves out.

    `unreachable`: not even alone; `outbid`: not beside those of higher priority; `undecided`: the limits came first.
    """

    id: str
    kind: Literal["unreachable", "outbid", "undecided"]
    reason: str


@dataclass(frozen=True, slots=True)
class SearchStatistics:
    """What the search spent. `steps` counts decisions tried, over all attempts of one call."""

    steps: int = 0
    backtracks: int = 0
    solve_seconds: float = 0.0


@dataclass(frozen=True, slots=True)
class PlanningResult:
    """A plan and the goals it leaves out, or no plan and the reason."""

    plan: FlexiblePlan | None
    dropped: tuple[DroppedGoal, ...] = ()
    reason: str | None = None
    statistics: SearchStatistics = SearchStatistics()


Planner = Callable[[Problem], PlanningResult]
