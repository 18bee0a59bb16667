"""The summary of a run: what a person or a campaign asks first."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from executive.conclusions import REPLAN, FaultRecord
from executive.executive import Executive
from executive.records import AdoptedPlan
from scenarios.config import FaultSection, Scenario
from scenarios.flight_rules import FLIGHT_RULES, RuleViolation
from scenarios.words import Reasons, most_like

OUTCOMES = ("failed", "standby", "degraded", "completed")
"""From worst to best."""


def summarize(
    scenario: Scenario,
    seed: int,
    faults: Sequence[FaultSection],
    executive: Executive,
    rule_violations: Sequence[RuleViolation],
    reasons: Reasons,
    wall_seconds: float,
) -> dict[str, Any]:
    """The content of `summary.json`, but for what only the recording and the simulator know."""
    plans = executive.plans
    dispatch = executive.dispatch
    p50, p99 = (_percentile(dispatch.latencies, share) for share in (0.5, 0.99))
    return {
        "scenario": scenario.name,
        "about": scenario.summary,
        "seed": seed,
        "outcome": executive.outcome,
        "expected": scenario.expect.faulted if faults else scenario.expect.nominal,
        "unmet": [],
        "goals": [{"id": g.id, "status": g.status, "time": g.time, "reason": g.reason} for g in executive.goals],
        "plans": [_plan(adopted, reasons) for adopted in plans],
        "replans": sum(not adopted.joined for adopted in plans[1:]),
        "recoveries": sum(_is_recovered(record) for record in executive.faults),
        "faults": _faults(faults, executive.faults),
        "dispatch": {
            "timepoints": dispatch.timepoints,
            "violations": sum(dispatch.violations.values()),
            "violations_by_kind": dict(dispatch.violations),
            "latency_us_p50": p50,
            "latency_us_p99": p99,
            "wall_seconds": round(sum(dispatch.latencies), 6),
        },
        "flight_rules": {
            "checked": len(FLIGHT_RULES),
            "violations": [{"rule": v.rule, "start": v.start, "end": v.end} for v in rule_violations],
        },
        "sim": {
            "sim_seconds": executive.now,
            "wall_seconds": round(wall_seconds, 3),
            "realtime_factor": round(executive.now / wall_seconds, 1),
        },
        "wall_seconds": round(wall_seconds, 3),
    }


def unmet(summary: dict[str, Any], scenario: Scenario, own_faults: bool) -> list[str]:
    """What of the scenario's promises the run does not keep, in words; the detailed ones hold for its `own_faults`."""
    found = []
    if OUTCOMES.index(summary["outcome"]) < OUTCOMES.index(summary["expected"]):
        found.append(f"outcome: expected {summary['expected']} at least, found {summary['outcome']}")
    if not own_faults:
        return found
    expect = scenario.expect
    if expect.replans is not None and summary["replans"] > expect.replans:
        found.append(f"replans: expected {expect.replans} at most, found {summary['replans']}")
    if summary["recoveries"] < expect.recoveries:
        found.append(f"recoveries: expected {expect.recoveries} at least, found {summary['recoveries']}")
    status = {goal["id"]: goal["status"] for goal in summary["goals"]}
    found += [
        f"goal {goal}: expected achieved, found {status[goal]}"
        for goal in expect.achieved
        if status[goal] != "achieved"
    ]
    return found


def fell_short(summary: dict[str, Any]) -> bool:
    """Whether the run keeps less than its scenario promises, or broke a flight rule."""
    return bool(summary["unmet"] or summary["flight_rules"]["violations"])


def _is_recovered(record: FaultRecord) -> bool:
    """Whether something was done about it, and it forced no other plan."""
    return bool(record.responses) and REPLAN not in record.responses


def _plan(adopted: AdoptedPlan, reasons: Reasons) -> dict[str, Any]:
    return {
        "id": adopted.id,
        "horizon": list(adopted.plan.horizon),
        "tokens": len(adopted.plan.tokens),
        "timelines": len(adopted.plan.timelines),
        "constraints": len(adopted.plan.constraints),
        "steps": adopted.statistics.steps,
        "solve_seconds": round(adopted.statistics.solve_seconds, 4),
        "deliberation_charged": adopted.deliberation_charged,
        "dynamically_controllable": adopted.dynamically_controllable,
        "reason": reasons.say(adopted.reason),
    }


def _faults(injected: Sequence[FaultSection], detected: Sequence[FaultRecord]) -> list[dict[str, Any]]:
    """What was injected and what was detected, matched by the words they share: the executive knows only the latter."""
    rows: list[dict[str, Any]] = []
    unseen = sorted(injected, key=lambda f: f.at)
    matches: dict[int, FaultRecord] = {}
    others: list[FaultRecord] = []
    for record in sorted(detected, key=lambda d: d.detected):
        there = {f.name: n for n, f in enumerate(unseen) if f.at <= record.detected and n not in matches}
        name = most_like(there, record.monitor, record.diagnosis)
        if name is None:
            others.append(record)
        else:
            matches[there[name]] = record
    for number, fault in enumerate(unseen):
        rows.append({"name": fault.name, "injected": fault.at} | _detection(matches.get(number)))
    rows.extend({"name": d.monitor, "injected": None} | _detection(d) for d in others)
    return rows


def _detection(record: FaultRecord | None) -> dict[str, Any]:
    if record is None:
        return {"detected": None, "diagnosis": None, "response": None, "recovered": None}
    response = ", ".join(record.responses) or "replan"
    return {
        "detected": record.detected,
        "diagnosis": record.diagnosis,
        "response": response,
        "recovered": record.recovered,
    }


def _percentile(latencies_s: Sequence[float], share: float) -> float | None:
    """A percentile in microseconds; None without any latency."""
    if not latencies_s:
        return None
    ordered = sorted(latencies_s)
    return round(ordered[min(len(ordered) - 1, int(share * len(ordered)))] * 1e6, 1)
