"""Progress of what takes longer than a moment, for a person at a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def loading(what: str, quiet: bool) -> Iterator[None]:
    """A line on standard error while something is read, gone when it is; nothing where that is no terminal."""
    if quiet or not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(f"{what}: loading"):
        yield


@contextmanager
def progress_bar(
    title: str, total: int, quiet: bool
) -> Iterator[tuple[Callable[[int, str], None], Callable[[str], None]]]:
    """Functions for progress and for warnings, on standard error: a bar if that is a terminal, else nothing."""
    if quiet or not sys.stderr.isatty():
        yield lambda second, doing: None, lambda text: print(f"remote-agent: {text}", file=sys.stderr)
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True, highlight=False)) as progress:
        task = progress.add_task(title, total=total)

        def show(second: int, doing: str) -> None:
            progress.update(task, completed=second, description=f"{title}: {doing}")
            if doing == "planning":
                progress.refresh()  # nothing else is told while the planner thinks

        yield show, lambda text: progress.console.print(f"remote-agent: {text}", markup=False, soft_wrap=True)
