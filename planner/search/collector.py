"""Python's cyclic garbage collector beside a search: a plan is one large living graph that it would walk in vain.

What a search builds is alive until it is undone. So the collector waits for that.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

from planner.trail import Trail

LEAST = 200_000
"""Changes undone before a collection is worth its while: a few tens of megabytes."""


class Collector:
    """Collects garbage when as much has been undone since the last time as is alive."""

    __slots__ = ("_due", "_trail")

    def __init__(self, trail: Trail) -> None:
        self._trail = trail
        self._due = LEAST

    def relieve(self) -> None:
        """Collect if it is time to."""
        if self._trail.undone >= self._due:
            gc.collect()
            self._due = self._trail.undone + max(LEAST, len(self._trail))


@contextmanager
def patient_collector() -> Iterator[None]:
    """Run the body without automatic collections, and put the collector back as it was."""
    before = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if before:
            gc.enable()
