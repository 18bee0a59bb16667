"""How soon one value of a timeline can follow another: what `meets`, `met_by` and `contained_by` imply.

A timeline whose predicates say what comes directly before and after them is a graph: its nodes are predicates with
values for their enumerated parameters, an edge leads from each to what may follow it at once, and a node takes its
shortest duration. The shortest way between two nodes is a lower bound on the time between two tokens that no rule
states: between pointing here and pointing there lies a turn, however it is made. Ways are found by Floyd's algorithm
("Algorithm 97: shortest path", 1962). Two tokens that other tokens must last through, on one further timeline, are as
far apart as those: between an exposure of this and an exposure of that lies the turn as well.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from planner.domains import Domain, Values
from planner.model.classes import ModelObject, Predicate
from planner.model.ground import Grounding, Node

MOST_NODES = 200
"""A graph that would have more nodes than this is drawn without values of parameters."""

Timeline = tuple[ModelObject, str]


class TransitionGraph:
    """The graph of one attribute, as objects of one class have it.

    `around`: the timelines of what must last through its tokens, as far as that keeps them apart.
    """

    def __init__(self, grounding: Grounding, neighbour: Callable[[str, str], TransitionGraph]) -> None:
        self._grounding = grounding
        self._neighbour = neighbour
        self.nodes = _nodes(grounding)
        self._known = {id(node.predicate) for node in self.nodes}
        self._ways = _shortest_ways(grounding, self.nodes)
        self._gaps: NDArray[np.float64] | None = None
        self._around: list[Timeline] = []
        self._least: dict[tuple[object, ...], float] = {}

    @property
    def is_free(self) -> bool:
        """Everything may directly follow everything."""
        return not self._all_gaps().any()

    @property
    def around(self) -> Sequence[Timeline]:
        """The timelines of what must last through tokens of this one, where that keeps tokens apart."""
        self._all_gaps()
        return self._around

    def least_gap(
        self,
        first: Predicate,
        of_first: Sequence[Domain],
        second: Predicate,
        of_second: Sequence[Domain],
        alone: bool = False,
    ) -> float:
        """The fewest ticks from the end of a token to the start of a later one, given the domains of their parameters
        in the order of declaration; inf when the one cannot follow the other. `alone`: what is around does not count.
        """
        if id(first) not in self._known or id(second) not in self._known:
            return 0
        key = alone, id(first), id(second), *map(_key, of_first), *map(_key, of_second)
        found = self._least.get(key)
        if found is None:
            gaps = self._ways if alone else self._all_gaps()
            block = gaps[np.ix_(self._places(first, of_first), self._places(second, of_second))]
            found = self._least[key] = float(block.min()) if block.size else math.inf
        return found

    def _places(self, predicate: Predicate, domains: Sequence[Domain]) -> list[int]:
        """The nodes that a token may be."""
        pairs = zip(predicate.parameters, domains, strict=True)
        given = [((p.name,), domain) for p, domain in pairs if isinstance(domain, Values)]
        return [
            place
            for place, node in enumerate(self.nodes)
            if node.predicate is predicate
            and not any(node.scope[path].intersect(domain).is_empty for path, domain in given)
        ]

    def _all_gaps(self) -> NDArray[np.float64]:
        """The shortest ways, and what is around."""
        if self._gaps is None:
            self._gaps = self._ways
            homes = dict.fromkeys(self._grounding.home_of(demand) for node in self.nodes for demand in node.inside)
            for home in homes:
                if home is not None and (apart := self._apart(home)).any():
                    self._around.append(home)
                    self._gaps = np.maximum(self._gaps, apart)
        return self._gaps

    def _apart(self, home: Timeline) -> NDArray[np.float64]:
        """(n, n): how far apart tokens are because other tokens, of that timeline, must last through them."""
        apart = np.zeros_like(self._ways)
        other = self._neighbour(home[0].cls, home[1])
        ways = other._ways.copy()
        np.fill_diagonal(ways, 0)  # one token may last through both
        hosts = [self._hosts(node, home, other) for node in self.nodes]
        for i, j in itertools.product(range(len(hosts)), repeat=2):
            for one, two in itertools.product(hosts[i], hosts[j]):
                if one and two:
                    apart[i, j] = max(apart[i, j], ways[np.ix_(one, two)].min())
        return apart

    def _hosts(self, node: Node, home: Timeline, other: TransitionGraph) -> list[list[int]]:
        """For each demand of a node on that timeline, the nodes there that meet it."""
        grounding = self._grounding
        return [
            [place for place, host in enumerate(other.nodes) if grounding.met(demand, node, host)]
            for demand in node.inside
            if grounding.home_of(demand) == home
        ]


def _key(domain: Domain) -> int:
    """Only values of finite domains tell nodes apart."""
    return domain.bits if isinstance(domain, Values) else 0


def _nodes(grounding: Grounding) -> list[Node]:
    model = grounding.model
    predicates = [p for p in model.predicates_of(grounding.cls).values() if p.attribute == grounding.attribute]
    for with_values in (True, False):
        candidates = (grounding.node(p, v) for p in predicates for v in _assignments(grounding, p, with_values))
        nodes = list(itertools.islice(filter(None, candidates), MOST_NODES + 1))
        if len(nodes) <= MOST_NODES:
            return nodes
    return []


def _assignments(grounding: Grounding, predicate: Predicate, with_values: bool) -> Iterator[dict[str, Domain]]:
    names, choices = list[str](), list[list[Domain]]()
    for parameter in predicate.parameters if with_values else ():
        domain = grounding.model.domain_of(parameter.type)
        if isinstance(domain, Values) and not domain.is_open:
            names.append(parameter.name)
            choices.append([domain.keep((value,)) for value in domain.values()])
    return (dict(zip(names, chosen, strict=True)) for chosen in itertools.product(*choices))


def _shortest_ways(grounding: Grounding, nodes: Sequence[Node]) -> NDArray[np.float64]:
    """(n, n): ticks from the end of a node to the start of another."""
    ways = np.zeros((len(nodes), len(nodes)))
    if not any(node.after or node.before for node in nodes) or any(node.shortest < 1 for node in nodes):
        return ways  # what takes no time may stand between any two
    for (i, one), (j, two) in itertools.product(enumerate(nodes), repeat=2):
        if not (grounding.accepts(one.after, one, two) and grounding.accepts(two.before, two, one)):
            ways[i, j] = math.inf
    for k, node in enumerate(nodes):
        np.minimum(ways, ways[:, k, None] + (node.shortest + ways[None, k, :]), out=ways)
    return ways
