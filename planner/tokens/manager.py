"""TokenNetworkManager (paper, section 4): tokens, timelines and rule instances on the constraint network."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import reduce
from operator import or_
from typing import Any

from planner.constraints.network import AnyVariable, ConstraintNetworkManager, Owner, Variable
from planner.constraints.procedure import ConstraintProcedure
from planner.constraints.temporal_forms import post_temporal
from planner.domains import Domain, Interval, Universe, Values, singleton
from planner.errors import ModelError
from planner.model.classes import ModelObject, objects_in
from planner.model.manager import ModelManager
from planner.model.resources import USES
from planner.model.rules import Statement
from planner.tokens.coverage import Coverage, cover
from planner.tokens.form import Form, form_of
from planner.tokens.instance import Extent, GuardInstance, Named, RuleInstance, carry_out
from planner.tokens.openness import OpenTokens
from planner.tokens.path import TokenPath
from planner.tokens.resources import PendingUse, Resource
from planner.tokens.timeline import Timeline, may_codesignate
from planner.tokens.token import Role, Token, TokenState
from planner.trail import Trail


class TokenNetworkManager:
    """The partial plan: tokens, the timelines that they lie on, and what the model asks of them.

    Every change is trailed. `open` are the inactive tokens, `undecided` the variables that a complete
    plan must bind in order of creation, `settled` those that had one value from the start, `alternatives` those that
    choose between the alternatives of a rule of a token that the problem states, `coverages` what constraint tokens
    make of value tokens: the order of a search never depends on what was undone before. `by_path` are the
    tokens by their paths and `variables` the variables that rules have of their own; of two with one name, the first.
    """

    def __init__(self, model: ModelManager, network: ConstraintNetworkManager, trail: Trail) -> None:
        self.model = model
        self.network = network
        self.trail = trail
        self.names: dict[str, Named] = {}
        self.tokens: list[Token] = []
        self.by_path: dict[TokenPath, Token] = {}
        self._forms: dict[tuple[str, str], Form] = {}
        self.variables: dict[str, Variable] = {}
        self._named: list[Variable] = []
        self.open = OpenTokens(network, trail)
        self.undecided: list[Variable] = []
        self.settled: dict[int, Variable] = {}
        self.readings: dict[int, list[RuleInstance]] = {}
        self.alternatives: list[Variable] = []
        self.guards: list[GuardInstance] = []
        self.coverages: list[Coverage] = []
        self._fired = 0
        self.timelines: dict[tuple[ModelObject, str], Timeline] = {}
        self.resources: dict[ModelObject, Resource] = {}
        self._decided = 0
        self._unordered: dict[str, list[Token]] = {}
        self._constants: dict[tuple[type, Any], Variable] = {}
        self._members: dict[tuple[ModelObject, str], Named] = {}
        self._make_timelines()

    def _make_timelines(self) -> None:
        for thing in self.model.objects.values():
            for attribute in self.model.attributes_of(thing.cls).values():
                if attribute.kind == "timeline":
                    key = (thing, attribute.name)
                    self.timelines[key] = Timeline(thing, attribute.name, self.network.temporal)
                elif attribute.kind in ("reusable", "reservoir"):
                    self.resources[thing] = Resource(thing, self.model, self.network, self.trail)

    # Tokens come and go

    def create(
        self, predicate: tuple[str, str], path: TokenPath, role: Role, owner: Owner, master: Token | None = None
    ) -> Token:
        """A new inactive token of `(class, predicate)` with its parameter constraints."""
        form = self._forms.get(predicate) or self._form(predicate)
        token = self.enter(form, path, role, owner, master)
        instance = RuleInstance(form.label, token)
        self.network.distance(token.start, token.end, form.duration.lower, form.duration.upper, instance)
        self.carry_out(form.predicate.body, instance)
        return token

    def enter(self, form: Form, path: TokenPath, role: Role, owner: Owner, master: Token | None) -> Token:
        """A new inactive token, with nothing said of it yet."""
        token = Token(self.network, self.tokens[-1].id + 1 if self.tokens else 0, path, form, role, owner, master)
        self.trail.append(self.tokens, token)
        if path not in self.by_path:
            self.trail.add(self.by_path, path, token)
        self.open.add(token)
        return token

    def _form(self, predicate: tuple[str, str]) -> Form:
        form = form_of(self.model, *predicate)
        if form.is_settled:
            self._forms[predicate] = form
        return form

    def insert(self, token: Token, position: int, owner: Owner) -> None:
        """Put an inactive token into the empty slot at a position of its timeline; its object must be decided."""
        timeline = self.timeline_of(token)
        sequence = timeline.sequence
        if position > 0:
            self.network.distance(sequence[position - 1].end, token.start, 0, math.inf, owner)
        if position < len(sequence):
            self.network.distance(token.end, sequence[position].start, 0, math.inf, owner)
        sequence.insert(position, token)
        self.trail.call(sequence.pop, position)
        self.open.moved((timeline.object, timeline.attribute))
        self.trail.assign(token, "placed_by", owner)
        self._activate(token)
        for limit in timeline.limits:
            cover(self, limit, token)

    def activate(self, token: Token, owner: Owner) -> None:
        """Make a token without a slot of its own active: a transaction on a resource, a value of an attribute without
        order, or a constraint token, which lies over a timeline."""
        if token.kind == "constraint":
            self._confine(token, owner)
            return
        if token.kind in ("reusable", "reservoir"):
            self.resources[token.thing].add(token)
        else:
            self.trail.append(self._unordered_of(token), token)
        self.trail.assign(token, "placed_by", owner)
        self._activate(token)

    def _confine(self, limit: Token, owner: Owner) -> None:
        timeline = self.timeline_of(limit)
        self.trail.append(timeline.limits, limit)
        self.trail.assign(limit, "placed_by", owner)
        self.trail.assign(limit, "state", TokenState.ACTIVE)
        self.open.close(limit)
        for token in timeline.sequence:
            cover(self, limit, token)

    def merge(self, token: Token, host: Token, owner: Owner) -> None:
        """Codesignate an inactive token with an active one: equality of all their variables, owned by `owner`."""
        self.network.distance(token.start, host.start, 0, 0, owner)
        self.network.distance(token.end, host.end, 0, 0, owner)
        self.require("eq", (token.object, host.object), owner)
        for name, variable in token.parameters.items():
            self.require("eq", (variable, host.parameters[name]), owner)
        self.trail.assign(token, "state", TokenState.MERGED)
        self.trail.assign(token, "host", host)
        self.open.close(token)

    def reject(self, token: Token) -> None:
        """Leave a rejectable token out."""
        self.trail.assign(token, "state", TokenState.REJECTED)
        self.open.close(token)

    def _activate(self, token: Token) -> None:
        self.trail.assign(token, "state", TokenState.ACTIVE)
        self.open.close(token)
        for variable in token.parameters.values():
            self.must_be_decided(variable)
        if token.role == "fact":
            return
        cls = token.thing.cls
        for number, rule in enumerate(self.model.rules_for(cls, token.predicate.name)):
            label = rule.where or f"rule {number + 1} of {token.predicate.full_name}"
            instance = RuleInstance(label, token, path=f"{number + 1}:" if number else "")
            self.trail.append(token.rules, instance)
            self.carry_out(rule.body, instance)

    @property
    def open_tokens(self) -> dict[int, Token]:
        """The inactive tokens by number, in order of creation."""
        return self.open.all()

    def named(self, name: str) -> Token | None:
        """The token whose path has this text."""
        return self.by_path.get(TokenPath.of(name))

    # Where a token may go

    def timeline_of(self, token: Token) -> Timeline:
        """The timeline of a token whose object is decided."""
        return self.timelines[token.thing, token.predicate.attribute]

    def openings(self, token: Token) -> tuple[list[Token], list[tuple[ModelObject, int]]]:
        """Where the token could go as far as bounds can tell: hosts, and empty slots as timeline and position."""
        if token.kind != "timeline":
            return list(self.hosts(token)), []
        hosts: list[Token] = []
        places: list[tuple[ModelObject, int]] = []
        for timeline in self._timelines_for(token):
            found, slots = timeline.openings(token)
            hosts += found
            places += [(timeline.object, position) for position in slots]
        return hosts, places

    def fitting(self, token: Token) -> tuple[Iterable[Token], Iterable[tuple[ModelObject, int]]]:
        """Those of its `openings` that constraints with what is near leave it too. At the propagated fixpoint only."""
        if token.kind != "timeline":
            return self.openings(token)
        found = [(timeline.object, *timeline.fitting(token)) for timeline in self._timelines_for(token)]
        hosts = (host for _, some, _ in found for host in some)
        return hosts, ((thing, position) for thing, _, slots in found for position in slots)

    def hosts(self, token: Token) -> Iterator[Token]:
        """The active tokens that this one could be codesignated with, found as they are asked for."""
        if token.kind == "timeline":
            for timeline in self._timelines_for(token):
                yield from timeline.hosts(token)
        elif token.kind == "unordered":
            yield from (host for host in self._unordered_of(token) if may_codesignate(token, host))

    def places(self, token: Token) -> Iterator[tuple[ModelObject, int]]:
        """The empty slots of timelines that it could take, as object and position, found as they are asked for."""
        if token.kind == "timeline":
            for timeline in self._timelines_for(token):
                yield from ((timeline.object, position) for position in timeline.slots(token))

    def _timelines_for(self, token: Token) -> list[Timeline]:
        attribute = token.predicate.attribute
        return [self.timelines[thing, attribute] for thing in objects_in(token.object.domain)]

    def _unordered_of(self, token: Token) -> list[Token]:
        return self._unordered.setdefault(token.predicate.full_name, [])

    # Services to rule instances

    def carry_out(self, statements: Sequence[Statement], instance: RuleInstance) -> None:
        """Carry out a body for an instance, and note what it makes."""
        if statements:
            before = self.measure()
            carry_out(self, statements, instance)
            instance.extent = self.extent_since(before)

    def measure(self) -> tuple[int, int, int, int]:
        """How much there is, for `extent_since`."""
        return self.network.posted, len(self.network.propagators), len(self.tokens), len(self._named)

    def extent_since(self, before: tuple[int, int, int, int]) -> Extent:
        """What came after `measure`."""
        edges, propagators, tokens, named = self.measure()
        return Extent(
            range(before[0], edges),
            range(before[1], propagators),
            tuple(self.tokens[before[2] : tokens]),
            tuple(self._named[before[3] : named]),
        )

    def require(self, name: str, scope: Sequence[AnyVariable], owner: Owner) -> None:
        """Post the constraint of that name: as a temporal one where it is, else by its procedure."""
        procedure = self.model.procedures.get(name)
        procedure.check_scope(len(scope))
        if name == USES.name:
            self.network.watch(PendingUse(self.resources, scope, owner, self.trail))
        elif not post_temporal(self.network, name, scope, owner):
            self.network.post(procedure, tuple(scope), owner)

    def name_variable(self, variable: Variable) -> None:
        """Let a variable that a rule has of its own be found by its name."""
        self.trail.append(self._named, variable)
        name = variable.name
        if name not in self.variables:
            self.trail.add(self.variables, name, variable)

    def note_reading(self, variable: Variable, instance: RuleInstance) -> None:
        """What an instance makes depends on the domain that a variable has now."""
        if id(variable) not in self.readings:
            self.trail.add(self.readings, id(variable), [])
        self.trail.append(self.readings[id(variable)], instance)

    def must_be_decided(self, variable: Variable) -> None:
        """Note a variable that a complete plan must bind."""
        domain = variable.domain
        if domain.is_singleton and not domain.is_open:
            self.trail.add(self.settled, id(variable), variable)
        else:
            self.trail.append(self.undecided, variable)

    def still_undecided(self) -> Iterator[Variable]:
        """The variables that a complete plan must bind and that have several values left, in order of creation."""
        undecided = self.undecided
        first = self._decided
        while first < len(undecided) and undecided[first].domain.is_singleton:
            first += 1
        if first > self._decided:
            self.trail.assign(self, "_decided", first)
        for index in range(first, len(undecided)):
            variable = undecided[index]
            if not variable.domain.is_singleton:
                yield variable

    def waiting_guards(self) -> Iterator[GuardInstance]:
        """The guards of rules whose test is not decided, in order of creation."""
        guards = self.guards
        first = self._fired
        while first < len(guards) and guards[first].fired:
            first += 1
        if first > self._fired:
            self.trail.assign(self, "_fired", first)
        return (guard for guard in guards[first:] if not guard.fired)

    def slots_under(self, limit: Token) -> list[Token]:
        """The hosts of the slots in a row that a constraint token may lie over or touch, as far as bounds can tell."""
        timeline = self.timeline_of(limit)
        first, last = timeline.window(limit)
        return timeline.sequence[first:last]

    def open_coverages(self) -> Iterator[Coverage]:
        """The pairs of a constraint token and a value token on which it still depends where they are to each other."""
        return (coverage for coverage in self.coverages if not coverage.is_settled)

    def constant(self, value: Any) -> Variable:
        """A variable that has a value for ever."""
        key = (type(value), value)  # 1, 1.0 and True are equal to a dictionary
        if key not in self._constants:
            domain = self.domain_of_object(value) if isinstance(value, ModelObject) else singleton(value)
            self._constants[key] = self.network.variable(str(value), domain, None)
        return self._constants[key]

    def domain_of_object(self, thing: ModelObject) -> Domain:
        """The domain that holds one object."""
        return self.model.objects_of("Object").keep((thing,))

    def member_of(self, thing: ModelObject, name: str) -> Named:
        """A member of an object: an object, or a variable."""
        key = (thing, name)
        if key not in self._members:
            known = self.model.members_of(thing.cls)
            if name not in known:
                raise ModelError(f"object {thing} of class {thing.cls} has no member {name!r}")
            value = thing.members.get(name, self.model.domain_of(known[name]))
            if isinstance(value, ModelObject):
                self._members[key] = value
            elif isinstance(value, Interval | Values):
                self._members[key] = self.network.variable(f"{thing}.{name}", value, None)
            else:
                self._members[key] = self.constant(value)
        return self._members[key]

    def open_members(self) -> Iterator[tuple[ModelObject, str, Variable]]:
        """The members that objects leave open, as far as somebody asked for them."""
        for (thing, name), found in self._members.items():
            given = thing.members.get(name)
            if isinstance(found, Variable) and (given is None or isinstance(given, Interval | Values)):
                yield thing, name, found

    def member_of_any(self, of: Variable, objects: Sequence[ModelObject], name: str, owner: Owner) -> Variable:
        """A variable that equals the member of whichever object `of` turns out to be."""
        members = {thing: self._member_variable(thing, name) for thing in objects}
        table = {thing: variable.domain for thing, variable in members.items()}
        merged = _union(list(table.values()))
        result = self.network.variable(f"{of.name}.{name}", merged, owner)
        self.network.post(element_of(table), (of, result), owner)
        return result

    def _member_variable(self, thing: ModelObject, name: str) -> AnyVariable:
        found = self.member_of(thing, name)
        if isinstance(found, ModelObject):
            return self.constant(found)
        assert not isinstance(found, Token)
        return found

    def result_domain(self, procedure: str) -> Domain:
        """The domain that a function's result starts from."""
        boolean = procedure.startswith("test")
        return self.model.domain_of("bool" if boolean else "float")


def _union(domains: Sequence[Domain]) -> Domain:
    """The smallest domain that holds all of these."""
    if all(d.is_numeric for d in domains):
        whole = all(isinstance(d, Interval) and d.integer for d in domains)
        return Interval(min(d.lower for d in domains), max(d.upper for d in domains), whole)
    finite = [d for d in domains if isinstance(d, Values)]
    if len({id(d.universe) for d in finite}) == 1:
        return Values(finite[0].universe, reduce(or_, (d.bits for d in finite)))
    return Universe("member", (v for d in domains for v in d.values())).domain()


def element_of(table: dict[ModelObject, Domain]) -> ConstraintProcedure:
    """The relation between an object and the value of one of its members."""

    def narrow(domains: Sequence[Domain]) -> Sequence[Domain] | None:
        """table[object] = value."""
        objects, value = domains
        left = [o for o in objects_in(objects) if not table[o].intersect(value).is_empty]
        if not left:
            return None
        assert isinstance(objects, Values)
        return objects.keep(left), value.intersect(_union([table[o] for o in left]))

    return ConstraintProcedure("member", narrow, 2, 2)
