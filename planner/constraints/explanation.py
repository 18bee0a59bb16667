"""Why an inconsistency holds: the owners whose constraints and restrictions cause it, found by following reasons.

Every reason is followed back from the moment at which it acted: what came later cannot have caused it, even where it
is what bounds a variable now. The owners that result are sufficient, not necessarily minimal.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Literal

from planner.constraints.network import AnyVariable, DurationVariable, Inconsistency, Moment, TimeVariable, Variable
from planner.temporal.network import INFINITY

if TYPE_CHECKING:
    from planner.constraints.network import ConstraintNetworkManager

UNBOUNDED = INFINITY
"""A weight from here on says nothing."""

Side = Literal["lower", "upper"]


def explain(network: ConstraintNetworkManager, inconsistency: Inconsistency) -> list[Any]:
    """The owners in the order in which they are met, each once."""
    return _Tracer(network).trace(inconsistency)


def reasons(network: ConstraintNetworkManager, variables: Iterable[AnyVariable]) -> list[Any]:
    """The owners that together bring the variables' domains to what they are now, each once."""
    tracer = _Tracer(network)
    tracer.pending.extend((variable, network.now()) for variable in variables)
    return tracer.follow()


class _Tracer:
    def __init__(self, network: ConstraintNetworkManager) -> None:
        self.network = network
        self.owners: dict[int, Any] = {}
        self.seen_changes: set[int] = set()
        self.seen_edges: set[int] = set()
        self.seen_bounds: set[tuple[int, Side, int]] = set()
        self.pending: list[tuple[AnyVariable, Moment]] = []
        self.arcs: list[tuple[int, int, int, int, int, int]] | None = None

    def trace(self, inconsistency: Inconsistency) -> list[Any]:
        now = self.network.now()
        self._because(inconsistency.because, now)
        if inconsistency.variable is not None:
            self.pending.append((inconsistency.variable, now))
        self._edges(inconsistency.cycle)
        return self.follow()

    def follow(self) -> list[Any]:
        """Follow what is pending to its owners."""
        while self.pending:
            variable, before = self.pending.pop()
            self._owner(variable.owner)
            if isinstance(variable, TimeVariable):
                self._bounds(variable, before)
                continue
            self._changes(variable, before)
            if isinstance(variable, DurationVariable):
                self._bounds(variable.start, before)
                self._bounds(variable.end, before)
        return list(self.owners.values())

    def _changes(self, variable: Variable | DurationVariable, before: Moment) -> None:
        """What changed a variable's own domain before a moment."""
        index = variable.latest
        while index >= 0 and index not in self.seen_changes:
            because, moment, previous = self.network.change(index)
            if index < before.changes:
                self.seen_changes.add(index)
                self._because(because, moment)
            index = previous

    def _because(self, because: Any, moment: Moment) -> None:
        if hasattr(because, "scope"):
            self._owner(because.owner)
            self.pending.extend((variable, moment) for variable in because.scope)
        else:
            self._owner(because)

    def _bounds(self, variable: TimeVariable, before: Moment) -> None:
        """What bounded a timepoint at a moment: the chain of reasons now, unless part of it came later."""
        for side in ("lower", "upper"):
            if (variable.timepoint, side, before.edges) in self.seen_bounds:
                continue
            self.seen_bounds.add((variable.timepoint, side, before.edges))
            chain = self.network.temporal.explain(variable.timepoint, side)
            if any(edge >= before.edges for edge in chain):
                chain = self._chain_then(variable.timepoint, side, before.edges)
            self._edges(chain)

    def _chain_then(self, timepoint: int, side: Side, edges: int) -> tuple[int, ...]:
        """The chain of reasons of a bound when only the first so many temporal constraints were in force.

        Shortest paths from the origin by passes over those constraints (Bellman, "On a routing problem", 1958).
        """
        if self.arcs is None:
            self.arcs = list(self.network.temporal.constraints())
        sign = 1 if side == "upper" else -1
        nearest = {self.network.temporal.ORIGIN: 0}
        reason: dict[int, tuple[int, int]] = {}
        changed = True
        while changed:
            changed = False
            for edge, from_, to, minimum, maximum, _ in self.arcs:
                if edge >= edges:
                    break
                up, down = (maximum, -minimum) if sign > 0 else (-minimum, maximum)
                for a, b, weight in ((from_, to, up), (to, from_, down)):
                    if weight < UNBOUNDED and a in nearest and nearest[a] + weight < nearest.get(b, UNBOUNDED):
                        nearest[b] = nearest[a] + weight
                        reason[b] = (edge, a)
                        changed = True
        chain: list[int] = []
        while timepoint in reason:
            edge, timepoint = reason[timepoint]
            chain.append(edge)
        return tuple(chain)

    def _edges(self, edges: tuple[int, ...]) -> None:
        for edge in edges:
            if edge not in self.seen_edges:
                self.seen_edges.add(edge)
                self._because(self.network.stakeholder_named(edge), self.network.posted_at(edge))

    def _owner(self, owner: Any) -> None:
        if owner is not None:
            self.owners.setdefault(id(owner), owner)
