"""Which values a set of variables can take when all must differ: matching and strongly connected components.

J.-C. Regin, "A filtering algorithm for constraints of difference in CSPs", AAAI 1994. Value nodes are left out of the
graph: a variable leads to the owners of its other choices.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import TypeVar

V = TypeVar("V", bound=Hashable)
Choices = Sequence[Sequence[int]]


def supported_values(choices: Sequence[Sequence[V]]) -> list[list[V]] | None:
    """For each variable the values of its choices that some assignment of different values uses; None without one."""
    number: dict[V, int] = {}
    numbered = [[number.setdefault(v, len(number)) for v in values] for values in choices]
    own = _matching(numbered, len(number))
    if own is None:
        return None
    owner = {value: variable for variable, value in enumerate(own)}
    edges = [[owner[v] for v in values if v in owner and v != own[i]] for i, values in enumerate(numbered)]
    component = _components(edges)
    can_move = _can_move(numbered, edges, owner)
    return [
        [
            value
            for value, v in zip(values, numbered[i], strict=True)
            if v not in owner or can_move[owner[v]] or component[owner[v]] == component[i]
        ]
        for i, values in enumerate(choices)
    ]


def _matching(choices: Choices, value_count: int) -> list[int] | None:
    """A value of its own for each variable, by shortest augmenting paths; None when there are not enough."""
    own = [-1] * len(choices)
    owner = [-1] * value_count
    for start in range(len(choices)):
        came: dict[int, int] = {}
        queue = [start]
        end = -1
        for variable in queue:  # grows while it is walked
            for value in choices[variable]:
                if value not in came:
                    came[value] = variable
                    if owner[value] < 0:
                        end = value
                        break
                    queue.append(owner[value])
            if end >= 0:
                break
        if end < 0:
            return None
        while end >= 0:
            variable = came[end]
            owner[end], own[variable], end = variable, end, own[variable]
    return own


def _can_move(choices: Choices, edges: Choices, owner: dict[int, int]) -> list[bool]:
    """Which variables can give up their value, along a chain of moves that ends in a value nobody has."""
    into: list[list[int]] = [[] for _ in choices]
    for variable, targets in enumerate(edges):
        for target in targets:
            into[target].append(variable)
    queue = [i for i, values in enumerate(choices) if any(v not in owner for v in values)]
    result = [False] * len(choices)
    for variable in queue:
        result[variable] = True
    for variable in queue:  # grows while it is walked
        for previous in into[variable]:
            if not result[previous]:
                result[previous] = True
                queue.append(previous)
    return result


def _components(edges: Choices) -> list[int]:
    """The strongly connected component of each node (R. Tarjan, 1972, without recursion)."""
    count = len(edges)
    number, low, component = [-1] * count, [0] * count, [-1] * count
    stack: list[int] = []
    found = 0
    for root in range(count):
        if number[root] >= 0:
            continue
        work = [(root, 0)]
        while work:
            node, position = work.pop()
            if position == 0:
                number[node] = low[node] = found
                found += 1
                stack.append(node)
            else:
                low[node] = min(low[node], low[edges[node][position - 1]])
            while position < len(edges[node]):
                target = edges[node][position]
                position += 1
                if number[target] < 0:
                    work += [(node, position), (target, 0)]
                    break
                if component[target] < 0:
                    low[node] = min(low[node], number[target])
            else:
                if low[node] == number[node]:
                    while component[node] < 0:
                        component[stack.pop()] = node
    return component
