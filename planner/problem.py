"""A planning problem and its answer, as values: what an executive gives to the planner and gets back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
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
class ConstraintPattern:
    """A constraint token to be: an attribute `"Class.attribute"` of an object (None: some object of the class) has only
    these values from start to end, and may change among them. Without values it has none.

    Of the patterns in `values` the predicate and the parameters count. Without bounds on its start the token begins
    with the horizon, and without bounds on end and duration it ends with it.
    """

    attribute: str
    values: tuple[TokenPattern, ...] = ()
    object: str | None = None
    start: Bounds = ANY
    end: Bounds = ANY
    duration: Bounds = ANY

    def within(self, horizon: tuple[int, int]) -> ConstraintPattern:
        """The pattern with the bounds that it has over a horizon."""
        start = (horizon[0], horizon[0]) if self.start == ANY else self.start
        end = (horizon[1], horizon[1]) if self.end == self.duration == ANY else self.end
        return replace(self, start=start, end=end)


@dataclass(frozen=True, slots=True)
class Goal:
    """A token that the plan should achieve. Of two goals that cannot both be, the higher priority stays."""

    id: str
    token: TokenPattern
    priority: int = 0


@dataclass(frozen=True, slots=True)
class Problem:
    """Horizon [start, end] in ticks; `state`: tokens that hold at its start, whose rules apply; `facts`: tokens that
    are true and seek no support; `goals`: to be achieved inside the horizon, dropped by priority when they cannot be;
    `constraints`: what attributes keep to, whatever else the plan does.
    """

    horizon: tuple[int, int]
    state: tuple[TokenPattern, ...] = ()
    facts: tuple[TokenPattern, ...] = ()
    goals: tuple[Goal, ...] = ()
    constraints: tuple[ConstraintPattern, ...] = ()


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
