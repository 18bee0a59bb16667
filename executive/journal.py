"""The journal: append-only JSON lines, the only record of what happened in a run.

Every entry has `t` (simulation seconds) and `event`; nothing measured on a wall clock is ever written, keys are sorted,
and each line is flushed, so that the same inputs give the same bytes and a kill loses at most the line being written.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Protocol

from executive.errors import JournalError

_NOTHING: Mapping[str, object] = {}


class LineStream(Protocol):
    """Where a journal's lines go: any text stream."""

    def write(self, text: str, /) -> int:
        """Take one line with its end."""
        ...

    def flush(self) -> None:
        """Bring it to where a kill cannot reach it."""
        ...

    def close(self) -> None:
        """Take no more."""
        ...


class Journal:
    """Writes entries to a text stream, which it closes only if it opened it (`create`)."""

    def __init__(self, stream: LineStream) -> None:
        self._stream = stream
        self._owned = False
        self._encode = json.JSONEncoder(sort_keys=True, separators=(",", ":"), allow_nan=False).encode

    @classmethod
    def create(cls, path: Path) -> Journal:
        """A journal in a new file; JournalError when there is one already, or none can be made."""
        try:
            journal = cls(path.open("x", encoding="utf-8", newline="\n"))
        except OSError as error:
            raise JournalError(f"{path}: {error.strerror}") from error
        journal._owned = True
        return journal

    def write(self, time: int, event: str, fields: Mapping[str, object] = _NOTHING) -> None:
        """Append one entry. JournalError for what is not plain JSON data, for NaN, or when the journal is closed."""
        try:
            line = self._encode({"t": time, "event": event, **fields})
        except (TypeError, ValueError) as error:
            raise JournalError(f"journal entry {event!r} at {time} s: {error}") from error
        try:
            self._stream.write(line + "\n")
            self._stream.flush()
        except ValueError as error:
            raise JournalError(f"journal entry {event!r} at {time} s: the journal is closed") from error

    def close(self) -> None:
        """Close the file that `create` opened."""
        if self._owned:
            self._stream.close()

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, tb: TracebackType | None) -> None:
        self.close()
