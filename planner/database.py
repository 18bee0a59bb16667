"""PlanDatabase: one trail and the managers on it; the search engine's whole view of a partial plan."""

from __future__ import annotations

import math

from planner.constraints.network import ConstraintNetworkManager
from planner.domains import Interval
from planner.errors import ModelError, ProblemError
from planner.model.manager import ModelManager
from planner.problem import ConstraintPattern, TokenPattern
from planner.temporal.network import TemporalNetworkManager
from planner.tokens.limits import create as create_limit
from planner.tokens.manager import TokenNetworkManager
from planner.tokens.path import TokenPath
from planner.tokens.statements import allowed_values, apply_pattern
from planner.tokens.token import Role, Token
from planner.trail import Trail


class PlanDatabase:
    """A partial plan for a model over a horizon [start, end] in ticks."""

    def __init__(self, model: ModelManager, horizon: tuple[int, int]) -> None:
        self.model = model
        self.horizon = horizon
        self.trail = Trail()
        self.temporal = TemporalNetworkManager()
        self.trail.join(_Kernel(self.temporal))
        self.network = ConstraintNetworkManager(self.trail, self.temporal)
        self.tokens = TokenNetworkManager(model, self.network, self.trail)

    def state(self, pattern: TokenPattern, name: str, role: Role) -> Token:
        """Add a token that the problem states; the caller propagates.

        A goal lies inside the horizon. A token of the initial state or a fact without a start of its own begins
        with the horizon. ProblemError for a pattern that means nothing in the model.
        """
        try:
            declared = self.model.predicate_named(pattern.predicate)
        except ModelError as error:
            raise ProblemError(f"{name}: {error}") from error
        token = self.tokens.create((declared.cls, declared.name), TokenPath.of(name), role, name)
        apply_pattern(self.tokens, token, pattern)
        start, end = self.horizon
        if role in ("goal", "rejectable"):
            self.network.restrict(token.start, Interval(start, math.inf), "horizon")
            self.network.restrict(token.end, Interval(-math.inf, end), "horizon")
        elif pattern.start == (None, None):
            self.network.restrict(token.start, Interval(start, start), "horizon")
        return token

    def confine(self, pattern: ConstraintPattern, name: str) -> Token:
        """Add a constraint token that the problem states; the caller propagates.

        ProblemError for a pattern that means nothing in the model.
        """
        tokens, placed = self.tokens, pattern.within(self.horizon)
        attribute, allowed = allowed_values(tokens, pattern, name)
        token = create_limit(tokens, attribute, allowed, TokenPath.of(name), "state", name)
        apply_pattern(tokens, token, TokenPattern(name, placed.object, {}, placed.start, placed.end, placed.duration))
        return token


class _Kernel:
    """The temporal network as a participant of the trail."""

    def __init__(self, temporal: TemporalNetworkManager) -> None:
        self.mark = temporal.mark
        self.undo_to = temporal.undo_to
