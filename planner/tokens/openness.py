"""The tokens that are not on a timeline yet, kept so that a search finds the most urgent without looking at each.

Those that the problem says are active stand in order of creation. The others stand in groups by where they may go.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from operator import attrgetter

from planner.constraints.network import ConstraintNetworkManager
from planner.model.classes import ModelObject
from planner.tokens.groups import OpenGroup
from planner.tokens.token import Token, TokenState
from planner.trail import Trail

Place = tuple[ModelObject | str, str]
"""Where a token may go: an object, or a class while several are possible, and the attribute."""


class OpenTokens:
    """The inactive tokens of a plan. Every change is trailed.

    A token comes with `add`, and `close` is told when it is inactive no more. `groups`: those that a search may put in
    any order, as far as it has looked at them.
    """

    def __init__(self, network: ConstraintNetworkManager, trail: Trail) -> None:
        self.groups: dict[Place, OpenGroup] = {}
        self._network = network
        self._trail = trail
        self._unseen: dict[int, Token] = {}
        # Given tokens by number, those that are open no more included: only before `_first` there are no others.
        self._given: list[Token] = []
        self._first = 0

    def add(self, token: Token) -> None:
        """A token that is inactive now."""
        if not token.is_given:
            self._trail.add(self._unseen, token.id, token)
            return
        place = bisect_left(self._given, token.id, key=attrgetter("id"))
        if place < self._first:
            self._trail.assign(self, "_first", place)
        if place == len(self._given) or self._given[place] is not token:
            self._given.insert(place, token)
            self._trail.call(self._given.pop, place)

    def close(self, token: Token) -> None:
        """A token is inactive no more; of a given one, its state says so."""
        if token.is_given:
            return
        home = self._unseen if token.group is None else token.group.tokens
        del home[token.id]
        self._trail.call(home.__setitem__, token.id, token)
        if token.group is not None:
            self.touch(token.group)

    def forget(self, token: Token) -> None:
        """A token is in the plan no more."""
        if not token.is_given:
            self.close(token)
            return
        place = self._given.index(token)
        del self._given[place]
        self._trail.call(self._given.insert, place, token)
        if place < self._first:
            self._trail.assign(self, "_first", self._first - 1)

    def put_first(self, token: Token) -> None:
        """The problem says that a token is active: it is a given one from now on."""
        inactive = token.state is TokenState.INACTIVE
        if inactive:
            self.close(token)
        self._trail.assign(token, "must_host", True)
        if inactive:
            self.add(token)

    def given(self) -> Iterator[Token]:
        """The inactive tokens that the problem says are active, in order of creation."""
        given, first = self._given, self._first
        while first < len(given) and given[first].state is not TokenState.INACTIVE:
            first += 1
        if first > self._first:
            self._trail.assign(self, "_first", first)
        for place in range(first, len(given)):
            if given[place].state is TokenState.INACTIVE:
                yield given[place]

    def look(self) -> Iterator[OpenGroup]:
        """The other inactive tokens by where they may go, those that came since the last look included."""
        for token in [self._unseen[number] for number in sorted(self._unseen)]:
            self._join_group(token)
        return iter(self.groups.values())

    def all(self) -> dict[int, Token]:
        """All inactive tokens by number, in order of creation."""
        found = [t for t in self._given if t.state is TokenState.INACTIVE]
        found += self._unseen.values()
        found += (token for group in self.groups.values() for token in group.tokens.values())
        return {token.id: token for token in sorted(found, key=attrgetter("id"))}

    def moved(self, place: Place) -> None:
        """Something moved where tokens may go: what a search found out about them stands no more."""
        group = self.groups.get(place)
        if group is not None:
            self.touch(group)

    def touch(self, group: OpenGroup) -> None:
        """Look at a group again, now and when this is undone."""
        group.touch()
        self._trail.call(group.touch)

    def _join_group(self, token: Token) -> None:
        wide = token.kind != "timeline" or not token.object.domain.is_singleton
        place = token.predicate.cls if wide else token.thing
        group = self.groups.setdefault((place, token.predicate.attribute), OpenGroup(wide))
        del self._unseen[token.id]
        self._trail.call(self._unseen.__setitem__, token.id, token)
        self._trail.add(group.tokens, token.id, token)
        self._trail.assign(token, "group", group)
        self.touch(group)
        if not wide:
            self._network.hear(token.start, group)
            self._network.hear(token.end, group)
