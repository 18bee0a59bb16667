"""Objects: constructors carried out on the model manager, before there is a plan."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from planner.domains import Interval, Values
from planner.language.nddl.errors import Complaint, Position
from planner.language.nddl.library import CONSTRUCTORS, DEFAULTS, UNBOUNDED_BY_DEFAULT, BuiltInConstructor, hint
from planner.language.nddl.symbols import Symbols
from planner.language.nddl.syntax import (
    Assignment,
    Binary,
    Choice,
    Constructor,
    Declaration,
    Expression,
    Name,
    New,
    Range,
    Statement,
    Super,
)
from planner.language.nddl.values import Literals, arithmetic, is_number
from planner.model.classes import ModelObject
from planner.model.manager import ModelManager
from planner.model.resources import GROUNDED

MAX_OBJECTS_DEEP = 50
"""Constructors that create objects that create objects: beyond this they never end."""
GROUNDED_PROFILE = "GroundedProfile"
"""The value of a resource's member `profileType` that asks for the schedule of earliest times only."""
Arguments = Mapping[str, object]


class Objects:
    """Creates the objects of a program. `variables`: global variables whose value is known."""

    def __init__(self, model: ModelManager, symbols: Symbols) -> None:
        self.model = model
        self.symbols = symbols
        self.literals = Literals(symbols, model)
        self.variables: dict[str, object] = {}
        self._depth = 0
        self._unnamed = 0

    def create(
        self, new: New, name: str, parent: ModelObject | None = None, scope: Arguments | None = None
    ) -> ModelObject:
        """A new object of that name and what its constructor makes; a complaint says what does not fit."""
        if new.cls not in self.symbols.classes:
            raise Complaint(new.at, f"there is no class named {new.cls!r}{hint(new.cls, self.symbols.classes)}")
        if name in self.model.objects:
            raise Complaint(new.at, f"an object named {name!r} exists already")
        self._depth += 1
        try:
            if self._depth > MAX_OBJECTS_DEEP:
                raise Complaint(new.at, f"objects create objects more than {MAX_OBJECTS_DEEP} deep")
            arguments = [self.value(a, parent, scope or {}) for a in new.arguments]
            thing = self.model.add_object(name, new.cls, parent=parent)
            self._initialise(thing, new.cls)
            self._construct(thing, new.cls, arguments, new.at)
            if thing.members.get("profileType") == GROUNDED_PROFILE and "profile" in self.model.members_of(new.cls):
                self.model.set_member(thing, "profile", GROUNDED)
            return thing
        finally:
            self._depth -= 1

    def unnamed(self, cls: str) -> str:
        """A name for an object that the text gives none."""
        while True:
            self._unnamed += 1
            name = f"{cls}_{self._unnamed}"
            if name not in self.model.objects and name not in self.symbols.variables:
                return name

    def _initialise(self, thing: ModelObject, cls: str) -> None:
        """The initial values that the declarations of members give."""
        for symbol in reversed(list(self.symbols.lineage(cls))):
            if symbol.definition is None:
                continue
            for member in symbol.definition.members or ():
                if isinstance(member, Declaration):
                    for variable in member.variables:
                        if variable.value is not None:
                            self._assign(thing, variable.name, variable.value, {}, variable.at)

    def _construct(self, thing: ModelObject, cls: str, arguments: Sequence[object], at: Position) -> None:
        """Carry out the constructor of the class, or of the nearest above, that takes these arguments."""
        for symbol in self.symbols.lineage(cls):
            if symbol.constructors:
                self._own_constructor(thing, symbol.name, symbol.constructors, arguments, at)
                return
            if symbol.definition is None:
                self._built_in(thing, symbol.name, arguments, at)
                return

    def _own_constructor(
        self, thing: ModelObject, cls: str, candidates: Sequence[Constructor], arguments: Sequence[object], at: Position
    ) -> None:
        fitting = [c for c in candidates if self._fits(c, arguments)]
        if not fitting:
            forms = "; ".join(f"{cls}({', '.join(t for t, _ in c.parameters)})" for c in candidates)
            given = ", ".join(self._kind(a) for a in arguments)
            raise Complaint(at, f"no constructor of class {cls} takes ({given}): there is {forms}")
        chosen = fitting[0]
        scope = {name: value for (_, name), value in zip(chosen.parameters, arguments, strict=True)}
        parent = self.symbols.classes[cls].parent
        if parent is not None and not any(isinstance(s, Super) for s in chosen.body):
            self._default(thing, parent, at)
        for statement in chosen.body:
            self._constructor_statement(thing, cls, statement, scope)

    def _default(self, thing: ModelObject, cls: str, at: Position) -> None:
        """What a parent does when `super` is not called: its constructor without arguments, if it has one."""
        for symbol in self.symbols.lineage(cls):
            if symbol.constructors:
                if any(not c.parameters for c in symbol.constructors):
                    self._own_constructor(thing, symbol.name, symbol.constructors, (), at)
                return
            if symbol.definition is None:
                self._defaults(thing, symbol.name)
                return

    def _constructor_statement(self, thing: ModelObject, cls: str, node: Statement, scope: Arguments) -> None:
        if isinstance(node, Super):
            parent = self.symbols.classes[cls].parent or "Object"
            self._construct(thing, parent, [self.value(a, thing, scope) for a in node.arguments], node.at)
        elif isinstance(node, Assignment):
            path = node.target.path[1:] if node.target.path[0] == "this" else node.target.path
            if len(path) != 1:
                raise Complaint(node.at, f"a constructor sets members of its own object, not {str(node.target)!r}")
            self._assign(thing, path[0], node.value, scope, node.at)
        else:
            kind = type(node).__name__.lower()
            raise Complaint(node.at, f"a constructor has assignments and super(...) only, not a {kind}")

    def _assign(self, thing: ModelObject, member: str, node: Expression, scope: Arguments, at: Position) -> None:
        name, type_ = self.symbols.member_named(thing.cls, member, at)
        value: object
        if isinstance(node, New):
            value = self.create(node, f"{thing.name}.{member}", thing, scope)
        elif isinstance(node, Range):
            value = self.literals.domain_of_type(type_).intersect(
                self.literals.interval(node, self.literals.is_real(type_))
            )
        elif isinstance(node, Choice):
            value = self.literals.choice(node, type_)
        else:
            value = self.value(node, thing, scope)
        if not self._is_of(value, type_):
            raise Complaint(at, f"member {member!r} is of type {type_}, which {self._kind(value)} is not")
        if is_number(value) and self.symbols.base(type_) == "int":
            value = int(value) if math.isfinite(value) else Interval(value, value)
        self.model.set_member(thing, name, value)

    # Constructors of the classes that every model has

    def _built_in(self, thing: ModelObject, cls: str, arguments: Sequence[object], at: Position) -> None:
        forms = CONSTRUCTORS.get(cls, (BuiltInConstructor(()),))
        form = next((f for f in forms if len(f.members) == len(arguments)), None)
        if form is None:
            shown = "; ".join(f"{cls}({', '.join(m if m != '-' else 'limit' for m in f.members)})" for f in forms)
            raise Complaint(at, f"no constructor of class {cls} takes {len(arguments)} arguments: there is {shown}")
        if not arguments:
            self._defaults(thing, cls)
        for member, value in zip(form.members, arguments, strict=True):
            if member == "data":
                self._check_text(cls, value, at)
            elif not is_number(value):
                raise Complaint(at, f"{cls}: expected a number for {member!r}, found {self._kind(value)}")
            if member != "-" and not (member in UNBOUNDED_BY_DEFAULT and value == math.inf):
                self.model.set_member(thing, member, value)

    def _check_text(self, cls: str, value: object, at: Position) -> None:
        if not isinstance(value, str):
            raise Complaint(at, f"{cls}: expected a text, found {self._kind(value)}")

    def _defaults(self, thing: ModelObject, cls: str) -> None:
        for member, value in DEFAULTS.get(cls, {}).items():
            self.model.set_member(thing, member, value)

    # Values

    def value(self, node: Expression, thing: ModelObject | None, scope: Arguments) -> object:
        """The value of an argument or of the right side of an assignment, where objects are created."""
        if isinstance(node, New):
            return self.create(node, self.unnamed(node.cls), thing, scope)
        if isinstance(node, Name):
            found = self._named(node, thing, scope)
            if found is not None:
                return found
        if isinstance(node, Range):
            return self.literals.interval(node, False)
        if isinstance(node, Binary) and node.operator in ("+", "-", "*", "/"):
            left, right = self.value(node.left, thing, scope), self.value(node.right, thing, scope)
            found = arithmetic(node, left, right) if is_number(left) and is_number(right) else None
            if found is not None:
                return found
        value = self.literals.value(node)
        if value is None:
            known = [*scope, *(self.symbols.members_of(thing.cls) if thing else ()), *self.variables]
            known += [*self.model.objects, *self.symbols.enumerations_of]
            text = str(node) if isinstance(node, Name) else ""
            what = f"{text!r} has no value here{hint(text, known)}" if text else "expected a value"
            raise Complaint(node.at, what)
        return value

    def named(self, path: tuple[str, ...], at: Position) -> object | None:
        """What a path of names at the top is; None when it is nothing known yet."""
        return self._named(Name(path, at=at), None, {}) if path else None

    def _named(self, node: Name, thing: ModelObject | None, scope: Arguments) -> object | None:
        first, *rest = node.path
        found: object | None
        if first == "this":
            found = thing
        elif first in scope:
            found = scope[first]
        elif thing is not None and (member := self.symbols.member(thing.cls, first)) and member[0] in thing.members:
            found = thing.members[member[0]]
        else:
            found = self.variables[first] if first in self.variables else self.model.objects.get(first)
        for name in rest:
            if not isinstance(found, ModelObject):
                return None
            own, _ = self.symbols.member_named(found.cls, name, node.at)
            found = found.members.get(own)
        return found

    def _fits(self, constructor: Constructor, arguments: Sequence[object]) -> bool:
        return len(constructor.parameters) == len(arguments) and all(
            self._is_of(value, type_) for (type_, _), value in zip(constructor.parameters, arguments, strict=True)
        )

    def _is_of(self, value: object, type_: str) -> bool:
        """Whether a value can be one of the type."""
        base = self.symbols.base(type_)
        if isinstance(value, Interval | Values):
            return True
        if isinstance(value, ModelObject):
            return base in self.symbols.classes and self.symbols.is_subclass(value.cls, base)
        if base == "bool":
            return isinstance(value, bool)
        if base == "float":
            return is_number(value)
        if base == "int":
            return is_number(value) and (math.isinf(value) or value == int(value))
        if base in self.symbols.enumerations:
            return value in self.symbols.enumerations[base].values
        return isinstance(value, str) if base == "string" else False

    def _kind(self, value: object) -> str:
        if isinstance(value, ModelObject):
            return value.cls
        if isinstance(value, bool):
            return "bool"
        if is_number(value):
            return "int" if isinstance(value, int) else "float"
        return repr(value)
