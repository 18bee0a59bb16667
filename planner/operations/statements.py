"""What an operation says, in terms of names, and the handle by which it is known."""

from __future__ import annotations

from dataclasses import dataclass

from planner.domains import Domain
from planner.tokens.instance import Extent
from planner.tokens.path import TokenPath


@dataclass(frozen=True, slots=True)
class Insertion:
    """A token becomes active on an object. `attribute`: the one on whose timeline it gets a slot, or "" when it needs
    none."""

    token: TokenPath
    object: str
    attribute: str

    def __repr__(self) -> str:
        return f"insert {self.token} on {self.object}" + (f".{self.attribute}" if self.attribute else "")


@dataclass(frozen=True, slots=True)
class Codesignation:
    """A token is one with a host that has a slot."""

    token: TokenPath
    host: TokenPath

    def __repr__(self) -> str:
        return f"codesignate {self.token} with {self.host}"


@dataclass(frozen=True, slots=True)
class Restriction:
    """A variable is within a domain. `token`: the path of the token whose variable it is; None: a rule's own variable,
    which `variable` names in full."""

    token: TokenPath | None
    variable: str
    domain: Domain

    def __repr__(self) -> str:
        where = f"{self.token}." if self.token is not None else ""
        return f"restrict {where}{self.variable} to {self.domain!r}"


Statement = Insertion | Codesignation | Restriction


class Operation:
    """An operation that was issued and not undone: the owner of what it posts, so that explanations can name it.

    `number`: its place in the order of issue. `depth`: the level of the trail that it opened, None while dormant.
    `reason`: why it is dormant although its tokens are there, otherwise empty. `extent`: what it posted itself.
    """

    __slots__ = ("depth", "extent", "number", "reason", "statement")

    def __init__(self, number: int, statement: Statement) -> None:
        self.number = number
        self.statement = statement
        self.depth: int | None = None
        self.reason: tuple[str, ...] = ()
        self.extent: Extent | None = None

    def __repr__(self) -> str:
        return repr(self.statement)
