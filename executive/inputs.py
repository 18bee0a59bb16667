"""What the executive is told from outside besides telemetry, as journal entries and back: goals, settings, answers.

With these and the observations a journal holds everything that a run depended on, so that it can be flown again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from executive.errors import JournalError
from executive.records import Settings
from planner.errors import PlanFormatError
from planner.plan import FlexiblePlan
from planner.problem import DroppedGoal, Goal, PlanningResult, SearchStatistics, TokenPattern

Json = dict[str, Any]

_NUMBERS = ("budget", "retry_delay", "longest_delay", "relax_after", "goal_attempts")


@dataclass(frozen=True, slots=True)
class Answer:
    """What came of asking the planner: a result, or the words of what it raised. `charged`: seconds of its thinking.

    `charged` is simulation time. How long the planner took by the clock on the wall is not part of it.
    """

    result: PlanningResult
    raised: str | None
    charged: int


def goal_to_json(goal: Goal) -> Json:
    """A goal as plain data."""
    pattern = goal.token
    return {
        "id": goal.id,
        "priority": goal.priority,
        "predicate": pattern.predicate,
        "object": pattern.object,
        "parameters": {k: list(v) if isinstance(v, tuple) else v for k, v in pattern.parameters.items()},
        "start": list(pattern.start),
        "end": list(pattern.end),
        "duration": list(pattern.duration),
        "contingent": pattern.contingent,
    }


def goal_from_json(content: Mapping[str, Any]) -> Goal:
    """The goal that was written down; JournalError when a field is missing."""
    try:
        pattern = TokenPattern(
            content["predicate"],
            content["object"],
            {k: tuple(v) if isinstance(v, list) else v for k, v in content["parameters"].items()},
            _pair(content["start"]),
            _pair(content["end"]),
            _pair(content["duration"]),
            content["contingent"],
        )
        return Goal(content["id"], pattern, content["priority"])
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise JournalError(f"goal in a journal: {type(error).__name__}: {error}") from error


def settings_to_json(settings: Settings) -> Json:
    """The settings that decide what an executive does with a planner's answers."""
    return {name: getattr(settings, name) for name in _NUMBERS} | {"waypoints": list(settings.waypoints)}


def settings_from_json(scenario: str, seed: int, content: Mapping[str, Any]) -> Settings:
    """The settings that were written down. Facts and the price of planning are not: they went into the answers."""
    try:
        numbers = {name: content[name] for name in _NUMBERS}
        return Settings(scenario, seed, waypoints=tuple(content["waypoints"]), **numbers)
    except (KeyError, TypeError) as error:
        raise JournalError(f"settings in a journal: {type(error).__name__}: {error}") from error


def answer_to_json(answer: Answer) -> Json:
    """An answer as plain data; of the search's statistics the counts, and nothing that a clock measured."""
    result = answer.result
    return {
        "charged": answer.charged,
        "raised": answer.raised,
        "reason": result.reason,
        "dropped": [[goal.id, goal.kind, goal.reason] for goal in result.dropped],
        "steps": result.statistics.steps,
        "backtracks": result.statistics.backtracks,
        "content": None if result.plan is None else result.plan.to_json(),
    }


def answer_from_json(content: Mapping[str, Any]) -> Answer:
    """The answer that was written down; JournalError when it is none."""
    try:
        plan = None if content["content"] is None else FlexiblePlan.from_json(content["content"])
        dropped = tuple(DroppedGoal(*goal) for goal in content["dropped"])
        statistics = SearchStatistics(content["steps"], content["backtracks"])
        return Answer(
            PlanningResult(plan, dropped, content["reason"], statistics), content["raised"], content["charged"]
        )
    except (KeyError, TypeError, PlanFormatError) as error:
        raise JournalError(f"a planner's answer: {type(error).__name__}: {error}") from error


def _pair(content: Any) -> tuple[int | None, int | None]:
    lower, upper = content
    return lower, upper
