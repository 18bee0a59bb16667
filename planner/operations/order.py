"""The order of the tokens of a timeline, those whose insertions are dormant included."""

from __future__ import annotations

import math

from planner.database import PlanDatabase
from planner.operations.statements import Operation
from planner.tokens.path import TokenPath
from planner.tokens.token import Token


class Lineup:
    """The insertions on one timeline in the order of their tokens. Only issuing and undoing an insertion changes it."""

    __slots__ = ("_line",)

    def __init__(self) -> None:
        self._line: list[Operation] = []

    def enter(self, operation: Operation, predecessor: Operation | None) -> None:
        """A new insertion comes directly after that of its predecessor, or first."""
        self._line.insert(0 if predecessor is None else self._line.index(predecessor) + 1, operation)

    def leave(self, operation: Operation) -> None:
        """The insertion is undone: the order of the others stays."""
        self._line.remove(operation)

    def predecessor(self, operation: Operation) -> Operation | None:
        """The nearest insertion before this one that is in force."""
        for place in range(self._line.index(operation) - 1, -1, -1):
            if self._line[place].depth is not None:
                return self._line[place]
        return None


class Precedences:
    """The temporal constraints between neighbours on timelines, by the paths of the tokens that they bind.

    Of tokens that were neighbours once and are no more they still hold, and say nothing new.
    """

    def __init__(self, database: PlanDatabase) -> None:
        self._database = database
        self._bonds: dict[TokenPath, list[tuple[int, TokenPath]]] = {}

    def note(self, edge: int, first: Token, second: Token) -> None:
        """A temporal constraint lets one token end before another starts."""
        for one, other in ((first.path, second.path), (second.path, first.path)):
            self._database.trail.append(self._bonds.setdefault(one, []), (edge, other))

    def of(self, token: Token) -> list[int]:
        """The constraints that bind a token."""
        return [edge for edge, _ in self._bonds.get(token.path, ())]

    def forget(self, token: Token) -> None:
        """The constraints that bind a token are taken out."""
        trail, bonds = self._database.trail, self._bonds.get(token.path, [])
        for other in {other for _, other in bonds}:
            trail.set(self._bonds, other, [bond for bond in self._bonds[other] if bond[1] != token.path])
        if bonds:
            trail.set(self._bonds, token.path, [])

    def link(self, first: Token, second: Token) -> None:
        """Let neighbours follow each other, unless they do."""
        if all(other != second.path for _, other in self._bonds.get(first.path, ())):
            edge = self._database.network.distance(first.end, second.start, 0, math.inf, second.placed_by)
            self.note(edge, first, second)
