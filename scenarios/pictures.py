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
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from rerun.chunk import RrdReader
from rerun.experimental import ViewerClient

from scenarios.recording.blueprint import LOG
from scenarios.recording.boards import FAULTS_PATH
from scenarios.recording.stream import EPOCH_PROPERTY, TIMELINE
from scenarios.recording.style import elapsed, entity

SIZE = (1920, 1080)
_START_SECONDS = 30.0
_LOAD_SECONDS = 60.0
_SETTLE_SECONDS = 0.6
_ENDING_SECONDS = 5.0
_TOASTS_SECONDS = 6.0  # after which the viewer's notices of its start are gone
_MOST_FAULTS, _APART_SECONDS = 4, 1800


class PicturesError(Exception):
    """No pictures could be taken; the text says what is missing."""


@dataclass(frozen=True, slots=True)
class _Tab:
    """A tab of the layout and its container in the blueprint."""

    name: str
    container: str


def take_pictures(
    rrd: Path,
    out: Path,
    moments: Sequence[int] | None = None,
    size: tuple[int, int] = SIZE,
    tell: Callable[[int, int], None] = lambda taken, of: None,
) -> list[Path]:
    """A picture of every tab at every moment, `size` pixels, as `<number>_<tab>_<hh-mm-ss>.png` in `out`.

    `moments`: simulation seconds of the cursor; None takes those of `read_moments`. `tell`: told after each picture
    how many there are, and of how many. Raises PicturesError when there is no readable recording, no viewer or no
    graphics driver, and when a view reports that it cannot draw something.
    """
    if not rrd.is_file():
        raise PicturesError(f"{rrd}: expected a recording, found no file")
    telling = read_moments(rrd)
    chosen = telling if moments is None else moments
    out.mkdir(parents=True, exist_ok=True)
    pictures = []
    with _viewer(size) as viewer:
        _open(viewer, rrd)
        tabs = _tabs(viewer)
        time.sleep(_TOASTS_SECONDS)
        for moment in chosen:
            viewer.set_time(TIMELINE, duration=float(moment), play_state="paused")
            for number, tab in enumerate(tabs):
                _show(viewer, tab)
                clock = elapsed(moment).replace(":", "-").replace(" ", "_")
                picture = out / f"{number}_{entity(tab.name).lower()}_{clock}.png"
                _shoot(viewer, picture)
                pictures.append(picture)
                tell(len(pictures), len(chosen) * len(tabs))
        _check_reports(viewer, rrd)
    return pictures


def read_moments(rrd: Path) -> list[int]:
    """The simulation seconds at which a recording is best looked at: faults noticed, as far as they are apart, the end.

    Without faults the middle instead. PicturesError when it is no recording of a run.
    """
    known = False
    times: list[int] = []
    rows: dict[int, list[str]] = {}
    for chunk in _chunks(rrd):
        path = str(chunk.entity_path)
        known = known or path == f"/__properties/{EPOCH_PROPERTY}"
        if chunk.is_static or path not in (FAULTS_PATH, LOG):
            continue
        batch = chunk.to_record_batch()
        instants = [t // 1_000_000_000 for t in batch.column(TIMELINE).cast("int64").to_pylist()]
        times += instants
        if path == FAULTS_PATH:
            states = batch.column("StateChange:state").to_pylist()
            rows |= dict(zip(instants, states, strict=True))
    if not known:
        raise PicturesError(f"{rrd}: expected a recording of a run, found none of its properties")
    moments: list[int] = []
    for moment in _noticed(rows):
        if len(moments) < _MOST_FAULTS and (not moments or moment >= moments[-1] + _APART_SECONDS):
            moments.append(moment)
    last = max(times, default=0)
    return [*moments, last] if moments else [(min(times, default=0) + last) // 2]


def _noticed(rows: Mapping[int, Sequence[str]]) -> Iterator[int]:
    """When a fault was detected that was not a moment before, ascending. `rows`: what the lane of faults shows."""
    before: set[str] = set()
    for second, row in sorted(rows.items()):
        detected = {state.partition(":")[0] for state in row if ": detected" in state}
        if detected - before:
            yield second
        before = detected


def _chunks(rrd: Path) -> list[Any]:
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore"
        )  # a run that was killed leaves a file without its index, which is read all the same
        try:
            return list(RrdReader(rrd).stream())
        except (ValueError, OSError, RuntimeError) as error:
            raise PicturesError(f"{rrd}: expected a recording, found none that can be read: {error}") from error


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
