"""ModelManager (paper, section 4): the input interface for a domain model, and the answers about it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from typing import Any

from planner.constraints.procedure import ProcedureRegistry
from planner.domains import BOOLEAN, Domain, Interval, Universe, Values
from planner.errors import ModelError, nearest
from planner.model.applicable import AttributeValue, ConfigurationConstraint, constraints_on
from planner.model.classes import Attribute, Kind, ModelClass, ModelObject, Parameter, Predicate, Type
from planner.model.ground import Grounding
from planner.model.relations import distances
from planner.model.resources import USES, add_resource_predicates, resource_classes
from planner.model.rules import (
    AllowedValue,
    Confine,
    ForEach,
    Guard,
    OneOf,
    Ref,
    Relate,
    Require,
    Rule,
    Statement,
    Subgoal,
)
from planner.model.transitions import TransitionGraph

BASIC: dict[str, Domain] = {
    "int": Interval(-math.inf, math.inf),
    "float": Interval(-math.inf, math.inf, integer=False),
    "bool": BOOLEAN.domain(),
}
# The attribute that a timeline class has when it names none, as in NDDL, where class and attribute are one.
STATE = "state"
SAME_OBJECT = Ref(("object",))
"""The target of a subgoal that the token's own object must have."""


class ModelManager:
    """A domain model: filled by a front end through `add_...`, then asked by the planner.

    Every `add_...` raises ModelError when a name is taken or unknown, with the nearest names that exist. `variables`:
    the types of a problem's own variables, which rules may speak of.
    """

    def __init__(self, name: str, procedures: ProcedureRegistry) -> None:
        self.name = name
        self.procedures = procedures.with_procedures(USES)
        self.enumerations: dict[str, Universe] = {}
        self.strings = Universe("string", (), is_open=True)
        self.objects: dict[str, ModelObject] = {}
        self.variables: dict[str, Type] = {}
        self._object_universe = Universe("object", (), is_open=True)
        self._classes: dict[str, ModelClass] = {}
        self._aliases: dict[str, Domain] = {}
        self._rules: dict[tuple[str, str], tuple[Rule, ...]] = {}
        self._transitions: dict[tuple[str, str], TransitionGraph] = {}
        self._instances: dict[str, Values] = {}
        for built_in in (ModelClass("Object", None), ModelClass("Timeline", "Object"), *resource_classes()):
            self._classes[built_in.name] = built_in
        self._classes["Timeline"].attributes[STATE] = Attribute(STATE)
        add_resource_predicates(self)

    # Input

    def add_enumeration(self, name: str, values: Iterable[Any]) -> Universe:
        """Name a finite set of values: labels or numbers."""
        self._check_free(name, "type")
        self.enumerations[name] = Universe(name, values)
        return self.enumerations[name]

    def add_type(self, name: str, domain: Domain) -> None:
        """Name a domain."""
        self._check_free(name, "type")
        self._aliases[name] = domain

    def add_class(self, name: str, parent: str = "Object", members: Mapping[str, Type] | None = None) -> None:
        """Add a class under a parent, with members of these types besides the inherited ones."""
        self._check_free(name, "class")
        self.class_named(parent)
        self._classes[name] = ModelClass(name, parent, members=dict(members or {}))

    def add_attribute(self, cls: str, name: str, kind: Kind = "timeline") -> None:
        """Add an attribute: one timeline (or resource) for each object of the class."""
        attributes = self.class_named(cls).attributes
        if name in attributes:
            raise ModelError(f"class {cls}: attribute {name!r} is declared twice")
        attributes[name] = Attribute(name, kind)

    def add_predicate(
        self,
        cls: str,
        name: str,
        parameters: Sequence[Parameter] = (),
        *,
        attribute: str = STATE,
        body: Sequence[Statement] = (),
        duration: tuple[float, float] = (1, math.inf),
        contingent: bool = False,
        exogenous: bool = False,
        solitary: bool = False,
    ) -> Predicate:
        """Add a value pattern to an attribute of a class (an attribute not declared is an unordered one)."""
        owner = self.class_named(cls)
        if name in owner.predicates:
            raise ModelError(f"class {cls}: predicate {name!r} is declared twice")
        for parameter in parameters:
            self.domain_of(parameter.type)
        if not 0 <= duration[0] <= duration[1]:
            raise ModelError(f"{cls}.{name}: expected a duration of 0 <= minimum <= maximum, found {duration}")
        if contingent and math.isinf(duration[1]):
            raise ModelError(f"{cls}.{name}: a contingent duration needs a finite maximum")
        owner.predicates[name] = Predicate(
            cls, name, attribute, tuple(parameters), tuple(body), duration, contingent, exogenous, solitary
        )
        return owner.predicates[name]

    def add_rule(self, rule: Rule) -> None:
        """Add a configuration constraint schema; a predicate may have several, and inherits its parents'."""
        cls, predicate = rule.owner
        self.predicate(cls, predicate)
        self.class_named(cls).rules.setdefault(predicate, []).append(rule)
        self._rules.clear()
        self._transitions.clear()

    def constrain_parameters(self, cls: str, name: str, body: Sequence[Statement]) -> None:
        """Add parameter constraints to a predicate of this class: they hold for every token of it, active or not."""
        declared = self.class_named(cls).predicates.get(name)
        if declared is None:
            raise ModelError(f"class {cls} declares no predicate named {name!r}")
        self.class_named(cls).predicates[name] = replace(declared, body=(*declared.body, *body))

    def add_object(
        self, name: str, cls: str, members: Mapping[str, Any] | None = None, parent: ModelObject | None = None
    ) -> ModelObject:
        """Add an instance of a class, with values for its members. `parent`: the object that it is part of."""
        self.class_named(cls)
        if name in self.objects:
            raise ModelError(f"object {name!r} is declared twice")
        known = self.members_of(cls)
        for member in members or {}:
            if member not in known:
                raise ModelError(f"object {name}: class {cls} has no member {member!r}{nearest(member, known)}")
        self.objects[name] = ModelObject(name, cls, dict(members or {}), parent)
        self._object_universe.add(self.objects[name])
        self._instances.clear()
        return self.objects[name]

    def add_variable(self, name: str, type_: Type) -> None:
        """Declare a variable of the problem that rules may name, with the values from which a plan chooses."""
        self.domain_of(type_)
        self.variables[name] = type_

    def set_member(self, thing: ModelObject, member: str, value: Any) -> None:
        """Give a member of an object its value, before the creation of objects ends."""
        known = self.members_of(thing.cls)
        if member not in known:
            raise ModelError(f"object {thing}: class {thing.cls} has no member {member!r}{nearest(member, known)}")
        if self.is_closed:
            raise ModelError(f"object {thing}: member {member!r} is set after the creation of objects has ended")
        self.objects[thing.name].members[member] = value

    def close(self) -> None:
        """End the creation of objects: from here on object variables range over those there are.

        ModelError when a rule names a predicate, relation or constraint procedure that does not exist.
        """
        for found in self._classes.values():
            for rule in (r for rules in found.rules.values() for r in rules):
                self._check_statements(rule.body, rule.where or f"a rule of {found.name}")
            for declared in found.predicates.values():
                self._check_statements(declared.body, f"predicate {declared.full_name}")
        self._object_universe.is_open = False

    @property
    def is_closed(self) -> bool:
        """Whether the creation of objects has ended."""
        return not self._object_universe.is_open

    # Information

    def class_named(self, name: str) -> ModelClass:
        """The class of that name."""
        try:
            return self._classes[name]
        except KeyError:
            raise ModelError(f"there is no class named {name!r}{nearest(name, self._classes)}") from None

    def classes(self) -> Iterator[ModelClass]:
        """All classes in order of declaration, the built-in ones first."""
        return iter(self._classes.values())

    def lineage(self, cls: str) -> Iterator[ModelClass]:
        """The class, its parent, and so on up."""
        name: str | None = cls
        while name is not None:
            found = self.class_named(name)
            yield found
            name = found.parent

    def is_subclass(self, cls: str, ancestor: str) -> bool:
        """Whether the class is the ancestor or below it."""
        return any(c.name == ancestor for c in self.lineage(cls))

    def members_of(self, cls: str) -> dict[str, Type]:
        """Members with their types, inherited ones included."""
        members: dict[str, Type] = {}
        for found in self.lineage(cls):
            members = found.members | members
        return members

    def attributes_of(self, cls: str) -> dict[str, Attribute]:
        """Attributes by name, inherited ones included."""
        attributes: dict[str, Attribute] = {}
        for found in self.lineage(cls):
            attributes = found.attributes | attributes
        return attributes

    def predicates_of(self, cls: str) -> dict[str, Predicate]:
        """Predicates by name, inherited ones included."""
        predicates: dict[str, Predicate] = {}
        for found in self.lineage(cls):
            predicates = found.predicates | predicates
        return predicates

    def predicate(self, cls: str, name: str) -> Predicate:
        """A predicate of the class or of one it inherits from."""
        for found in self.lineage(cls):
            if name in found.predicates:
                return found.predicates[name]
        known = self.predicates_of(cls)
        raise ModelError(f"class {cls} has no predicate named {name!r}{nearest(name, known)}")

    def predicate_named(self, full_name: str) -> Predicate:
        """The predicate of a name `Class.predicate`."""
        cls, dot, name = full_name.partition(".")
        if not dot:
            raise ModelError(f"expected a predicate as Class.predicate, found {full_name!r}")
        return self.predicate(cls, name)

    def kind_of(self, predicate: Predicate) -> Kind:
        """What tokens of the predicate's attribute mean to each other."""
        attribute = self.attributes_of(predicate.cls).get(predicate.attribute)
        return attribute.kind if attribute else "unordered"

    def rules_for(self, cls: str, predicate: str) -> tuple[Rule, ...]:
        """The configuration constraint schemata of a predicate as tokens of this class have it, inherited ones last.

        What an inherited one asks of the same object is the object's own predicate, where its class declares it again.
        """
        key = (cls, predicate)
        if key not in self._rules:
            own = tuple(self.class_named(cls).rules.get(predicate, ()))
            above = (r for c in islice(self.lineage(cls), 1, None) for r in c.rules.get(predicate, ()))
            self._rules[key] = (*own, *(replace(r, body=self._own(r.body, cls)) for r in above))
        return self._rules[key]

    def _own(self, body: Sequence[Statement], cls: str) -> tuple[Statement, ...]:
        """A body as an object of the class has it."""
        return tuple(self._own_statement(statement, cls) for statement in body)

    def _own_statement(self, statement: Statement, cls: str) -> Statement:
        if isinstance(statement, Subgoal) and statement.target == SAME_OBJECT:
            mine = cls, statement.predicate[1]
            again = self.predicate(*mine) is not self.predicate(*statement.predicate)
            return replace(statement, predicate=mine) if again else statement
        if isinstance(statement, Guard):
            then, otherwise = self._own(statement.then, cls), self._own(statement.otherwise, cls)
            return replace(statement, then=then, otherwise=otherwise)
        if isinstance(statement, ForEach):
            return replace(statement, body=self._own(statement.body, cls))
        if isinstance(statement, OneOf):
            return replace(statement, branches=tuple(self._own(branch, cls) for branch in statement.branches))
        return statement

    def transitions_of(self, cls: str, attribute: str) -> TransitionGraph:
        """How soon the values of an attribute can follow one another, as objects of this class have it."""
        key = (cls, attribute)
        if key not in self._transitions:
            self._transitions[key] = TransitionGraph(Grounding(self, cls, attribute), self.transitions_of)
        return self._transitions[key]

    def applicable(self, values: Iterable[tuple[str, str]]) -> frozenset[Rule]:
        """The schemata that apply while attributes have values of these predicates, each given as (class, name)."""
        return frozenset(rule for cls, name in values for rule in self.rules_for(cls, name))

    def changes(
        self, before: Iterable[tuple[str, str]], after: Iterable[tuple[str, str]]
    ) -> tuple[frozenset[Rule], frozenset[Rule]]:
        """The schemata that come to apply, and those that cease to, between two sets of attribute values."""
        old, new = self.applicable(before), self.applicable(after)
        return new - old, old - new

    def constraints_on(self, values: Iterable[AttributeValue]) -> frozenset[ConfigurationConstraint]:
        """The configuration constraints that apply while attributes have these values, instantiated: guards that the
        parameters decide are replaced by what they chose."""
        return constraints_on(self, values)

    def constraint_changes(
        self, before: Iterable[AttributeValue], after: Iterable[AttributeValue]
    ) -> tuple[frozenset[ConfigurationConstraint], frozenset[ConfigurationConstraint]]:
        """The configuration constraints that come to apply, and those that cease to, between two sets of values."""
        old, new = self.constraints_on(before), self.constraints_on(after)
        return new - old, old - new

    def objects_of(self, cls: str) -> Values:
        """The instances of a class and of those below it, as a domain."""
        if cls not in self._instances:
            self.class_named(cls)
            instances = (o for o in self.objects.values() if self.is_subclass(o.cls, cls))
            self._instances[cls] = self._object_universe.domain(instances)
        return self._instances[cls]

    def object_named(self, name: str) -> ModelObject:
        """The object of that name."""
        try:
            return self.objects[name]
        except KeyError:
            raise ModelError(f"there is no object named {name!r}{nearest(name, self.objects)}") from None

    def domain_of(self, type_: Type) -> Domain:
        """The domain of a type, by name or as it stands."""
        if not isinstance(type_, str):
            return type_
        if type_ in BASIC:
            return BASIC[type_]
        if type_ == "string":
            return self.strings.domain()
        if type_ in self.enumerations:
            return self.enumerations[type_].domain()
        if type_ in self._aliases:
            return self._aliases[type_]
        if type_ in self._classes:
            return self.objects_of(type_)
        known = [*BASIC, "string", *self.enumerations, *self._aliases, *self._classes]
        raise ModelError(f"there is no type named {type_!r}{nearest(type_, known)}")

    def check_allowed(self, attribute: tuple[str, str], values: Sequence[AllowedValue]) -> None:
        """ModelError unless a constraint token on an attribute, (class, name), may have these values, each predicate
        once."""
        cls, name = attribute
        known = self.attributes_of(cls)
        if name not in known or known[name].kind != "timeline":
            timelines = [n for n, found in known.items() if found.kind == "timeline"]
            raise ModelError(f"class {cls} has no timeline named {name!r}{nearest(name, timelines)}")
        seen = set()
        for value in values:
            declared = self.predicate(*value.predicate)
            related = self.is_subclass(cls, declared.cls) or self.is_subclass(declared.cls, cls)
            if declared.attribute != name or not related:
                raise ModelError(f"{declared.full_name} is no value of the attribute {cls}.{name}")
            if declared.full_name in seen:
                raise ModelError(f"{declared.full_name} is given twice: expected each predicate once")
            seen.add(declared.full_name)
            parameters = [p.name for p in declared.parameters]
            for parameter, _ in value.parameters:
                if parameter not in parameters:
                    hint = nearest(parameter, parameters)
                    raise ModelError(f"{declared.full_name} has no parameter {parameter!r}{hint}")

    def _check_statements(self, statements: Sequence[Statement], where: str) -> None:
        for statement in statements:
            try:
                if isinstance(statement, Subgoal):
                    self.predicate(*statement.predicate)
                elif isinstance(statement, Confine):
                    self.check_allowed(statement.attribute, statement.values)
                if isinstance(statement, Subgoal | Confine | Relate):
                    distances(statement.relation, statement.bounds)
                elif isinstance(statement, Require):
                    self.procedures.get(statement.procedure).check_scope(len(statement.arguments))
                elif isinstance(statement, Guard):
                    self.procedures.get(statement.test).check_scope(len(statement.arguments))
            except ModelError as error:
                raise ModelError(f"{where}: {error}") from None
            if isinstance(statement, Guard):
                self._check_statements((*statement.then, *statement.otherwise), where)
            elif isinstance(statement, ForEach):
                self._check_statements(statement.body, where)
            elif isinstance(statement, OneOf):
                self._check_statements([s for branch in statement.branches for s in branch], where)

    def _check_free(self, name: str, what: str) -> None:
        if name in BASIC or name in self.enumerations or name in self._aliases or name in self._classes:
            raise ModelError(f"{what} {name!r}: the name is already taken")
