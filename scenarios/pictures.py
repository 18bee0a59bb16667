"""Pictures of a recording without a display: every tab, through a headless viewer that is ended afterwards.

Needs the viewer that comes with rerun-sdk and a graphics driver; a software one is in the system package
`mesa-vulkan-drivers`.
"""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sysconfig
import tempfile
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from rerun.chunk import RrdReader
from rerun.experimental import ViewerClient

from scenarios.recording.blueprint import LOG
from scenarios.recording.boards import HEADER_PATH
from scenarios.recording.stream import EPOCH_PROPERTY, TIMELINE
from scenarios.recording.style import elapsed, entity

SIZE = (1920, 1080)
_START_SECONDS = 30.0
_LOAD_SECONDS = 60.0
_SETTLE_SECONDS = 0.6
_ENDING_SECONDS = 5.0


class PicturesError(Exception):
    """No pictures could be taken; the text says what is missing."""


@dataclass(frozen=True, slots=True)
class _Tab:
    """A tab of the layout and its container in the blueprint."""

    name: str
    container: str


def take_pictures(
    rrd: Path, out: Path, moments: Sequence[int] | None = None, size: tuple[int, int] = SIZE
) -> list[Path]:
    """A picture of every tab at every moment, `size` pixels, as `<number>_<tab>_<hh-mm-ss>.png` in `out`.

    `moments`: simulation seconds of the cursor; None takes the first fault that was detected, or else the middle of
    the recording. Raises PicturesError when there is no readable recording, no viewer or no graphics driver, and when a
    view reports that it cannot draw something.
    """
    if not rrd.is_file():
        raise PicturesError(f"{rrd}: expected a recording, found no file")
    epoch_ns, telling = read_moment(rrd)
    out.mkdir(parents=True, exist_ok=True)
    pictures = []
    with _viewer(size) as viewer:
        _open(viewer, rrd)
        tabs = _tabs(viewer)
        for moment in moments if moments is not None else (telling,):
            instant = np.datetime64(epoch_ns + moment * 1_000_000_000, "ns")
            viewer.set_time(TIMELINE, timestamp=instant, play_state="paused")
            for number, tab in enumerate(tabs):
                _show(viewer, tab)
                clock = elapsed(moment).replace(":", "-").replace(" ", "_")
                picture = out / f"{number}_{entity(tab.name).lower()}_{clock}.png"
                _shoot(viewer, picture)
                pictures.append(picture)
        _check_reports(viewer, rrd)
    return pictures


def read_moment(rrd: Path) -> tuple[int, int]:
    """Unix nanoseconds of simulation second 0, and the simulation second at which a recording is best looked at."""
    epoch_ns: int | None = None
    times: list[int] = []
    detected: list[int] = []
    for chunk in _chunks(rrd):
        path = str(chunk.entity_path)
        if path == f"/__properties/{EPOCH_PROPERTY}":
            found = _first_number(chunk.to_record_batch(), "epoch_ns")
            epoch_ns = epoch_ns if found is None else found
        elif path == HEADER_PATH and not chunk.is_static:
            batch = chunk.to_record_batch()
            instants = batch.column(TIMELINE).cast("int64").to_pylist()
            times += instants
            states = batch.column("StateChange:state").to_pylist()
            detected += [t for t, row in zip(instants, states, strict=True) if any(": detected" in s for s in row)]
        elif path == LOG and not chunk.is_static:
            times += chunk.to_record_batch().column(TIMELINE).cast("int64").to_pylist()
    if epoch_ns is None:
        raise PicturesError(f"{rrd}: expected a recording of a run, found none of its properties")
    moment = min(detected) if detected else (min(times) + max(times)) // 2 if times else epoch_ns
    return epoch_ns, (moment - epoch_ns) // 1_000_000_000


def _chunks(rrd: Path) -> list[Any]:
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore"
        )  # a run that was killed leaves a file without its index, which is read all the same
        try:
            return list(RrdReader(rrd).stream())
        except (ValueError, OSError, RuntimeError) as error:
            raise PicturesError(f"{rrd}: expected a recording, found none that can be read: {error}") from error


def _first_number(batch: Any, name: str) -> int | None:
    for column in batch.schema.names:
        if column.rpartition(":")[2] == name:
            values = batch.column(column).to_pylist()[0]
            return int(values[0]) if values else None
    return None


