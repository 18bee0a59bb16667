"""Numba's cache of compiled functions, which asks whether any file with compiled functions changed.

Numba itself asks for the file of the function alone, and would go on with what a function called, in another file, was
when it was compiled. Imported only where numba is.
"""

from __future__ import annotations

from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    InTreeCacheLocator,
    UserProvidedCacheLocator,
    UserWideCacheLocator,
)

_MARK = b"@compiled\n"


@cache
def sources_stamp(root: Path) -> str:
    """A hash of all files under `root` that hold compiled functions, as they were when it was first asked for."""
    digest = sha256()
    for path in sorted(root.rglob("*.py")):
        text = path.read_bytes()
        if _MARK in text:
            digest.update(sha256(text).digest())
    return digest.hexdigest()


def _of_all_sources(locator: Any) -> Any:
    """The same place for the cache, stamped with the function's own file and all of ours. `locator`: numba's class."""

    def stamp(self: Any) -> tuple[object, str]:
        return locator.get_source_stamp(self), sources_stamp(Path(__file__).parent)

    return type(locator.__name__, (locator,), {"get_source_stamp": stamp})


class _Implementation(CompileResultCacheImpl):  # type: ignore[misc]  # numba has no types
    _locator_classes = tuple(map(_of_all_sources, (UserProvidedCacheLocator, InTreeCacheLocator, UserWideCacheLocator)))


class SourcesCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """A dispatcher's cache: beside the source if that can be written, else the user's."""

    _impl_class = _Implementation
