"""Times as people write them: 90, 3h20m, 1d 02:03:04."""

from __future__ import annotations

import re

_PARTS = re.compile(r"\s*(?:(\d{1,9})\s*d)?\s*(?:(\d{1,9})\s*h)?\s*(?:(\d{1,9})\s*m(?:in)?)?\s*(?:(\d{1,9})\s*s?)?\s*$")
_CLOCK = re.compile(r"\s*(?:(\d{1,9})\s*d\s+)?(\d{1,9}):([0-5]\d)(?::([0-5]\d))?\s*$")


def seconds_of(text: object) -> int:
    """Whole seconds of a whole number, or of text such as `3h20m` or `03:20:00`; ValueError says what was expected."""
    if isinstance(text, int) and not isinstance(text, bool):
        return text
    matched = _CLOCK.match(text) or _PARTS.match(text) if isinstance(text, str) and text.strip() else None
    if matched is None:
        raise ValueError(f"expected seconds or a time such as 3h20m, found {text!r:.80}")
    days, hours, minutes, seconds = (int(group or 0) for group in matched.groups())
    return ((days * 24 + hours) * 60 + minutes) * 60 + seconds


def clock(seconds: float) -> str:
    """Seconds as `1d 02:03:04`, without the days when there are none."""
    days, rest = divmod(int(seconds), 86400)
    text = f"{rest // 3600:02d}:{rest % 3600 // 60:02d}:{rest % 60:02d}"
    return f"{days}d {text}" if days else text
