"""Timelines: the tokens of one attribute of one object in total order (paper, section 3).

The sequence of hosts is the only index. At the temporal network's fixpoint the latest start and the earliest end rise
along it, so the slots and the tokens that a newcomer may meet are a window found by bisection.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator

from planner.model.classes import ModelObject
from planner.temporal.network import EARLIEST, LATEST, TemporalNetworkManager
from planner.tokens.token import Token

NEAR = 256
"""So many timepoints around an open token are asked how far from it they must be."""
MANY = 128
"""With more tokens than this where it may go, a token is not looked at so closely."""


class Timeline:
    """The development of one attribute. `sequence`: the hosts of its filled slots in order. `limits`: the constraint
    tokens that lie over it."""

    __slots__ = ("attribute", "limits", "object", "sequence", "temporal")

    def __init__(self, object_: ModelObject, attribute: str, temporal: TemporalNetworkManager) -> None:
        self.object = object_
        self.attribute = attribute
        self.temporal = temporal
        self.sequence: list[Token] = []
        self.limits: list[Token] = []

    def __repr__(self) -> str:
        return f"{self.object}.{self.attribute}"

    def window(self, token: Token) -> tuple[int, int]:
        """The part [first, last) of the sequence whose tokens may touch the token."""
        bounds, sequence = self.temporal.bounds, self.sequence
        earliest = -bounds[LATEST * token.start.timepoint + EARLIEST]
        latest = bounds[LATEST * token.end.timepoint]
        first = bisect_left(sequence, earliest, key=lambda t: bounds[LATEST * t.end.timepoint])
        last = bisect_right(sequence, latest, first, key=lambda t: -bounds[LATEST * t.start.timepoint + EARLIEST])
        return first, last

    def openings(self, token: Token) -> tuple[list[Token], list[int]]:
        """All of its `hosts` and `slots`."""
        first, last = self.window(token)
        hosts = []
        if may_seek_hosts(token):
            hosts = [host for host in self.sequence[first:last] if may_codesignate(token, host)]
        return hosts, list(self._slots(token, first, last))

    def fitting(self, token: Token) -> tuple[Iterable[Token], Iterable[int]]:
        """Those of its `openings` that constraints with what is near the token leave it too: a subgoal that meets its
        master, for example, has but the slot beside it. Where many tokens lie, all of them, found when asked for."""
        first, last = self.window(token)
        if last - first > MANY:
            return self.hosts(token), self.slots(token)
        hosts, slots = self.openings(token)
        if len(hosts) + len(slots) < 2:
            return hosts, slots
        temporal, sequence = self.temporal, self.sequence
        sooner = temporal.reach(token.start.timepoint, False, NEAR)
        later = temporal.reach(token.end.timepoint, True, NEAR)
        after = [p == 0 or sooner(sequence[p - 1].end.timepoint) >= 0 for p in slots]
        before = [p == len(sequence) or later(sequence[p].start.timepoint) >= 0 for p in slots]
        return (
            [host for host in hosts if sooner(host.start.timepoint) >= 0 and later(host.end.timepoint) >= 0],
            [p for p, *both in zip(slots, after, before, strict=True) if all(both)],
        )

    def hosts(self, token: Token) -> Iterator[Token]:
        """The hosts that the token could be codesignated with, as far as bounds and domains can tell, in order."""
        if not may_seek_hosts(token):
            return
        first, last = self.window(token)
        for position in range(first, last):
            if may_codesignate(token, self.sequence[position]):
                yield self.sequence[position]

    def slots(self, token: Token) -> Iterator[int]:
        """The empty slots that the token could take as far as bounds can tell, in order.

        Each is the position of the token which the newcomer would come before.
        """
        return self._slots(token, *self.window(token))

    def _slots(self, token: Token, first: int, last: int) -> Iterator[int]:
        bounds, sequence = self.temporal.bounds, self.sequence
        start, end = LATEST * token.start.timepoint, LATEST * token.end.timepoint
        start_lower, start_upper = -bounds[start + EARLIEST], bounds[start]
        end_lower, end_upper = -bounds[end + EARLIEST], bounds[end]
        shortest = token.duration.stated.lower
        for position in range(first, last + 1):
            earliest, latest = start_lower, end_upper
            if position > 0:
                before = -bounds[LATEST * sequence[position - 1].end.timepoint + EARLIEST]
                if before > start_upper:
                    break
                earliest = max(earliest, before)
            if position < len(sequence):
                after = bounds[LATEST * sequence[position].start.timepoint]
                if after < end_lower:
                    continue
                latest = min(latest, after)
            if earliest + shortest <= latest:
                yield position


def may_seek_hosts(token: Token) -> bool:
    """Whether a token may be one with another at all."""
    return not (token.must_host or token.solitary)


def may_codesignate(token: Token, host: Token) -> bool:
    """Whether two tokens could be one, as far as the domains of their variables can tell."""
    if token.predicate is not host.predicate or not may_seek_hosts(token):
        return False
    bounds = host.start.temporal.bounds
    for mine, other in ((token.start, host.start), (token.end, host.end)):
        a, b = LATEST * mine.timepoint, LATEST * other.timepoint
        if -bounds[a + EARLIEST] > bounds[b] or -bounds[b + EARLIEST] > bounds[a]:
            return False
    for name, variable in token.parameters.items():
        if variable.domain.intersect(host.parameters[name].domain).is_empty:
            return False
    return not token.object.domain.intersect(host.object.domain).is_empty
