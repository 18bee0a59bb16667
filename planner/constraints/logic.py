"""Truth values: or, testEq and its kin, testAnd, testOr, testNot, testSingleton, testSpecified, and the counts.

A number counts as true when it is not zero. A test's first argument is the truth of a relation between the rest:
narrowed once the relation is certain or impossible, and imposing the relation or its contrary once it is decided.
Strength: generalised arc consistency on enumerated domains, bounds consistency on intervals.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from planner.constraints.equality import eq, leq, lt, neq, without
from planner.constraints.numeric import clip
from planner.constraints.procedure import Narrowed, Narrowing
from planner.domains import BOOLEAN, FALSE, TRUE, Domain, Interval, Values

UNDECIDED_BITS = BOOLEAN.domain().bits


def can_be(domain: Domain, truth: bool) -> bool:
    """Whether a boolean domain still has that value."""
    return domain.is_open or truth in domain


def decide(domain: Domain, truth: bool) -> Domain | None:
    """The boolean domain with that value only; None when it does not have it, an open one as it is."""
    if domain.is_open:
        return domain
    if isinstance(domain, Interval):
        return clip(domain, int(truth), int(truth))
    if domain.universe is TRUE.universe:
        wanted = TRUE if truth else FALSE
        return domain if domain.bits == wanted.bits else wanted if domain.bits & wanted.bits else None
    kept = domain.keep((truth,))
    return kept if kept.bits else None


def reified(positive: Narrowing, negative: Narrowing) -> Narrowing:
    """The narrowing of b = relation(rest), from those of the relation and its contrary, which must decide failure."""

    def narrow(domains: Sequence[Domain]) -> Narrowed:
        truth, rest = domains[0], domains[1:]
        true, false = can_be(truth, True), can_be(truth, False)
        held = positive(rest) if true else None
        missed = negative(rest) if false else None
        if held is None and missed is None:
            return None
        if held is not None and missed is not None:
            return domains
        decided = decide(truth, held is not None)
        narrowed = held if held is not None else missed
        if decided is None or narrowed is None:
            return None
        # Truth unknown and open: the relation is known, but there is no domain to tell it to.
        return (decided, *narrowed)

    return narrow


def _greater(domains: Sequence[Domain]) -> Narrowed:
    x, y = domains
    narrowed = lt((y, x))
    return None if narrowed is None else (narrowed[1], narrowed[0])


def _not_less(domains: Sequence[Domain]) -> Narrowed:
    x, y = domains
    narrowed = leq((y, x))
    return None if narrowed is None else (narrowed[1], narrowed[0])


_reified_eq = reified(eq, neq)
_reified_neq = reified(neq, eq)
_reified_leq = reified(leq, _greater)
_reified_lt = reified(lt, _not_less)


def _undecided(domains: Sequence[Domain]) -> bool:
    """Whether x < y, x = y and x > y are all possible between integer intervals: no test can be decided, b is free.

    A shortcut for the common case; False when it is not known.
    """
    truth, x, y = domains
    return (
        isinstance(x, Interval)
        and isinstance(y, Interval)
        and isinstance(truth, Values)
        and truth.bits == UNDECIDED_BITS
        and truth.universe is TRUE.universe
        and x.integer
        and y.integer
        and x.lower < y.upper
        and y.lower < x.upper
    )


def test_eq(domains: Sequence[Domain]) -> Narrowed:
    """b = (x = y), arguments (b, x, y)."""
    if _undecided(domains):
        return domains
    return _reified_eq(domains)


def test_neq(domains: Sequence[Domain]) -> Narrowed:
    """b = (x != y), arguments (b, x, y)."""
    if _undecided(domains):
        return domains
    return _reified_neq(domains)


def test_leq(domains: Sequence[Domain]) -> Narrowed:
    """b = (x <= y), arguments (b, x, y)."""
    if _undecided(domains):
        return domains
    return _reified_leq(domains)


def test_less_than(domains: Sequence[Domain]) -> Narrowed:
    """b = (x < y), arguments (b, x, y)."""
    if _undecided(domains):
        return domains
    return _reified_lt(domains)


def _can_be_zero(domain: Domain) -> bool:
    return domain.is_open or 0 in domain


def _must_be_zero(domain: Domain) -> bool:
    return not domain.is_open and domain.is_singleton and 0 in domain


def any_true(domains: Sequence[Domain]) -> Narrowed:
    """x1 != 0 or ... or xn != 0."""
    hopeful = [i for i, d in enumerate(domains) if not _must_be_zero(d)]
    if not hopeful:
        return None
    if len(hopeful) > 1:
        return domains
    return _replace(domains, hopeful[0], without(domains[hopeful[0]], 0))


def _none_true(domains: Sequence[Domain]) -> Narrowed:
    result = [d if d.is_open else _zero(d) for d in domains]
    return None if None in result else [d for d in result if d is not None]


def _all_true(domains: Sequence[Domain]) -> Narrowed:
    result = [without(d, 0) for d in domains]
    return None if None in result else [d for d in result if d is not None]


def _some_false(domains: Sequence[Domain]) -> Narrowed:
    hopeful = [i for i, d in enumerate(domains) if _can_be_zero(d)]
    if not hopeful:
        return None
    if len(hopeful) > 1 or domains[hopeful[0]].is_open:
        return domains
    return _replace(domains, hopeful[0], _zero(domains[hopeful[0]]))


def _zero(domain: Domain) -> Domain | None:
    if isinstance(domain, Interval):
        return clip(domain, 0, 0)
    kept = domain.keep((0,))
    return kept if kept.bits else None


def _replace(domains: Sequence[Domain], place: int, new: Domain | None) -> Narrowed:
    if new is None:
        return None
    return domains if new is domains[place] else [*domains[:place], new, *domains[place + 1 :]]


_reified_or = reified(any_true, _none_true)
_reified_and = reified(_all_true, _some_false)


def test_or(domains: Sequence[Domain]) -> Narrowed:
    """b = (x1 or ... or xn), arguments (b, x1, ..., xn)."""
    return _reified_or(domains)


def test_and(domains: Sequence[Domain]) -> Narrowed:
    """b = (x1 and ... and xn), arguments (b, x1, ..., xn)."""
    return _reified_and(domains)


def test_not(domains: Sequence[Domain]) -> Narrowed:
    """b = not x, arguments (b, x)."""
    return _reified_not(domains)


_reified_not = reified(_none_true, _all_true)


def test_singleton(domains: Sequence[Domain]) -> Narrowed:
    """b is true once x has one value, arguments (b, x).

    Until then nothing is known about b, and x is never narrowed: b = false means "not decided yet", which an assigned x
    contradicts.
    """
    truth, x = domains
    if x.is_open or not x.is_singleton:
        return domains
    decided = decide(truth, True)
    return None if decided is None else (decided, x)


def count_zeroes(domains: Sequence[Domain]) -> Narrowed:
    """n = the number of x1, ..., xn that are zero, arguments (n, x1, ..., xn)."""
    return _count(domains, _must_be_zero, _can_be_zero, _zero, _not_zero)


def count_non_zeroes(domains: Sequence[Domain]) -> Narrowed:
    """n = the number of x1, ..., xn that are not zero, arguments (n, x1, ..., xn)."""
    return _count(domains, _cannot_be_zero, _may_be_true, _not_zero, _zero)


def _not_zero(domain: Domain) -> Domain | None:
    return without(domain, 0)


def _cannot_be_zero(domain: Domain) -> bool:
    return not _can_be_zero(domain)


def _may_be_true(domain: Domain) -> bool:
    return not _must_be_zero(domain)


def _count(
    domains: Sequence[Domain],
    must: Callable[[Domain], bool],
    may: Callable[[Domain], bool],
    impose: Callable[[Domain], Domain | None],
    forbid: Callable[[Domain], Domain | None],
) -> Narrowed:
    """n = how many of the rest have a property: what must have it, what may, and how to impose or forbid it."""
    terms = domains[1:]
    certain = sum(1 for d in terms if must(d))
    possible = sum(1 for d in terms if may(d))
    count: Domain | None = domains[0]
    if isinstance(count, Values) and count.is_open:
        return domains
    count = clip(domains[0], certain, possible)
    if count is None:
        return None
    change = forbid if count.upper == certain else impose if count.lower == possible else None
    if change is None or certain == possible:
        return [count, *terms]
    result: list[Domain] = [count]
    for domain in terms:
        undecided = may(domain) and not must(domain) and not domain.is_open
        kept = change(domain) if undecided else domain
        if kept is None:
            return None
        result.append(kept)
    return result
