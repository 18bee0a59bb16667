"""Offscreen OpenGL without a display, found safely.

A missing or broken library can end the import of MuJoCo's bindings, or the process. So a backend is first looked for
with the dynamic loader, then tried in a process of its own, and only then used in this one. A `MUJOCO_GL` of egl or
osmesa set by the user narrows the choice to it; the simulator itself never sets it.
"""

from __future__ import annotations

import ctypes
import functools
import importlib
import os
import subprocess
import sys
from typing import Any

from sim.errors import RenderingUnavailable

PACKAGES = {"egl": "libegl1 libgl1", "osmesa": "libosmesa6"}
_LIBRARIES = {"egl": (("libEGL.so.1",), ("libGL.so.1",)), "osmesa": (("libOSMesa.so.8", "libOSMesa.so.6"),)}
_PROBE = """
import mujoco
from mujoco.{backend} import GLContext
context = GLContext(16, 16)
context.make_current()
mujoco.MjrContext(mujoco.MjModel.from_xml_string("<mujoco/>"), mujoco.mjtFontScale.mjFONTSCALE_100.value)
print("rendering works")
"""
_PROBE_LIMIT_S = 60.0


@functools.cache
def find_backend() -> str:
    """Name of a backend that works here, `egl` or `osmesa`; a fact of the machine, so found once.

    Raises `RenderingUnavailable`, which names the Debian packages.
    """
    wanted = os.environ.get("MUJOCO_GL", "").strip().lower()
    candidates = [wanted] if wanted in PACKAGES else list(PACKAGES)
    for backend in candidates:
        if all(any(map(_loads, names)) for names in _LIBRARIES[backend]) and _works(backend):
            return backend
    raise RenderingUnavailable(
        f"views from outside need offscreen OpenGL: tried {', '.join(candidates)}, found none that works. "
        "On Debian install " + " or ".join(f"`{PACKAGES[backend]}`" for backend in candidates) + "."
    )


def make_context(width: int, height: int) -> Any:
    """An OpenGL context of MuJoCo's own class for frames up to the size given. Raises as `find_backend`."""
    backend = find_backend()
    try:
        return importlib.import_module(f"mujoco.{backend}").GLContext(width, height)
    except (ImportError, RuntimeError, AttributeError, OSError) as error:
        raise RenderingUnavailable(
            f"offscreen OpenGL by {backend} failed in this process: {error}. PyOpenGL may already be bound to another "
            f"backend here; on Debian the packages are `{PACKAGES[backend]}`."
        ) from error


def _environment(backend: str) -> dict[str, str]:
    return {"MUJOCO_GL": backend, "PYOPENGL_PLATFORM": backend}


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def _works(backend: str) -> bool:
    command = [sys.executable, "-c", _PROBE.format(backend=backend)]
    environment = {**os.environ, **_environment(backend)}
    try:
        result = subprocess.run(command, env=environment, capture_output=True, timeout=_PROBE_LIMIT_S, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return result.returncode == 0 and b"rendering works" in result.stdout
