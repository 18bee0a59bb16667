"""Runs as files: repeatable, side by side, interrupted, without OpenGL."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import sim.offscreen
from scenarios.folder import new_folder
from scenarios.recording.reading import read
from scenarios.report import write_report
from scenarios.run_story import RunStory
from tests.scenarios.commands import entries_of, remote_agent, small

ROOT = Path(__file__).parents[2]


def test_the_same_seed_gives_the_same_journal(tmp_path: Path) -> None:
    scenario = small(tmp_path)
    journals = []
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        out = tmp_path / name
        remote_agent("run", scenario, "--no-images", "--seed", seed, "--out", out)
        lines = (out / "journal.jsonl").read_bytes().splitlines()
        journals.append(lines)
    assert journals[0] == journals[1]
    assert journals[0][1:] != journals[2][1:]


def test_folders_are_numbered_and_never_shared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with ThreadPoolExecutor(8) as pool:
        folders = list(pool.map(lambda _: new_folder(None, "x"), range(24)))
    assert len(set(folders)) == 24
    assert all((tmp_path / folder / "plans").is_dir() for folder in folders)


def test_a_folder_that_another_run_takes_meanwhile_is_left_to_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    taken = new_folder(None, "x")
    monkeypatch.setattr(Path, "iterdir", lambda self: iter(()))  # as it looked before the other run began to write
    assert new_folder(None, "x") != taken


def test_an_empty_folder_is_taken(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    assert new_folder(tmp_path / "run", "x") == tmp_path / "run"


def test_an_interrupted_run_leaves_a_readable_folder(tmp_path: Path) -> None:
    out = tmp_path / "run"
    command = [sys.executable, "-m", "scenarios", "run", "opnav-12h", "--no-images", "--out", str(out)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    journal = out / "journal.jsonl"
    while time.monotonic() < deadline and process.poll() is None:
        if journal.exists() and b"plan.adopted" in journal.read_bytes():
            break
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 130
    assert told == f"remote-agent: interrupted; what was written so far is readable: {out}\n"
    assert not (out / "summary.json").exists()
    assert entries_of(out)[-1]["t"] < 43_200
    assert read(out / "run.rrd").plots
    story = RunStory.load(out)
    assert story.horizon == (0, 43_200)
    assert {goal["status"] for goal in story.goals()} <= {"open", "achieved"}
    assert "not finished" in write_report(out).read_text()


@pytest.fixture
def no_opengl(monkeypatch: pytest.MonkeyPatch) -> object:
    sim.offscreen.find_backend.cache_clear()
    missing = dict.fromkeys(sim.offscreen.PACKAGES, (("libnothing.so.0",),))
    monkeypatch.setattr(sim.offscreen, "_LIBRARIES", missing)
    yield None
    sim.offscreen.find_backend.cache_clear()


@pytest.mark.usefixtures("no_opengl")
def test_without_opengl_the_run_goes_on_and_says_so_once(tmp_path: Path) -> None:
    answer = remote_agent("run", small(tmp_path), "--no-faults", "--json", "--out", tmp_path / "run")
    assert answer.status == 0
    assert answer.json()["outcome"] == "completed"
    assert answer.json()["recording"]["images"] == 3  # the science camera's need no OpenGL
    (line,) = answer.err.splitlines()
    assert line.startswith("remote-agent: the run goes on without views from outside: ")
    assert "libegl1" in line
