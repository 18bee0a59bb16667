"""Instances of configuration constraint schemata: their statements carried out on the network, their guards watched."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from planner.constraints.network import (
    AnyVariable,
    ConstraintNetworkManager,
    DurationVariable,
    Owner,
    TimeVariable,
    Variable,
)
from planner.domains import Domain, Interval, Universe, singleton
from planner.errors import ModelError
from planner.model.classes import ModelObject, objects_in
from planner.model.relations import Distance, distances
from planner.model.rules import (
    Apply,
    Confine,
    Constant,
    Expression,
    ForEach,
    Guard,
    Local,
    OneOf,
    Ref,
    Relate,
    Require,
    Statement,
    Subgoal,
)
from planner.tokens.limits import Allowed
from planner.tokens.limits import create as create_limit
from planner.tokens.path import TokenPath
from planner.tokens.token import Token

if TYPE_CHECKING:
    from planner.tokens.manager import TokenNetworkManager

Named = Token | AnyVariable | ModelObject


class Extent(NamedTuple):
    """What an owner made: temporal constraints and propagators by their numbers, tokens, variables of its own; what
    parts of it made included."""

    edges: range
    propagators: range
    tokens: tuple[Token, ...]
    variables: tuple[Variable, ...]


class RuleInstance:
    """A schema's body applied to a token: the owner of all that its statements made. `label` says which, for people;
    it is made text only when somebody asks. `cause`: the guard or loop that applied a part of the body. `path`: what
    tells the names of its subgoals from those of the token's other rules. `beside`: another token that it rests on."""

    __slots__ = ("beside", "cause", "extent", "label", "names", "parent", "path", "token", "withdrawn")

    def __init__(
        self,
        label: object,
        token: Token | None,
        parent: RuleInstance | None = None,
        cause: GuardInstance | ForEachInstance | None = None,
        path: str = "",
        beside: Token | None = None,
    ) -> None:
        self.label = label
        self.token = token
        self.parent = parent
        self.cause = cause
        self.beside: Token | None = beside if parent is None else parent.beside
        self.path: str = path if parent is None else parent.path + path
        self.names: dict[str, Named] = {}
        self.extent: Extent | None = None
        self.withdrawn = False

    def find(self, name: str) -> Named | None:
        """What a name means here: in this body, in those around it, or as a variable of the token."""
        scope: RuleInstance | None = self
        while scope is not None:
            if name in scope.names:
                return scope.names[name]
            scope = scope.parent
        return self.token.variable(name) if self.token is not None else None

    @property
    def name(self) -> str:
        """What only this instance is called."""
        return f"{self.label} of {self.token.path.text}" if self.token is not None else str(self.label)

    def __repr__(self) -> str:
        return f"{self.label} of {self.token.name}" if self.token is not None else str(self.label)


class ForEachInstance:
    """A loop that runs once, when all else has been propagated: only then is known which objects are left."""

    __slots__ = ("bodies", "done", "instance", "loop", "manager", "owner", "queued", "scope")

    def __init__(self, manager: TokenNetworkManager, loop: ForEach, over: AnyVariable, instance: RuleInstance) -> None:
        self.manager = manager
        self.loop = loop
        self.scope: tuple[AnyVariable, ...] = (over,)
        self.instance = instance
        self.owner: Owner = instance
        self.queued = False
        self.done = False
        self.bodies: list[RuleInstance] = []

    def run(self, network: ConstraintNetworkManager) -> None:
        """Apply the body for every object that is left."""
        if self.done:
            return
        network.trail.assign(self, "done", True)
        for thing in objects_in(self.scope[0].domain):
            body = RuleInstance(self.instance.label, self.instance.token, self.instance, self, f"{thing.name}.")
            body.names[self.loop.name] = thing
            network.trail.append(self.bodies, body)
            self.manager.carry_out(self.loop.body, body)


