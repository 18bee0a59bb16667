"""The temporal kernel compiled: `kernel_python` through numba, or as it stands without it.

One source, two executions. Compiled functions are cached on disk beside their source; the first run on a machine
compiles for a few seconds, later ones load in a quarter of a second. Numba's own cache will do: all that is compiled is
in one file, which it watches.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from types import FunctionType
from typing import Any

from planner.temporal import kernel_python

_INLINED = (
    "push",
    "span_of",
    "set_span",
    "put",
    "link",
    "unlink_last",
    "unlink",
    "relink",
    "set_weight",
    "settle",
    "assert_arc",
    "write_edge",
    "write_cycle",
    "enforce",
    "note_changes",
    "undo_record",
    "undo_to",
    "propagate",
    "reset",
    "reset_dependents",
    "take_out",
    "relax_into",
    "recompute",
    "sift",
)
"""Functions called by others, callees first."""

_ENTRIES = {"propagate": (5, 0), "undo_to": (5, 1), "probe": (5, 5), "remove": (6, 0), "shortest": (3, 3)}
"""The kernel's entry points: number of buffers, then of integers."""


@dataclass(frozen=True, slots=True)
class Kernel:
    """The entry points, documented at their source; `compiled` tells whether buffers are arrays or memoryviews."""

    compiled: bool
    propagate: Callable[..., int]
    undo_to: Callable[..., int]
    probe: Callable[..., int]
    remove: Callable[..., int]
    shortest: Callable[..., int]


def load_kernel(compiled: bool | None = None) -> Kernel:
    """The compiled kernel, or the plain one; None: the compiled one if numba is installed."""
    if compiled is None:
        compiled = importlib.util.find_spec("numba") is not None
    return _compile() if compiled else _PLAIN


_SOURCES: dict[str, Any] = vars(kernel_python)
_PLAIN = Kernel(compiled=False, **{name: _SOURCES[name] for name in _ENTRIES})


@cache
def _compile() -> Kernel:
    """Compile or load from numba's cache.

    Each function is bound to a namespace in which its callees are compiled ones. The entry points are bound to their
    one signature: a call then skips the dispatch on argument types, which would cost as much as a small propagation.
    """
    import numba

    namespace = dict(_SOURCES)
    for name in _INLINED:
        namespace[name] = numba.njit(cache=True)(_rebound(name, namespace))
    entries: dict[str, Callable[..., int]] = {}
    for name, (buffers, integers) in _ENTRIES.items():
        signature = numba.int64(*[numba.int64[::1]] * buffers, *[numba.int64] * integers)
        dispatcher = numba.njit(signature, cache=True)(_rebound(name, namespace))
        entries[name] = dispatcher.get_overload(signature.args)
    return Kernel(compiled=True, **entries)


def _rebound(name: str, namespace: dict[str, Any]) -> FunctionType:
    source: FunctionType = _SOURCES[name]
    return FunctionType(source.__code__, namespace, name)
