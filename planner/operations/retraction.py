"""What goes with one operation that is taken out of a plan in place, by dependency.

That is: what the operation posted; the rules of a token that is no longer active, and what they made, tokens with the
operations on them included; the domains from the first change on that something gone made, and whatever was derived
from such a domain after that; the branch of a guard that only such a domain decided. Rather too much goes than too
little: the domains before those changes rest on nothing that goes, so propagation from there reaches the fixpoint of
what is left, and what still holds comes back, guards and dormant operations included.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from planner.constraints import retraction as network_retraction
from planner.constraints.network import (
    AnyVariable,
    Constraint,
    DurationVariable,
    Propagator,
    TimeVariable,
    Variable,
)
from planner.constraints.retraction import Change, Changing, domain_at, history, made_by
from planner.database import PlanDatabase
from planner.domains import Domain
from planner.operations.order import Precedences
from planner.operations.register import Register
from planner.operations.restricting import variable_of
from planner.operations.statements import Codesignation, Operation, Restriction
from planner.tokens.instance import Extent, ForEachInstance, GuardInstance, RuleInstance
from planner.tokens.resources import Clash, PendingUse, Pruning
from planner.tokens.token import Token


class Unsuited(Exception):  # noqa: N818 - a signal between two ways to the same result
    """Something that depends on the order in which things happened would go: only replay is exact."""


@dataclass(frozen=True, slots=True)
class _Cut:
    """Changes of a variable that go: from the one at `first`, before which the domain was `before`, to before that at
    `last`, which stands by itself; or all."""

    variable: Changing
    first: int
    before: Domain
    last: float = math.inf

    @property
    def domain(self) -> Domain:
        """What the variable's domain is before anything is derived anew."""
        return self.before if self.last == math.inf else self.variable.domain


