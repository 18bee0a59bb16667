"""A negative cycle out of the walk on which the kernel found an inconsistency."""

from __future__ import annotations


def negative_loop(walk: list[tuple[int, int, int, int]]) -> list[tuple[int, int, int, int]]:
    """A simple cycle of negative weight out of a closed walk of negative weight."""
    path: list[tuple[int, int, int, int]] = []
    place: dict[int, int] = {}
    for edge in walk:
        place[edge[0]] = len(path)
        path.append(edge)
        first = place.get(edge[1])
        if first is None:
            continue
        if sum(weight for _, _, weight, _ in path[first:]) < 0:
            return path[first:]
        for closed in path[first:]:
            del place[closed[0]]
        del path[first:]
    return path
