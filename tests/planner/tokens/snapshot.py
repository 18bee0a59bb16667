"""Everything that a plan database holds, as plain values: two equal snapshots are two equal databases."""

from __future__ import annotations

from typing import Any

from planner.constraints.network import AnyVariable, TimeVariable
from planner.database import PlanDatabase
from planner.tokens.instance import GuardInstance
from planner.tokens.token import Token


def snapshot(database: PlanDatabase) -> dict[str, Any]:
    """Tokens, timelines, domains, bounds, watchers, logs and queues."""
    tokens, network, temporal = database.tokens, database.network, database.temporal
    points = 1 + max((t.end.timepoint for t in tokens.tokens), default=0)
    return {
        "tokens": [_token(t) for t in tokens.tokens],
        "open": sorted(tokens.open_tokens),
        "groups": [(repr(k), sorted(group.tokens)) for k, group in tokens.open.groups.items() if group.tokens],
        "given": ([t.id for t in tokens.open._given], tokens.open._first),
        "undecided": [_variable(v) for v in tokens.undecided],
        "alternatives": [v.name for v in tokens.alternatives],
        "skipped": (tokens._decided, tokens._fired),
        "guards": [(id(guard), guard.fired) for guard in tokens.guards],
        "sequences": {repr(k): [t.name for t in line.sequence] for k, line in tokens.timelines.items()},
        "unordered": {k: [t.name for t in users] for k, users in tokens._unordered.items() if users},
        "resources": {k.name: [t.name for t in profile.users] for k, profile in tokens.resources.items()},
        "constants": [c for v in tokens._constants.values() if (c := _variable(v))[2:] != (-1, [])],
        "members": [_variable(v) for v in tokens._members.values() if hasattr(v, "watchers") and v.watchers],
        "changes": [(v.name, old, id(because), *rest) for v, old, because, *rest in network._changes],
        "edges": [(id(owner), moment) for owner, moment in network._edges],
        "in force": network._in_force,
        "queue": [repr(p) for p in network._queue],
        "time watchers": {k: [v.name for v in held] for k, held in network._time_watchers.items()},
        "listeners": {k: id(listener) for k, listener in network._listeners.items()},
        "constraints": list(temporal.constraints()),
        "bounds": [(temporal.lower(p), temporal.upper(p)) for p in range(points)],
    }


def _token(token: Token) -> tuple[Any, ...]:
    variables = [token.object, token.start, token.end, token.duration, *token.parameters.values()]
    host = token.host.name if token.host is not None else None
    grouped = token.group is not None
    return (token.name, token.state.name, host, token.placed, grouped, token.contingent, [*map(_variable, variables)])


def _variable(variable: AnyVariable) -> tuple[Any, ...]:
    latest = -1 if isinstance(variable, TimeVariable) else variable.latest
    watchers = [(id(w), w.queued, isinstance(w, GuardInstance) and w.fired) for w in variable.watchers]
    return (variable.name, repr(variable.domain), latest, watchers)
