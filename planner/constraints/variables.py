"""Variables of the constraint network: plain ones, timepoints, and the distances between timepoints."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Protocol

from planner.domains import Domain, Interval
from planner.temporal.network import TemporalNetworkManager

if TYPE_CHECKING:
    from planner.constraints.network import Propagator

Owner = Any
"""Who posted a constraint or restricted a domain: a decision, a rule instance, the problem. Compared by `is`."""

UNBOUNDED = 1 << 49
"""A timepoint's bound from here on says nothing."""


class Named(Protocol):
    """What a variable may be a part of."""

    @property
    def name(self) -> str:
        """Its name."""
        ...


class _Part:
    """Something with a name: its own, or that of what it is a part of (`of`) and its own; made when somebody asks."""

    __slots__ = ("of", "part")

    part: str
    of: Named | None

    @property
    def name(self) -> str:
        """The name."""
        return self.part if self.of is None else f"{self.of.name}.{self.part}"


class Variable(_Part):
    """A variable with its domain. `owner`: who made it. `latest`: the index of its latest change in the log, or -1."""

    __slots__ = ("domain", "latest", "owner", "watchers")

    def __init__(self, name: str, domain: Domain, owner: Owner, of: Named | None = None) -> None:
        self.part = name
        self.of = of
        self.domain: Domain = domain
        self.owner = owner
        self.watchers: list[Propagator] = []
        self.latest = -1

    def __repr__(self) -> str:
        return f"{self.name}={self.domain!r}"


class TimeVariable(_Part):
    """A timepoint as a variable: its domain is what the temporal network says. `narrowings`: the temporal constraints
    that restricted it."""

    __slots__ = ("narrowings", "owner", "temporal", "timepoint", "watchers")

    def __init__(
        self, name: str, timepoint: int, temporal: TemporalNetworkManager, owner: Owner, of: Named | None = None
    ) -> None:
        self.part = name
        self.of = of
        self.timepoint = timepoint
        self.temporal = temporal
        self.owner = owner
        self.watchers: list[Propagator] = []
        self.narrowings: list[int] = []

    @property
    def domain(self) -> Domain:
        """The timepoint's bounds."""
        lower, upper = self.temporal.lower(self.timepoint), self.temporal.upper(self.timepoint)
        return Interval(lower if lower > -UNBOUNDED else -math.inf, upper if upper < UNBOUNDED else math.inf)

    def __repr__(self) -> str:
        return f"{self.name}={self.domain!r}"


class DurationVariable(_Part):
    """The distance from one timepoint to another as a variable: what is stated of it, within the bounds of both ends.

    Of a duration that nature decides (`by_nature`) only what is stated counts: what the network wants of it is no
    reason for nature. `latest`: the index of the latest change of `stated` in the log, or -1. `narrowings`: the
    temporal constraints that restricted it.
    """

    __slots__ = ("by_nature", "end", "latest", "narrowings", "owner", "start", "stated", "watchers")

    def __init__(
        self,
        name: str,
        start: TimeVariable,
        end: TimeVariable,
        stated: Interval,
        owner: Owner,
        of: Named | None = None,
    ) -> None:
        self.part = name
        self.of = of
        self.start = start
        self.end = end
        self.stated = stated
        self.owner = owner
        self.watchers: list[Propagator] = []
        self.narrowings: list[int] = []
        self.latest = -1
        self.by_nature = False

    @property
    def domain(self) -> Domain:
        """What the constraints on the distance and, but for nature's choice, the bounds of both ends leave."""
        if self.by_nature:
            return self.stated
        start, end = self.start.domain, self.end.domain
        return self.stated.bounded(end.lower - start.upper, end.upper - start.lower)

    def __repr__(self) -> str:
        return f"{self.name}={self.domain!r}"


AnyVariable = Variable | TimeVariable | DurationVariable
