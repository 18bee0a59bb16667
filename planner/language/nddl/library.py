"""The library headers that the front end itself provides, and what their classes' constructors mean.

`Plasma.nddl` (with `Core.nddl`, `Constraints.nddl`, `StringData.nddl`), `PlannerConfig.nddl` and `Resources.nddl`: a
model may include them and need not, since their classes are there anyhow. Timelines and resources are classes of every
model (planner.model.resources); here are their constructors as NDDL writes them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from planner.errors import nearest

HEADERS = frozenset(
    {"Plasma.nddl", "PlannerConfig.nddl", "Resources.nddl", "Core.nddl", "Constraints.nddl", "StringData.nddl"}
)
CONFIG = "PlannerConfig"
LIBRARY_CLASSES: dict[str, dict[str, str]] = {
    CONFIG: dict.fromkeys(("m_horizonStart", "m_horizonEnd", "m_maxPlannerSteps", "m_maxPlannerDepth"), "int"),
    "StringData": {"data": "string"},
}
"""The classes of the headers that are nothing but their members, with the types of those."""
_ENDLESS = {"capacity": math.inf, "level_min": -math.inf}
DEFAULTS: dict[str, dict[str, object]] = {
    CONFIG: {"m_horizonStart": 0, "m_horizonEnd": 100, "m_maxPlannerSteps": 200},
    "CBReusable": dict(_ENDLESS),
    "Reusable": dict(_ENDLESS),
    "Reservoir": {"initial": 0, "level_min": -math.inf},
}
"""The members that a constructor without arguments sets."""
MEMBER_NAMES = {
    "initialCapacity": "initial",
    "levelLimitMin": "level_min",
    "levelLimitMax": "level_max",
    "productionRateMax": "production_rate_max",
    "productionMax": "production_max",
    "consumptionRateMax": "consumption_rate_max",
    "consumptionMax": "consumption_max",
}
"""What the headers call the members of resources, and what the model does."""


@dataclass(frozen=True, slots=True)
class BuiltInConstructor:
    """A constructor whose arguments are the values of these members, in order."""

    members: tuple[str, ...]


def _constructors(*signatures: str) -> tuple[BuiltInConstructor, ...]:
    return tuple(BuiltInConstructor(tuple(s.split())) for s in signatures)


# The sum of what a reusable gives out is not bounded here: the fourth argument of EUROPA's longest form is its rate.
_REUSABLE = _constructors(
    "",
    "capacity",
    "capacity level_min",
    "capacity level_min consumption_rate_max",
    "capacity level_min - consumption_rate_max",
)
CONSTRUCTORS: dict[str, tuple[BuiltInConstructor, ...]] = {
    "Object": _constructors(""),
    "Timeline": _constructors(""),
    "UnaryResource": _constructors(""),
    "Unary": _constructors("", "-"),
    "CBReusable": _REUSABLE,
    "Reusable": _REUSABLE,
    "Reservoir": _constructors(
        "",
        "initial level_min level_max",
        "initial level_min level_max production_max consumption_max",
        "initial level_min level_max production_rate_max production_max consumption_rate_max consumption_max",
    ),
    CONFIG: _constructors(
        "",
        "m_horizonStart m_horizonEnd",
        "m_horizonStart m_horizonEnd m_maxPlannerSteps",
        "m_horizonStart m_horizonEnd m_maxPlannerSteps m_maxPlannerDepth",
    ),
    "StringData": _constructors("data"),
}
OBSOLETE_NAMES = {
    "Resource": "class Resource with its predicate change is of EUROPA 2.1: extend Reservoir, with produce and consume",
    "NddlWorld": "NddlWorld is older than PlannerConfig, which has the same arguments",
    "MINUS_INFINITY": "MINUS_INFINITY is of EUROPA 2.1: write -inf, or -inff for a real number",
    "PLUS_INFINITY": "PLUS_INFINITY is of EUROPA 2.1: write +inf, or +inff for a real number",
}
"""Names of earlier libraries, and what took their place."""


def hint(name: str, known: Iterable[str]) -> str:
    """What to write instead of a name that means nothing: what took its place, or the nearest of those known."""
    return f"; {OBSOLETE_NAMES[name]}" if name in OBSOLETE_NAMES else nearest(name, known)


UNBOUNDED_BY_DEFAULT = frozenset(
    {"production_rate_max", "production_max", "consumption_rate_max", "consumption_max", "level_max"}
)
