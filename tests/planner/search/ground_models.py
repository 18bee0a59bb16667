"""The slow oracle's small domains and problems as the planner's."""

from __future__ import annotations

from planner.constraints.standard import STANDARD
from planner.language.builder import ModelBuilder, PredicateBuilder, RuleBuilder
from planner.model.manager import ModelManager
from planner.problem import Goal, Problem, TokenPattern
from tests.planner.search.ground import HORIZON, VALUES, Either, Keep, Small, Statement, When


def model_of(small: Small) -> ModelManager:
    """The same domain for the planner."""
    builder = ModelBuilder("small", STANDARD)
    number = builder.enumeration("Number", VALUES)
    lines = {name: builder.timeline(name) for name in ("A", "B")}
    predicates = {
        k.name: lines[k.line].predicate(k.name, {"x": number}, duration=k.duration, exogenous=k.exogenous)
        for k in small.kinds.values()
    }
    for kind in small.kinds.values():
        with predicates[kind.name].requires() as this:
            for statement in kind.rule:
                _state(this, statement, predicates)
    for name in lines:
        builder.object(name.lower(), name)
    return builder.finish()


def _state(rule: RuleBuilder, statement: Statement, predicates: dict[str, PredicateBuilder]) -> None:
    if isinstance(statement, When):
        with rule.when(rule.x == statement.x) as inside:
            for ask in statement.body:
                _state(inside, ask, predicates)
    elif isinstance(statement, Either):
        with rule.either() as alternatives:
            for body in statement.bodies:
                with alternatives.alternative() as alternative:
                    for ask in body:
                        _state(alternative, ask, predicates)
    elif isinstance(statement, Keep):
        values = [
            predicates[kind].where(**({} if x is None else {"x": rule.x if x == -1 else x}))
            for kind, x in statement.allowed
        ]
        rule.constraint_token(statement.relation, values, attribute=f"{statement.line}.state")
    else:
        token = rule.relation(statement.relation, predicates[statement.target], statement.bounds)
        if statement.same or statement.x is not None:
            rule.require(token.x == (rule.x if statement.same else statement.x))


def problem_of(small: Small) -> Problem:
    """The same problem for the planner."""
    patterns: dict[str, list[TokenPattern]] = {"goal": [], "fact": [], "state": []}
    for one in small.given:
        parameters = {} if one.x is None else {"x": one.x}
        end = one.end if one.role == "goal" else (None, None)
        predicate = f"{small.kinds[one.kind].line}.{one.kind}"
        patterns[one.role].append(TokenPattern(predicate, parameters=parameters, start=one.start, end=end))
    goals = tuple(Goal(f"g{n}", pattern) for n, pattern in enumerate(patterns["goal"]))
    return Problem(HORIZON, tuple(patterns["state"]), tuple(patterns["fact"]), goals)
