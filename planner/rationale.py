"""Why each token of a plan is there: who stated it, which rule of which token asked for it, whose needs it meets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from planner.constraints.network import Owner
from planner.database import PlanDatabase
from planner.extraction import host_of, numbered
from planner.tokens.instance import RuleInstance
from planner.tokens.token import Role, Token, TokenState

Placing = Literal["stated", "chosen", "codesignated", "outside"]
"""stated: the problem places it; chosen: the search gave it a slot; codesignated: it is one with its host; outside: it
may lie outside of the horizon, and the plan leaves it open."""


@dataclass(frozen=True, slots=True)
class TokenRationale:
    """Why a token is there. `token` and the other identifiers are those of the plan.

    `name`: what the problem calls it, or the path of subgoals that leads to it. `because`: the statement or the rule
    that asked for it, as text. `required_by`: the token whose rule that is, None where the problem states it. `host`:
    the token that it is one with. `supports`: the tokens whose rules asked for what it is host of.
    """

    token: str
    name: str
    role: Role
    because: str
    placing: Placing
    required_by: str | None = None
    host: str | None = None
    supports: tuple[str, ...] = ()


def rationale(database: PlanDatabase) -> tuple[TokenRationale, ...]:
    """A rationale for every token of the plan that a complete database holds, in the plan's order."""
    tokens, outside = numbered(database)
    ids = {id(token): name for name, token in (*tokens, *outside)}
    supports: dict[int, dict[str, None]] = {}
    for _, token in tokens:
        if token.master is not None:
            supports.setdefault(id(host_of(token)), {})[ids[id(host_of(token.master))]] = None
    return tuple(
        TokenRationale(
            token=name,
            name=token.name,
            role=token.role,
            because=_label(token.owner),
            placing=_placing(token),
            required_by=ids.get(id(token.master)) if token.master is not None else None,
            host=ids[id(host_of(token))] if token.host is not None else None,
            supports=tuple(supports.get(id(token), ())),
        )
        for name, token in (*tokens, *outside)
    )


def _label(owner: Owner) -> str:
    return str(owner.label) if isinstance(owner, RuleInstance) else str(owner)


def _placing(token: Token) -> Placing:
    if token.state is TokenState.INACTIVE:
        return "outside"
    if token.host is not None:
        return "codesignated"
    return "stated" if token.is_given or isinstance(token.placed_by, RuleInstance) else "chosen"