class Retraction:
    """What goes with one operation: `run` finds it out without changing anything.

    `suspended`: the operations that go dormant, the one itself included.
    """

    def __init__(self, database: PlanDatabase, register: Register, precedences: Precedences) -> None:
        self.database = database
        self.network = database.network
        self.register = register
        self.precedences = precedences
        self.suspended: dict[int, Operation] = {}
        self.released: dict[int, Token] = {}
        self.destroyed: dict[int, Token] = {}
        self.dead: set[int] = set()
        self.edges: set[int] = set()
        self.instances: list[RuleInstance] = []
        self.propagators: dict[int, Propagator] = {}
        self.variables: dict[int, Variable] = {}
        self.cuts: dict[int, _Cut] = {}
        self.guards: dict[int, GuardInstance] = {}
        self.undone: dict[int, GuardInstance] = {}
        self.uses: dict[int, PendingUse] = {}
        self._pending: list[Changing] = []
        self._owners: list[Operation | RuleInstance] = []

    def run(self, operation: Operation) -> None:
        """Find out all that goes. Unsuited if it cannot be told in place."""
        self._owners.append(operation)
        self._drop_pruning()
        before = (-1, -1)
        while before != (len(self.edges), len(self.undone)) or self._pending or self._owners:
            before = len(self.edges), len(self.undone)
            self._take_down()
            self._follow()
            self._review_guards()
            self._review_readers_of_time()
        self._check_readings()

    def _check_readings(self) -> None:
        """What an instance makes of a domain at its time cannot be made anew in place."""
        gone = set(map(id, self.instances))
        for key in self.cuts:
            for instance in self.database.tokens.readings.get(key, ()):
                if not instance.withdrawn and id(instance) not in gone:
                    raise Unsuited

    # What goes with its owner

    def _take_down(self) -> None:
        while self._owners:
            owner = self._owners.pop()
            if isinstance(owner, Operation):
                self._suspend(owner)
            elif not owner.withdrawn:  # what two tokens make of each other goes with either
                self.instances.append(owner)
                if owner.extent is not None:
                    self._withdraw(owner.extent)

    def _suspend(self, operation: Operation) -> None:
        if operation.number in self.suspended:
            return
        self.suspended[operation.number] = operation
        tokens, statement, extent = self.database.tokens, operation.statement, operation.extent
        assert extent is not None
        if isinstance(statement, Restriction):
            self.edges.update(extent.edges)
            if (variable := variable_of(self.database, statement)) is not None:
                self._drop_changes(variable, operation)
            return
        token = tokens.by_path[statement.token]
        self.released[id(token)] = token
        if isinstance(statement, Codesignation):
            self._withdraw(extent)
            return
        self._drop_changes(token.object, operation)
        self.edges.update(self.precedences.of(token))
        self._owners.extend(token.rules)
        for other in self.register.about(token.path):
            if isinstance(other.statement, Codesignation) and other.statement.host == token.path:
                self._owners.append(other)

    def _withdraw(self, extent: Extent) -> None:
        """Everything that one owner made."""
        self.edges.update(extent.edges)
        for token in extent.tokens:
            self._destroy(token)
        for variable in extent.variables:
            self.variables[id(variable)] = variable
            self.dead.add(id(variable))
            self._owners.extend(self.register.about(variable.name))
        for number in extent.propagators:
            self._remove(self.network.propagators[number])

    def _destroy(self, token: Token) -> None:
        if id(token) in self.destroyed:
            return
        self.destroyed[id(token)] = token
        self.dead.update(map(id, (token.object, token.duration, *token.parameters.values())))
        self._owners.extend(self.register.about(token.path))

    def _remove(self, propagator: Propagator) -> None:
        if id(propagator) in self.propagators or isinstance(propagator, Pruning):  # which goes with its transaction
            return
        self.propagators[id(propagator)] = propagator
        if isinstance(propagator, GuardInstance | ForEachInstance):
            self._owners.extend(propagator.bodies)
        elif isinstance(propagator, Constraint):
            self._drop_effects(propagator, -1)
        elif isinstance(propagator, PendingUse):
            self.uses[id(propagator)] = propagator
        else:
            raise Unsuited

    def _drop_pruning(self) -> None:
        """What resources took away, where transactions left no room: any other transaction, any bound may be why."""
        if any(resource.transactions for resource in self.database.tokens.resources.values()):
            edges, changes = network_retraction.made_by_any(self.network, Clash)
            self.edges.update(edges)
            for variable, index, before in changes:
                self._cut(variable, index, before)

    # What follows from what goes

    def _drop_effects(self, constraint: Constraint, after: int, until: float = math.inf) -> None:
        """What a constraint derived after a change and before another."""
        for variable in constraint.scope:
            self._drop_changes(variable, constraint, after, until)

    def _drop_changes(self, variable: AnyVariable, because: object, after: int = -1, until: float = math.inf) -> None:
        """What one cause did to a variable after a change and before another."""
        if isinstance(variable, Variable):
            if variable.latest <= after:
                return
        else:
            for edge in variable.narrowings:
                changes = self.network.posted_at(edge).changes
                if after < changes <= until and self.network.stakeholder_named(edge) is because:
                    self.edges.add(edge)
        if isinstance(variable, TimeVariable):
            return
        if id(variable) not in self.dead:
            for index, before in made_by(self.network, variable, because, after, until):
                self._cut(variable, index, before)

    def _cut(self, variable: Changing, index: int, before: Domain) -> None:
        known = self.cuts.get(id(variable))
        if known is not None and known.first <= index < known.last:
            return
        if known is not None and known.first < index:
            index, before = known.first, known.before
            last = self._stands_by_itself(variable, known.last, before)
        else:
            last = self._stands_by_itself(variable, index if known is None else max(index, known.last - 1), before)
        self.cuts[id(variable)] = _Cut(variable, index, before, last)
        self._pending.append(variable)

    def _stands_by_itself(self, variable: Changing, after: float, before: Domain) -> float:
        """The first change later than `after` whose cause would have made the same of `before`."""
        found = math.inf
        if isinstance(variable, Variable):
            domain: Domain = variable.domain
            for change in history(self.network, variable):
                if change.at <= after:
                    break
                if self._made_of(variable, before, change) == domain:
                    found = change.at
                domain = change.before
        return found

    def _made_of(self, variable: Variable, before: Domain, change: Change) -> Domain | None:
        """What the cause of a change makes of another domain; None: the cause goes, or rests on what does."""
        cause = change.because
        if isinstance(cause, Operation):
            statement = cause.statement
            if cause.number in self.suspended or isinstance(statement, Codesignation):
                return None
            if isinstance(statement, Restriction):
                return before.intersect(statement.domain)
            thing = self.database.model.objects[statement.object]
            return before.intersect(self.database.tokens.domain_of_object(thing))
        if not isinstance(cause, Constraint) or id(cause) in self.propagators:
            return None
        domains = []
        for other in cause.scope:
            cut = self.cuts.get(id(other))
            if other is variable:
                domains.append(before)
            elif not isinstance(other, Variable) or (cut is not None and cut.first < change.at < cut.last):
                return None
            else:
                domains.append(domain_at(self.network, other, change.at))
        narrowed = cause.procedure.narrow(domains)
        return None if narrowed is None else narrowed[list(cause.scope).index(variable)]

    def _follow(self) -> None:
        """What was derived from domains that are put back, from then on."""
        while self._pending:
            variable = self._pending.pop()
            cut = self.cuts[id(variable)]
            index = cut.first
            for change in history(self.network, variable):
                if change.at < index:
                    break
                if not isinstance(change.because, Constraint | Operation | Clash):
                    raise Unsuited
            if isinstance(variable, DurationVariable):
                for edge in variable.narrowings:
                    if self.network.posted_at(edge).changes > index:  # posted after the change was noted
                        self.edges.add(edge)
            for watcher in variable.watchers:
                if id(watcher) in self.propagators:
                    continue
                if isinstance(watcher, Constraint):
                    self._drop_effects(watcher, index, cut.last)
                elif isinstance(watcher, GuardInstance):
                    if watcher.fired:
                        self.guards[id(watcher)] = watcher
                elif isinstance(watcher, PendingUse):
                    if not cut.domain.is_singleton:
                        self.uses[id(watcher)] = watcher
                elif not isinstance(watcher, Pruning) and (not isinstance(watcher, ForEachInstance) or watcher.done):
                    raise Unsuited

    def _review_guards(self) -> None:
        """Guards that only what goes decided."""
        for guard in list(self.guards.values()):
            if id(guard) not in self.propagators and id(guard) not in self.undone:
                domains = [self.cuts[id(v)].domain if id(v) in self.cuts else v.domain for v in guard.scope]
                if guard.outcome(domains) is None:
                    self._undo_guard(guard)

    def _undo_guard(self, guard: GuardInstance) -> None:
        self.undone[id(guard)] = guard
        self._owners.extend(guard.bodies)

    def _review_readers_of_time(self) -> None:
        """Whatever was derived from times after a temporal constraint that goes was in force may rest on it."""
        if not self.edges:
            return
        first = min(self.edges)
        for propagator in self.network.readers_of_time:
            if id(propagator) in self.propagators:
                continue
            if isinstance(propagator, GuardInstance):
                if propagator.fired and id(propagator) not in self.undone:
                    self._undo_guard(propagator)
            elif isinstance(propagator, Constraint):
                self._drop_derived_from_time(propagator, first)
            elif not isinstance(propagator, Pruning):
                raise Unsuited

    def _drop_derived_from_time(self, constraint: Constraint, first: int) -> None:
        for variable in constraint.scope:
            if not isinstance(variable, Variable):
                for edge in variable.narrowings:
                    later = self.network.posted_at(edge).edges > first
                    if later and self.network.stakeholder_named(edge) is constraint:
                        self.edges.add(edge)
            if not isinstance(variable, TimeVariable):
                gone = []
                for change in history(self.network, variable):
                    if change.edges <= first:
                        break
                    if change.because is constraint:
                        gone.append(change)
                for change in reversed(gone):
                    self._cut(variable, change.at, change.before)
