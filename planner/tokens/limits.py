"""Constraint tokens (paper, section 3): an attribute keeps to a set of values over an interval, changing as it may."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from planner.constraints.network import AnyVariable, Owner
from planner.domains import Domain, Interval
from planner.model.classes import Predicate
from planner.tokens.form import Form
from planner.tokens.path import TokenPath
from planner.tokens.token import Role, Token

if TYPE_CHECKING:
    from planner.tokens.manager import TokenNetworkManager


@dataclass(frozen=True, slots=True)
class Allowed:
    """A value that a constraint token allows: a predicate, and what some of its parameters equal, or are within."""

    predicate: Predicate
    limits: Mapping[str, AnyVariable | Domain]


def create(
    manager: TokenNetworkManager,
    attribute: tuple[str, str],
    allowed: Sequence[Allowed],
    path: TokenPath,
    role: Role,
    owner: Owner,
    master: Token | None = None,
) -> Token:
    """A new open constraint token on an attribute (class, name) with these values."""
    cls, of = attribute
    name = f"{{{' | '.join(value.predicate.name for value in allowed)}}}"
    predicate = Predicate(cls, name, of, duration=(0, math.inf))
    form = Form(predicate, "constraint", manager.model.objects_of(cls), Interval(0, math.inf), (), name)
    token = manager.enter(form, path, role, owner, master)
    token.allowed = tuple(allowed)
    manager.network.distance(token.start, token.end, 0, math.inf, owner)
    return token
