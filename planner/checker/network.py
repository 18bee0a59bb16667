"""The plan's simple temporal network as the checker sees it (Dechter, Meiri and Pearl 1991), built from the plan alone.

A distance graph: an edge from a to b of weight w reads `b - a <= w`. A relation is entailed (holds in every schedule)
when the shortest path says so. Shortest paths are found on demand: first by a direct edge, by the bounds, and by two
schedules that may refute the claim; then by Dijkstra's algorithm on weights made non-negative by a schedule as the
potential (Johnson 1977), no further than the claim reaches.
"""

from __future__ import annotations

import heapq
import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from planner.plan import ORIGIN, Bounds, FlexiblePlan, PlanToken

INF = math.inf
Edges = list[dict[int, float]]


@dataclass(frozen=True, slots=True)
class Row:
    """`minimum <= to - from_ <= maximum`, and what says so."""

    from_: int
    to: int
    minimum: float
    maximum: float
    why: str


class PlanNetwork:
    """Timepoints by number (0 is the origin) and what is true of them in every schedule.

    `host_of`: by token, the first token of its slot, whose timepoints it shares. `conflict`: the constraints of a
    negative cycle, when there is no schedule at all, and `conflict_tokens` those whose timepoints it passes; nothing
    else may be asked then.
    `earliest`, `latest`: two schedules; what is unbounded is at a far but finite distance in them.
    """

    def __init__(self, plan: FlexiblePlan, host_of: Mapping[str, str]) -> None:
        self.index: dict[str, int] = {ORIGIN: 0}
        for host in dict.fromkeys(host_of.values()):
            self.index[f"{host}.start"] = len(self.index)
            self.index[f"{host}.end"] = len(self.index)
        for token, host in host_of.items():
            self.index[f"{token}.start"] = self.index[f"{host}.start"]
            self.index[f"{token}.end"] = self.index[f"{host}.end"]
        self.size = max(self.index.values()) + 1
        self.rows = [*_rows(plan, self.index)]
        self.out: Edges = [{} for _ in range(self.size)]
        self.into: Edges = [{} for _ in range(self.size)]
        for row in self.rows:
            self._edge(row.from_, row.to, row.maximum)
            self._edge(row.to, row.from_, -row.minimum)
        potential, cycle = _schedule(self.out)
        self.conflict = tuple(self._why(a, b) for a, b in cycle)
        self.conflict_tokens: tuple[str, ...] = ()
        if self.conflict:
            on_it = {point for edge in cycle for point in edge}
            tokens = (name.rpartition(".")[0] for name, point in self.index.items() if point in on_it and point)
            self.conflict_tokens = tuple(dict.fromkeys(tokens))
            return
        potential = [p - potential[0] for p in potential]
        self.upper = _distances(self.out, potential, {0: 0.0})
        self.lower = [-d for d in _distances(self.into, [-p for p in potential], {0: 0.0})]
        finite = sum(abs(w) for edges in self.out for w in edges.values())
        self.far = 3 * finite + 1
        everywhere = dict.fromkeys(range(self.size), self.far) | {0: 0.0}
        self.latest = _distances(self.out, potential, everywhere)
        self.earliest = [-d for d in _distances(self.into, [-p for p in potential], everywhere)]
        # Between the two schedules there is slack on every flexible edge: a search from it stays short.
        self.potential = [(a + b) / 2 for a, b in zip(self.earliest, self.latest, strict=True)]

    def _edge(self, a: int, b: int, weight: float) -> None:
        if weight < self.out[a].get(b, INF):
            self.out[a][b] = self.into[b][a] = weight

    def _why(self, a: int, b: int) -> str:
        """What put the weight on an edge."""
        weight = self.out[a][b]
        return next(
            row.why
            for row in self.rows
            if (row.from_, row.to, row.maximum) == (a, b, weight) or (row.to, row.from_, -row.minimum) == (a, b, weight)
        )

    def point(self, token: str, which: str) -> int:
        """The number of a token's `start` or `end`."""
        return self.index[f"{token}.{which}"]

    def at_most(self, a: int, b: int, limit: float) -> bool:
        """Whether `b - a <= limit` in every schedule."""
        if limit == INF or self.out[a].get(b, INF) <= limit or self.upper[b] - self.lower[a] <= limit:
            return True
        if a == b:
            return limit >= 0
        for schedule in (self.earliest, self.latest):
            if schedule[b] - schedule[a] > limit:
                return False
        return self._shortest(a, b, limit) <= limit

    def within(self, a: int, b: int, minimum: float, maximum: float) -> bool:
        """Whether `minimum <= b - a <= maximum` in every schedule."""
        return self.at_most(a, b, maximum) and self.at_most(b, a, -minimum)

    def span(self, a: int, b: int) -> tuple[float, float]:
        """The least and the greatest `b - a` over all schedules."""
        return -self.distance(b, a), self.distance(a, b)

    def distance(self, a: int, b: int) -> float:
        """The greatest `b - a` over all schedules."""
        if a == b:
            return 0
        known = min(self.out[a].get(b, INF), self.upper[b] - self.lower[a])
        return min(known, self._shortest(a, b, known))

    def distances_from(self, a: int) -> list[float]:
        """For every timepoint, how much later than a it may be at most, over all schedules."""
        return _distances(self.out, self.potential, {a: 0.0})

    def stretched(self, a: int, b: int) -> list[float]:
        """The earliest schedule in which b is as long after a as any schedule lets it be."""
        latest = self.earliest[a] + min(self.distance(a, b), self.latest[b] - self.earliest[a])
        before = _distances(self.into, [-p for p in self.potential], {b: 0.0})
        return [max(time, latest - d) for time, d in zip(self.earliest, before, strict=True)]

    def shrunk(self, a: int, b: int) -> list[float]:
        """The latest schedule in which b is as shortly after a as any schedule lets it be."""
        earliest = self.latest[a] - min(self.distance(b, a), self.latest[a] - self.earliest[b])
        after = _distances(self.out, self.potential, {b: 0.0})
        return [min(time, earliest + d) for time, d in zip(self.latest, after, strict=True)]

    def _shortest(self, a: int, b: int, limit: float) -> float:
        """The shortest path from a to b where it is at most the limit, else infinity."""
        potential = self.potential
        reach = limit + potential[a] - potential[b]
        settled: set[int] = set()
        heap = [(0.0, a)]
        best = {a: 0.0}
        while heap:
            far, here = heapq.heappop(heap)
            if here == b:
                return far - potential[a] + potential[b]
            if here in settled:
                continue
            settled.add(here)
            for there, weight in self.out[here].items():
                reached = far + weight + potential[here] - potential[there]
                if reached <= reach and reached < best.get(there, INF):
                    best[there] = reached
                    heapq.heappush(heap, (reached, there))
        return INF


