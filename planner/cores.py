"""Few of many requirements that cannot hold together: a deletion filter that goes from large pieces to single ones.

Every set that is kept has been seen to fail, so that the filter may be broken off at any time. After Chinneck and
Dravnieks, "Locating minimal infeasible constraint sets in linear programs" (1991), with pieces halved as in Junker,
"QuickXplain" (2004).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Core(Generic[T]):
    """Requirements that fail together. `minimal`: each of them has been seen to be needed for that."""

    members: tuple[T, ...]
    minimal: bool


def smallest_core(failing: Sequence[T], fails: Callable[[Sequence[T]], bool | None]) -> Core[T]:
    """A core of requirements that are known to fail together, in their order.

    `fails` says whether some of them do, None when it cannot tell; what fails must fail with more requirements too.
    """
    kept = list(failing)
    size = len(kept)
    minimal = not kept
    while size:
        size = min((size + 1) // 2, len(kept)) if size > 1 else 1
        first, minimal = 0, True
        while first < len(kept):
            rest = kept[:first] + kept[first + size :]
            verdict = fails(rest)
            if verdict:
                kept = rest
                continue
            minimal &= verdict is not None
            first += size
        if size <= 1 or not kept:
            break
    return Core(tuple(kept), minimal)
