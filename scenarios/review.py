"""Looking at a run: the Rerun viewer on a screen, or pictures without one."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from scenarios.errors import ScenarioError
from scenarios.folder import RECORDING
from scenarios.pictures import PicturesError, take_pictures


def recording_of(run_dir: Path) -> Path:
    """The recording of a run folder; ScenarioError when it has none."""
    recording = run_dir / RECORDING
    if not recording.is_file():
        raise ScenarioError(f"{run_dir}: expected a run folder with {RECORDING}, found none")
    return recording


def take(recording: Path, out: Path) -> list[Path]:
    """Pictures of every tab of a recording, in a folder that is made."""
    try:
        return take_pictures(recording, out)
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