class GuardInstance:
    """A guard on watch: acts once when its test is decided."""

    __slots__ = ("bodies", "deciding", "fired", "guard", "instance", "manager", "owner", "queued", "scope", "test")

    def __init__(
        self, manager: TokenNetworkManager, guard: Guard, scope: Sequence[AnyVariable], instance: RuleInstance
    ) -> None:
        self.manager = manager
        self.guard = guard
        self.scope = scope
        self.instance = instance
        self.owner: Owner = instance
        self.queued = False
        self.fired = False
        self.bodies: list[RuleInstance] = []
        self.test = manager.model.procedures.get(guard.test)
        # A set that the test names is no variable: nobody decides it.
        self.deciding = [
            n for n, a in enumerate(guard.arguments) if not (isinstance(a, Constant) and a.domain is not None)
        ] or list(range(len(scope)))

    def run(self, network: ConstraintNetworkManager) -> None:
        """Apply the branch that the test chose, if it is decided."""
        if self.fired:
            return
        holds = self.outcome([variable.domain for variable in self.scope])
        if holds is not None:
            self.fire(holds)

    def outcome(self, domains: Sequence[Domain]) -> bool | None:
        """Whether the test holds for such domains of its scope; None: they do not decide it."""
        if self.test.narrow(domains) is None:
            return False
        return True if all(domains[n].is_singleton and not domains[n].is_open for n in self.deciding) else None

    def fire(self, holds: bool) -> None:
        """Apply the branch for a test that holds, or for one that does not."""
        self.manager.trail.assign(self, "fired", True)
        branch = self.guard.then if holds else self.guard.otherwise
        if branch:
            body = RuleInstance(self.instance.label, self.instance.token, self.instance, self)
            self.manager.trail.append(self.bodies, body)
            self.manager.carry_out(branch, body)


def carry_out(manager: TokenNetworkManager, statements: Sequence[Statement], instance: RuleInstance) -> None:
    """Carry out statements in order for an instance."""
    for statement in statements:
        _CARRY_OUT[type(statement)](manager, statement, instance)


def _subgoal(manager: TokenNetworkManager, statement: Subgoal, instance: RuleInstance) -> None:
    token = manager.create(statement.predicate, _path(statement.name, instance), "subgoal", instance, instance.token)
    token.solitary = token.solitary or statement.solitary
    _place_subgoal(manager, statement, token, instance)


def _confine(manager: TokenNetworkManager, statement: Confine, instance: RuleInstance) -> None:
    allowed = []
    for value in statement.values:
        limits: dict[str, AnyVariable | Domain] = {}
        for name, expression in value.parameters:
            domain = expression.domain if isinstance(expression, Constant) else None
            limits[name] = evaluate(manager, expression, instance) if domain is None else domain
        allowed.append(Allowed(manager.model.predicate(*value.predicate), limits))
    path = _path(statement.name, instance)
    token = create_limit(manager, statement.attribute, allowed, path, "subgoal", instance, instance.token)
    _place_subgoal(manager, statement, token, instance)


def _path(name: str, instance: RuleInstance) -> TokenPath:
    """The path of a token that an instance asks for."""
    master = instance.token
    step = instance.path + name
    return TokenPath.of(step) if master is None else master.path.then(step)


def _place_subgoal(
    manager: TokenNetworkManager, statement: Subgoal | Confine, token: Token, instance: RuleInstance
) -> None:
    """Give a token that an instance asks for its name, its object and its place in time."""
    instance.names[statement.name] = token
    if statement.target is not None:
        target = resolve(manager, statement.target, instance)
        if isinstance(target, Token):
            raise ModelError(f"{instance.label}: {statement.target!r} is a token, expected an object")
        if isinstance(target, ModelObject):
            manager.network.restrict(token.object, manager.domain_of_object(target), instance)
        else:
            manager.require("eq", (token.object, target), instance)
    if instance.token is not None:
        relate(manager, distances(statement.relation, statement.bounds), instance.token, token, instance)


def _relate(manager: TokenNetworkManager, statement: Relate, instance: RuleInstance) -> None:
    tokens = []
    for name in (statement.origin, statement.target):
        found = instance.token if name == "this" else instance.find(name) or manager.names.get(name)
        if not isinstance(found, Token):
            raise ModelError(f"{instance.label}: {name!r} is not a token")
        tokens.append(found)
    relate(manager, distances(statement.relation, statement.bounds), tokens[0], tokens[1], instance)


def relate(manager: TokenNetworkManager, table: Sequence[Distance], origin: Token, target: Token, owner: Owner) -> None:
    """Post a temporal relation between two tokens."""
    sides = {"o.start": origin.start, "o.end": origin.end, "t.start": target.start, "t.end": target.end}
    for distance in table:
        manager.network.distance(sides[distance.from_], sides[distance.to], distance.minimum, distance.maximum, owner)


def _require(manager: TokenNetworkManager, statement: Require, instance: RuleInstance) -> None:
    if statement.procedure == "temporalDistance" and _plain_distance(manager, statement, instance):
        return
    scope = [evaluate(manager, argument, instance) for argument in statement.arguments]
    manager.require(statement.procedure, scope, instance)


def _plain_distance(manager: TokenNetworkManager, statement: Require, instance: RuleInstance) -> bool:
    """Post a distance between two timepoints whose bounds are written out; False when it is none."""
    if len(statement.arguments) != 3 or not isinstance(statement.arguments[1], Constant):
        return False
    from_, to = (evaluate(manager, statement.arguments[n], instance) for n in (0, 2))
    written = statement.arguments[1]
    domain = written.domain if written.domain is not None else singleton(written.value)
    if not (isinstance(from_, TimeVariable) and isinstance(to, TimeVariable) and isinstance(domain, Interval)):
        return False
    manager.network.distance(from_, to, domain.lower, domain.upper, instance)
    return True


