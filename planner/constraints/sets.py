"""Constraints that read a domain as a set: allDiff, subsetOf, eqUnion, memberImply, and condEq, condAllDiff.

Where an argument is called a set, its whole domain is meant, as a constant: it is read and never narrowed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from planner.constraints.equality import eq, without
from planner.constraints.logic import reified
from planner.constraints.matching import supported_values
from planner.constraints.numeric import clip, same
from planner.constraints.procedure import Narrowed
from planner.domains import Domain, Interval, Values

# Integer intervals up to this size join the matching of allDiff; larger ones only lose ends that are taken.
LISTED_SIZE = 256


def all_diff(domains: Sequence[Domain]) -> Narrowed:
    """xi != xj for all i < j.

    Generalised arc consistency over enumerated domains and integer intervals of up to 256 values (hulls of it), by
    matching; other intervals lose the ends that assigned variables take.
    """
    result = list(domains)
    listed = [i for i, d in enumerate(domains) if not d.is_open and d.size <= LISTED_SIZE]
    kept = supported_values([list(domains[i].values()) for i in listed])
    if kept is None:
        return None
    for i, values in zip(listed, kept, strict=True):
        domain = result[i]
        if isinstance(domain, Values):
            result[i] = domain.keep(values)
        elif domain.integer:
            result[i] = domain.bounded(min(values), max(values))
    return _drop_taken(result)


def _drop_taken(result: list[Domain]) -> Narrowed:
    """Remove the value of each assigned variable from all the others, until nothing changes."""
    waiting = [i for i, d in enumerate(result) if not d.is_open and d.is_singleton]
    while waiting:
        place = waiting.pop()
        value = result[place].value
        for i, domain in enumerate(result):
            if i == place:
                continue
            kept = without(domain, value)
            if kept is None:
                return None
            if kept is not domain:
                result[i] = kept
                # An end that moved may have met another taken value: look at all of them again.
                waiting = [k for k, d in enumerate(result) if not d.is_open and d.is_singleton]
    return result


def subset_of(domains: Sequence[Domain]) -> Narrowed:
    """x is in S, arguments (x, S): S is a set."""
    x, allowed = domains
    if x.is_open or allowed.is_open:
        return domains
    kept = _within(x, allowed)
    return domains if kept is x else None if kept is None else (kept, allowed)


def _within(x: Domain, allowed: Domain) -> Domain | None:
    """The values of x that the set has."""
    narrowed = eq((x, allowed))
    return None if narrowed is None else narrowed[0]


def eq_union(domains: Sequence[Domain]) -> Narrowed:
    """A = B1 or ... or A = Bn as sets: A loses what no B has, each B what A lacks; arguments (A, B1, ..., Bn).

    With every argument assigned: all equal. Weaker than equality before: {1, 2} = {1} + {2} holds.
    """
    union, *parts = domains
    if union.is_open or any(d.is_open for d in parts):
        return domains
    kept = _among(union, parts)
    if kept is None:
        return None
    result = [kept]
    for part in parts:
        narrowed = _within(part, kept)
        if narrowed is None:
            return None
        result.append(narrowed)
    return result


def _hull_of(domain: Domain, pieces: Sequence[Domain]) -> Domain | None:
    if isinstance(domain, Values):
        return domain.keep(v for piece in pieces for v in piece.values())
    return clip(domain, min(p.lower for p in pieces), max(p.upper for p in pieces))


def member_imply(domains: Sequence[Domain]) -> Narrowed:
    """a in B implies c in D, arguments (a, B, c, D): B and D are sets."""
    a, condition, c, consequence = domains
    if condition.is_open or consequence.is_open:
        return domains
    if not c.is_open and _within(c, consequence) is None:
        kept = a if a.is_open else _outside(a, condition)
        return None if kept is None else (kept, condition, c, consequence)
    if a.is_open or c.is_open or not _all_within(a, condition):
        return domains
    narrowed = _within(c, consequence)
    return None if narrowed is None else (a, condition, narrowed, consequence)


def _all_within(a: Domain, allowed: Domain) -> bool:
    kept = _within(a, allowed)
    if kept is None or isinstance(a, Values):
        return kept is a
    if isinstance(allowed, Interval):
        # A real is whole only when it is assigned.
        return kept is a and (a.integer or not allowed.integer or a.is_singleton)
    return a.size <= allowed.size and all(v in allowed for v in a.values())


def _outside(a: Domain, banned: Domain) -> Domain | None:
    """The values of a that the set lacks; an interval loses ends only."""
    if isinstance(a, Values):
        kept = a.keep(v for v in a.values() if _within(a.keep((v,)), banned) is None)
        return kept if kept.bits else None
    if _all_within(a, banned):
        return None
    if isinstance(banned, Values):
        return _peel(a, banned)
    if banned.integer and not a.integer:
        return a
    if a.integer:
        low = math.floor(banned.upper) + 1 if banned.lower <= a.lower <= banned.upper else a.lower
        high = math.ceil(banned.lower) - 1 if banned.lower <= a.upper <= banned.upper else a.upper
        return clip(a, low, high)
    low = banned.upper if banned.lower <= a.lower <= banned.upper else a.lower
    high = banned.lower if banned.lower <= a.upper <= banned.upper else a.upper
    return clip(a, low, high)


def _peel(a: Interval, banned: Values) -> Interval | None:
    """The interval less the banned values at its ends."""
    if not a.integer:
        return a
    while not a.is_empty and (a.lower in banned or a.upper in banned):
        a = a.without(a.lower if a.lower in banned else a.upper)
    return None if a.is_empty else a


def not_all_equal(domains: Sequence[Domain]) -> Narrowed:
    """Some two of x1, ..., xn differ."""
    loose = [i for i, d in enumerate(domains) if d.is_open or not d.is_singleton]
    if len(loose) > 1:
        return domains
    fixed = [d for i, d in enumerate(domains) if i not in loose]
    if any(not same(d.value, fixed[0].value) for d in fixed[1:]):
        return domains
    if not loose:
        return None
    kept = without(domains[loose[0]], fixed[0].value)
    return None if kept is None else [kept if i == loose[0] else d for i, d in enumerate(domains)]


def _can_be_equal(x: Domain, y: Domain) -> bool:
    return x.is_open or y.is_open or eq((x, y)) is not None


def _pairs(count: int) -> Iterator[tuple[int, int]]:
    return ((i, j) for i in range(count) for j in range(i + 1, count))


def some_equal(domains: Sequence[Domain]) -> Narrowed:
    """Some two of x1, ..., xn are equal."""
    possible = [(i, j) for i, j in _pairs(len(domains)) if _can_be_equal(domains[i], domains[j])]
    if not possible:
        return None
    common = set(possible[0]).intersection(*possible)
    if not common:
        return domains
    result = list(domains)
    # A variable that is in every pair that can be equal: its value is one of its partners'.
    for place in common:
        kept = _among(domains[place], [domains[j if i == place else i] for i, j in possible])
        if kept is None:
            return None
        result[place] = kept
    return result


def _among(domain: Domain, others: Sequence[Domain]) -> Domain | None:
    """The values that one of the others has; all of them when any domain is open."""
    if domain.is_open or any(d.is_open for d in others):
        return domain
    pieces = [piece for d in others if (piece := _within(domain, d)) is not None]
    return _hull_of(domain, pieces) if pieces else None


_reified_all_equal = reified(eq, not_all_equal)
_reified_all_diff = reified(all_diff, some_equal)


def cond_eq(domains: Sequence[Domain]) -> Narrowed:
    """b = (x1 = ... = xn), arguments (b, x1, ..., xn)."""
    return _reified_all_equal(domains)


def cond_all_diff(domains: Sequence[Domain]) -> Narrowed:
    """b = (xi != xj for all i < j), arguments (b, x1, ..., xn)."""
    return _reified_all_diff(domains)
