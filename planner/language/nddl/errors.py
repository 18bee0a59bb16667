"""What is wrong with an NDDL file, for the modeller who has to mend it.

NddlError(ProblemError)     one or more diagnostics of the text: the file cannot be used
UnsupportedError(NddlError) the text is fine, but asks for something that this planner does not do

A diagnostic names file, line and column, shows the source line with a caret, and says what was expected and found.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from planner.errors import ProblemError

MAX_SHOWN_WIDTH = 160


class Source:
    """A text under the name of its file."""

    __slots__ = ("_line_starts", "file", "text")

    def __init__(self, file: str, text: str) -> None:
        self.file = file
        self.text = text
        self._line_starts = [0, *(m.end() for m in re.finditer("\n", text))]

    def line_and_column(self, offset: int) -> tuple[int, int]:
        """Where an offset is, both counted from 1."""
        line = bisect_right(self._line_starts, offset)
        return line, offset - self._line_starts[line - 1] + 1

    def line(self, number: int) -> str:
        """A line of the text, without its end."""
        start = self._line_starts[number - 1]
        end = self._line_starts[number] - 1 if number < len(self._line_starts) else len(self.text)
        return self.text[start:end]


class Position(NamedTuple):
    """A place in a source text. Line and column are worked out when somebody asks."""

    source: Source
    offset: int

    @property
    def file(self) -> str:
        """The name of the file."""
        return self.source.file

    @property
    def line(self) -> int:
        """The line, from 1."""
        return self.source.line_and_column(self.offset)[0]

    @property
    def column(self) -> int:
        """The column, from 1."""
        return self.source.line_and_column(self.offset)[1]

    def __str__(self) -> str:
        return "{}:{}:{}".format(self.file, *self.source.line_and_column(self.offset))

    def __repr__(self) -> str:
        return str(self)


NOWHERE = Position(Source("<built in>", ""), 0)


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One complaint. `unsupported`: nothing is wrong with the text, but this planner does not do what it asks for."""

    at: Position
    message: str
    unsupported: bool = False

    def __str__(self) -> str:
        head = f"{self.at}: {self.message}"
        number, column = self.at.source.line_and_column(self.at.offset)
        source = self.at.source.line(number)
        if not source.strip():
            return head
        line, column = _window(source, column - 1)
        pad = "".join("\t" if c == "\t" else " " for c in line[:column])
        return f"{head}\n    {line}\n    {pad}^"


def _window(source: str, column: int) -> tuple[str, int]:
    """The part of a long line around a column, and the column in it."""
    if len(source) <= MAX_SHOWN_WIDTH:
        return source.rstrip(), column
    first = max(0, column - MAX_SHOWN_WIDTH // 2)
    return source[first : first + MAX_SHOWN_WIDTH].rstrip(), column - first


class NddlError(ProblemError):
    """The text is not a model with a problem; `diagnostics` says all that was found wrong, in reading order."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        super().__init__("\n".join(map(str, diagnostics)))
        self.diagnostics = tuple(diagnostics)


class UnsupportedError(NddlError):
    """The text asks for what this planner does not do."""


class Complaint(Exception):  # noqa: N818 - becomes a Diagnostic of an NddlError, never reaches a user by itself
    """Signal inside the front end: something is wrong at a place; the statement is given up, the reading goes on."""

    def __init__(self, at: Position, message: str, unsupported: bool = False) -> None:
        super().__init__()
        self.at = at
        self.message = message
        self.unsupported = unsupported


class Report:
    """Collects what is wrong while a model is read, up to `limit` complaints."""

    def __init__(self, limit: int = 50) -> None:
        self.limit = limit
        self.found: list[Diagnostic] = []
        self._seen: set[tuple[Position, str]] = set()

    def complain(self, complaint: Complaint) -> None:
        """Note a complaint; one that was noted before is not repeated."""
        key = (complaint.at, complaint.message)
        if key in self._seen or len(self.found) >= self.limit:
            return
        self._seen.add(key)
        self.found.append(Diagnostic(complaint.at, complaint.message, complaint.unsupported))

    def raise_if_failed(self) -> None:
        """NddlError with all that was found; UnsupportedError when nothing is wrong but that."""
        if not self.found:
            return
        files = list(dict.fromkeys(d.at.file for d in self.found))
        kind = UnsupportedError if all(d.unsupported for d in self.found) else NddlError
        raise kind(sorted(self.found, key=lambda d: (files.index(d.at.file), d.at.offset)))


def listed(names: Iterable[str]) -> str:
    """Names in quotes, for a message."""
    return ", ".join(f"'{name}'" for name in names)
