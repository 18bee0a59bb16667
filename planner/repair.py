"""From what was found wrong with an extracted plan back to the database: which owners a search has to undo.

A judge outside of the planner, such as the check of dynamic controllability, sees a plan: hosts and constraints. What
it names rests on constraints of the database, and these on decisions. Every owner behind what is named is given: a
search that takes them for the explanation of a dead end goes back to the newest of them, and misses no plan.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from typing import Protocol

from planner.constraints.explanation import reasons
from planner.constraints.network import Owner
from planner.database import PlanDatabase
from planner.extraction import host_of, numbered
from planner.plan import ORIGIN, PlanConstraint
from planner.search.endless import ARBITRARY
from planner.search.outcome import Refusal
from planner.tokens.token import Token


class Complaint(Protocol):
    """What is wrong with a plan: no plan that has these tokens with these constraints between them is good.

    `text`: for people. `tokens`: identifiers of hosts, whose times and durations count. `constraints`: of the plan.
    """

    @property
    def text(self) -> str:
        """What is wrong."""
        ...

    @property
    def tokens(self) -> Sequence[str]:
        """Hosts."""
        ...

    @property
    def constraints(self) -> Sequence[PlanConstraint]:
        """Of the plan."""
        ...


def refusal_of(database: PlanDatabase, complaint: Complaint) -> Refusal:
    """A complaint about the database's plan as a search takes it."""
    return Refusal(complaint.text, owners_behind(database, complaint))


def owners_behind(database: PlanDatabase, complaint: Complaint) -> tuple[Owner, ...] | None:
    """The owners of all that a complaint about the database's plan names; None when it names nothing,
    or when an arbitrary value has a part in it."""
    by_id = dict(numbered(database)[0])
    named = [by_id[name] for name in complaint.tokens]
    if not named and not complaint.constraints:
        return None
    variables = [v for token in named for v in (token.start, token.end, token.duration)]
    owners: list[Owner] = [owner for token in named for owner in (token.owner, token.placed_by)]
    owners += reasons(database.network, variables)
    pairs = {frozenset((c.from_, c.to)) for c in complaint.constraints}
    pairs |= {frozenset((f"{name}.start", f"{name}.end")) for name in complaint.tokens}
    owners += _posted_between(database, by_id, pairs)
    return None if ARBITRARY in owners else tuple(owners)


def _posted_between(database: PlanDatabase, named: Mapping[str, Token], pairs: Set[frozenset[str]]) -> Iterator[Owner]:
    """Who posted the temporal constraints between these ends of hosts, and who made tokens one with those hosts."""
    ends = {0: ORIGIN}
    token_of: dict[int, Token] = {}
    name_of = {id(token): name for name, token in named.items()}
    for token in named.values():
        host = name_of[id(host_of(token))]
        for side, variable in (("start", token.start), ("end", token.end)):
            ends[variable.timepoint] = f"{host}.{side}"
            token_of[variable.timepoint] = token
    posted = [
        (from_, to, database.network.stakeholder_named(number))
        for _, from_, to, _, _, number in database.temporal.constraints()
    ]
    merged_by: dict[int, list[Owner]] = {}
    for from_, to, owner in posted:
        one, two = token_of.get(from_), token_of.get(to)
        if one is not None and two is not None and one.host is two:
            merged_by.setdefault(id(one), []).append(owner)
    for from_, to, owner in posted:
        if from_ in ends and to in ends and frozenset((ends[from_], ends[to])) in pairs:
            yield owner
            for point in (from_, to):
                token_or_none = token_of.get(point)
                while token_or_none is not None:
                    yield from merged_by.get(id(token_or_none), ())
                    token_or_none = token_or_none.host
