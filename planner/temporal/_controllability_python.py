"""The controllability check in plain Python: the oracle of the compiled kernel, and its stand-in without numba.

Same algorithm and same results, from lists, dictionaries and `heapq`; nodes and edges as in `_controllability_kernel`.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.temporal.stnu import UNBOUNDED

IntArray = NDArray[np.int64]


class _Kind(Enum):
    ORDINARY = 0
    LOWER = 1
    LABELLED = 2


class _Edge(NamedTuple):
    """`t_to - t_from <= weight`; `parts` are the rows it was composed of, `link` where it was read."""

    from_: int
    to: int
    weight: int
    kind: _Kind = _Kind.ORDINARY
    parts: tuple[int, int] | None = None
    link: int = -1


@dataclass(eq=False)
class _Graph:
    """All edges in the order found, and for each node the rows entering it, negative and not."""

    n: int
    edges: list[_Edge] = field(default_factory=list)
    negative: list[list[int]] = field(default_factory=list)
    others: list[list[int]] = field(default_factory=list)

    def add(self, edge: _Edge) -> int:
        row = len(self.edges)
        self.edges.append(edge)
        return row


@dataclass(eq=False)
class _Frame:
    """One node's propagation: the best way known from each node met, as (distance, first row, rest row)."""

    source: int
    best: dict[int, tuple[int, int, int]]
    heap: list[tuple[int, int]]
    done: set[int] = field(default_factory=set)
    row: int = -1
    waiting: int = -1


def _graph(n: int, links: IntArray) -> _Graph:
    """The network in normal form."""
    graph, nodes = _Graph(n), n
    for i, (a, c, lower, upper, contingent) in enumerate(links.tolist()):
        if contingent:
            p, spread = nodes, upper - lower
            nodes += 1
            found = [_Edge(a, p, lower), _Edge(p, a, -lower), _Edge(p, c, spread), _Edge(c, p, 0)]
            if spread:
                found += [_Edge(p, c, 0, _Kind.LOWER), _Edge(c, p, -spread, _Kind.LABELLED)]
        else:
            found = [_Edge(a, c, upper)] if upper != UNBOUNDED else []
            found += [_Edge(c, a, -lower)] if lower != -UNBOUNDED else []
        for edge in found:
            graph.add(edge._replace(link=i))
    graph.negative = [[] for _ in range(nodes)]
    graph.others = [[] for _ in range(nodes)]
    for row, edge in enumerate(graph.edges):
        (graph.negative if edge.weight < 0 else graph.others)[edge.to].append(row)
    return graph


def _reach(frame: _Frame, node: int, distance: int, first: int, rest: int) -> None:
    known = frame.best.get(node)
    if known is None or distance < known[0]:
        frame.best[node] = distance, first, rest
        heapq.heappush(frame.heap, (distance, node))


def _start(graph: _Graph, source: int) -> _Frame:
    frame = _Frame(source, {}, [])
    for row in graph.negative[source] + graph.others[source]:
        edge = graph.edges[row]
        if edge.kind is not _Kind.LOWER:
            _reach(frame, edge.from_, edge.weight, row, -1)
    return frame


def _extend(graph: _Graph, frame: _Frame, node: int, row: int) -> None:
    distance = frame.best[node][0]
    for entering in graph.others[node]:
        edge = graph.edges[entering]
        if edge.kind is not _Kind.LOWER or edge.from_ != frame.source:
            _reach(frame, edge.from_, distance + edge.weight, entering, row)


def _take(graph: _Graph, frame: _Frame) -> tuple[int, int] | None:
    """Settle the nearest node left: the node and its distance, its path recorded in `frame.row`."""
    while frame.heap:
        distance, node = heapq.heappop(frame.heap)
        if node in frame.done or (node == frame.source and distance >= 0):
            continue
        frame.done.add(node)
        _, first, rest = frame.best[node]
        frame.row = first
        if rest >= 0:
            kind = _Kind.LABELLED if frame.source >= graph.n and distance < 0 else _Kind.ORDINARY
            frame.row = graph.add(_Edge(node, frame.source, distance, kind, (first, rest)))
            if distance >= 0:
                graph.others[frame.source].append(frame.row)
        if distance < 0:
            return node, distance
    return None


