"""The slow judge of the temporal network manager: the same interface over Floyd-Warshall from scratch, and checks."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field

import numpy as np

from planner.temporal import kernel_python as layout
from planner.temporal.network import INFINITY, TemporalNetworkManager

FAR = float("inf")
Rows = dict[int, tuple[int, int, int, int]]


def all_pairs(points: list[tuple[int, int]], rows: Rows) -> np.ndarray:
    """Shortest distances (n, n) by Floyd-Warshall; points' initial bounds are edges from and to timepoint 0."""
    n = len(points)
    d = np.full((n, n), FAR)
    np.fill_diagonal(d, 0)
    for t, (lower, upper) in enumerate(points):
        d[0, t] = min(d[0, t], upper)
        d[t, 0] = min(d[t, 0], -lower)
    for from_, to, minimum, maximum in rows.values():
        if maximum < INFINITY:
            d[from_, to] = min(d[from_, to], maximum)
        if minimum > -INFINITY:
            d[to, from_] = min(d[to, from_], -minimum)
    for k in range(n):
        np.minimum(d, d[:, k : k + 1] + d[k : k + 1, :], out=d)
    return d


def consistent(d: np.ndarray) -> bool:
    return bool((np.diagonal(d) >= 0).all())


@dataclass
class Reference:
    """What the manager must equal. A row is (from, to, minimum, maximum)."""

    points: list[tuple[int, int]] = field(default_factory=lambda: [(0, 0)])
    rows: Rows = field(default_factory=dict)
    queue: list[tuple[int, tuple[int, int, int, int]]] = field(default_factory=list)
    posted: int = 0
    removed: set[int] = field(default_factory=set)
    watched: set[int] = field(default_factory=set)
    unread: set[int] = field(default_factory=set)

    def snapshot(self) -> Reference:
        return copy.deepcopy(self)

    def post(self, from_: int, to: int, minimum: int, maximum: int) -> int:
        self.queue.append((self.posted, (from_, to, minimum, maximum)))
        self.posted += 1
        return self.posted - 1

    def tighten(self, constraint: int, minimum: int, maximum: int) -> None:
        self.queue.append((constraint, (-1, -1, minimum, maximum)))

    def after_queue(self) -> Rows:
        rows = dict(self.rows)
        for constraint, (from_, to, minimum, maximum) in self.queue:
            if constraint in self.removed:
                continue
            if from_ >= 0:
                rows[constraint] = (from_, to, minimum, maximum)
            else:
                a, b, low, high = rows[constraint]
                rows[constraint] = (a, b, max(low, minimum), min(high, maximum))
        return rows

    def bounds(self) -> list[tuple[int, int]]:
        d = all_pairs(self.points, self.rows)
        return [(int(-d[t, 0]), int(d[0, t])) for t in range(len(self.points))]

    def propagate(self) -> bool:
        after = self.after_queue()
        if not consistent(all_pairs(self.points, after)):
            return False
        self._replace(after)
        self.queue = []
        return True

    def remove(self, constraints: list[int]) -> None:
        self.removed |= set(constraints)
        self._replace({key: row for key, row in self.rows.items() if key not in self.removed})

    def _replace(self, rows: Rows) -> None:
        before = self.bounds()
        self.rows = rows
        after = self.bounds()
        self.unread |= {t for t in self.watched if before[t] != after[t]}


def image(network: TemporalNetworkManager) -> tuple[object, ...]:
    """Everything that undo must restore: header, bounds with reasons, arcs in force, weights, queue flags, watches."""
    header = network._header.tolist()
    n, count, top = header[layout.POINTS], header[layout.CONSTRAINTS], header[layout.TOP]
    arcs = network._arc_view.tolist()
    spans = []
    for label in range(2 * n):
        inward = network._point_view[8 * (label >> 1) + layout.INWARD + (label & 1)]
        for span in (network._label_view[4 * label + layout.SPAN], inward):
            block, size = span >> 32, span & layout.TARGET
            spans.append(network._pool[2 * block + 2 : 2 * (block + size) + 2].tolist())
    words = [network._label_view[8 * t + k] for t in range(n) for k in (0, 1, 3, 4, 5, 7)]
    watches = [network._point_view[8 * t + k] for t in range(n) for k in range(4)]
    kept = [header[k] for k in range(layout.CYCLE)] + [header[layout.EMPTY]]
    weights = arcs[1 : 8 * count : 2]
    return kept, spans, words, watches, weights, network._trail_view[4 * layout.HEADER_ROWS : 4 * top].tolist()


def check_conflict(network: TemporalNetworkManager, reference: Reference) -> None:
    """The reported cycle is simple, closed, negative, and made of posted constraints or initial bounds."""
    rows = reference.after_queue()
    cycle = network.conflict_cycle()
    assert network.conflict() == tuple(edge[3] for edge in cycle if edge[3] >= 0)
    if not cycle:
        assert any(lower > upper for lower, upper in reference.points)
        return
    assert sum(edge[2] for edge in cycle) < 0
    assert len({edge[0] for edge in cycle}) == len(cycle)
    for edge, following in zip(cycle, cycle[1:] + cycle[:1], strict=True):
        assert edge[1] == following[0]
        from_, to, weight, constraint = edge
        if constraint < 0:
            assert 0 in (from_, to)
            assert weight == (reference.points[to][1] if from_ == 0 else -reference.points[from_][0])
            continue
        a, b, minimum, maximum = rows[constraint]
        # A walk is found while the queue enters in order, so a later tightening in the queue may not be in it yet.
        assert ((from_, to) == (a, b) and weight >= maximum) or ((from_, to) == (b, a) and weight >= -minimum)
        assert weight < INFINITY


def check_explanations(network: TemporalNetworkManager, reference: Reference) -> None:
    """The constraints of an explanation imply the bound by themselves, none of them twice."""
    for t in range(len(reference.points)):
        for which, value in (("lower", network.lower(t)), ("upper", network.upper(t))):
            chain = network.explain(t, which)  # type: ignore[arg-type]
            assert len(set(chain)) == len(chain)
            d = all_pairs(reference.points, {key: reference.rows[key] for key in chain})
            assert value == (-d[t, 0] if which == "lower" else d[0, t])
