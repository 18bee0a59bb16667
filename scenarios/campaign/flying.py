"""What a worker does: fly one variation, and say what came of it in one flat row. Nothing that goes wrong escapes."""

from __future__ import annotations

import json
from typing import Any

from scenarios.campaign.variations import Variation, varied
from scenarios.config import Scenario
from scenarios.judging import violations_of
from scenarios.run import Flight, RunOptions

Row = dict[str, Any]

CRASHED = "crashed"
"""The outcome of a run that ended in an error, or took its worker along."""


def fly(scenario: Scenario, own: Variation) -> Row:
    """Fly it, unrecorded. An error of any kind is a row too: one bad run does not stop the others."""
    try:
        its = varied(scenario, own)
        flight = Flight(its, RunOptions(own.seed, own.faults, images=False))
        summary = flight.fly_unrecorded()
        invalid = sum(bool(violations_of(adopted.plan, its)) for adopted in flight.plans)
        return {**_identity(own), **_outcome(summary), "plans_invalid": invalid, "error": ""}
    except Exception as error:  # a campaign asks what breaks: this is an answer
        return crashed(own, f"{type(error).__name__}: {error}")


def crashed(own: Variation, error: str) -> Row:
    """The row of a run that gave no summary."""
    nothing = dict.fromkeys(("goals", "achieved", "dropped", "missed", "plans", "replans", "plan_steps"), 0)
    rest = {"detected": 0, "rule_violations": 0, "rules": "", "dispatch_violations": 0, "makespan_s": None}
    times = {"planning_s": 0.0, "wall_s": 0.0, "plans_invalid": 0, "error": error}
    return {**_identity(own), "outcome": CRASHED, **nothing, **rest, "kept": False, "explained": bool(error), **times}


def _identity(own: Variation) -> Row:
    faults = [fault.model_dump(exclude_defaults=True) for fault in own.faults]
    return {
        "run": own.number,
        "seed": own.seed,
        "fault": own.label,
        "faults": json.dumps(faults),
        "spacecraft": json.dumps(own.spacecraft),
    }


def _outcome(summary: dict[str, Any]) -> Row:
    """The figures of a summary. `kept`: no goal was missed that could be reached."""
    goals, plans = summary["goals"], summary["plans"]
    count = {status: sum(goal["status"] == status for goal in goals) for status in ("achieved", "dropped", "missed")}
    rules = summary["flight_rules"]["violations"]
    return {
        "outcome": summary["outcome"],
        "goals": len(goals),
        **count,
        "plans": len(plans),
        "replans": summary["replans"],
        "plan_steps": sum(plan["steps"] for plan in plans),
        "detected": sum(fault["detected"] is not None for fault in summary["faults"]),
        "rule_violations": len(rules),
        "rules": ",".join(sorted({violation["rule"] for violation in rules})),
        "dispatch_violations": summary["dispatch"]["violations"],
        "makespan_s": max((goal["time"] for goal in goals if goal["status"] == "achieved"), default=None),
        "kept": count["missed"] == 0,
        "explained": all(goal["reason"] for goal in goals if goal["status"] != "achieved"),
        "planning_s": sum(plan["solve_seconds"] for plan in plans),
        "wall_s": summary["wall_seconds"],
    }
