"""What operations say of the domains of single variables."""

from __future__ import annotations

from planner.constraints.network import AnyVariable, Variable
from planner.database import PlanDatabase
from planner.domains import Interval
from planner.operations.statements import Insertion, Operation, Restriction


def restrict(database: PlanDatabase, operation: Operation) -> None:
    """What an operation says of the domain of a single variable."""
    statement = operation.statement
    if isinstance(statement, Restriction):
        variable = variable_of(database, statement)
        assert variable is not None
        if isinstance(variable, Variable):
            database.network.restrict(variable, statement.domain, operation)
        else:
            assert isinstance(statement.domain, Interval)
            database.network.bound(variable, statement.domain, operation)
    elif isinstance(statement, Insertion):
        tokens = database.tokens
        thing = tokens.domain_of_object(database.model.objects[statement.object])
        database.network.restrict(tokens.by_path[statement.token].object, thing, operation)


def variable_of(database: PlanDatabase, statement: Restriction) -> AnyVariable | None:
    """The variable that a restriction speaks of, if it is there."""
    if statement.token is None:
        return database.tokens.variables.get(statement.variable)
    token = database.tokens.by_path.get(statement.token)
    return None if token is None else token.variable(statement.variable)
