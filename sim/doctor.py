"""What this machine has of what the simulator needs: one finding a need, with the remedy where something is missing.

Nothing is changed and nothing is raised: a doctor that falls ill at the first symptom is of no use.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from sim.errors import SimulatorError
from sim.offscreen import find_backend

PYTHON = (3, 11)
MUJOCO = (4, 0)
DISK_MB = 200
"""What a run folder of some days with pictures may take."""


@dataclass(frozen=True, slots=True)
class Finding:
    """`need` is met (`ok`) or not; `found`: what there is, `remedy`: what to install or do. `required`: for flying."""

    need: str
    ok: bool
    found: str
    remedy: str = ""
    required: bool = True


def examine(folder: Path) -> tuple[Finding, ...]:
    """Look at Python, MuJoCo, numba, a flight of a minute, offscreen OpenGL, the viewer, and the disk of `folder`."""
    return (
        _python(),
        _package("mujoco", MUJOCO, "physics"),
        _package("numpy", (2, 0), "arithmetic"),
        _package("numba", (0, 60), "compiled flight loop", required=False),
        _flight(),
        _opengl(),
        _package("rerun-sdk", (0, 41), "recording and viewer"),
        _disk(folder),
    )


def _python() -> Finding:
    version = ".".join(map(str, sys.version_info[:3]))
    wanted = ".".join(map(str, PYTHON))
    return Finding("Python", sys.version_info[:2] >= PYTHON, version, f"install Python {wanted} or newer")


def _package(name: str, at_least: tuple[int, ...], purpose: str, *, required: bool = True) -> Finding:
    wanted = ".".join(map(str, at_least))
    remedy = f"pip install '{name}>={wanted}'"
    try:
        version = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return Finding(f"{name} ({purpose})", False, "not installed", remedy, required)
    numbers = tuple(int(part) for part in version.split(".")[: len(at_least)] if part.isdigit())
    return Finding(f"{name} ({purpose})", numbers >= at_least, version, remedy, required)


def _flight() -> Finding:
    def fly() -> str:
        from sim.config import SpacecraftConfig
        from sim.spacecraft import Spacecraft

        craft = Spacecraft(SpacecraftConfig(), 1)
        craft.advance(60)
        return f"a minute flown, {craft.telemetry()['acs.state']}"

    return _tried("flight", fly, "reinstall the package: pip install --force-reinstall remote-agent")


def _opengl() -> Finding:
    try:
        return Finding("offscreen OpenGL (views from outside)", True, find_backend(), required=False)
    except SimulatorError as error:
        remedy = "apt-get install --no-install-recommends libegl1 libgl1 (or libosmesa6)"
        return Finding("offscreen OpenGL (views from outside)", False, str(error), remedy, required=False)


def _disk(folder: Path) -> Finding:
    def look() -> str:
        there = next(place for place in (folder, *folder.absolute().parents) if place.exists())
        free_MB = shutil.disk_usage(there).free // 1_000_000
        if free_MB < DISK_MB:
            raise OSError(f"{free_MB} MB free in {there}, expected {DISK_MB}")
        return f"{free_MB} MB free in {there}"

    return _tried("disk", look, f"free {DISK_MB} MB, or put run folders elsewhere with --out")


def _tried(need: str, attempt: Callable[[], str], remedy: str) -> Finding:
    try:
        return Finding(need, True, attempt())
    except Exception as error:
        return Finding(need, False, f"{type(error).__name__}: {error}", remedy)
