"""Goals against the domain model: what a goal names must exist, and is looked for before a run begins."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from planner.domains import Interval
from planner.errors import ModelError, PlannerError, nearest
from planner.model.classes import Predicate
from planner.model.manager import ModelManager
from scenarios.errors import ScenarioError

if TYPE_CHECKING:
    from scenarios.config import GoalSection, Scenario


def check_goals(scenario: Scenario, where: str) -> None:
    """ScenarioError, a line each, for every goal whose predicate, parameter or value the model does not have."""
    model = model_of(scenario, where)
    complaints = [
        f"{where}: goals[{number}].{complaint}"
        for number, goal in enumerate(scenario.goals)
        for complaint in _complaints(model, goal)
    ]
    if complaints:
        raise ScenarioError("\n".join(complaints))


def model_of(scenario: Scenario, where: str) -> ModelManager:
    """The domain model for the scenario's hardware; ScenarioError when that hardware cannot be planned for."""
    from scenarios.ds1.capability import capability_of
    from scenarios.ds1.domain import build_model

    try:
        return build_model(capability_of(scenario.spacecraft_config(), scenario.horizon, scenario.deliberation))
    except (PlannerError, ArithmeticError, ValueError) as error:
        raise ScenarioError(f"{where}: spacecraft: no domain model can be made for it: {error}") from error


def _complaints(model: ModelManager, goal: GoalSection) -> Iterator[str]:
    try:
        predicate = model.predicate_named(goal.predicate)
    except ModelError as error:
        yield f"predicate: {error}"
        return
    known = {parameter.name: parameter for parameter in predicate.parameters}
    for name, value in goal.parameters.items():
        if name not in known:
            yield f"parameters: {goal.predicate} has no parameter {name!r}{_hint(name, predicate)}"
            continue
        domain = model.domain_of(known[name].type)
        allowed = value if isinstance(value, tuple) else (value,)
        if not allowed:
            yield f"parameters.{name}: expected a value or a list of values, found an empty list"
        if isinstance(domain, Interval):
            yield from (
                f"parameters.{name}: expected a number in [{domain.lower:g}, {domain.upper:g}], found {one!r:.80}"
                for one in allowed
                if isinstance(one, str | bool) or one not in domain
            )
            continue
        values = [str(one) for one in domain.values()]
        yield from (
            f"parameters.{name}: expected one of {', '.join(values)}, found {one!r:.80}{nearest(str(one), values)}"
            for one in allowed
            if str(one) not in values
        )


def _hint(name: str, predicate: Predicate) -> str:
    names = [parameter.name for parameter in predicate.parameters]
    return nearest(name, names) or f"; it has {', '.join(names) or 'none'}"
