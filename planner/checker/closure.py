"""The heaviest closed set: which of some events have happened, at worst, when each drags others along.

A set is closed when it holds whatever its members imply. The heaviest one is the source side of a minimum cut (Picard
1976): source to what adds, what takes away to sink, implications without limit; found by shortest augmenting paths
(Edmonds and Karp 1972) in exact fractions, so that equal sums are equal.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise


def heaviest_closed_set(weights: Sequence[float], implied: Sequence[Sequence[int]]) -> set[int]:
    """The members of a closed set of greatest weight, the smallest such set.

    `weights`: shape (n,), finite. `implied`: for each member, the others that are in every set which it is in.
    """
    size = len(weights)
    source, sink = size, size + 1
    room: list[dict[int, Fraction | None]] = [{} for _ in range(size + 2)]  # None: without limit
    for member, weight in enumerate(weights):
        if weight > 0:
            _edge(room, source, member, Fraction(weight))
        elif weight < 0:
            _edge(room, member, sink, Fraction(-weight))
        for other in implied[member]:
            _edge(room, member, other, None)
    while (parent := _reach(room, source)).get(sink) is not None:
        _augment(room, parent, source, sink)
    return {member for member in parent if member < size}


def _edge(room: list[dict[int, Fraction | None]], a: int, b: int, most: Fraction | None) -> None:
    room[a][b] = most
    room[b].setdefault(a, Fraction(0))


def _reach(room: list[dict[int, Fraction | None]], source: int) -> dict[int, int]:
    """From the source, by edges with room left: each node reached, with the one before it."""
    parent = {source: source}
    waiting = deque([source])
    while waiting:
        here = waiting.popleft()
        for there, left in room[here].items():
            if left != 0 and there not in parent:
                parent[there] = here
                waiting.append(there)
    return parent


def _augment(room: list[dict[int, Fraction | None]], parent: dict[int, int], source: int, sink: int) -> None:
    path = [sink]
    while path[-1] != source:
        path.append(parent[path[-1]])
    edges = [(before, here) for here, before in pairwise(path)]
    amount = min(left for a, b in edges if (left := room[a][b]) is not None)
    for a, b in edges:
        forth, back = room[a][b], room[b][a]
        room[a][b] = None if forth is None else forth - amount
        room[b][a] = None if back is None else back + amount
