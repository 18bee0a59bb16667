"""The one undo: every change of plan state goes through a Trail, levels close in reverse order.

Python state lies in ordinary lists, dictionaries and attributes; the trail remembers what stood there before. Stores
with logs of their own (the compiled temporal kernel, the variable domains) join as participants: a level marks them
all, and undoing a level puts everything back, whatever happened in between.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol


class Participant(Protocol):
    """A store with an undo log of its own."""

    def mark(self) -> int:
        """A position in its log."""
        ...

    def undo_to(self, mark: int) -> None:
        """Undo everything after that position."""
        ...


_SET, _ASSIGN, _ADDED, _CALL = range(4)

Record = list[Any] | tuple[int, Any, Any, Any]
"""A list stands for an append to it, the most frequent change; else the kind of change, where, and what was there."""


class Trail:
    """Chronological undo. `push` opens a level, `pop_to` undoes all that changed since. `undone`: how many changes it
    has taken back so far."""

    __slots__ = ("_levels", "_log", "_participants", "undone")

    def __init__(self) -> None:
        self.undone = 0
        self._log: list[Record] = []
        self._levels: list[tuple[int, ...]] = []
        self._participants: list[Participant] = []

    @property
    def depth(self) -> int:
        """The number of open levels."""
        return len(self._levels)

    def __len__(self) -> int:
        """The number of changes that can be undone, those of participants not counted."""
        return len(self._log)

    def join(self, participant: Participant) -> None:
        """Have a store marked and undone with every level. Only before the first level."""
        if self._levels:
            raise ValueError("a participant joins before the first level is opened")
        self._participants.append(participant)

    def push(self) -> int:
        """Open a level; returns the depth that `pop_to` takes to close it again."""
        self._levels.append((len(self._log), *[p.mark() for p in self._participants]))
        return len(self._levels) - 1

    def pop_to(self, depth: int) -> None:
        """Undo levels until only `depth` are open."""
        if not 0 <= depth < len(self._levels):
            raise ValueError(f"cannot undo to depth {depth}: {len(self._levels)} levels are open")
        target, *marks = self._levels[depth]
        del self._levels[depth:]
        log = self._log
        self.undone += len(log) - target
        while len(log) > target:
            record = log.pop()
            if isinstance(record, list):
                record.pop()
                continue
            kind, container, key, old = record
            if kind == _SET:
                container[key] = old
            elif kind == _ASSIGN:
                setattr(container, key, old)
            elif kind == _ADDED:
                del container[key]
            else:
                container(*old)
        for participant, mark in zip(self._participants, marks, strict=True):
            participant.undo_to(mark)

    def set(self, container: Any, key: Any, value: Any) -> None:
        """`container[key] = value` for a list, or for a key that a dictionary has."""
        self._log.append((_SET, container, key, container[key]))
        container[key] = value

    def assign(self, thing: Any, attribute: str, value: Any) -> None:
        """`thing.attribute = value`."""
        self._log.append((_ASSIGN, thing, attribute, getattr(thing, attribute)))
        setattr(thing, attribute, value)

    def append(self, container: list[Any], value: Any) -> None:
        """`container.append(value)`."""
        self._log.append(container)
        container.append(value)

    def add(self, container: dict[Any, Any], key: Any, value: Any) -> None:
        """`container[key] = value` for a key that the dictionary does not have."""
        self._log.append((_ADDED, container, key, None))
        container[key] = value

    def call(self, undo: Callable[..., object], *arguments: Any) -> None:
        """Call `undo(*arguments)` when this level is undone."""
        self._log.append((_CALL, undo, None, arguments))
