"""Taking causes out of the network in place: what followed from them goes, what others cause is derived anew.

The log of changes makes this possible: the history of a variable is the chain of its changes, each with its reason. A
variable that a removed cause has changed goes back to its domain before that change, and so does, from there on,
whatever a constraint derived from it. Everything is logged like any other change: undoing the level puts it back.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from planner.constraints.network import (
    AnyVariable,
    ConstraintNetworkManager,
    DurationVariable,
    Owner,
    Propagator,
    TimeVariable,
    Variable,
)
from planner.domains import Domain, Interval

Changing = Variable | DurationVariable
"""A variable with a history of its own; that of a timepoint lies in the temporal network."""


class Change(NamedTuple):
    """A change in a variable's history: its place in the log, the domain before, the reason, how many temporal
    constraints were in force."""

    at: int
    before: Domain
    because: Owner
    edges: int


def history(network: ConstraintNetworkManager, variable: Changing) -> Iterator[Change]:
    """The changes that a variable's domain rests on, newest first."""
    index = variable.latest
    while index >= 0:
        _, before, because, previous, edges = network._changes[index]
        yield Change(index, before, because, edges)
        index = previous


def made_by(
    network: ConstraintNetworkManager, variable: Changing, because: Owner, after: int, until: float
) -> list[tuple[int, Domain]]:
    """The changes of a variable that one cause made after one change and before another: places in the log and the
    domains before, oldest first."""
    found = []
    index = variable.latest
    while index > after:
        _, before, cause, previous, _ = network._changes[index]
        if cause is because and index < until:
            found.append((index, before))
        index = previous
    found.reverse()
    return found


def made_by_any(network: ConstraintNetworkManager, kind: type) -> tuple[list[int], list[tuple[Changing, int, Domain]]]:
    """What causes of one kind made: temporal constraints, and changes that domains rest on with the domains before,
    those of each variable oldest first."""
    edges = [number for number, (owner, _) in enumerate(network._edges) if isinstance(owner, kind)]
    variables = {id(entry[0]): entry[0] for entry in network._changes if isinstance(entry[2], kind)}
    changes = []
    for variable in variables.values():
        gone = [(variable, c.at, c.before) for c in history(network, variable) if isinstance(c.because, kind)]
        changes += gone[::-1]
    return edges, changes


def domain_at(network: ConstraintNetworkManager, variable: AnyVariable, index: int) -> Domain:
    """The domain that a variable had when the change with that place in the log was made."""
    domain = variable.domain
    if isinstance(variable, Variable):
        for change in history(network, variable):
            if change.at <= index:
                break
            domain = change.before
    return domain


def reset(network: ConstraintNetworkManager, variable: Changing, index: int) -> None:
    """Put a variable back to before a change of its history, and have its watchers run again."""
    changed, before, _, previous, _ = network._changes[index]
    assert changed is variable
    if isinstance(variable, Variable):
        network._note(variable, variable.domain, None)
        variable.domain = before
    else:
        assert isinstance(before, Interval)
        network._note(variable, variable.stated, None)
        variable.stated = before
    variable.latest = previous
    network._enqueue_all(variable.watchers)


def splice(network: ConstraintNetworkManager, variable: Variable, index: int, kept: int) -> None:
    """Take the changes from one to before a later one out of a variable's history; the later one stands by itself."""
    _, before, _, previous, _ = network._changes[index]
    entry = network._changes[kept]
    _, _, because, _, edges = entry
    network.trail.call(network._changes.__setitem__, kept, entry)
    network._changes[kept] = variable, before, because, previous, edges


def enqueue(network: ConstraintNetworkManager, propagators: Iterable[Propagator]) -> None:
    """Have propagators run again."""
    for propagator in propagators:
        network._enqueue(propagator)


def detach(network: ConstraintNetworkManager, propagator: Propagator) -> None:
    """Let nothing bring a propagator into the queue any more."""
    readers = network.readers_of_time
    if any(not isinstance(variable, Variable) for variable in propagator.scope) and propagator in readers:
        place = readers.index(propagator)
        del readers[place]
        network.trail.call(readers.insert, place, propagator)
    for variable in propagator.scope:
        watchers = variable.watchers
        place = watchers.index(propagator)
        del watchers[place]
        network.trail.call(watchers.insert, place, propagator)


def forget_timepoint(network: ConstraintNetworkManager, variable: TimeVariable) -> None:
    """Let nobody hear of a timepoint that is no more."""
    if network._time_watchers.get(variable.timepoint):
        network.trail.set(network._time_watchers, variable.timepoint, [])
