"""ConstraintNetworkManager (paper, section 5): dynamic variables and constraints, propagated to a joint fixpoint.

One door for change: a domain shrinks only through `restrict(variable, domain, because)`. The reason is kept: it is the
explanation of tomorrow's inconsistency. The temporal network is a propagator inside the same fixpoint; timepoints and
durations are variables like any other to a constraint procedure.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple, Protocol

from planner.constraints.procedure import ConstraintProcedure
from planner.constraints.variables import (
    UNBOUNDED,
    AnyVariable,
    DurationVariable,
    Named,
    Owner,
    TimeVariable,
    Variable,
)
from planner.domains import Domain, Interval
from planner.temporal.network import INFINITY, TemporalNetworkManager
from planner.trail import Trail

__all__ = [
    "AnyVariable",
    "Constraint",
    "ConstraintNetworkManager",
    "DurationVariable",
    "Inconsistency",
    "Moment",
    "Owner",
    "Propagator",
    "TimeVariable",
    "Variable",
    "ticks",
]

FAR = UNBOUNDED + (UNBOUNDED >> 1)
"""Where the bounds of a timepoint begin, give or take its drift."""
DRIFT = 1 << 16
"""Ticks by which the bounds of each new timepoint begin later than those of the one before. Stated order mostly follows
time, and then an unbounded chain posts in linear time: no new link moves the bounds of all those before it."""


class Inconsistency(Exception):  # noqa: N818 - the field's word; it is a signal of search, not a user's error
    """No solution below this point: what was asked for (`because`) leaves a variable, a scope or time without values.

    `because`: the propagator that found no solution, or the owner of a restriction. `variable`: the one that the
    restriction would leave without values. `cycle`: temporal constraints that cannot hold together.
    """

    def __init__(self, because: Owner = None, variable: AnyVariable | None = None, cycle: tuple[int, ...] = ()) -> None:
        super().__init__()
        self.because = because
        self.variable = variable
        self.cycle = cycle


class Propagator(Protocol):
    """What may stand in the queue: constraints, and watchers such as guards that act when their scope is decided."""

    owner: Owner
    queued: bool

    @property
    def scope(self) -> Sequence[AnyVariable]:
        """The variables whose changes matter to it."""
        ...

    def run(self, network: ConstraintNetworkManager) -> None:
        """Narrow or act; Inconsistency when there is no solution."""
        ...


class Listener(Protocol):
    """What wants to know that times moved, and no more."""

    def touch(self) -> None:
        """They moved, or moved back."""
        ...


class Constraint:
    """A constraint procedure over a scope of variables."""

    __slots__ = ("owner", "procedure", "queued", "scope")

    def __init__(self, procedure: ConstraintProcedure, scope: Sequence[AnyVariable], owner: Owner) -> None:
        self.procedure = procedure
        self.scope = scope
        self.owner = owner
        self.queued = False

    def run(self, network: ConstraintNetworkManager) -> None:
        """Apply the procedure once and restrict what it narrowed."""
        domains = [variable.domain for variable in self.scope]
        narrowed = self.procedure.narrow(domains)
        if narrowed is domains:
            return
        if narrowed is None:
            raise Inconsistency(because=self)
        for variable, old, new in zip(self.scope, domains, narrowed, strict=True):
            if new is not old:
                network.restrict(variable, new, self)

    def __repr__(self) -> str:
        return f"{self.procedure.name}({', '.join(v.name for v in self.scope)})"


class Moment(NamedTuple):
    """A point in the history of the network: so many domain changes made, so many temporal constraints in force."""

    changes: int
    edges: int


class ConstraintNetworkManager:
    """Variables, constraints and their propagation on one trail.

    The temporal network is this manager's own: whoever posts there directly makes explanations wrong. Levels of the
    trail are opened at a fixpoint.
    """

    def __init__(self, trail: Trail, temporal: TemporalNetworkManager) -> None:
        self.trail = trail
        self.temporal = temporal
        # Of every domain change: the variable, its domain before, the reason, the index of the variable's change
        # before that, and the number of temporal constraints in force.
        self._changes: list[tuple[Variable | DurationVariable, Domain, Owner, int, int]] = []
        # Of every temporal constraint, by its identifier: the owner and the moment at which it was posted.
        self._edges: list[tuple[Owner, Moment]] = []
        self._in_force = 0
        self._time_watchers: dict[int, list[AnyVariable]] = {}
        self._listeners: dict[int, Listener] = {}
        self._queue: deque[Propagator] = deque()
        self._postponed: deque[Propagator] = deque()
        # All that were ever put on watch and not undone, in order, and those of them that read times and are there.
        self.propagators: list[Propagator] = []
        self.readers_of_time: list[Propagator] = []
        trail.join(self)

    # Undo log of the domains

    def mark(self) -> int:
        """The position in the log of domain changes; ValueError unless the network is at a fixpoint."""
        if self._queue or self._postponed or self._in_force != len(self._edges):
            raise ValueError("a level is opened at a fixpoint: expected `propagate` before `push`")
        return len(self._changes)

    def undo_to(self, mark: int) -> None:
        """Take back the changes after a mark, newest first, and forget what was queued."""
        changes = self._changes
        while len(changes) > mark:
            variable, old, _, previous, _ = changes.pop()
            variable.latest = previous
            if isinstance(variable, Variable):
                variable.domain = old
            else:
                assert isinstance(old, Interval)
                variable.stated = old
        self._in_force = len(self._edges)
        self._clear_queue()

    # Variables

    def variable(self, name: str, domain: Domain, owner: Owner, of: Named | None = None) -> Variable:
        """A new variable. It lives as long as its owner does; nothing needs undoing until it is constrained."""
        return Variable(name, domain, owner, of)

    def timepoint(self, name: str, lower: float, upper: float, owner: Owner, of: Named | None = None) -> TimeVariable:
        """A new timepoint within [lower, upper] ticks; bounds that say something are constraints of the owner."""
        drift = min(DRIFT * self.temporal.timepoint_count, UNBOUNDED >> 2)
        point = self.temporal.add_timepoint(drift - FAR, drift + FAR)
        variable = TimeVariable(name, point, self.temporal, owner, of)
        if lower > -math.inf or upper < math.inf:
            self._post_edge(self.temporal.ORIGIN, variable.timepoint, lower, upper, owner)
        return variable

    def restrict(self, variable: AnyVariable, domain: Domain, because: Owner) -> bool:
        """Intersect a variable's domain; whether anything was removed. Inconsistency when nothing is left."""
        old = variable.domain
        new = old.intersect(domain)
        if new is old:
            return False
        if new.is_empty:
            raise Inconsistency(because, variable)
        if isinstance(variable, Variable):
            self._note(variable, old, because)
            variable.domain = new
            self._enqueue_all(variable.watchers)
            return True
        # Only the ends that moved are this owner's doing. The watchers of a timepoint hear of it from the temporal
        # network, which knows its bounds only after its own propagation.
        lower = new.lower if new.lower > old.lower else -math.inf
        upper = new.upper if new.upper < old.upper else math.inf
        if isinstance(variable, TimeVariable):
            edge = self._post_edge(self.temporal.ORIGIN, variable.timepoint, lower, upper, because)
        else:
            self._note(variable, variable.stated, because)
            variable.stated = variable.stated.bounded(lower, upper)
            edge = self.distance(variable.start, variable.end, lower, upper, because)
            self._enqueue_all(variable.watchers)
        self.trail.append(variable.narrowings, edge)
        return True

    def bound(self, variable: TimeVariable | DurationVariable, domain: Interval, because: Owner) -> None:
        """Restrict a time in full, where other constraints bound it more tightly for now too."""
        given = Interval(-math.inf, math.inf).intersect(domain)
        if variable.domain.intersect(given).is_empty:
            raise Inconsistency(because, variable)
        if isinstance(variable, TimeVariable):
            edge = self._post_edge(self.temporal.ORIGIN, variable.timepoint, given.lower, given.upper, because)
        else:
            self._note(variable, variable.stated, because)
            variable.stated = variable.stated.bounded(given.lower, given.upper)
            edge = self.distance(variable.start, variable.end, given.lower, given.upper, because)
            self._enqueue_all(variable.watchers)
        self.trail.append(variable.narrowings, edge)

    def _note(self, variable: Variable | DurationVariable, old: Domain, because: Owner) -> None:
        self._changes.append((variable, old, because, variable.latest, self._in_force))
        variable.latest = len(self._changes) - 1

    # Constraints

    def post(self, procedure: ConstraintProcedure, scope: Sequence[AnyVariable], owner: Owner) -> Constraint:
        """Add a constraint and queue it."""
        constraint = Constraint(procedure, scope, owner)
        self.watch(constraint)
        return constraint

    def watch(self, propagator: Propagator) -> None:
        """Queue a propagator now, and whenever a variable of its scope changes."""
        self.trail.append(self.propagators, propagator)
        if any(not isinstance(variable, Variable) for variable in propagator.scope):
            self.trail.append(self.readers_of_time, propagator)
        self.alert(propagator)
        self._enqueue(propagator)

    def alert(self, propagator: Propagator) -> None:
        """Queue a propagator whenever a variable of its scope changes from now on."""
        for variable in propagator.scope:
            self.trail.append(variable.watchers, propagator)
            if isinstance(variable, TimeVariable):
                self._watch_time(variable.timepoint, variable)
            elif isinstance(variable, DurationVariable):
                self._watch_time(variable.start.timepoint, variable)
                self._watch_time(variable.end.timepoint, variable)

    def hear(self, variable: TimeVariable, listener: Listener) -> None:
        """Touch a listener, the one of this timepoint, when its bounds move; and when that is undone."""
        self.temporal.watch(variable.timepoint)
        if variable.timepoint in self._listeners:
            self.trail.set(self._listeners, variable.timepoint, listener)
        else:
            self.trail.add(self._listeners, variable.timepoint, listener)

    def distance(self, from_: TimeVariable, to: TimeVariable, lower: float, upper: float, owner: Owner) -> int:
        """Post `lower <= to - from_ <= upper` ticks; returns the temporal constraint's identifier."""
        return self._post_edge(from_.timepoint, to.timepoint, lower, upper, owner)

    def _post_edge(self, from_: int, to: int, lower: float, upper: float, owner: Owner) -> int:
        self.trail.append(self._edges, (owner, self.now()))
        return self.temporal.post(from_, to, ticks(lower), ticks(upper), len(self._edges) - 1)

    def stakeholder_named(self, number: int) -> Owner:
        """The owner by the number that the temporal network knows it by."""
        return self._edges[number][0] if number >= 0 else None

    def posted_at(self, edge: int) -> Moment:
        """When a temporal constraint was posted."""
        return self._edges[edge][1]

    @property
    def posted(self) -> int:
        """The number of temporal constraints, those that wait for propagation included."""
        return len(self._edges)

    def now(self) -> Moment:
        """The present moment."""
        return Moment(len(self._changes), self._in_force)

    # Propagation

    def postpone(self, propagator: Propagator) -> None:
        """Have a propagator run once, when everything else has come to its fixpoint."""
        propagator.queued = True
        self._postponed.append(propagator)

    def propagate(self) -> None:
        """Run to the joint fixpoint of procedures and temporal network; Inconsistency when there is no solution."""
        queue, temporal = self._queue, self.temporal
        while True:
            if not temporal.propagate():
                raise Inconsistency(cycle=temporal.conflict())
            self._in_force = len(self._edges)
            self._times_moved(temporal.changed())
            if not queue:
                if not self._postponed:
                    return
                queue.append(self._postponed.popleft())
            while queue:
                propagator = queue.popleft()
                propagator.queued = False
                propagator.run(self)

    def _times_moved(self, timepoints: Sequence[int]) -> None:
        touched: dict[Listener, None] = {}
        for timepoint in timepoints:
            for variable in self._time_watchers.get(timepoint, ()):
                self._enqueue_all(variable.watchers)
            listener = self._listeners.get(timepoint)
            if listener is not None:
                touched[listener] = None
        for listener in touched:
            listener.touch()
            self.trail.call(listener.touch)

    def explain(self, inconsistency: Inconsistency) -> list[Owner]:
        """The owners whose constraints and restrictions together cause the inconsistency. Call before undoing it.

        Every reason is followed back through the log of changes and the temporal network's reason chains; the
        set that results is sufficient, not necessarily minimal.
        """
        from planner.constraints.explanation import explain

        return explain(self, inconsistency)

    def change(self, index: int) -> tuple[Owner, Moment, int]:
        """An entry of the log: its reason, the moment, the index of the variable's change before that or -1."""
        _, _, because, previous, edges = self._changes[index]
        return because, Moment(index, edges), previous

    # Queue

    def _watch_time(self, timepoint: int, variable: AnyVariable) -> None:
        variables = self._time_watchers.get(timepoint)
        if variables is None:
            self.temporal.watch(timepoint)
            self.trail.add(self._time_watchers, timepoint, [variable])
        elif not any(v is variable for v in variables):
            self.trail.append(variables, variable)

    def _enqueue(self, propagator: Propagator) -> None:
        if not propagator.queued:
            propagator.queued = True
            self._queue.append(propagator)

    def _enqueue_all(self, propagators: Sequence[Propagator]) -> None:
        for propagator in propagators:
            if not propagator.queued:
                propagator.queued = True
                self._queue.append(propagator)

    def _clear_queue(self) -> None:
        for waiting in (self._queue, self._postponed):
            for propagator in waiting:
                propagator.queued = False
            waiting.clear()


def ticks(value: float) -> int:
    """A bound for the temporal network."""
    if value == math.inf:
        return INFINITY
    return -INFINITY if value == -math.inf else int(value)
