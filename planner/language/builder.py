"""The Python builder: a domain model written as it reads.

    model = ModelBuilder("camera and engine", STANDARD)
    asteroid = model.enumeration("Asteroid", ["Gaspra", "Ida"])
    engine, camera, attitude = (model.timeline(name) for name in ("Engine", "Camera", "Attitude"))
    off, idle = engine.predicate("off"), engine.predicate("idle")
    ready = camera.predicate("ready")
    picture = camera.predicate("picture", {"asteroid": asteroid})
    point_at = attitude.predicate("pointAt", {"asteroid": asteroid})

    with picture.requires() as this:                                    # the paper's Figure 2
        this.contained_by(off)
        this.contained_by(point_at, asteroid=this.asteroid)
        this.before(ready, bounds=(0, 0))
        this.after(ready, bounds=(0, 0))
        this.throughout(off, idle)                   # a constraint token: other values too, and changes among them

Everything here only calls `ModelManager.add_...`, so this is also the documentation of that interface by example. The
finished model answers questions:

    manager = model.finish()
    [c.name for c in manager.lineage("Camera")]                         # Camera, Timeline, Object
    manager.attributes_of("Camera"), manager.predicates_of("Camera"), manager.objects_of("Timeline")
    ida, gaspra = (AttributeValue.of("Camera.picture", asteroid=name) for name in ("Ida", "Gaspra"))
    manager.constraints_on([ida])                                       # what its rules ask for
    come, go = manager.constraint_changes(before=[ida], after=[gaspra, AttributeValue.of("Engine.off")])
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from planner.constraints.procedure import ProcedureRegistry
from planner.domains import Domain, Interval, Universe
from planner.errors import ModelError, nearest
from planner.language.terms import Operand, Term, Test, expression_of
from planner.model.classes import ModelObject, Parameter, Type
from planner.model.manager import STATE, ModelManager
from planner.model.relations import distances
from planner.model.rules import (
    AllowedValue,
    Confine,
    Constant,
    Guard,
    Local,
    OneOf,
    Ref,
    Relate,
    Require,
    Rule,
    Statement,
    Subgoal,
)

Bounds = tuple[float, float]


class ModelBuilder:
    """Builds one model. `procedures`: the constraint procedures that its rules may name."""

    def __init__(self, name: str, procedures: ProcedureRegistry) -> None:
        self.manager = ModelManager(name, procedures)

    def enumeration(self, name: str, values: Iterable[Any]) -> str:
        """Name a finite set of labels or numbers, in the order in which a search should try them."""
        self.manager.add_enumeration(name, values)
        return name

    def timeline(self, name: str, members: Mapping[str, Type] | None = None) -> ClassBuilder:
        """A class whose objects have one attribute, called `state`."""
        self.manager.add_class(name, "Timeline", members)
        return ClassBuilder(self, name)

    def component(
        self, name: str, attributes: Sequence[str], members: Mapping[str, Type] | None = None
    ) -> ClassBuilder:
        """A class whose objects have several attributes."""
        self.manager.add_class(name, "Object", members)
        for attribute in attributes:
            self.manager.add_attribute(name, attribute)
        return ClassBuilder(self, name)

    def object(self, name: str, cls: str, members: Mapping[str, Any] | None = None) -> ModelObject:
        """An instance of a class."""
        return self.manager.add_object(name, cls, members)

    def finish(self) -> ModelManager:
        """The model, closed to new objects."""
        self.manager.close()
        return self.manager


class ClassBuilder:
    """A model class under construction."""

    def __init__(self, builder: ModelBuilder, name: str) -> None:
        self._builder = builder
        self.name = name

    def predicate(
        self,
        name: str,
        parameters: Mapping[str, Type] | None = None,
        *,
        attribute: str = STATE,
        duration: Bounds = (1, math.inf),
        contingent: bool = False,
        exogenous: bool = False,
    ) -> PredicateBuilder:
        """A value that the attribute may have. `contingent`: nature decides the duration within its bounds.
        `exogenous`: no plan brings it about."""
        listed = tuple(Parameter(n, t) for n, t in (parameters or {}).items())
        self._builder.manager.add_predicate(
            self.name,
            name,
            listed,
            attribute=attribute,
            duration=duration,
            contingent=contingent,
            exogenous=exogenous,
        )
        return PredicateBuilder(self._builder.manager, self.name, name)

    def predicate_of(self, cls: str, name: str) -> PredicateBuilder:
        """A predicate of another class, to be declared by the time that the model is finished."""
        return PredicateBuilder(self._builder.manager, cls, name)


class PredicateBuilder:
    """A predicate, by which rules refer to it and which rules are stated for."""

    def __init__(self, manager: ModelManager, cls: str, name: str, target: Ref | None = None) -> None:
        self._manager = manager
        self.cls = cls
        self.name = name
        self.target = target

    def __repr__(self) -> str:
        return f"{self.cls}.{self.name}"

    def of(self, thing: ModelObject | str) -> PredicateBuilder:
        """The predicate of one object, or of the one that the rule's object has as the member of that name."""
        path = ("object", thing) if isinstance(thing, str) else (thing.name,)
        return PredicateBuilder(self._manager, self.cls, self.name, Ref(path))

    def where(self, **values: Operand | Iterable[Any]) -> AllowedBuilder:
        """The predicate as one of the values of a constraint token, with parameters that equal a term or a value, or
        are among some values."""
        return AllowedBuilder(self, values)

    @contextmanager
    def requires(self, where: str = "") -> Iterator[RuleBuilder]:
        """State a configuration constraint: what must hold whenever this is the attribute's value."""
        statements: list[Statement] = []
        yield RuleBuilder(self._manager, self, statements, "")
        label = where or f"configuration constraint of {self!r}"
        self._manager.add_rule(Rule((self.cls, self.name), tuple(statements), label))

    @contextmanager
    def parameters_satisfy(self) -> Iterator[RuleBuilder]:
        """State parameter constraints: what holds of the parameters and times of every token, required or planned."""
        statements: list[Statement] = []
        yield RuleBuilder(self._manager, self, statements, "")
        self._manager.constrain_parameters(self.cls, self.name, statements)