def _origins(graph: _Graph, rows: list[int]) -> list[int]:
    found, seen, stack = set(), set(rows), list(rows)
    while stack:
        edge = graph.edges[stack.pop()]
        if edge.parts is None:
            found.add(edge.link)
        for part in edge.parts or ():
            if part not in seen:
                seen.add(part)
                stack.append(part)
    return sorted(found)


def _search(graph: _Graph) -> list[int] | None:
    """The rows of a semi-reducible negative cycle, or None when every propagation finished."""
    finished: set[int] = set()
    for root in range(len(graph.negative)):
        if not graph.negative[root] or root in finished:
            continue
        frames, opened = [_start(graph, root)], {root: 0}
        while frames:
            frame, node = frames[-1], frames[-1].waiting
            if node < 0:
                taken = _take(graph, frame)
                if taken is None:
                    finished.add(frame.source)
                    del opened[frame.source]
                    frames.pop()
                    continue
                node = taken[0]
                if node in opened:
                    return [frame.row for frame in frames[opened[node] :]]
                if graph.negative[node] and node not in finished:
                    frame.waiting, opened[node] = node, len(frames)
                    frames.append(_start(graph, node))
                    continue
            frame.waiting = -1
            _extend(graph, frame, node, frame.row)
    return None


def _dispatch_form(graph: _Graph, links: IntArray) -> tuple[IntArray, IntArray]:
    """As `_controllability_kernel.dispatch_form`."""
    n = graph.n
    chosen = [(a, c, lower, upper) for a, c, lower, upper, contingent in links.tolist() if contingent]
    natural = {c for _, c, _, _ in chosen}
    leaders = [(node, 0) for node in range(n)] + [(a, lower) for a, _, lower, _ in chosen]
    fixed = {c: (a, lower) for a, c, lower, upper in chosen if lower == upper}
    firsts = [_first(fixed, place) for place in leaders]
    tightest: dict[tuple[int, int], int] = {}
    waits: dict[tuple[int, int], int] = {}
    for edge in graph.edges:
        if edge.kind is _Kind.LABELLED:
            if edge.from_ < n and edge.from_ not in natural:
                key, weight = (edge.to - n, edge.from_), edge.weight - chosen[edge.to - n][2]
                waits[key] = min(weight, waits.get(key, weight))
        elif edge.kind is _Kind.ORDINARY:
            for places in (leaders, firsts):
                (x, x_after), (y, y_after) = places[edge.from_], places[edge.to]
                if x != y:
                    weight = edge.weight + x_after - y_after
                    tightest[x, y] = min(weight, tightest.get((x, y), weight))
    return _rows(tightest), _rows(waits)


def _first(fixed: dict[int, tuple[int, int]], place: tuple[int, int]) -> tuple[int, int]:
    """Follow fixed durations back to the timepoint that starts them, no further than once around a cycle."""
    node, after = place
    for _ in fixed:
        if node not in fixed:
            break
        node, delay = fixed[node]
        after += delay
    return node, after


def _rows(weights: dict[tuple[int, int], int]) -> IntArray:
    rows = sorted((x, y, weight) for (x, y), weight in weights.items())
    return np.array(rows, dtype=np.int64).reshape(len(rows), 3)


def check_links(n: int, links: IntArray) -> tuple[IntArray, IntArray, IntArray, bool]:
    """Edges, waits, the conflict's links and whether there is a conflict (then no edges and waits)."""
    graph = _graph(n, links)
    cycle = _search(graph)
    if cycle is not None:
        empty = np.empty((0, 3), np.int64)
        return empty, empty, np.array(_origins(graph, cycle), dtype=np.int64), True
    edges, waits = _dispatch_form(graph, links)
    return edges, waits, np.empty(0, np.int64), False