def _local(manager: TokenNetworkManager, statement: Local, instance: RuleInstance) -> None:
    variable = manager.network.variable(
        f"{instance.path}{statement.name}", manager.model.domain_of(statement.type), instance, instance
    )
    instance.names[statement.name] = variable
    manager.name_variable(variable)
    if statement.decide:
        manager.must_be_decided(variable)


def _guard(manager: TokenNetworkManager, statement: Guard, instance: RuleInstance) -> None:
    scope = [evaluate(manager, argument, instance) for argument in statement.arguments]
    guard = GuardInstance(manager, statement, scope, instance)
    manager.trail.append(manager.guards, guard)
    manager.network.watch(guard)


def _for_each(manager: TokenNetworkManager, statement: ForEach, instance: RuleInstance) -> None:
    over = evaluate(manager, statement.over, instance)
    loop = ForEachInstance(manager, statement, over, instance)
    manager.network.alert(loop)
    manager.network.postpone(loop)


def _one_of(manager: TokenNetworkManager, statement: OneOf, instance: RuleInstance) -> None:
    choices = Universe(statement.name, range(len(statement.branches)))
    variable = manager.network.variable(f"{instance.path}{statement.name}", choices.domain(), instance, instance)
    manager.name_variable(variable)
    manager.must_be_decided(variable)
    if instance.token is not None and instance.token.depth == 0:
        manager.trail.append(manager.alternatives, variable)
    for number, branch in enumerate(statement.branches):
        chosen = Guard("eq", (), branch)
        constant = manager.constant(number)
        manager.network.watch(GuardInstance(manager, chosen, (variable, constant), instance))


_CARRY_OUT: dict[type, Callable[[TokenNetworkManager, Any, RuleInstance], None]] = {
    Subgoal: _subgoal,
    Confine: _confine,
    Relate: _relate,
    Require: _require,
    Local: _local,
    Guard: _guard,
    OneOf: _one_of,
    ForEach: _for_each,
}


def evaluate(manager: TokenNetworkManager, expression: Expression, instance: RuleInstance) -> AnyVariable:
    """The variable of an expression, made with the constraint that defines it where it is a function."""
    if isinstance(expression, Constant):
        domain = singleton(expression.value) if expression.domain is None else expression.domain
        if expression.domain is None and isinstance(expression.value, ModelObject):
            domain = manager.domain_of_object(expression.value)
        return manager.network.variable(repr(expression), domain, instance)
    if isinstance(expression, Apply):
        scope = [evaluate(manager, argument, instance) for argument in expression.arguments]
        result = manager.network.variable(repr(expression), manager.result_domain(expression.procedure), instance)
        manager.require(expression.procedure, [*scope, result], instance)
        return result
    found = resolve(manager, expression, instance)
    if isinstance(found, Token):
        raise ModelError(f"{instance.label}: {expression!r} is a token, expected a variable")
    if isinstance(found, ModelObject):
        return manager.constant(found)
    return found


def resolve(manager: TokenNetworkManager, ref: Ref, instance: RuleInstance) -> Named:
    """What a path means to an instance; ModelError names the part that means nothing."""
    first, *rest = ref.path
    found: Named | None = instance.token if first == "this" else instance.find(first)
    if found is None and instance.token is not None:
        cls = instance.token.predicate.cls
        if first in manager.model.members_of(cls):
            found = member(manager, instance.token.object, first, instance)
    if found is None:
        found = manager.names.get(first) or manager.model.objects.get(first)
    if found is None:
        raise ModelError(f"{instance.label}: {first!r} means nothing here")
    for name in rest:
        if isinstance(found, Token):
            found = found.variable(name) or member(manager, found.object, name, instance)
        else:
            found = member(manager, found, name, instance)
    return found


def member(manager: TokenNetworkManager, of: AnyVariable | ModelObject, name: str, instance: RuleInstance) -> Named:
    """A member of an object, or of whichever object a variable turns out to be."""
    if isinstance(of, TimeVariable | DurationVariable):
        raise ModelError(f"{instance.label}: {of.name} is a time, it has no member {name!r}")
    if isinstance(of, ModelObject):
        return manager.member_of(of, name)
    manager.note_reading(of, instance)
    objects = objects_in(of.domain)
    if not objects:
        raise ModelError(f"{instance.label}: {of.name} is not an object, it has no member {name!r}")
    if len(objects) == 1:
        return manager.member_of(objects[0], name)
    return manager.member_of_any(of, objects, name, instance)