@contextmanager
def _viewer(size: tuple[int, int]) -> Iterator[ViewerClient]:
    """A headless viewer that listens on the loopback interface alone; its whole process group ends with the block."""
    with tempfile.TemporaryFile() as log:
        port = _free_port()
        command = [_executable(), "--headless", "--bind", "127.0.0.1", "--port", str(port)]
        command += ["--window-size", f"{size[0]}x{size[1]}", "--hide-welcome-screen"]
        process = subprocess.Popen(
            command,
            stdout=log,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            env={**os.environ, "RERUN_APP_ONLY": "true"},
        )
        try:
            yield _connect(process, port, log)
        finally:
            _end(process)


def _executable() -> str:
    beside = Path(sysconfig.get_path("scripts")) / "rerun"
    found = str(beside) if beside.is_file() else shutil.which("rerun")
    if found is None:
        raise PicturesError(
            f"the program `rerun` of rerun-sdk was expected in {beside.parent} or on PATH, found nowhere"
        )
    return found


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _connect(process: subprocess.Popen[bytes], port: int, log: IO[bytes]) -> ViewerClient:
    deadline = time.monotonic() + _START_SECONDS
    while process.poll() is None and time.monotonic() < deadline:
        with socket.socket() as probe:
            probe.settimeout(0.2)
            listening = probe.connect_ex(("127.0.0.1", port)) == 0
        if listening:
            try:
                viewer = ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
                viewer.get_state()
            except (RuntimeError, ConnectionError, OSError):
                listening = False
            else:
                return viewer
        time.sleep(0.1)
    log.seek(0)
    said = log.read().decode(errors="replace").strip().splitlines()
    raise PicturesError(
        "no picture can be taken: the headless viewer did not start. It needs a graphics driver; a software one comes "
        f"with the system package mesa-vulkan-drivers. Its last words: {said[-1] if said else 'none'}"
    )


def _end(process: subprocess.Popen[bytes]) -> None:
    """End the launcher and the viewer that it started: they share a process group of their own."""
    for sign in (signal.SIGTERM, signal.SIGKILL):
        with suppress(ProcessLookupError):
            os.killpg(process.pid, sign)
        with suppress(subprocess.TimeoutExpired):
            process.wait(_ENDING_SECONDS)


def _open(viewer: ViewerClient, rrd: Path) -> None:
    viewer.open(str(rrd.resolve()))
    deadline = time.monotonic() + _LOAD_SECONDS
    while time.monotonic() < deadline:
        state = viewer.get_state()
        if not state.loading and any(recording.timelines for recording in state.recordings):
            return
        time.sleep(0.2)
    raise PicturesError(f"{rrd}: the viewer did not load the recording within {_LOAD_SECONDS:.0f} seconds")


def _containers(blueprint: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    return {
        path.strip("/"): content["ContainerBlueprint"]
        for path, content in blueprint.items()
        if "ContainerBlueprint" in content
    }


def _tabs(viewer: ViewerClient) -> list[_Tab]:
    containers = _containers(viewer.get_blueprint("recording").blueprint)
    for content in containers.values():
        if content["container_kind"] == "Tabs":
            return [_Tab(str(containers[name]["display_name"]), name) for name in content["contents"]]
    raise PicturesError("the recording's layout was expected to have tabs, found none")


def _show(viewer: ViewerClient, tab: _Tab) -> None:
    blueprint = viewer.get_blueprint("recording").blueprint
    for content in _containers(blueprint).values():
        if content["container_kind"] == "Tabs":
            content["active_tab"] = tab.container
    viewer.set_blueprint(blueprint, "recording")


def _shoot(viewer: ViewerClient, picture: Path) -> None:
    """Chunks load when they are first wanted: the first shot makes the viewer want them, the second is kept."""
    viewer.take_screenshot()
    time.sleep(_SETTLE_SECONDS)
    picture.write_bytes(viewer.take_screenshot())


def _check_reports(viewer: ViewerClient, rrd: Path) -> None:
    reports = [f"{view.name}: {report}" for view in viewer.get_state().views for report in view.reports]
    if reports:
        raise PicturesError(f"{rrd}: the viewer cannot draw all of it: " + "; ".join(reports))
