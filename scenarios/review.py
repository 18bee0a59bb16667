"""Looking at a run: the Rerun viewer on a screen, or pictures without one."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from scenarios.errors import ScenarioError
from scenarios.folder import RECORDING
from scenarios.pictures import PicturesError, take_pictures
from scenarios.progress import progress_bar
from scenarios.times import seconds_of


def recording_of(run_dir: Path) -> Path:
    """The recording of a run folder; ScenarioError when it has none."""
    recording = run_dir / RECORDING
    if not recording.is_file():
        raise ScenarioError(f"{run_dir}: expected a run folder with {RECORDING}, found none")
    return recording


def moments_of(texts: Sequence[str] | None, out: Path | None) -> list[int] | None:
    """The simulation seconds of --at; ScenarioError when one is no time, or no pictures were asked for."""
    if texts and out is None:
        raise ScenarioError("--at: says of when the pictures of --png are; give that too")
    try:
        return [seconds_of(text) for text in texts] if texts else None
    except ValueError as error:
        raise ScenarioError(f"--at: {error}") from error


def take(recording: Path, out: Path, moments: Sequence[int] | None, quiet: bool) -> list[Path]:
    """Pictures of every tab of a recording, in a folder that is made. `moments`: None for those that tell most."""
    try:
        with progress_bar("pictures", 1000, quiet) as (show, _):
            return take_pictures(
                recording, out, moments, tell=lambda taken, of: show(1000 * taken // of, f"{taken} of {of}")
            )
    except PicturesError as error:
        raise ScenarioError(f"{recording}: {error}") from error


def open_viewer(recording: Path) -> None:
    """Open the viewer on this screen and wait until it is closed."""
    beside = Path(sys.executable).with_name("rerun")
    viewer = str(beside) if beside.exists() else shutil.which("rerun")
    if viewer is None:
        raise ScenarioError("the rerun viewer is not installed beside this Python; pip install rerun-sdk brings it")
    if subprocess.run([viewer, str(recording)], check=False).returncode != 0:
        raise ScenarioError("the viewer could not open a window; without a display, use --png FOLDER")
