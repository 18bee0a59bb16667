"""The command as a user calls it, and a scenario that is flown in a second or two."""

from __future__ import annotations

import io
import json
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

from scenarios.cli import main

SMALL = """
name = "small"
summary = "one session, one downlink"
horizon = "3h"
deliberation = "5m"

[[goals]]
id = "session"
predicate = "Navigation.session"
parameters = { target = "asteroid_b" }
window = ["40m", "2h"]
priority = 5

[[goals]]
id = "downlink"
predicate = "Radio.downlink"
window = ["2h", "3h"]
lasting = "10m"

[[faults]]
name = "micas-stuck-on"
at = "30m"
"""


@dataclass(frozen=True)
class Answer:
    status: int
    out: str
    err: str

    def json(self) -> Any:
        """The one object on standard output, and nothing else there."""
        assert self.out.count("\n") == 1
        return json.loads(self.out)


def remote_agent(*arguments: object) -> Answer:
    """Call the command in this process."""
    out, err = io.StringIO(), io.StringIO()
    argv = ["remote-agent", *map(str, arguments)]
    status = 0
    with mock.patch.object(sys, "argv", argv), redirect_stdout(out), redirect_stderr(err):
        try:
            main()
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    return Answer(status, out.getvalue(), err.getvalue())


def small(folder: Path, *changes: tuple[str, str]) -> Path:
    """The small scenario as a file, with text replaced in it."""
    text = SMALL
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = folder / "small.toml"
    path.write_text(text, encoding="utf-8")
    return path


def entries_of(run: Path) -> list[dict[str, Any]]:
    """The journal's entries."""
    return [json.loads(line) for line in (run / "journal.jsonl").read_text(encoding="utf-8").splitlines()]
