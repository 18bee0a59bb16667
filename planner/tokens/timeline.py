"""Timelines: the tokens of one attribute of one object in total order (paper, section 3).

The sequence of hosts is the only index. At the temporal network's fixpoint the latest start and the earliest end rise
along it, so the slots and the tokens that a newcomer may meet are a window found by bisection.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator

from planner.model.classes import ModelObject
from planner.temporal.network import TemporalNetworkManager
from planner.tokens.token import Token


class Timeline:
    """The development of one attribute. `sequence`: the hosts of its filled slots in order."""

    __slots__ = ("attribute", "object", "sequence", "temporal")

    def __init__(self, object_: ModelObject, attribute: str, temporal: TemporalNetworkManager) -> None:
        self.object = object_
        self.attribute = attribute
        self.temporal = temporal
        self.sequence: list[Token] = []

    def __repr__(self) -> str:
        return f"{self.object}.{self.attribute}"

    def window(self, token: Token) -> tuple[int, int]:
        """The part [first, last) of the sequence whose tokens may share time with the token."""
        lower, upper = self.temporal.lower, self.temporal.upper
        first = bisect_left(
            self.sequence,
            lower(token.start.timepoint) + 1,
            key=lambda t: upper(t.end.timepoint),
        )
        last = bisect_right(
            self.sequence,
            upper(token.end.timepoint) - 1,
            key=lambda t: lower(t.start.timepoint),
        )
        return first, max(first, last)

    def hosts(self, token: Token) -> Iterator[Token]:
        """The tokens of the timeline that the token could be codesignated with, as far as bounds can tell."""
        first, last = self.window(token)
        for candidate in self.sequence[first:last]:
            if may_codesignate(token, candidate):
                yield candidate

    def slots(self, token: Token) -> Iterator[int]:
        """The positions at which the token could be inserted, as far as bounds can tell."""
        lower, upper, sequence = self.temporal.lower, self.temporal.upper, self.sequence
        start_lower, end_upper = lower(token.start.timepoint), upper(token.end.timepoint)
        start_upper, end_lower = upper(token.start.timepoint), lower(token.end.timepoint)
        shortest = token.duration.stated.lower
        # The first position whose predecessor can end before the latest start, and on while the successor leaves room.
        first, last = self.window(token)
        for position in range(first, last + 1):
            earliest = start_lower
            if position > 0:
                before = lower(sequence[position - 1].end.timepoint)
                if before > start_upper:
                    return
                earliest = max(earliest, before)
            latest = end_upper
            if position < len(sequence):
                after = upper(sequence[position].start.timepoint)
                if after < end_lower:
                    continue
                latest = min(latest, after)
            if earliest + shortest <= latest:
                yield position


def may_codesignate(token: Token, host: Token) -> bool:
    """Whether two tokens could be one, as far as the domains of their variables can tell."""
    if token.predicate is not host.predicate:
        return False
    lower, upper = host.start.temporal.lower, host.start.temporal.upper
    if (
        lower(token.start.timepoint) > upper(host.start.timepoint)
        or lower(host.start.timepoint) > upper(token.start.timepoint)
        or lower(token.end.timepoint) > upper(host.end.timepoint)
        or lower(host.end.timepoint) > upper(token.end.timepoint)
    ):
        return False
    for name, variable in token.parameters.items():
        if variable.domain.intersect(host.parameters[name].domain).is_empty:
            return False
    return not token.object.domain.intersect(host.object.domain).is_empty
