"""From an explanation to the decisions that it rests on: what a dependency-directed search has to undo.

An owner that an explanation names exists because of decisions: a rule instance because its token was made active (and
its guard decided), a token because a rule instance asked for it. What a decision itself rests on counts when its flaw
is exhausted: why the flaw was there, and why it had no other decisions. Where this cannot be told, every decision is
taken as a culprit: a search may then jump less far, never too far.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from planner.constraints.explanation import reasons
from planner.constraints.network import AnyVariable, Owner
from planner.database import PlanDatabase
from planner.model.classes import objects_in
from planner.search.decisions import Activate, Assign, Codesignate, Insert, Limit, Order, Reject, Settle
from planner.search.flaws import Astride, Flaw, OpenToken, Undecided
from planner.tokens.gap import Succession
from planner.tokens.instance import RuleInstance
from planner.tokens.resources import Clash
from planner.tokens.token import Token

DECISIONS = (Activate, Assign, Codesignate, Insert, Limit, Order, Reject, Settle)


class Culprits:
    """Finds culprits among the decisions in force: `depths` gives each one's place on the search's stack."""

    def __init__(self, database: PlanDatabase, depths: Mapping[int, int]) -> None:
        self.database = database
        self.depths = depths

    def of(self, owners: Iterable[Owner]) -> set[int]:
        """The places of all decisions that these owners rest on."""
        found: set[int] = set()
        seen: set[int] = set()
        pending = list(owners)
        while pending:
            owner = pending.pop()
            if owner is None or isinstance(owner, str) or id(owner) in seen:
                continue
            seen.add(id(owner))
            if isinstance(owner, DECISIONS):
                place = self.depths.get(id(owner))
                if place is None:
                    return self.everything()
                found.add(place)
            elif isinstance(owner, RuleInstance):
                pending += self._behind_instance(owner)
            elif isinstance(owner, Succession):
                pending += (*_behind_token(owner.first), *_behind_token(owner.second))
            elif isinstance(owner, Clash):
                pending += owner.causes
            else:
                return self.everything()
        return found

    def of_flaw(self, flaw: Flaw) -> set[int]:
        """The places of the decisions that left a flaw with the choice of decisions that it has now."""
        if isinstance(flaw, Undecided | Astride):
            return self.of([flaw.variable.owner, *self._reasons([flaw.variable])])
        if isinstance(flaw, OpenToken):
            return self.of(self._behind_openings(flaw.token))
        return self.everything()

    def everything(self) -> set[int]:
        """All places."""
        return set(self.depths.values())

    def _reasons(self, variables: Iterable[AnyVariable]) -> list[Owner]:
        return reasons(self.database.network, variables)

    def _behind_instance(self, instance: RuleInstance) -> list[Owner]:
        behind = [
            owner for token in (instance.token, instance.beside) if token is not None for owner in _behind_token(token)
        ]
        if instance.cause is not None:
            behind += [instance.parent, *self._reasons(instance.cause.scope)]
        return behind

    def _behind_openings(self, token: Token) -> list[Owner]:
        """Why the token may go only where it may: its own variables, what lies on its timelines, and the bounds of what
        is near. What is farther off is kept apart by the order on the timeline, hence by what placed it there."""
        variables: list[AnyVariable] = [token.start, token.end, token.duration, token.object]
        variables += token.parameters.values()
        behind: list[Owner] = [token.owner]
        if token.kind != "timeline":
            return self._behind_unordered(token, variables, behind)
        for thing in objects_in(token.object.domain):
            timeline = self.database.tokens.timelines[thing, token.predicate.attribute]
            first, last = timeline.window(token)
            for host in timeline.sequence:
                behind += _behind_token(host)
            for host in timeline.sequence[max(0, first - 1) : last + 1]:
                variables += [host.start, host.end, *host.parameters.values()]
        return behind + self._reasons(variables)

    def _behind_unordered(self, token: Token, variables: list[AnyVariable], behind: list[Owner]) -> list[Owner]:
        for host in self.database.tokens.tokens:
            if host.placed and host.predicate is token.predicate:
                behind += _behind_token(host)
                variables += [host.start, host.end, *host.parameters.values()]
        return behind + self._reasons(variables)


def _behind_token(token: Token) -> list[Owner]:
    """Why a token is there, active, and where it is."""
    return [token.owner, token.placed_by]
