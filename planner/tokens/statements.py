"""From a problem's token patterns to restrictions on tokens."""

from __future__ import annotations

import math

from planner.constraints.network import AnyVariable
from planner.domains import Domain, Interval, Universe
from planner.errors import ModelError, ProblemError, nearest
from planner.model.rules import AllowedValue, Constant
from planner.plan import Bounds, Value
from planner.problem import ConstraintPattern, TokenPattern
from planner.tokens.limits import Allowed
from planner.tokens.manager import TokenNetworkManager
from planner.tokens.token import Token


def apply_pattern(manager: TokenNetworkManager, token: Token, pattern: TokenPattern) -> None:
    """Restrict a token to its pattern; ProblemError names an unknown object, parameter or value."""
    network, owner = manager.network, token.name
    if pattern.object is not None:
        thing = manager.model.objects.get(pattern.object)
        if thing is None:
            hint = nearest(pattern.object, manager.model.objects)
            raise ProblemError(f"{owner}: there is no object named {pattern.object!r}{hint}")
        if thing not in token.object.domain:
            raise ProblemError(f"{owner}: object {thing} has no predicate {pattern.predicate}")
        network.restrict(token.object, manager.domain_of_object(thing), owner)
    for name, value in pattern.parameters.items():
        variable = token.parameters.get(name)
        if variable is None:
            hint = nearest(name, token.parameters)
            raise ProblemError(f"{owner}: predicate {pattern.predicate} has no parameter {name!r}{hint}")
        network.restrict(variable, _narrowed(variable.domain, value, f"{owner}.{name}"), owner)
        if isinstance(value, tuple) and isinstance(variable.domain, Interval):
            allowed = network.variable(f"{owner}.{name} allowed", Universe(name, value).domain(), owner)
            manager.require("eq", (variable, allowed), owner)  # an interval alone would admit what lies between
    for variable_of_time, bounds in ((token.start, pattern.start), (token.end, pattern.end)):
        _bound(manager, variable_of_time, bounds, owner)
    if pattern.contingent is not None:
        token.duration.by_nature = pattern.contingent
    if token.contingent and pattern.contingent is None:
        # A wish for a duration is a requirement on the plan; it does not change what nature may choose.
        lower, upper = pattern.duration
        network.distance(
            token.start, token.end, -math.inf if lower is None else lower, math.inf if upper is None else upper, owner
        )
    else:
        _bound(manager, token.duration, pattern.duration, owner)


def allowed_values(
    manager: TokenNetworkManager, pattern: ConstraintPattern, name: str
) -> tuple[tuple[str, str], list[Allowed]]:
    """The attribute, (class, name), and the values of a constraint token; ProblemError for what means nothing."""
    model = manager.model
    cls, _, attribute = pattern.attribute.partition(".")
    allowed = []
    try:
        for value in pattern.values:
            declared = model.predicate_named(value.predicate)
            types = {p.name: model.domain_of(p.type) for p in declared.parameters}
            limits: dict[str, AnyVariable | Domain] = {
                parameter: _set_of(types[parameter], one, f"{name}: {value.predicate}.{parameter}")
                for parameter, one in value.parameters.items()
                if parameter in types
            }
            allowed.append(Allowed(declared, limits))
        model.check_allowed(
            (cls, attribute),
            [
                AllowedValue((a.predicate.cls, a.predicate.name), tuple((p, Constant()) for p in v.parameters))
                for a, v in zip(allowed, pattern.values, strict=True)
            ],
        )
    except ModelError as error:
        raise ProblemError(f"{name}: {error}") from error
    return (cls, attribute), allowed


def _set_of(domain: Domain, value: Value | tuple[Value, ...], where: str) -> Domain:
    """Just these values of a domain: of an interval too, not what lies between."""
    narrowed = _narrowed(domain, value, where)
    return Universe(where, value).domain() if isinstance(value, tuple) and isinstance(domain, Interval) else narrowed


def _bound(manager: TokenNetworkManager, variable: AnyVariable, bounds: Bounds, owner: str) -> None:
    lower, upper = bounds
    if lower is not None and upper is not None and lower > upper:
        raise ProblemError(f"{variable.name}: the bounds [{lower} {upper}] are empty")
    if lower is not None or upper is not None:
        domain = Interval(-math.inf if lower is None else lower, math.inf if upper is None else upper)
        manager.network.restrict(variable, domain, owner)


def _narrowed(domain: Domain, value: Value | tuple[Value, ...], where: str) -> Domain:
    allowed = value if isinstance(value, tuple) else (value,)
    for one in allowed:
        if one not in domain and str(one) not in map(str, _listed(domain)):
            hint = nearest(str(one), map(str, _listed(domain)))
            raise ProblemError(f"{where}: {one!r} is not one of {domain!r}{hint}")
    if isinstance(domain, Interval):
        numbers = [v for v in allowed if isinstance(v, int | float)]
        return domain.bounded(min(numbers), max(numbers))
    names = {str(one) for one in allowed}
    return domain.keep(v for v in domain.values() if v in allowed or str(v) in names)


def _listed(domain: Domain) -> list[object]:
    return list(domain.values()) if not isinstance(domain, Interval) else []
