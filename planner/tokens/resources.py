"""Reusable resources: each token takes a quantity at its start and gives it back at its end.

Two judgements. `Usage` prunes what no schedule allows: the parts of tokens that happen in every schedule must fit under
the capacity, and what they leave bounds the quantity of a token that shares time with them. `clash` looks at what some
schedule of the flexible plan allows: a set of tokens, pairwise unordered, that together exceed the capacity. A plan
without a clash keeps its level for every schedule that it allows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from planner.constraints.network import AnyVariable, ConstraintNetworkManager, Inconsistency, Owner, Variable
from planner.domains import Interval
from planner.errors import ModelError
from planner.model.classes import ModelObject
from planner.tokens.token import Token
from planner.trail import Trail


class Clash:
    """Tokens that together exceed a resource, as the scope of an inconsistency or the subject of a flaw."""

    __slots__ = ("owner", "profile", "queued", "scope", "tokens")

    def __init__(self, profile: ResourceProfile, tokens: Sequence[Token]) -> None:
        self.profile = profile
        self.tokens = tuple(tokens)
        self.owner: Owner = profile
        self.queued = False
        self.scope: tuple[AnyVariable, ...] = tuple(
            v for t in tokens for v in (t.start, t.end, t.parameters["quantity"])
        )

    def run(self, network: ConstraintNetworkManager) -> None:
        """Nothing to do: a clash is found, not propagated."""

    def __repr__(self) -> str:
        used = ", ".join(f"{t.name} {t.parameters['quantity'].domain!r}" for t in self.tokens)
        return f"{self.profile}: {used}"


class Usage:
    """One token's use of a resource, as a propagator: the compulsory parts of all tokens bound its quantity."""

    __slots__ = ("owner", "profile", "queued", "scope", "token")

    def __init__(self, profile: ResourceProfile, token: Token) -> None:
        self.profile = profile
        self.token = token
        self.owner: Owner = token.owner
        self.queued = False
        self.scope: tuple[AnyVariable, ...] = (token.start, token.end, token.parameters["quantity"])

    def run(self, network: ConstraintNetworkManager) -> None:
        """Narrow the quantities of all tokens that share time with compulsory parts; Inconsistency above capacity."""
        self.profile.narrow()


class ResourceProfile:
    """The transactions on one reusable resource."""

    def __init__(self, thing: ModelObject, network: ConstraintNetworkManager, trail: Trail) -> None:
        self.object = thing
        self.network = network
        self.trail = trail
        if "capacity" not in thing.members:
            raise ModelError(f"object {thing} of class {thing.cls}: a resource needs a value for its member 'capacity'")
        self.capacity = float(thing.members["capacity"])
        self.users: list[Token] = []

    def __repr__(self) -> str:
        return f"{self.object} (capacity {self.capacity:g})"

    def add(self, token: Token) -> None:
        """A token becomes a transaction here."""
        self.trail.append(self.users, token)
        self.network.watch(Usage(self, token))

    def narrow(self) -> None:
        """Bound every quantity by what the compulsory parts of the others leave."""
        parts = [(t, *self._compulsory(t), float(_quantity(t).domain.lower)) for t in self.users]
        certain = [(t, lst, eet, q) for t, lst, eet, q in parts if lst < eet and q > 0]
        for token in self.users:
            quantity = _quantity(token)
            others = [(lst, eet, q, t) for t, lst, eet, q in certain if t is not token]
            left = self._room(token, others) if others else self.capacity
            if quantity.domain.upper > left:
                if quantity.domain.lower > left:
                    raise Inconsistency(because=Clash(self, [token, *[t for *_, t in others]]))
                domain = Interval(0, left, integer=False)
                self.network.restrict(quantity, domain, Clash(self, [token, *[t for *_, t in others]]))

    def _room(self, token: Token, others: Sequence[tuple[int, int, float, Token]]) -> float:
        """The most that the token can use wherever it lies: below the peak of its own compulsory part, or below the
        lowest point of the others' profile over all the time that it may touch."""
        lst, eet = self._compulsory(token)
        temporal = self.network.temporal
        start, end = temporal.lower(token.start.timepoint), temporal.upper(token.end.timepoint)
        edges = {start, *(b for s, e, _, _ in others for b in (s, e) if start < b < end)}
        levels = {t: sum(q for s, e, q, _ in others if s <= t < e) for t in edges}
        lowest = min(levels.values())
        peak = 0.0
        if lst < eet:
            inside = {lst, *(b for s, _, _, _ in others if lst < (b := s) < eet)}
            peak = max(sum(q for s, e, q, _ in others if s <= t < e) for t in inside)
        return self.capacity - max(lowest, peak)

    def _compulsory(self, token: Token) -> tuple[int, int]:
        temporal = self.network.temporal
        return temporal.upper(token.start.timepoint), temporal.lower(token.end.timepoint)

    def clash(self) -> Clash | None:
        """A set of tokens that some schedule lets overlap and that exceeds the capacity, heaviest first; or None."""
        users = [(t, float(_quantity(t).domain.lower)) for t in self.users]
        users = sorted(((t, q) for t, q in users if q > 0), key=lambda u: (-u[1], u[0].id))
        if sum(q for _, q in users) <= self.capacity:
            return None
        found = self._clique([], 0.0, users)
        return Clash(self, found) if found else None

    def _clique(self, chosen: list[Token], level: float, rest: list[tuple[Token, float]]) -> list[Token] | None:
        if level > self.capacity:
            return chosen
        available = sum(q for _, q in rest)
        for index, (token, quantity) in enumerate(rest):
            if level + available <= self.capacity:
                return None
            available -= quantity
            beside = [(t, q) for t, q in rest[index + 1 :] if self._may_overlap(token, t)]
            found = self._clique([*chosen, token], level + quantity, beside)
            if found:
                return found
        return None

    def _may_overlap(self, a: Token, b: Token) -> bool:
        return not self._ordered(a, b) and not self._ordered(b, a)

    def _ordered(self, a: Token, b: Token) -> bool:
        temporal = self.network.temporal
        if temporal.upper(a.end.timepoint) <= temporal.lower(b.start.timepoint):
            return True
        return temporal.distance(a.end.timepoint, b.start.timepoint)[0] >= 0

    def orders(self, clash: Clash) -> list[tuple[Token, Token]]:
        """The pairs (first, second) of a clash whose ordering would help and is possible, least restricting first."""
        temporal = self.network.temporal
        pairs: list[tuple[float, int, int, Token, Token]] = []
        for a in clash.tokens:
            for b in clash.tokens:
                if a is b:
                    continue
                room = temporal.distance(a.end.timepoint, b.start.timepoint)[1]
                if room >= 0:
                    pairs.append((-min(room, math.inf), a.id, b.id, a, b))
        return [(a, b) for *_, a, b in sorted(pairs, key=lambda p: p[:3])]


def _quantity(token: Token) -> Variable:
    return token.parameters["quantity"]
