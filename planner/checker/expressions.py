"""What the names and expressions of a configuration constraint mean once its tokens are chosen in the plan."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from planner.checker.view import Slot, View, closed
from planner.domains import Domain, Interval, Values, singleton
from planner.errors import ModelError
from planner.model.classes import ModelObject, Predicate
from planner.model.rules import Apply, Constant, Expression, Ref

TIMES = ("start", "end", "duration")
UNBOUNDED = Interval(-math.inf, math.inf)

Path = tuple[int, ...]
"""A place in nested bodies: the body of the rule is (), a branch in it one longer."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """A required token that the plan need not have, because it may lie outside the horizon."""

    name: str
    predicate: Predicate


@dataclass(frozen=True, slots=True)
class Quantity:
    """A start, end or duration, which the plan need not decide."""

    token: Slot | Wanted
    which: str


Meaning = Slot | Wanted | ModelObject | Quantity | Domain | None
"""What a path of names stands for; None: nothing is known about it."""
Names = Mapping[tuple[Path, str], Slot | Wanted | Domain]
Times = Callable[[Quantity], Domain]
"""The values of times under some view of the schedule."""


class Expressions:
    """Meanings for one token, `slot`, of a plan."""

    def __init__(self, view: View, slot: Slot) -> None:
        self.view = view
        self.model = view.model
        self.slot = slot

    def resolve(self, ref: Ref, names: Names, path: Path) -> Meaning:
        """What a path of names means; ModelError where the model says nothing of the kind."""
        first, *rest = ref.path
        found = self._first(first, names, path)
        for name in rest:
            found = self._part(found, name)
        return found

    def token(self, name: str, names: Names, path: Path) -> Slot | Wanted:
        """The token of that name."""
        found = self._first(name, names, path)
        if not isinstance(found, Slot | Wanted):
            raise ModelError(f"{self.slot.predicate.full_name}: {name!r} is not a token")
        return found

    def domain(self, expression: Expression, names: Names, path: Path, times: Times) -> Domain | None:
        """The values that an expression may have; None when nothing is known about it or it has none."""
        if isinstance(expression, Constant):
            return self._constant(expression)
        if isinstance(expression, Apply):
            scope = self._scope(expression, names, path, times)
            narrowed = None if scope is None else self.model.procedures.get(expression.procedure).narrow(scope)
            return None if narrowed is None else narrowed[-1]
        found = self.resolve(expression, names, path)
        if isinstance(found, Quantity):
            return times(found)
        if isinstance(found, ModelObject):
            return self.only(found)
        if isinstance(found, Slot | Wanted):
            raise ModelError(f"{self.slot.predicate.full_name}: {expression!r} is a token, expected a variable")
        return found

    def quantities(self, expressions: Sequence[Expression], names: Names, path: Path) -> Iterator[Quantity]:
        """The times that expressions mention."""
        for expression in expressions:
            if isinstance(expression, Apply):
                yield from self.quantities(expression.arguments, names, path)
            elif isinstance(expression, Ref):
                found = self.resolve(expression, names, path)
                if isinstance(found, Quantity):
                    yield found

    def narrowed(
        self, procedure: str, arguments: Sequence[Expression], names: Names, path: Path, times: Times
    ) -> Iterator[tuple[Ref, Domain]]:
        """What a relation leaves of the variables in its arguments, in one pass; nothing when it cannot tell."""
        domains = [self.domain(argument, names, path, times) for argument in arguments]
        known = [d for d in domains if d is not None]
        if len(known) == len(domains):
            yield from self._passed_down(procedure, arguments, known, names, path, times)

    def _passed_down(
        self,
        procedure: str,
        arguments: Sequence[Expression],
        scope: Sequence[Domain],
        names: Names,
        path: Path,
        times: Times,
    ) -> Iterator[tuple[Ref, Domain]]:
        left = self.model.procedures.get(procedure).narrow(scope)
        for argument, part in zip(arguments, left or (), strict=False):
            if isinstance(argument, Ref):
                yield argument, part
            elif isinstance(argument, Apply):
                inner = self._scope(argument, names, path, times)
                if inner is not None:
                    inner[-1] = part
                    yield from self._passed_down(argument.procedure, argument.arguments, inner, names, path, times)

    def range_of(self, quantity: Quantity) -> Domain:
        """All that a time may be, over all schedules."""
        if isinstance(quantity.token, Wanted):
            return UNBOUNDED
        return Interval(*self.view.range_of(quantity.token, quantity.which))

    def only(self, thing: ModelObject) -> Domain:
        """The domain of one object."""
        everything = self.model.objects_of("Object")
        return closed(everything.keep((thing,)))

    def _scope(self, apply: Apply, names: Names, path: Path, times: Times) -> list[Domain] | None:
        """The domains of a function's arguments and its result; None when one is unknown."""
        domains = [self.domain(argument, names, path, times) for argument in apply.arguments]
        known = [d for d in domains if d is not None]
        kind = "bool" if apply.procedure.startswith("test") else "float"
        return [*known, self.model.domain_of(kind)] if len(known) == len(domains) else None

    def _constant(self, constant: Constant) -> Domain:
        if constant.domain is not None:
            return closed(constant.domain)
        if isinstance(constant.value, ModelObject):
            return self.only(constant.value)
        return singleton(constant.value)

    def _first(self, name: str, names: Names, path: Path) -> Meaning:
        if name == "this":
            return self.slot
        for length in range(len(path), -1, -1):
            if (path[:length], name) in names:
                return names[path[:length], name]
        if name in self.slot.values or name in TIMES or name == "object":
            return self._part(self.slot, name)
        if name in self.model.members_of(self.slot.object.cls):
            return self._member(self.slot.object, name)
        if name in self.view.variables:
            return self.view.variables[name]
        if name in self.model.objects:
            return self.model.objects[name]
        raise ModelError(f"{self.slot.predicate.full_name}: {name!r} means nothing here")

    def _part(self, whole: Meaning, name: str) -> Meaning:
        if isinstance(whole, Slot):
            if name in whole.values:
                return whole.values[name]
            if name in TIMES:
                return Quantity(whole, name)
            return self.only(whole.object) if name == "object" else self._member(whole.object, name)
        if isinstance(whole, Wanted):
            return self._of_wanted(whole, name)
        if isinstance(whole, ModelObject):
            return self._member(whole, name)
        if isinstance(whole, Values) and whole.is_singleton and isinstance(whole.value, ModelObject):
            return self._member(whole.value, name)
        if isinstance(whole, Quantity):
            raise ModelError(f"{self.slot.predicate.full_name}: a time has no member {name!r}")
        return None

    def _of_wanted(self, wanted: Wanted, name: str) -> Meaning:
        for parameter in wanted.predicate.parameters:
            if parameter.name == name:
                return closed(self.model.domain_of(parameter.type))
        if name in TIMES:
            return Quantity(wanted, name)
        return closed(self.model.objects_of(wanted.predicate.cls)) if name == "object" else None

    def _member(self, thing: ModelObject, name: str) -> Meaning:
        known = self.model.members_of(thing.cls)
        if name not in known:
            raise ModelError(f"object {thing} of class {thing.cls} has no member {name!r}")
        value = thing.members.get(name)
        if isinstance(value, ModelObject):
            return value
        if value is None or isinstance(value, Interval | Values):
            return self.view.variables[f"{thing}.{name}"]
        return singleton(value)