class RuleBuilder:
    """The statements of one rule, or of a branch of it. Parameters and times of the token are its attributes."""

    def __init__(
        self, manager: ModelManager, predicate: PredicateBuilder, statements: list[Statement], prefix: str
    ) -> None:
        self._manager = manager
        self._predicate = predicate
        self._statements = statements
        self._prefix = prefix

    def __getattr__(self, name: str) -> Term:
        return Term(Ref((_checked(self._manager, self._predicate, name),)))

    def relation(
        self, relation: str, target: PredicateBuilder, /, bounds: Bounds | Sequence[Bounds] = (), **equal: Operand
    ) -> TokenBuilder:
        """A token of the target predicate stands in a temporal relation to this one; parameters equal those given."""
        name = f"{self._prefix}{target.name}{len(self._statements)}"
        pairs = _pairs(bounds)
        distances(relation, pairs)  # says now, rather than when the model is finished, what is wrong with them
        self._statements.append(Subgoal(relation, (target.cls, target.name), name, target.target, pairs))
        token = TokenBuilder(self._manager, target, name)
        for parameter, value in equal.items():
            self.require(getattr(token, parameter) == value)
        return token

    def meets(self, target: PredicateBuilder, /, **equal: Operand) -> TokenBuilder:
        """The target begins at this token's end."""
        return self.relation("meets", target, (), **equal)

    def met_by(self, target: PredicateBuilder, /, **equal: Operand) -> TokenBuilder:
        """The target ends at this token's start."""
        return self.relation("met_by", target, (), **equal)

    def contained_by(self, target: PredicateBuilder, /, **equal: Operand) -> TokenBuilder:
        """The target lasts through all of this token."""
        return self.relation("contained_by", target, (), **equal)

    def contains(
        self, target: PredicateBuilder, /, bounds: Bounds | Sequence[Bounds] = (), **equal: Operand
    ) -> TokenBuilder:
        """The target lies within this token."""
        return self.relation("contains", target, bounds, **equal)

    def before(
        self, target: PredicateBuilder, /, bounds: Bounds | Sequence[Bounds] = (), **equal: Operand
    ) -> TokenBuilder:
        """This token ends before the target starts, within the bounds."""
        return self.relation("before", target, bounds, **equal)

    def after(
        self, target: PredicateBuilder, /, bounds: Bounds | Sequence[Bounds] = (), **equal: Operand
    ) -> TokenBuilder:
        """This token starts after the target ends, within the bounds."""
        return self.relation("after", target, bounds, **equal)

    def equals(self, target: PredicateBuilder, /, **equal: Operand) -> TokenBuilder:
        """The target starts and ends with this token."""
        return self.relation("equals", target, (), **equal)

    def constraint_token(
        self,
        relation: str,
        allowed: Sequence[PredicateBuilder | AllowedBuilder],
        bounds: Bounds | Sequence[Bounds] = (),
        *,
        attribute: str = "",
    ) -> ConstraintTokenBuilder:
        """Over an interval in a temporal relation to this token an attribute has only the allowed values, and may
        change among them. `attribute`: `"Class.attribute"`, needed only to allow no value at all."""
        values = tuple(_allowed(self._manager, a) for a in allowed)
        of = _attribute(self._manager, values, attribute)
        name = f"{self._prefix}{of[1]}{len(self._statements)}"
        pairs = _pairs(bounds)
        distances(relation, pairs)
        self._manager.check_allowed(of, values)
        targets = [a.predicate.target if isinstance(a, AllowedBuilder) else a.target for a in allowed]
        self._statements.append(Confine(relation, of, values, name, targets[0] if targets else None, pairs))
        return ConstraintTokenBuilder(name)

    def throughout(self, *allowed: PredicateBuilder | AllowedBuilder) -> ConstraintTokenBuilder:
        """As long as this lasts, an attribute has only the allowed values, and may change among them."""
        return self.constraint_token("equals", allowed)

    def relate(
        self,
        relation: str,
        origin: TokenBuilder | ConstraintTokenBuilder,
        target: TokenBuilder | ConstraintTokenBuilder,
        bounds: Bounds | Sequence[Bounds] = (),
    ) -> None:
        """A temporal relation between two tokens named here."""
        self._statements.append(Relate(relation, origin.name, target.name, _pairs(bounds)))

    def require(self, test: Test) -> None:
        """A relation between terms holds."""
        self._statements.append(Require(test.procedure, test.arguments))

    def constrain(self, procedure: str, *arguments: Operand) -> None:
        """The constraint procedure of that name holds over the arguments."""
        self._manager.procedures.get(procedure).check_scope(len(arguments))
        self._statements.append(Require(procedure, tuple(expression_of(a) for a in arguments)))

    def local(self, name: str, type_: str | Domain) -> Term:
        """A local variable; one of a class ranges over its instances: there is one such that ..."""
        self._statements.append(Local(name, type_))
        return Term(Ref((name,)))

    @contextmanager
    def when(self, test: Test) -> Iterator[RuleBuilder]:
        """What is stated inside applies once the test is decided true."""
        statements: list[Statement] = []
        yield RuleBuilder(self._manager, self._predicate, statements, f"{self._prefix}when{len(self._statements)}.")
        self._statements.append(Guard(test.procedure, test.arguments, tuple(statements)))

    @contextmanager
    def either(self) -> Iterator[AlternativesBuilder]:
        """At least one of the alternatives applies; which one, the search chooses, the first one first."""
        name = f"{self._prefix}either{len(self._statements)}"
        alternatives = AlternativesBuilder(self._manager, self._predicate, name)
        yield alternatives
        if not alternatives.branches:
            raise ModelError(f"either of {self._predicate!r}: expected at least one alternative")
        self._statements.append(OneOf(name, tuple(map(tuple, alternatives.branches))))

    def relation_to_one_of(
        self, relation: str, targets: Sequence[PredicateBuilder], bounds: Bounds | Sequence[Bounds] = ()
    ) -> None:
        """A token of one of the targets stands in the relation to this one: a set of allowed values."""
        with self.either() as alternatives:
            for target in targets:
                with alternatives.alternative() as alternative:
                    alternative.relation(relation, target, bounds)


