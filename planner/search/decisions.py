"""Decisions: the paper's operations as values. Each is the owner of what it posts, so explanations can name it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol

from planner.constraints.network import AnyVariable, TimeVariable, Variable
from planner.database import PlanDatabase
from planner.domains import Domain, Interval
from planner.model.classes import ModelObject
from planner.tokens.gap import Gap
from planner.tokens.instance import GuardInstance
from planner.tokens.token import Token


class Decision(Protocol):
    """One way to resolve a flaw."""

    def apply(self, database: PlanDatabase) -> None:
        """Carry it out and propagate; Inconsistency when it leads nowhere."""
        ...


@dataclass(frozen=True, eq=False, slots=True)
class Insert:
    """Insert a token into an empty slot of a timeline: the one at `position` of the sequence as it stands."""

    token: Token
    object: ModelObject
    position: int

    def apply(self, database: PlanDatabase) -> None:
        """Decide the object, take the slot, instantiate the configuration constraints."""
        tokens = database.tokens
        database.network.restrict(self.token.object, tokens.domain_of_object(self.object), self)
        tokens.insert(self.token, self.position, self)
        keep_apart(database, self.token, self.position)
        database.network.propagate()

    def __repr__(self) -> str:
        return f"insert {self.token.name} on {self.object}.{self.token.predicate.attribute} at {self.position}"


@dataclass(frozen=True, eq=False, slots=True)
class Activate:
    """Make a token of an attribute without order active on an object."""

    token: Token
    object: ModelObject

    def apply(self, database: PlanDatabase) -> None:
        """Decide the object and instantiate the configuration constraints."""
        database.network.restrict(self.token.object, database.tokens.domain_of_object(self.object), self)
        database.tokens.activate(self.token, self)
        database.network.propagate()

    def __repr__(self) -> str:
        return f"activate {self.token.name} on {self.object}"


@dataclass(frozen=True, eq=False, slots=True)
class Codesignate:
    """Let a token be one with a host that is already on its timeline."""

    token: Token
    host: Token

    def apply(self, database: PlanDatabase) -> None:
        """Equate all variables of the two."""
        database.tokens.merge(self.token, self.host, self)
        database.network.propagate()

    def __repr__(self) -> str:
        return f"codesignate {self.token.name} with {self.host.name}"


@dataclass(frozen=True, eq=False, slots=True)
class Reject:
    """Leave a rejectable token out of the plan."""

    token: Token

    def apply(self, database: PlanDatabase) -> None:
        """Reject it."""
        database.tokens.reject(self.token)
        database.network.propagate()

    def __repr__(self) -> str:
        return f"reject {self.token.name}"


@dataclass(frozen=True, eq=False, slots=True)
class Assign:
    """Assign one value to a variable."""

    variable: Variable
    value: Any
    domain: Domain

    def apply(self, database: PlanDatabase) -> None:
        """Restrict the variable's domain to the value."""
        database.network.restrict(self.variable, self.domain, self)
        database.network.propagate()

    def __repr__(self) -> str:
        return f"assign {self.variable.name} = {self.value}"


@dataclass(frozen=True, eq=False, slots=True)
class Settle:
    """Decide the test of a guard: this relation over its scope, which makes the test hold or fail, is true."""

    guard: GuardInstance
    procedure: str
    scope: tuple[AnyVariable, ...]
    holds: bool

    def apply(self, database: PlanDatabase) -> None:
        """Post the relation and apply the guard's branch."""
        database.tokens.require(self.procedure, self.scope, self)
        self.guard.fire(self.holds)
        database.network.propagate()

    def __repr__(self) -> str:
        return f"let {self.procedure}({', '.join(v.name for v in self.scope)})"


@dataclass(frozen=True, eq=False, slots=True)
class Order:
    """Let one timepoint come `gap` ticks or more before another, so that a resource is not overdrawn."""

    first: TimeVariable
    second: TimeVariable
    gap: int = 0

    def apply(self, database: PlanDatabase) -> None:
        """Post the precedence."""
        database.network.distance(self.first, self.second, self.gap, math.inf, self)
        database.network.propagate()

    def __repr__(self) -> str:
        return f"order {self.first.name} before {self.second.name}" + (f" by {self.gap}" if self.gap else "")


@dataclass(frozen=True, eq=False, slots=True)
class Limit:
    """Keep a time or a quantity within an interval, so that a resource is not overdrawn."""

    variable: AnyVariable
    domain: Interval

    def apply(self, database: PlanDatabase) -> None:
        """Restrict the variable."""
        database.network.restrict(self.variable, self.domain, self)
        database.network.propagate()

    def __repr__(self) -> str:
        return f"keep {self.variable.name} within {self.domain!r}"


def keep_apart(database: PlanDatabase, token: Token, position: int) -> None:
    """Leave time between a token that was inserted and its neighbours for what must come between them.

    A fact has no rules, so it asks for nothing to come after it; nor does a token that may lie outside the horizon.
    Facts are on their timelines before anything else is, hence no later one can come in between.
    """
    timelines = database.tokens.timelines
    timeline = database.tokens.timeline_of(token)
    graph = database.model.transitions_of(timeline.object.cls, timeline.attribute)
    if graph.is_free:
        return
    alone = any(host.role == "fact" for home in graph.around for host in timelines[home].sequence)
    near = timeline.sequence[max(0, position - 1) : position + 2]
    for first, second in pairwise(near):
        if not any(t.role == "fact" or t.may_be_outside(database.horizon) for t in (first, second)):
            database.network.watch(Gap(graph, first, second, alone))
