"""The library headers that the front end itself provides, and what their classes' constructors mean.

`Plasma.nddl` (with `Core.nddl`, `Constraints.nddl`, `StringData.nddl`), `PlannerConfig.nddl` and `Resources.nddl`: a
model may include them and need not, since their classes are there anyhow. Timelines and resources are classes of every
model (planner.model.resources); here are their constructors as NDDL writes them.
"""

from __future__ import annotations

from dataclasses import dataclass

HEADERS = frozenset(
    {"Plasma.nddl", "PlannerConfig.nddl", "Resources.nddl", "Core.nddl", "Constraints.nddl", "StringData.nddl"}
)
CONFIG = "PlannerConfig"
CONFIG_MEMBERS = {"horizonStart": "int", "horizonEnd": "int", "maxSteps": "int", "maxDepth": "int"}


@dataclass(frozen=True, slots=True)
class BuiltInConstructor:
    """A constructor whose arguments are the values of these members, in order."""

    members: tuple[str, ...]


def _constructors(*signatures: str) -> tuple[BuiltInConstructor, ...]:
    return tuple(BuiltInConstructor(tuple(s.split())) for s in signatures)


# The sum of what a reusable gives out is not bounded here: the fourth argument of EUROPA's longest form is its rate.
_REUSABLE = _constructors(
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
        "initial level_min level_max",
        "initial level_min level_max production_max consumption_max",
        "initial level_min level_max production_rate_max production_max consumption_rate_max consumption_max",
    ),
    CONFIG: _constructors(
        "",
        "horizonStart horizonEnd",
        "horizonStart horizonEnd maxSteps",
        "horizonStart horizonEnd maxSteps maxDepth",
    ),
}
UNBOUNDED_BY_DEFAULT = frozenset(
    {"production_rate_max", "production_max", "consumption_rate_max", "consumption_max", "level_max"}
)
