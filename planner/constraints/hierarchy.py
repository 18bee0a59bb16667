"""Constraints on the tree of model objects: hasAncestor, commonAncestor.

An object exposes `.parent`: the object that it is part of, or None (or no such attribute) at the root. Its ancestors
are its parent and the parent's ancestors; it is not one of its own. Strength: generalised arc consistency. Nothing is
concluded while one of the domains is open.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from planner.constraints.procedure import Narrowed
from planner.domains import Domain, Interval, Values


def ancestors(value: Any) -> Iterator[Any]:
    """The parent, its parent and so on up to the root."""
    above = getattr(value, "parent", None)
    while above is not None:
        yield above
        above = getattr(above, "parent", None)


def _descendants_of(domain: Domain, restriction: Domain) -> dict[Any, list[Any]]:
    """For each restricting object that is an ancestor of a value of the domain: those values."""
    below: dict[Any, list[Any]] = {}
    for value in domain.values():
        for above in ancestors(value):
            if above in restriction:
                below.setdefault(above, []).append(value)
    return below


def _keep(domain: Domain, values: list[Any]) -> Domain | None:
    if isinstance(domain, Interval):  # a number has no ancestors
        return None
    kept = domain.keep(values)
    return kept if kept.bits else None


def _all_kept(domains: Sequence[Domain], kept: Sequence[list[Any]]) -> Narrowed:
    result = [_keep(d, values) for d, values in zip(domains, kept, strict=True)]
    return None if None in result else [d for d in result if d is not None]


def has_ancestor(domains: Sequence[Domain]) -> Narrowed:
    """r is an ancestor of x, arguments (x, r)."""
    if any(d.is_open for d in domains):
        return domains
    if not all(isinstance(d, Values) for d in domains):
        return None
    x, restriction = domains
    below = _descendants_of(x, restriction)
    return _all_kept(domains, ([v for values in below.values() for v in values], list(below)))


def common_ancestor(domains: Sequence[Domain]) -> Narrowed:
    """r is an ancestor of x and of y, arguments (x, y, r)."""
    if any(d.is_open for d in domains):
        return domains
    if not all(isinstance(d, Values) for d in domains):
        return None
    x, y, restriction = domains
    first, second = _descendants_of(x, restriction), _descendants_of(y, restriction)
    shared = [above for above in first if above in second]
    kept = ([v for above in shared for v in first[above]], [v for above in shared for v in second[above]], shared)
    return _all_kept(domains, kept)