def _rows(plan: FlexiblePlan, index: Mapping[str, int]) -> Iterable[Row]:
    for token in plan.tokens:
        start, end = index[f"{token.id}.start"], index[f"{token.id}.end"]
        yield _row(0, start, token.start, f"start of {told(token)}")
        yield _row(0, end, token.end, f"end of {told(token)}")
        lower, upper = token.duration
        yield _row(start, end, (0 if lower is None else lower, upper), f"duration of {told(token)}")
    for c in plan.constraints:
        yield _row(index[c.from_], index[c.to], (c.min, c.max), f"{c.from_} to {c.to} ({c.why})")


def _row(from_: int, to: int, bounds: Bounds, why: str) -> Row:
    lower, upper = unbounded(bounds)
    return Row(from_, to, lower, upper, why)


def unbounded(bounds: Bounds) -> tuple[float, float]:
    """A pair of bounds with infinity for what is not bounded."""
    return -INF if bounds[0] is None else bounds[0], INF if bounds[1] is None else bounds[1]


def told(token: PlanToken) -> str:
    """A token for a sentence: identifier, object and predicate."""
    return f"{token.id} ({token.object} {token.predicate.partition('.')[2]})"


def _schedule(out: Edges) -> tuple[list[float], list[tuple[int, int]]]:
    """A schedule, or the edges of a negative cycle (Bellman and Ford, with a queue)."""
    size = len(out)
    times = [0.0] * size
    parent = [-1] * size
    waiting = deque(range(size))
    queued = [True] * size
    relaxed = 0
    while waiting:
        here = waiting.popleft()
        queued[here] = False
        for there, weight in out[here].items():
            if times[here] + weight >= times[there]:
                continue
            if here == there:
                return times, [(here, here)]
            times[there] = times[here] + weight
            parent[there] = here
            relaxed += 1
            if relaxed % size == 0 and (cycle := _cycle(parent)):
                return times, cycle
            if not queued[there]:
                queued[there] = True
                waiting.append(there)
    return times, []


def _cycle(parent: Sequence[int]) -> list[tuple[int, int]]:
    """The edges of a cycle among the parents; empty when there is none."""
    seen = [-1] * len(parent)
    for first in range(len(parent)):
        here = first
        while here != -1 and seen[here] == -1:
            seen[here] = first
            here = parent[here]
        if here != -1 and seen[here] == first:
            edges: list[tuple[int, int]] = []
            there = here
            while not edges or there != here:
                edges.append((parent[there], there))
                there = parent[there]
            return edges[::-1]
    return []


def _distances(out: Edges, potential: Sequence[float], sources: Mapping[int, float]) -> list[float]:
    """Shortest distances from sources that are already some distance away; `potential` is a schedule of the graph."""
    best = [INF] * len(out)
    heap: list[tuple[float, int]] = []
    for source, far in sources.items():
        best[source] = far
        # Reduced distances: the potential of the common beginning is 0.
        heap.append((far - potential[source], source))
    heapq.heapify(heap)
    done = [False] * len(out)
    while heap:
        _, here = heapq.heappop(heap)
        if done[here]:
            continue
        done[here] = True
        for there, weight in out[here].items():
            if best[here] + weight < best[there]:
                best[there] = best[here] + weight
                heapq.heappush(heap, (best[there] - potential[there], there))
    return best
