"""Tokens that go in place: out of their slots, and out of the plan. Trailed like everything else."""

from __future__ import annotations

from bisect import bisect_left
from operator import attrgetter
from typing import Any

from planner.constraints.network import Variable
from planner.constraints.retraction import forget_timepoint
from planner.tokens.instance import GuardInstance
from planner.tokens.manager import TokenNetworkManager
from planner.tokens.resources import Pruning
from planner.tokens.token import Token, TokenState
from planner.trail import Trail


def release(manager: TokenNetworkManager, token: Token) -> None:
    """Make an active or merged token open again. What its rules made is the caller's to take out."""
    trail = manager.trail
    _leave_slot(manager, token)
    for attribute, value in (("state", TokenState.INACTIVE), ("host", None), ("placed_by", None), ("group", None)):
        trail.assign(token, attribute, value)
    trail.assign(token, "rules", [])
    manager.open.add(token)


def destroy(manager: TokenNetworkManager, token: Token) -> None:
    """Take a token out of the plan."""
    _leave_slot(manager, token)
    if token.is_given or token.state is TokenState.INACTIVE:
        manager.open.forget(token)
    place = bisect_left(manager.tokens, token.id, key=attrgetter("id"))
    del manager.tokens[place]
    manager.trail.call(manager.tokens.insert, place, token)
    if manager.by_path.get(token.path) is token:
        drop(manager.trail, manager.by_path, token.path)
    forget_timepoint(manager.network, token.start)
    forget_timepoint(manager.network, token.end)


def forget_variable(manager: TokenNetworkManager, variable: Variable) -> None:
    """A variable need not be decided any more, nor be found by its name."""
    trail = manager.trail
    if id(variable) in manager.settled:
        drop(trail, manager.settled, id(variable))
    elif variable in manager.undecided and take(trail, manager.undecided, variable) < manager._decided:
        trail.assign(manager, "_decided", manager._decided - 1)
    if manager.variables.get(variable.name) is variable:
        drop(trail, manager.variables, variable.name)
        if variable in manager.alternatives:
            take(trail, manager.alternatives, variable)


def forget_guard(manager: TokenNetworkManager, guard: GuardInstance) -> None:
    """A guard waits no more."""
    if guard in manager.guards and take(manager.trail, manager.guards, guard) < manager._fired:
        manager.trail.assign(manager, "_fired", manager._fired - 1)


def prune_anew(manager: TokenNetworkManager) -> list[Pruning]:
    """What is known of the transactions on resources stands no more: what has them prune again."""
    used = [resource for resource in manager.resources.values() if resource.transactions]
    for resource in used:
        resource.forget()
    return [pruning for resource in used for pruning in resource.prunings()]


def reopen(manager: TokenNetworkManager) -> None:
    """Look again at all that was decided: some of it may not be any more."""
    manager.trail.assign(manager, "_decided", 0)
    manager.trail.assign(manager, "_fired", 0)


def unsettle(manager: TokenNetworkManager, variable: Variable) -> None:
    """A variable that had one value from the start and has several now must be decided."""
    if id(variable) in manager.settled and not variable.domain.is_singleton:
        drop(manager.trail, manager.settled, id(variable))
        manager.trail.append(manager.undecided, variable)


def _leave_slot(manager: TokenNetworkManager, token: Token) -> None:
    if token.state is not TokenState.ACTIVE:
        return
    for variable in token.parameters.values():
        forget_variable(manager, variable)
    if token.kind == "timeline":
        timeline = manager.timeline_of(token)
        take(manager.trail, timeline.sequence, token)
        manager.open.moved((timeline.object, timeline.attribute))
    elif token.kind == "constraint":
        take(manager.trail, manager.timeline_of(token).limits, token)
    elif token.kind in ("reusable", "reservoir"):
        manager.resources[token.thing].remove(token)
    else:
        take(manager.trail, manager._unordered_of(token), token)


def take(trail: Trail, container: list[Any], item: Any) -> int:
    """Remove an item of a list; the place where it was."""
    place = container.index(item)
    del container[place]
    trail.call(container.insert, place, item)
    return place


def drop(trail: Trail, container: dict[Any, Any], key: Any) -> None:
    """Remove a key of a dictionary."""
    trail.call(container.__setitem__, key, container.pop(key))
