from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tests.scenarios.commands import Answer, entries_of, remote_agent


@dataclass(frozen=True)
class Flown:
    folder: Path
    answer: Answer
    summary: dict[str, Any]
    entries: list[dict[str, Any]]

    def of(self, event: str) -> list[dict[str, Any]]:
        return [entry for entry in self.entries if entry["event"] == event]


def _fly(folder: Path, *options: str) -> Flown:
    answer = remote_agent("run", "opnav-12h", "--no-images", "--json", "--out", folder, *options)
    return Flown(folder, answer, answer.json(), entries_of(folder))


@pytest.fixture(scope="session")
def nominal(tmp_path_factory: pytest.TempPathFactory) -> Flown:
    """opnav-12h without faults."""
    return _fly(tmp_path_factory.mktemp("runs") / "nominal", "--no-faults")


@pytest.fixture(scope="session")
def faulted(tmp_path_factory: pytest.TempPathFactory) -> Flown:
    """opnav-12h with the camera's switch stuck on."""
    return _fly(tmp_path_factory.mktemp("runs") / "faulted", "--fault", "micas-stuck-on")
