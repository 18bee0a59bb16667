"""Open tokens by where they may go, so that a search looks again only where something happened.

A group holds the open tokens of one timeline (or of a class whose objects are still open). Whatever could change where
its tokens may go makes it stale: a token that comes or goes, a slot that is taken, a bound that moves; and undoing any
of these. What a search found out about the tokens of a fresh group therefore still stands.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from planner.tokens.token import Token

Rank = tuple[int, ...]
"""How urgent a token is to a search; the lowest comes first."""


class OpenGroup:
    """The open tokens that compete for the same slots. `best`: what a search found while the group was fresh.

    A `wide` group, whose tokens may go to several timelines, is never fresh.
    """

    __slots__ = ("best", "stale", "tokens", "wide")

    def __init__(self, wide: bool) -> None:
        self.tokens: dict[int, Token] = {}
        self.wide = wide
        self.stale = True
        self.best: tuple[Rank, Token] | None = None

    def touch(self) -> None:
        """Something happened: look again."""
        self.stale = True
