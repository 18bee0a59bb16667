"""The order of the tokens of a timeline, those whose insertions are dormant included."""

from __future__ import annotations

from planner.operations.statements import Operation


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
