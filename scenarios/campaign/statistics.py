"""What a campaign's rows say, fault by fault: shares and means, each with its 95 % confidence interval.

Shares have Wilson's interval (E. B. Wilson, JASA 22, 1927), which holds for few runs and for shares near 0 and 1; means
have a percentile bootstrap from a fixed seed. Wall-clock figures stand apart: the others are the same for equal seeds.
"""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from scenarios.campaign.flying import CRASHED, Row

LEVEL_Z = statistics.NormalDist().inv_cdf(0.975)
RESAMPLES = 2000
TOTAL = "all runs"


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """The 95 % interval of a share; (0, 1) when nothing was tried."""
    if trials == 0:
        return 0.0, 1.0
    share, z2 = successes / trials, LEVEL_Z**2
    centre = (share + z2 / (2 * trials)) / (1 + z2 / trials)
    half = LEVEL_Z / (1 + z2 / trials) * math.sqrt(share * (1 - share) / trials + z2 / (4 * trials**2))
    return max(0.0, centre - half), min(1.0, centre + half)


def bootstrap(values: Sequence[float]) -> tuple[float, float]:
    """The 95 % interval of a mean; equal values give an interval of no width."""
    data = np.asarray(values, float)
    chosen = np.random.default_rng(0).integers(len(data), size=(RESAMPLES, len(data)))
    low, high = np.quantile(data[chosen].mean(axis=1), [0.025, 0.975])
    return float(low), float(high)


def table(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """One entry for all runs and one for each fault, in the order of names; nothing in it depends on a clock."""
    groups = {TOTAL: list(rows)}
    for row in sorted(rows, key=lambda row: str(row["fault"])):
        groups.setdefault(row["fault"], []).append(row)
    return [{"fault": name, **_figures(group)} for name, group in groups.items() if group]


def timing(rows: Sequence[Row]) -> dict[str, float | None]:
    """Seconds on the wall clock of one run: what differs from machine to machine."""
    flown = [row for row in rows if row["outcome"] != CRASHED]
    planning = sorted(row["planning_s"] for row in flown)
    return {
        "planning_s_median": statistics.median(planning) if planning else None,
        "planning_s_p99": planning[int(0.99 * (len(planning) - 1))] if planning else None,
        "wall_s_median": statistics.median(row["wall_s"] for row in flown) if flown else None,
    }


def worst(rows: Iterable[Row], count: int) -> list[Row]:
    """The runs to look at first: crashed, rules broken, unexplained, goals missed, goals dropped. Not those without."""

    def badness(row: Row) -> tuple[object, ...]:
        lost = not row["explained"], row["missed"], row["dropped"], row["replans"], row["plan_steps"]
        return row["outcome"] == CRASHED, row["rule_violations"], *lost

    bad = [row for row in rows if row["outcome"] != "completed" or row["rule_violations"] or not row["explained"]]
    return sorted(bad, key=lambda row: (badness(row), -row["run"]), reverse=True)[:count]


def _figures(group: Sequence[Row]) -> dict[str, Any]:
    flown = [row for row in group if row["outcome"] != CRASHED]
    kept = sum(row["kept"] for row in group)
    goals, achieved = (sum(row[name] for row in flown) for name in ("goals", "achieved"))
    makespans = [row["makespan_s"] for row in flown if row["makespan_s"] is not None]
    return {
        "runs": len(group),
        "kept": kept / len(group),
        "kept_interval": wilson(kept, len(group)),
        "achieved": achieved / goals if goals else None,
        "achieved_interval": bootstrap([row["achieved"] / row["goals"] for row in flown]) if goals else None,
        "replans": statistics.mean(row["replans"] for row in flown) if flown else None,
        "replans_interval": bootstrap([row["replans"] for row in flown]) if flown else None,
        "plan_steps_median": statistics.median(row["plan_steps"] for row in flown) if flown else None,
        "makespan_s_median": statistics.median(makespans) if makespans else None,
        "makespan_s_interval": bootstrap(makespans) if makespans else None,
        "rule_violations": sum(row["rule_violations"] for row in group),
        "invalid_plans": sum(row["plans_invalid"] for row in group),
        "unexplained": sum(not row["explained"] for row in group),
        "crashed": len(group) - len(flown),
        "outcomes": dict(sorted(Counter(row["outcome"] for row in group).items())),
    }
