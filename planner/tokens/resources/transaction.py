"""Transactions: what tokens take from a resource and give to it, as events at timepoints."""

from __future__ import annotations

from typing import Literal

from planner.constraints.network import AnyVariable, Owner, Propagator, TimeVariable
from planner.tokens.token import Token

Flow = Literal["uses", "produces", "consumes"]


class Transaction:
    """One token's use, production or consumption of a resource, or that of a `uses` constraint.

    `where`: the variable that says which resource it is on. `token`: the token that it is, unless a constraint asks for
    it. `watch`: what has the resource prune when it changes. `shortest`: the least number of ticks that a use is known
    to last, whatever its bounds say.
    """

    __slots__ = ("end", "flow", "name", "owner", "quantity", "shortest", "start", "token", "watch", "where")

    def __init__(
        self,
        name: str,
        flow: Flow,
        quantity: AnyVariable,
        times: tuple[TimeVariable, TimeVariable],
        where: AnyVariable,
        owner: Owner,
        token: Token | None = None,
        shortest: int = 0,
    ) -> None:
        self.name = name
        self.flow = flow
        self.quantity = quantity
        self.start, self.end = times
        self.where = where
        self.owner = owner
        self.token = token
        self.watch: Propagator | None = None
        self.shortest = shortest

    @property
    def scope(self) -> tuple[AnyVariable, ...]:
        """The variables that it rests on."""
        ends = (self.start,) if self.start is self.end else (self.start, self.end)
        return (*ends, self.quantity, self.where)

    @property
    def causes(self) -> tuple[Owner, ...]:
        """Who asked for it, and the decision that made it one."""
        return (self.owner,) if self.token is None else (self.owner, self.token.placed_by)

    @property
    def least(self) -> float:
        """The least quantity."""
        return float(self.quantity.domain.lower)

    @property
    def most(self) -> float:
        """The greatest quantity."""
        return float(self.quantity.domain.upper)

    def __repr__(self) -> str:
        least, most = self.least, self.most
        return f"{self.name} {self.flow} {least:g}" + (f" to {most:g}" if most > least else "")


class Event:
    """A step of a level: a transaction's `sign` times its quantity, `offset` ticks after a timepoint.

    `paired`: the event is one of the two ends of a use, and what is taken is given back.
    """

    __slots__ = ("offset", "paired", "point", "sign", "time", "transaction")

    def __init__(self, time: TimeVariable, offset: int, sign: int, transaction: Transaction, paired: bool) -> None:
        self.time = time
        self.point = time.timepoint
        self.offset = offset
        self.sign = sign
        self.transaction = transaction
        self.paired = paired

    @property
    def earliest(self) -> int:
        """The earliest tick at which the step may come."""
        return self.time.temporal.lower(self.point) + self.offset

    @property
    def latest(self) -> int:
        """The latest tick at which the step may come."""
        return self.time.temporal.upper(self.point) + self.offset

    def step(self, low: bool) -> float:
        """The step in the schedule that makes the level lowest (or highest), among the quantities left."""
        greatest = low if self.paired or self.sign < 0 else not low
        return self.sign * (self.transaction.most if greatest else self.transaction.least)
