"""The heaviest closed set: which of some events have happened, at worst, when each drags others along.

A set is closed when it holds whatever its members imply. The heaviest one is the source side of a minimum cut (Picard
1976): source to what adds, what takes away to sink, implications without limit. The maximum flow is found in levels
(Dinic 1970), on whole numbers so that equal sums are equal, and along implications that follow from no others.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import pairwise

Edges = list[dict[int, int]]
"""By node, the nodes that it has an edge to, with what may still flow along it."""


def heaviest_closed_set(weights: Sequence[float], implied: Sequence[int]) -> set[int]:
    """The members of a closed set of greatest weight, the smallest such set.

    `weights`: shape (n,), finite. `implied`: for each member, as bits, the others that are in every set that it is in;
    transitive.
    """
    first = [_lowest(implied, member) for member in range(len(weights))]
    exact = [Fraction(weight) for weight in weights]
    unit = math.lcm(*(weight.denominator for weight in exact)) if exact else 1
    whole = [0] * len(weights)
    for member, weight in enumerate(exact):
        whole[first[member]] += int(weight * unit)
    chosen = _source_side(whole, _covering(implied, first))
    return {member for member in range(len(weights)) if first[member] in chosen}


def _lowest(implied: Sequence[int], member: int) -> int:
    """The first of the members that are in just the same sets as this one."""
    return next((other for other in bits(implied[member]) if other < member and implied[other] >> member & 1), member)


def _covering(implied: Sequence[int], first: Sequence[int]) -> list[list[int]]:
    """By member, the first ones among those that it implies and that no other implied one implies in turn."""
    kept = sum(1 << member for member, one in enumerate(first) if member == one)
    found: list[list[int]] = [[] for _ in implied]
    for member in bits(kept):
        direct = implied[member] & kept & ~(1 << member)
        for other in bits(direct):
            direct &= ~(implied[other] & ~(1 << other))
        found[member] = list(bits(direct))
    return found


def bits(number: int) -> Iterator[int]:
    """The places of the bits of a number, rising."""
    while number:
        low = number & -number
        yield low.bit_length() - 1
        number ^= low


def _source_side(weights: Sequence[int], edges: Sequence[Sequence[int]]) -> set[int]:
    """What the source reaches when the flow is at its greatest."""
    size, endless = len(weights), 1 + sum(map(abs, weights))
    source, sink = size, size + 1
    room: Edges = [{} for _ in range(size + 2)]
    for member, weight in enumerate(weights):
        ends = (source, member) if weight > 0 else (member, sink)
        if weight:
            room[ends[0]][ends[1]] = abs(weight)
            room[ends[1]].setdefault(ends[0], 0)
        for other in edges[member]:
            room[member][other] = endless
            room[other].setdefault(member, 0)
    while (depth := _depths(room, source))[sink] >= 0:
        _saturate(room, depth, source, sink)
    return {member for member in range(size) if depth[member] >= 0}


def _depths(room: Edges, source: int) -> list[int]:
    """How many edges with room left each node is from the source; -1: out of reach."""
    depth = [-1] * len(room)
    depth[source] = 0
    reached = [source]
    for here in reached:
        for there, left in room[here].items():
            if left and depth[there] < 0:
                depth[there] = depth[here] + 1
                reached.append(there)
    return depth


def _saturate(room: Edges, depth: Sequence[int], source: int, sink: int) -> None:
    """Push flow along shortest paths until none is left."""
    ways = [list(edges) for edges in room]
    tried = [0] * len(room)
    path = [source]
    while path:
        here = path[-1]
        if here == sink:
            pairs = list(pairwise(path))
            amount = min(room[a][b] for a, b in pairs)
            for a, b in pairs:
                room[a][b] -= amount
                room[b][a] += amount
            del path[1 + next(place for place, (a, b) in enumerate(pairs) if not room[a][b]) :]
            continue
        while tried[here] < len(ways[here]):
            there = ways[here][tried[here]]
            if room[here][there] and depth[there] == depth[here] + 1:
                path.append(there)
                break
            tried[here] += 1
        else:
            path.pop()
            if path:
                tried[path[-1]] += 1
