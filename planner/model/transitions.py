"""How soon one value of an attribute can follow another: what the `meets` and `met_by` of a model make of its timelines.

A timeline whose predicates say what comes directly before and after them is a graph: its nodes are predicates with
values for their enumerated parameters, an edge leads from each to what may follow it at once, and a node takes its
shortest duration. The shortest way between two nodes is a lower bound on the time between two tokens that no other
rule states: between pointing here and pointing there lies a turn, however it is made. Ways are found by Floyd's
algorithm ("Algorithm 97: shortest path", 1962).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from planner.domains import Domain, Values
from planner.model.classes import Predicate
from planner.model.ground import Grounding, Node

if TYPE_CHECKING:
    from planner.model.manager import ModelManager

MOST_NODES = 200
"""A graph that would have more nodes than this is drawn without values of parameters."""


class TransitionGraph:
    """The graph of one attribute, as objects of one class have it."""

    def __init__(self, model: ModelManager, cls: str, attribute: str) -> None:
        self.nodes = _nodes(model, cls, attribute)
        self._gaps = _shortest_ways(Grounding(model, cls, attribute), self.nodes)
        self._known = {id(node.predicate) for node in self.nodes}
        self._least: dict[tuple[object, ...], float] = {}
        self.is_free = not self._gaps.any()
        """Everything may directly follow everything."""

    def least_gap(
        self, first: Predicate, of_first: Sequence[Domain], second: Predicate, of_second: Sequence[Domain]
    ) -> float:
        """The fewest ticks from the end of a token to the start of a later one, given the domains of their parameters
        in the order of declaration; inf when the one cannot follow the other."""
        if self.is_free or id(first) not in self._known or id(second) not in self._known:
            return 0
        key = id(first), id(second), *map(_key, of_first), *map(_key, of_second)
        found = self._least.get(key)
        if found is None:
            block = self._gaps[np.ix_(self._places(first, of_first), self._places(second, of_second))]
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


def _key(domain: Domain) -> int:
    """Only values of finite domains tell nodes apart."""
    return domain.bits if isinstance(domain, Values) else 0


def _nodes(model: ModelManager, cls: str, attribute: str) -> list[Node]:
    grounding = Grounding(model, cls, attribute)
    predicates = [p for p in model.predicates_of(cls).values() if p.attribute == attribute]
    for with_values in (True, False):
        candidates = (grounding.node(p, v) for p in predicates for v in _assignments(model, p, with_values))
        nodes = list(itertools.islice(filter(None, candidates), MOST_NODES + 1))
        if len(nodes) <= MOST_NODES:
            return nodes
    return []


def _assignments(model: ModelManager, predicate: Predicate, with_values: bool) -> Iterator[dict[str, Domain]]:
    names, choices = list[str](), list[list[Domain]]()
    for parameter in predicate.parameters if with_values else ():
        domain = model.domain_of(parameter.type)
        if isinstance(domain, Values) and not domain.is_open:
            names.append(parameter.name)
            choices.append([domain.keep((value,)) for value in domain.values()])
    return (dict(zip(names, chosen, strict=True)) for chosen in itertools.product(*choices))


def _shortest_ways(grounding: Grounding, nodes: Sequence[Node]) -> NDArray[np.float64]:
    """(n, n): ticks from the end of a node to the start of another."""
    gaps = np.zeros((len(nodes), len(nodes)))
    if not any(node.after or node.before for node in nodes) or any(node.shortest < 1 for node in nodes):
        return gaps  # what takes no time may stand between any two
    for (i, one), (j, two) in itertools.product(enumerate(nodes), repeat=2):
        if not (grounding.accepts(one.after, one, two) and grounding.accepts(two.before, two, one)):
            gaps[i, j] = math.inf
    for k, node in enumerate(nodes):
        np.minimum(gaps, gaps[:, k, None] + (node.shortest + gaps[None, k, :]), out=gaps)
    return gaps
