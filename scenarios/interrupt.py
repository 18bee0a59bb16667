"""Ctrl-C, or a request to terminate, that is never lost."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.resource_tracker import ensure_running
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def interruptible() -> Iterator[Callable[[], None]]:
    """A function to call between steps: KeyboardInterrupt when Ctrl-C or SIGTERM came since.

    Python raises it wherever it happens to be; in a callback of the garbage collector, that is nowhere, and the request
    would be lost. So it is also remembered.
    """
    if threading.current_thread() is not threading.main_thread():
        yield lambda: None
        return
    asked = False

    def remember(number: int, frame: FrameType | None) -> None:
        nonlocal asked
        asked = True
        signal.default_int_handler(number, frame)

    def check() -> None:
        if asked:
            raise KeyboardInterrupt

    def tell(lost: sys.UnraisableHookArgs) -> None:
        if lost.exc_type is not KeyboardInterrupt:
            told(lost)

    before, told = [signal.signal(number, remember) for number in SIGNALS], sys.unraisablehook
    sys.unraisablehook = tell
    try:
        yield check
    finally:
        for number, handler in zip(SIGNALS, before, strict=True):
            signal.signal(number, handler)
        sys.unraisablehook = told


@contextmanager
def children_deaf_to_it() -> Iterator[None]:
    """Processes and threads begun inside never hear a Ctrl-C: a terminal gives it to all, and one answer is enough.

    It is held back, and heard here at the end. What a process has blocked, its children have blocked too (POSIX).
    """
    ensure_running()  # multiprocessing's tracker, which unblocks it in the thread that begins it
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
