"""Property locks: what running tokens need maintained (Remote Agent's executive, Pell et al., Agents 1998).

A lock is taken when a token's start is proven and released at its end. Two locks that no telemetry could satisfy
together are incompatible, and the second is refused.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from executive.bindings import Maintained
from executive.conditions import RELATIVE, Condition, Parameters, Telemetry, Watch


@dataclass(frozen=True, slots=True)
class BrokenLock:
    """A property that a token needs and that telemetry denies."""

    token: str
    lock: Maintained
    detail: str


class LockTable:
    """The locks of all running tokens, in the order in which they were taken."""

    def __init__(self) -> None:
        self._held: dict[tuple[str, str], tuple[Maintained, Watch]] = {}

    def take(self, token: str, lock: Maintained, parameters: Parameters, telemetry: Telemetry) -> str | None:
        """Take a lock for a token; None, or what it is incompatible with, and then it is not taken."""
        wanted = replace(lock, conditions=tuple(c.bound_to(parameters) for c in lock.conditions))
        for (holder, _), (held, _) in self._held.items():
            for ours in wanted.conditions:
                for theirs in held.conditions:
                    if not compatible(ours, theirs):
                        return f"{lock.name!r} needs {ours}, but {held.name!r} of {holder} needs {theirs}"
        self._held[token, lock.name] = (wanted, Watch(wanted.conditions, lock.persistence, telemetry, broken=True))
        return None

    def hand_over(self, holder: str, to: LockTable, token: str) -> None:
        """Give the locks of one token to another table, for the token that goes on as its continuation."""
        for key in [key for key in self._held if key[0] == holder]:
            to._held[token, key[1]] = self._held.pop(key)

    def held(self) -> Iterable[Maintained]:
        """What is to be maintained now, parameters filled in."""
        return (lock for lock, _ in self._held.values())

    def kept(self, token: str, name: str, telemetry: Telemetry) -> bool:
        """Whether a token's lock of that name is satisfied at this instant, or is not held at all."""
        held = self._held.get((token, name))
        return held is None or held[1].is_satisfied(telemetry)

    def release(self, token: str) -> None:
        """Release all locks of a token."""
        for key in [key for key in self._held if key[0] == token]:
            del self._held[key]

    def broken(self, telemetry: Telemetry, now: int) -> tuple[BrokenLock, ...]:
        """The locks that have been broken for their persistence."""
        return tuple(
            BrokenLock(token, lock, f"{lock.name!r}: {watch.first_failing(telemetry)}")
            for (token, _), (lock, watch) in self._held.items()
            if watch.update(telemetry, now)
        )

    def dues(self, now: int) -> Iterable[int]:
        """The seconds at which a lock that is not satisfied now becomes broken."""
        return (due for _, watch in self._held.values() if (due := watch.due(now)) is not None)


def compatible(first: Condition, second: Condition) -> bool:
    """Whether some value of a channel satisfies both. Conditions on other channels or relative ones always are."""
    if first.channel != second.channel or first.op in RELATIVE or second.op in RELATIVE:
        return True
    if any(isinstance(c.value, str) and c.value.startswith("@") for c in (first, second)):
        return True
    for one, other in ((first, second), (second, first)):
        if one.op == "==":
            return other.holds({one.channel: one.value})
    if "!=" in (first.op, second.op):
        return True  # one value less never empties a set of many
    if first.op[0] == second.op[0]:
        return True
    low, high = (first, second) if first.op[0] == ">" else (second, first)
    least, most = float(low.value), float(high.value)
    return least < most or (least == most and (low.op, high.op) == (">=", "<="))
