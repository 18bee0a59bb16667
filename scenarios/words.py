"""Reasons in a reader's words: why a plan was given up, told from what the journal says."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from scenarios.times import clock

_KINDS = {
    "early": "something ended too early",
    "late": "something took too long",
    "unconfirmed": "a command had no effect",
    "refused": "a command was refused",
    "lock": "something that a running activity needs was lost",
    "incompatible": "two activities need opposite things",
    "fault": "a fault was found",
    "dispatch": "the plan could not be kept",
    "standby": "standby was not reached",
}
MEANT = {
    "completed": "every goal is achieved",
    "degraded": "goals that were out of reach are dropped, all others achieved",
    "standby": "goals are missed, and it waits without a plan",
    "failed": "goals are missed",
}
"""What the outcomes of a run mean."""
_FIRST = "initial"
_SECONDS = re.compile(r"\b(at|from) (\d+)(?: s)?(?=[:;,.)]|$)")


class Reasons:
    """Follows a journal. What was concluded in the very second in which a plan was given up is why it was given up."""

    def __init__(self) -> None:
        self._concluded: dict[int, str] = {}
        self._known: dict[str, str] = {}

    def tell(self, entry: Mapping[str, Any]) -> None:
        """A journal entry, in order."""
        event = entry.get("event")
        if event == "fault.detected" and entry.get("text"):
            self._concluded[entry["t"]] = str(entry["text"])
        elif event == "standby.entered" and entry["t"] in self._concluded:
            self._known[str(entry.get("reason", ""))] = self._concluded[entry["t"]]

    def say(self, reason: str) -> str:
        """The executive's reason in words: the conclusion drawn with it, or else what the violations mean."""
        return self._known.get(reason) or in_words(reason)

    def waits(self, reason: str) -> str:
        """Why the spacecraft is in standby, as `say` has it; before the first plan, that it waits for it."""
        return "waiting for the first plan" if reason == _FIRST else self.say(reason)

    def retold(self, entry: Mapping[str, Any]) -> Mapping[str, Any]:
        """The entry with its reason in words."""
        if not entry.get("reason"):
            return entry
        event, raw = entry.get("event"), str(entry["reason"])
        if event == "token.failed" and entry["t"] in self._concluded:
            return {**entry, "reason": self._concluded[entry["t"]]}
        return {**entry, "reason": self.waits(raw) if event == "standby.entered" else self.say(raw)}


def in_words(reason: str) -> str:
    """`late: ...` and its like with the kind of violation in words, seconds as times; the rest as it stands."""
    if reason == _FIRST:
        return "the first plan"
    reason = _SECONDS.sub(lambda found: f"{found[1]} {clock(int(found[2]))}", reason)
    kind, colon, detail = reason.partition(": ")
    return f"{_KINDS[kind]}: {detail}" if colon and kind in _KINDS else reason


def most_like(names: Iterable[str], *texts: str | None) -> str | None:
    """The name that has most words in common with the texts, of equals the first; None without names.

    What is detected aboard has another name than what was injected, and often only that it speaks of the same device.
    """
    said = {word for text in texts if text for word in re.split(r"[\W_]+", text.lower())}

    def shared(name: str) -> int:
        return len(said.intersection(re.split(r"[\W_]+", name.lower())))

    return max(names, key=shared, default=None)
