"""A disk that takes no more ends a run with one line that says what, why and when; what was written stays readable."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

import pytest

from executive.journal import LineStream
from planner.plan import FlexiblePlan
from scenarios.folder import new_stream
from scenarios.recording.reading import read
from scenarios.recording.stream import RESERVE_BYTES
from scenarios.run_story import RunStory
from tests.scenarios.commands import Answer, entries_of, remote_agent, small

FULL = os.strerror(errno.ENOSPC)


class FillingStream:
    """A journal's stream that takes so many lines and then fails, also at its end."""

    def __init__(self, inner: LineStream, room: int) -> None:
        self._inner = inner
        self._room = room

    def write(self, text: str, /) -> int:
        if self._room == 0:
            raise OSError(errno.ENOSPC, FULL)
        self._room -= 1
        return self._inner.write(text)

    def flush(self) -> None:
        self._inner.flush()

    def close(self) -> None:
        self._inner.close()
        raise OSError(errno.ENOSPC, FULL)


def broken_off(tmp_path: Path) -> tuple[Answer, Path]:
    """The small scenario flown until its disk is full, and its folder."""
    out = tmp_path / "run"
    answer = remote_agent("run", small(tmp_path), "--no-images", "--out", out)
    assert answer.status == 1
    assert answer.err.count("\n") == 1
    assert "Traceback" not in answer.err
    assert not (out / "summary.json").exists()
    assert RunStory.load(out).horizon == (0, 10_800)
    return answer, out


def test_no_room_for_the_journal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenarios.run.new_stream", lambda path: FillingStream(new_stream(path), 12))
    answer, out = broken_off(tmp_path)
    entries = entries_of(out)
    assert len(entries) == 12
    start = f"remote-agent: {out}/journal.jsonl: {FULL}; the run ended at "
    told, _, rest = answer.err.removeprefix(start).partition(" ")
    assert int(told) >= entries[-1]["t"]
    assert rest == "s, what was written until then is readable\n"


def test_a_run_that_found_no_room_goes_on_when_there_is_some(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        patch.setattr("scenarios.run.new_stream", lambda path: FillingStream(new_stream(path), 20))
        _, out = broken_off(tmp_path)
    resumed = remote_agent("run", tmp_path / "small.toml", "--no-images", "--resume", "--out", out)
    assert resumed.status in {0, 1}
    assert resumed.err == ""
    assert entries_of(out)[-1]["event"] == "run.finished"


def test_no_room_for_a_plan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: FlexiblePlan, path: Path) -> None:
        raise OSError(errno.ENOSPC, FULL)

    monkeypatch.setattr(FlexiblePlan, "save", refuse)
    answer, out = broken_off(tmp_path)
    last = entries_of(out)[-1]
    assert last["event"] == "plan.adopted"
    assert f"{out}/plans/{last['plan']}.json: {FULL}; the run ended at {last['t']} s" in answer.err


def test_hardly_any_room_left_for_the_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usage = namedtuple("usage", "total used free")
    asked: list[Path] = []

    def filling(path: Path) -> usage:
        asked.append(path)
        free = RESERVE_BYTES - (len(asked) > 4)
        return usage(1 << 40, (1 << 40) - free, free)

    monkeypatch.setattr("scenarios.recording.stream.shutil.disk_usage", filling)
    answer, out = broken_off(tmp_path)
    assert set(asked) == {out}
    assert f"{out}/run.rrd: {FULL}; the run ended at " in answer.err
    assert read(out / "run.rrd").plots  # it has its index, or reading it would warn


LOST = """
import resource, sys
from pathlib import Path
import numpy as np
import rerun as rr
from scenarios.recording.stream import Stream

resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
stream = Stream(Path(sys.argv[1]), 0.0, None, patience_s=0.5)
for work in (stream.flush, stream.close):
    stream.at(1, "noise", rr.Tensor(np.random.default_rng(1).integers(0, 255, 200_000, dtype=np.uint8)))
    try:
        work()
    except OSError as error:
        print(error.filename, error.strerror)
"""


def test_a_recording_that_is_lost_does_not_hold_up_the_end(tmp_path: Path) -> None:
    path = tmp_path / "lost.rrd"
    root = Path(__file__).parents[2]
    command = [sys.executable, "-c", LOST, str(path)]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    done = subprocess.run(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, timeout=60, check=False
    )
    assert done.stdout.decode().splitlines() == [f"{path} the recording could not be written (is the disk full?)"] * 2
    assert done.returncode == 1
