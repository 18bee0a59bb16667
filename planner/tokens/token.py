"""Tokens: restrictions on the value of an attribute over an interval (paper, section 3)."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import TYPE_CHECKING, Literal

from planner.constraints.network import AnyVariable, ConstraintNetworkManager, DurationVariable, Owner, Variable
from planner.model.classes import ModelObject
from planner.tokens.form import Form
from planner.tokens.groups import OpenGroup, Rank
from planner.tokens.path import TokenPath

if TYPE_CHECKING:
    from planner.tokens.limits import Allowed

# goal: must be achieved; rejectable: may be left out; fact: is true and seeks no support; state: holds at the start of
# the horizon, its rules apply; subgoal: some token's configuration constraint asks for it.
Role = Literal["goal", "rejectable", "fact", "state", "subgoal"]
GIVEN: tuple[Role, ...] = ("fact", "state")
"""The roles of tokens that the problem says are true: no plan has to bring them about."""


class TokenState(IntEnum):
    """Inactive: not on a timeline; active: host of a slot; merged: codesignated with a host; rejected: left out."""

    INACTIVE = 0
    ACTIVE = 1
    MERGED = 2
    REJECTED = 3


class Token:
    """A value token: a predicate name, variables for start, end and duration, and one for each parameter. Or a
    constraint token, without parameters, whose `allowed` are the values to which the attribute keeps.

    `path` is its name: that of the statement, then those of the subgoals that lead here. `owner`: who asked for the
    token; `placed_by`: the decision that made it active, or None; `master`: the token whose configuration constraint
    asked for it, or None; `depth`: how many of them up. `must_host`: the problem says that it is active, so it gets a
    slot of its own and is codesignated with nothing. `solitary`: codesignated with nothing, and no more than that.
    """

    __slots__ = (
        "allowed",
        "depth",
        "duration",
        "end",
        "group",
        "host",
        "id",
        "kind",
        "master",
        "must_host",
        "object",
        "owner",
        "parameters",
        "path",
        "placed_by",
        "predicate",
        "rank",
        "rank_key",
        "role",
        "rules",
        "solitary",
        "start",
        "state",
    )

    def __init__(
        self,
        network: ConstraintNetworkManager,
        number: int,
        path: TokenPath,
        form: Form,
        role: Role,
        owner: Owner,
        master: Token | None,
    ) -> None:
        self.id = number
        self.path = path
        self.predicate = form.predicate
        self.kind = form.kind
        self.start = network.timepoint("start", -math.inf, math.inf, owner, self)
        self.end = network.timepoint("end", -math.inf, math.inf, owner, self)
        self.duration = DurationVariable("duration", self.start, self.end, form.duration, owner, self)
        self.duration.by_nature = form.predicate.contingent
        self.object = Variable("object", form.objects, owner, self)
        self.parameters = {name: Variable(name, domain, owner, self) for name, domain in form.parameters}
        self.role: Role = role
        self.owner = owner
        self.master = master
        self.depth: int = master.depth + 1 if master is not None else 0
        self.state = TokenState.INACTIVE
        self.host: Token | None = None
        self.placed_by: Owner | None = None
        self.must_host = False
        self.solitary = form.predicate.solitary
        self.allowed: tuple[Allowed, ...] = ()
        self.group: OpenGroup | None = None
        # The instances of the rules that apply to it.
        self.rules: list[Owner] = []
        # What a search found out about the token, and the bounds for which it did: a cache, never undone.
        self.rank: Rank = ()
        self.rank_key: tuple[int, ...] = ()

    @property
    def name(self) -> str:
        """The path for people: the middle of a long one is left out."""
        return str(self.path)

    @property
    def thing(self) -> ModelObject:
        """The object that the token belongs to, once it is decided."""
        found = self.object.domain.value
        assert isinstance(found, ModelObject)
        return found

    @property
    def is_given(self) -> bool:
        """Whether the problem says that the token is active: its slot is sought before anything else."""
        return self.must_host or self.role in GIVEN

    @property
    def placed(self) -> bool:
        """Whether a decision made the token active."""
        return self.placed_by is not None

    @property
    def contingent(self) -> bool:
        """Whether nature decides the duration."""
        return self.duration.by_nature

    def variable(self, name: str) -> AnyVariable | None:
        """The variable of a parameter or of one of start, end, duration, object; None when there is none."""
        if name in self.parameters:
            return self.parameters[name]
        if name in ("start", "end", "duration", "object"):
            found: AnyVariable = getattr(self, name)
            return found
        return None

    def may_be_outside(self, horizon: tuple[int, int]) -> bool:
        """Whether the token can still lie wholly before or wholly after the horizon."""
        temporal = self.start.temporal
        return temporal.lower(self.end.timepoint) <= horizon[0] or temporal.upper(self.start.timepoint) >= horizon[1]

    def __repr__(self) -> str:
        return f"{self.name}:{self.predicate.full_name}"
