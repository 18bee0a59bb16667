"""Compilation of the arithmetic that runs every second of flight.

The functions marked `compiled` work on arrays of floats, are plain Python to read and to debug (`NUMBA_DISABLE_JIT=1`),
and go through numba where it is installed; without it they run as they stand, some ten times slower, to the same
numbers up to the last digits of the sine. The first flight on a machine compiles for some seconds; the result is
cached beside the source until one of the files with such functions changes.

An array is a component's memory: the component's module names its places, and only that module writes them, the flight
loop excepted, which carries readings from one to the other.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

Memory = NDArray[np.float64]
_Function = TypeVar("_Function", bound=Callable[..., Any])

HAS_NUMBA = importlib.util.find_spec("numba") is not None


def compiled(function: _Function) -> _Function:
    """Compile at the first call, or leave it as it is without numba."""
    if not HAS_NUMBA:
        return function
    from numba import njit

    from sim.kernel_cache import SourcesCache

    dispatcher = njit(function)
    if dispatcher is not function:  # it is, where compiling is switched off
        dispatcher._cache = SourcesCache(function)  # what `cache=True` does, with numba's own cache
    return cast(_Function, dispatcher)
