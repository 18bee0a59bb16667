"""A bound that no rule states: between two tokens of a timeline there is time for what must come between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from planner.constraints.network import AnyVariable, ConstraintNetworkManager, Inconsistency
from planner.model.transitions import TransitionGraph
from planner.tokens.token import Token


@dataclass(frozen=True, eq=False, slots=True)
class Succession:
    """That one token comes before another on a timeline: the owner of the gap between them."""

    first: Token
    second: Token

    def __repr__(self) -> str:
        return f"the way from {self.first.name} to {self.second.name}"


class Gap:
    """Keeps a token and a later one as far apart as the transition graph demands, the more the better their parameters
    are known. What it posts follows from the rules of any complete plan. `alone`: as in `least_gap`.
    """

    __slots__ = ("alone", "graph", "least", "owner", "queued", "scope", "succession")

    def __init__(self, graph: TransitionGraph, first: Token, second: Token, alone: bool) -> None:
        self.graph = graph
        self.succession = self.owner = Succession(first, second)
        self.scope: Sequence[AnyVariable] = (*first.parameters.values(), *second.parameters.values())
        self.alone = alone
        self.queued = False
        self.least = 0.0

    def run(self, network: ConstraintNetworkManager) -> None:
        """Post a longer distance when the graph knows of one; Inconsistency when the one cannot follow the other."""
        first, second = self.succession.first, self.succession.second
        least = self.graph.least_gap(
            first.predicate,
            [variable.domain for variable in first.parameters.values()],
            second.predicate,
            [variable.domain for variable in second.parameters.values()],
            self.alone,
        )
        if least == math.inf:
            raise Inconsistency(because=self)
        if least > self.least:
            network.trail.assign(self, "least", least)
            network.distance(first.end, second.start, least, math.inf, self)

    def __repr__(self) -> str:
        return repr(self.succession)
