"""What scenarios/README.md says of conclusions, against the code."""

from __future__ import annotations

import re
from pathlib import Path

import scenarios
from scenarios.ds1.bindings import BINDINGS

TEXT = (Path(scenarios.__file__).parent / "README.md").read_text(encoding="utf-8")


def told() -> dict[str, str]:
    """Every conclusion of the table, and whether it stands once a recovery has worked."""
    section = TEXT.split("## Conclusions")[1].split("\n## ")[0]
    rows = [line.strip("|").split("|") for line in section.splitlines() if line.startswith("| `")]
    return {name: row[-1].strip() for row in rows for name in re.findall(r"`([^`]+)`", row[0])}


def test_every_conclusion_is_told_and_whether_it_stands() -> None:
    known = {}
    for conclusion in BINDINGS.conclusions():
        response = BINDINGS.response(conclusion)
        stands = response is None or not response.recoveries or response.lasts
        known[re.sub(r"( weak) \d+$", r"\1", conclusion.name)] = "yes" if stands else "no"
    assert told() == known
