"""A run's journal is enough to replay it, and to go on with it after a kill."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from scenarios.folder import JOURNAL, PLANS
from tests.scenarios.commands import remote_agent
from tests.scenarios.conftest import Flown


def test_a_replay_is_identical(faulted: Flown) -> None:
    answer = remote_agent("replay", faulted.folder, "--json")
    assert answer.status == 0
    assert (answer.json()["identical"], answer.json()["first_difference"]) == (True, None)


def test_a_replay_finds_a_changed_line(faulted: Flown, tmp_path: Path) -> None:
    lines = (faulted.folder / JOURNAL).read_text().splitlines()
    number = next(n for n, line in enumerate(lines) if '"command.sent"' in line)
    entry = json.loads(lines[number])
    lines[number] = json.dumps(entry | {"name": "acs.standing"}, sort_keys=True, separators=(",", ":"))
    (tmp_path / JOURNAL).write_text("\n".join(lines) + "\n")
    answer = remote_agent("replay", tmp_path, "--json")
    assert answer.status == 1
    assert answer.json()["first_difference"]["line"] == number + 1


@pytest.mark.parametrize("share", [None, 0.97])
def test_a_broken_off_run_goes_on_to_the_same_journal(faulted: Flown, tmp_path: Path, share: float | None) -> None:
    """None: killed when there was no journal yet."""
    whole = (faulted.folder / JOURNAL).read_bytes()
    folder = tmp_path / "run"
    (folder / PLANS).mkdir(parents=True)
    if share is not None:
        (folder / JOURNAL).write_bytes(whole[: int(share * len(whole))])
    options = ("--fault", "micas-stuck-on", "--no-images", "--json", "--out", folder)
    answer = remote_agent("run", "opnav-12h", *options, "--resume")
    assert answer.status == 0
    assert (folder / JOURNAL).read_bytes() == whole
    assert answer.json()["goals"] == faulted.summary["goals"]


def test_another_seed_is_not_the_run_to_go_on_with(faulted: Flown, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    shutil.copytree(faulted.folder, folder)
    options = ("--fault", "micas-stuck-on", "--no-images", "--out", folder)
    answer = remote_agent("run", "opnav-12h", *options, "--seed", 7, "--resume")
    assert answer.status == 2
    assert "does not repeat itself" in answer.err
    assert (folder / JOURNAL).read_bytes() == (faulted.folder / JOURNAL).read_bytes()


def test_what_is_no_run_cannot_be_resumed_or_replayed(tmp_path: Path) -> None:
    for answer in (
        remote_agent("run", "opnav-12h", "--resume"),
        remote_agent("run", "opnav-12h", "--resume", "--out", tmp_path),
        remote_agent("replay", tmp_path),
    ):
        assert answer.status == 2
    assert not any(tmp_path.iterdir())
