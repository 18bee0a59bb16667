"""Files that are written whole or not at all."""

from __future__ import annotations

from errno import EISDIR
from os import strerror
from pathlib import Path


def write_whole(path: Path, text: str) -> None:
    """Write a file; when broken off, what was there before still is. OSError when it cannot be written."""
    if not path.name:
        raise IsADirectoryError(EISDIR, strerror(EISDIR), str(path))
    part = path.with_name(f"{path.name}.part")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(path)
    except OSError:
        part.unlink(missing_ok=True)
        raise
