"""Files to statements: includes resolved relative to the file, then along the include path, each file once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from planner.errors import nearest
from planner.language.nddl.errors import Complaint, Position, Report, Source
from planner.language.nddl.library import HEADERS
from planner.language.nddl.parser import parse
from planner.language.nddl.syntax import Include, Statement

MAX_INCLUDES_DEEP = 100
MAX_BYTES = 64_000_000
"""A file larger than this is not a model."""


class Loader:
    """Reads files. `search`: folders for includes that are not beside the file. `headers`: texts that stand for files
    of these names. `texts`: all strings that were read."""

    def __init__(self, report: Report, search: Sequence[Path] = (), headers: Mapping[str, str] | None = None) -> None:
        self.report = report
        self.search = tuple(search)
        self.headers = dict(headers or {})
        self.texts: set[str] = set()
        self._seen: set[Path] = set()

    def file(self, path: Path) -> list[Statement]:
        """The statements of a file and of what it includes, in order."""
        source = Source(str(path), "")
        try:
            text = self._read(path)
        except Complaint as complaint:
            self.report.complain(Complaint(Position(source, 0), complaint.message))
            return []
        self._seen.add(path.resolve())
        return list(self._flattened(parse(Source(str(path), text), self.report, self.texts), path.parent, 0))

    def text(self, text: str, name: str, folder: Path) -> list[Statement]:
        """The statements of a text that is in no file; includes are looked for in the folder."""
        return list(self._flattened(parse(Source(name, text), self.report, self.texts), folder, 0))

    def _flattened(self, statements: Sequence[Statement], folder: Path, depth: int) -> Iterator[Statement]:
        for statement in statements:
            if not isinstance(statement, Include):
                yield statement
                continue
            try:
                yield from self._included(statement, folder, depth)
            except Complaint as complaint:
                self.report.complain(complaint)

    def _included(self, node: Include, folder: Path, depth: int) -> Iterator[Statement]:
        if Path(node.file).name in HEADERS:
            return
        if depth >= MAX_INCLUDES_DEEP:
            raise Complaint(node.at, f"files include files more than {MAX_INCLUDES_DEEP} deep")
        if node.file in self.headers:
            text, self.headers[node.file] = self.headers[node.file], ""  # each file is read once
            yield from self._flattened(parse(Source(node.file, text), self.report, self.texts), folder, depth + 1)
            return
        path = self._find(node, folder)
        if path.resolve() in self._seen:
            return
        self._seen.add(path.resolve())
        try:
            text = self._read(path)
        except Complaint as complaint:
            raise Complaint(node.at, complaint.message) from None
        yield from self._flattened(parse(Source(str(path), text), self.report, self.texts), path.parent, depth + 1)

    def _find(self, node: Include, folder: Path) -> Path:
        folders = (folder, *self.search)
        for one in folders:
            try:
                if (one / node.file).is_file():
                    return one / node.file
            except (OSError, ValueError):
                break
        looked = ", ".join(str(f) for f in folders)
        hint = nearest(node.file, [*HEADERS, *self._neighbours(folders)])
        raise Complaint(node.at, f"cannot find the file {node.file!r} (looked in {looked}){hint}")

    def _neighbours(self, folders: Sequence[Path]) -> Iterator[str]:
        for folder in folders:
            if folder.is_dir():
                yield from (path.name for path in folder.glob("*.nddl"))

    def _read(self, path: Path) -> str:
        nowhere = Position(Source(str(path), ""), 0)
        try:
            content = path.read_bytes() if path.stat().st_size <= MAX_BYTES else None
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else str(error)
            raise Complaint(nowhere, f"cannot read {path}: {reason}") from None
        if content is None:
            raise Complaint(nowhere, f"{path} is larger than {MAX_BYTES // 1_000_000} MB: is this a model?")
        try:
            return content.decode("utf-8-sig")
        except UnicodeDecodeError:
            return content.decode("latin-1")
