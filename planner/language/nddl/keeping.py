"""Constraint tokens in rules: `only relation[bounds] {value, ...};`, read and translated. An extension of the language.

As long as an interval in that relation to the token's lasts, an attribute has only these values.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from planner.errors import ModelError
from planner.language.nddl.errors import Complaint
from planner.language.nddl.expressions import expression, interval
from planner.language.nddl.reader import Reader
from planner.language.nddl.syntax import AllowedValue, Bounds, Expression, Keep
from planner.model import rules

if TYPE_CHECKING:
    from planner.language.nddl.translator import Translator


def keep(reader: Reader) -> Keep:
    """`only equals {lamp.dark, lamp.dim(level == [0 2])};`."""
    at = reader.at()
    reader.advance()
    relation = reader.name("a temporal relation")
    bounds: list[Bounds] = []
    while reader.sees("["):
        one = interval(reader)
        bounds.append(Bounds(one.lower, one.upper, at=one.at))
    reader.expect("{", ", the values that are allowed")
    values = [_value(reader)]
    while not reader.accept("}"):
        reader.expect(",", " or '}' after an allowed value")
        values.append(_value(reader))
    reader.expect(";")
    return Keep(relation, tuple(bounds), tuple(values), at=at)


def _value(reader: Reader) -> AllowedValue:
    at = reader.at()
    path = reader.path("a predicate, as in object.predicate")
    parameters: list[tuple[str, Expression]] = []
    if reader.accept("("):
        while not reader.accept(")"):
            if parameters:
                reader.expect(",", " or ')' after a parameter")
            name = reader.name("the name of a parameter")
            reader.expect("==")
            parameters.append((name, expression(reader)))
    return AllowedValue(path, tuple(parameters), at=at)


def translate(translator: Translator, node: Keep, bounds: tuple[tuple[float, float], ...]) -> None:
    """Add the statement that asks for the constraint token."""
    scope, model = translator.scope, translator.model
    if scope.own is None:
        raise Complaint(node.at, "only: a constraint token belongs to a rule")
    values, owners, attributes = [], [], []
    for value in node.values:
        predicate, owner = scope.predicate_of(value.path, value.at)
        limits = tuple((name, translator.expression(limit)) for name, limit in value.parameters)
        values.append(rules.AllowedValue(predicate, limits))
        owners.append(owner)
        try:
            attributes.append((predicate[0], model.predicate(*predicate).attribute))
            model.check_allowed(attributes[0], values)
        except ModelError as error:
            raise Complaint(value.at, str(error)) from None
        if owner != owners[0]:
            raise Complaint(value.at, f"{'.'.join(value.path)}: expected a value of the object of the first one")
    name = translator.fresh("only")
    translator.out.append(rules.Confine(node.relation, attributes[0], tuple(values), name, owners[0], bounds))
