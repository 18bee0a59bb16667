"""Python's cyclic garbage collector beside a search: a plan is one large living graph that it would walk in vain."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

THRESHOLDS = (200_000, 50, 100)
"""Collections far apart: what a search undoes is still freed in the end, what it builds is not walked all the time."""


@contextmanager
def patient_collector() -> Iterator[None]:
    """Run the body with collections far apart, and put the collector back as it was."""
    before = gc.get_threshold()
    gc.set_threshold(*THRESHOLDS)
    try:
        yield
    finally:
        gc.set_threshold(*before)
