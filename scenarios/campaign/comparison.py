"""Two campaigns beside each other: the same runs before and after a change, and whether it made anything worse."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scenarios.campaign.flying import CRASHED, Row
from scenarios.campaign.statistics import bootstrap
from scenarios.campaign.store import rows_in, settings_in
from scenarios.errors import ScenarioError

SIGNIFICANT = 0.05


def compare(before: Path, after: Path) -> dict[str, Any]:
    """What changed from one campaign to the other, run by run. ScenarioError when their runs are not the same.

    A regression is a run that crashed or broke a flight rule and did not before, or significantly more runs that came
    to lose a goal than that ceased to (McNemar's exact test on the pairs).
    """
    first, second = settings_in(before), settings_in(after)
    for name in ("scenario", "faults", "seed"):
        one, other = getattr(first, name), getattr(second, name)
        if one != other:
            raise ScenarioError(f"{before} and {after} cannot be compared: {name} is {one!r} and {other!r}")
    old, new = ({row["run"]: row for row in rows_in(folder)} for folder in (before, after))
    shared = sorted(old.keys() & new.keys())
    if not shared:
        raise ScenarioError(f"{before} and {after} have no run in common")
    lost = [number for number in shared if old[number]["kept"] and not new[number]["kept"]]
    gained = [number for number in shared if new[number]["kept"] and not old[number]["kept"]]
    probability = mcnemar(len(lost), len(gained))
    broken = [number for number in shared if _breaks(new[number]) and not _breaks(old[number])]
    return {
        "runs": len(shared),
        "scenario_changed": first.text != second.text,
        "kept_before": sum(old[number]["kept"] for number in shared),
        "kept_after": sum(new[number]["kept"] for number in shared),
        "lost": [_told(new[number]) for number in lost],
        "gained": [_told(new[number]) for number in gained],
        "newly_broken": [_told(new[number]) for number in broken],
        "probability": probability,
        "differences": _differences(old, new, shared),
        "regression": bool(broken) or (len(lost) > len(gained) and probability < SIGNIFICANT),
    }


def mcnemar(lost: int, gained: int) -> float:
    """The two-sided exact probability of so unequal numbers if worse and better were equally likely."""
    trials = lost + gained
    tail: float = sum(math.comb(trials, k) for k in range(min(lost, gained) + 1)) / 2**trials
    return min(1.0, 2.0 * tail)


def _breaks(row: Row) -> bool:
    return bool(row["outcome"] == CRASHED or row["rule_violations"] or row["plans_invalid"] or not row["explained"])


def _told(row: Row) -> dict[str, Any]:
    return {name: row[name] for name in ("run", "seed", "fault", "outcome", "missed", "rules", "error")}


def _differences(old: Mapping[int, Row], new: Mapping[int, Row], shared: Sequence[int]) -> list[dict[str, Any]]:
    """Mean changes, after minus before, of the runs that both flew to their ends, with 95 % intervals."""
    both = [number for number in shared if CRASHED not in (old[number]["outcome"], new[number]["outcome"])]
    rows = []
    for name in ("achieved", "replans", "plan_steps", "makespan_s", "planning_s"):
        pairs = [(old[n][name], new[n][name]) for n in both]
        changes = [b - a for a, b in pairs if a is not None and b is not None]
        if changes:
            low, high = bootstrap(changes)
            rows.append({"figure": name, "mean_change": sum(changes) / len(changes), "low": low, "high": high})
    return rows
