"""The operations that were issued and not undone, and which of them speak of a token or a variable."""

from __future__ import annotations

from collections.abc import Iterator, KeysView
from itertools import takewhile

from planner.operations.order import Lineup
from planner.operations.statements import Codesignation, Insertion, Operation
from planner.tokens.path import TokenPath


class Register:
    """`issued`: by number, in order of issue. `waiting`: those of them that are dormant."""

    def __init__(self) -> None:
        self.issued: dict[int, Operation] = {}
        self.waiting: dict[int, Operation] = {}
        self._asleep: dict[TokenPath | None, dict[int, Operation]] = {}
        self._lineups: dict[tuple[str, str], Lineup] = {}
        self._about: dict[TokenPath | str, list[Operation]] = {}

    def enter(self, operation: Operation) -> None:
        """A new operation."""
        self.issued[operation.number] = operation
        for name in _names(operation):
            self._about.setdefault(name, []).append(operation)

    def leave(self, operation: Operation) -> None:
        """An operation is undone."""
        del self.issued[operation.number]
        self.wake(operation)
        for name in _names(operation):
            self._about[name].remove(operation)
        lineup = self.lineup(operation)
        if lineup is not None:
            lineup.leave(operation)

    def about(self, name: TokenPath | str) -> Iterator[Operation]:
        """The operations in force that speak of a token, or of a rule's variable, with this path."""
        return (o for o in self._about.get(name, ()) if o.depth is not None)

    def after(self, number: int) -> list[Operation]:
        """The operations issued after one of that number, in order of issue."""
        later = list(takewhile(lambda operation: operation.number > number, reversed(self.issued.values())))
        return later[::-1]

    def in_order(self) -> list[Operation]:
        """The dormant operations in order of issue."""
        return [self.waiting[number] for number in sorted(self.waiting)]

    def hopeful(self, names: KeysView[TokenPath]) -> list[Operation]:
        """The dormant operations, in order of issue, whose token is among those of these paths, or that name none."""
        there = self._asleep.keys() & names | self._asleep.keys() & {None}
        return sorted((o for name in there for o in self._asleep[name].values()), key=lambda o: o.number)

    def _fall_asleep(self, operation: Operation) -> None:
        self.waiting[operation.number] = operation
        self._asleep.setdefault(operation.statement.token, {})[operation.number] = operation

    def wake(self, operation: Operation) -> None:
        """An operation is dormant no more."""
        if self.waiting.pop(operation.number, None) is not None:
            asleep = self._asleep[operation.statement.token]
            del asleep[operation.number]
            if not asleep:
                del self._asleep[operation.statement.token]

    def suspend(self, operation: Operation) -> None:
        """An operation is not in force any more."""
        operation.depth = None
        if operation.number in self.issued:
            self._fall_asleep(operation)

    def place(self, operation: Operation, predecessor: Operation | None) -> None:
        """A new insertion comes directly after another on its timeline, or first."""
        statement = operation.statement
        assert isinstance(statement, Insertion)
        self._lineups.setdefault((statement.object, statement.attribute), Lineup()).enter(operation, predecessor)

    def lineup(self, operation: Operation) -> Lineup | None:
        """The order in which an insertion has its place."""
        statement = operation.statement
        if isinstance(statement, Insertion) and statement.attribute:
            return self._lineups[statement.object, statement.attribute]
        return None


def _names(operation: Operation) -> tuple[TokenPath | str, ...]:
    statement = operation.statement
    if isinstance(statement, Codesignation):
        return statement.token, statement.host
    return (statement.variable if statement.token is None else statement.token,)
