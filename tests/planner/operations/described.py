"""What a plan database holds in terms of names alone: two equal descriptions are two equal partial plans."""

from __future__ import annotations

from typing import Any

from planner.database import PlanDatabase
from planner.tokens.token import Token

FAR = 10**9
"""Ticks from here on are as good as unbounded."""


def described(database: PlanDatabase) -> dict[str, Any]:
    """Tokens, domains, bounds, distances, slots, and what is open."""
    tokens = database.tokens
    alive = {t.name: t for t in tokens.tokens}
    assert len(alive) == len(tokens.tokens), "token paths repeat"
    assert {t.path: t for t in tokens.tokens} == tokens.by_path
    return {
        "tokens": {name: _token(t) for name, t in alive.items()},
        "rule variables": {name: repr(v.domain) for name, v in tokens.variables.items()},
        "members": {v.name: repr(v.domain) for v in tokens._members.values() if hasattr(v, "watchers") and v.watchers},
        "sequences": {repr(k): [t.name for t in line.sequence] for k, line in tokens.timelines.items()},
        "limits": {repr(k): sorted(t.name for t in line.limits) for k, line in tokens.timelines.items() if line.limits},
        "astride": sorted(coverage.side.name for coverage in tokens.open_coverages()),
        "unordered": {k: sorted(t.name for t in users) for k, users in tokens._unordered.items() if users},
        "resources": {k.name: sorted(t.name for t in r.users) for k, r in tokens.resources.items()},
        "open": sorted(t.name for t in tokens.open_tokens.values()),
        "openings": {t.name: _openings(database, t) for t in tokens.open_tokens.values()},
        "undecided": sorted(v.name for v in tokens.still_undecided()),
        "alternatives": sorted(v.name for v in tokens.alternatives),
        "guards": sorted((repr(g.instance), [v.name for v in g.scope]) for g in tokens.waiting_guards()),
        "distances": _distances(database, alive),
    }


def _token(token: Token) -> tuple[Any, ...]:
    variables = [token.object, token.start, token.end, token.duration, *token.parameters.values()]
    host = token.host.name if token.host is not None else None
    domains = {v.name: repr(v.domain) for v in variables}
    return token.state.name, token.role, token.depth, host, token.placed, domains


def _openings(database: PlanDatabase, token: Token) -> tuple[Any, ...]:
    hosts, places = database.tokens.openings(token)
    return [h.name for h in hosts], [(thing.name, position) for thing, position in places]


def _distances(database: PlanDatabase, alive: dict[str, Token]) -> dict[str, list[tuple[int, int]]]:
    ordered = sorted(alive.values(), key=lambda t: t.name)
    points = [p for t in ordered for p in (t.start.timepoint, t.end.timepoint)]
    table = {}
    for token in ordered:
        row = database.temporal.distances_from(token.start.timepoint)
        table[token.name] = [(max(row[p][0], -FAR), min(row[p][1], FAR)) for p in points]
    return table