@dataclass(frozen=True, slots=True)
class AllowedBuilder:
    """A value of a constraint token, made by `PredicateBuilder.where`."""

    predicate: PredicateBuilder
    values: Mapping[str, Any]


class ConstraintTokenBuilder:
    """A constraint token named in a rule; its times and its object are its attributes."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.start, self.end, self.duration, self.object = (
            Term(Ref((name, which))) for which in ("start", "end", "duration", "object")
        )


class AlternativesBuilder:
    """The alternatives of an `either`."""

    def __init__(self, manager: ModelManager, predicate: PredicateBuilder, name: str) -> None:
        self._manager = manager
        self._predicate = predicate
        self._name = name
        self.branches: list[list[Statement]] = []

    @contextmanager
    def alternative(self) -> Iterator[RuleBuilder]:
        """What is stated inside is one alternative."""
        self.branches.append([])
        prefix = f"{self._name}.{len(self.branches)}."
        yield RuleBuilder(self._manager, self._predicate, self.branches[-1], prefix)


class TokenBuilder:
    """A token named in a rule; its parameters and times are its attributes."""

    def __init__(self, manager: ModelManager, predicate: PredicateBuilder, name: str) -> None:
        self._manager = manager
        self._predicate = predicate
        self.name = name

    def __getattr__(self, name: str) -> Term:
        return Term(Ref((self.name, _checked(self._manager, self._predicate, name))))


def _checked(manager: ModelManager, predicate: PredicateBuilder, name: str) -> str:
    known = [p.name for p in manager.predicate(predicate.cls, predicate.name).parameters]
    known += ["start", "end", "duration", "object"]
    known += list(manager.members_of(predicate.cls))
    if name not in known:
        raise ModelError(f"{predicate!r} has no variable {name!r}{nearest(name, known)}")
    return name


def _allowed(manager: ModelManager, value: PredicateBuilder | AllowedBuilder) -> AllowedValue:
    predicate, values = (value.predicate, value.values) if isinstance(value, AllowedBuilder) else (value, {})
    declared = {p.name: p.type for p in manager.predicate(predicate.cls, predicate.name).parameters}
    parameters = []
    for name, operand in values.items():
        domain = None
        if isinstance(operand, set | frozenset | list | tuple) and name in declared:
            known = manager.domain_of(declared[name])
            numbers = isinstance(known, Interval)
            domain = Universe(name, operand).domain() if numbers else known.keep(operand)  # type: ignore[union-attr]
        parameters.append((name, expression_of(operand) if domain is None else Constant(domain=domain)))
    return AllowedValue((predicate.cls, predicate.name), tuple(parameters))


def _attribute(manager: ModelManager, values: Sequence[AllowedValue], written: str) -> tuple[str, str]:
    if written:
        cls, _, name = written.partition(".")
        return cls, name
    if not values:
        raise ModelError("constraint token: expected allowed values, or the attribute that may have none")
    cls, name = values[0].predicate
    return cls, manager.predicate(cls, name).attribute


def _pairs(bounds: Bounds | Sequence[Bounds]) -> tuple[Bounds, ...]:
    if len(bounds) == 2 and not isinstance(bounds[0], tuple):
        return ((bounds[0], bounds[1]),)  # type: ignore[return-value]
    return tuple(bounds)  # type: ignore[arg-type]
