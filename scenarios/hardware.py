"""The spacecraft of a scenario file: the hardware's defaults with the changes of its section `[spacecraft]`.

Numbers, texts and spans by the names of `sim.config.SpacecraftConfig`. Orbits are tables of `sim.orbits.Elements`:
`[spacecraft.orbit]` is the spacecraft's own, `[spacecraft.targets.NAME]` has the fields of `sim.config.Target`, of one
that there is or of another, and in it `orbit` its ephemeris.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

from planner.errors import nearest
from sim import ConfigurationError, SpacecraftConfig
from sim.config import DEFAULT_TARGETS, Target
from sim.orbits import Elements

_Made = TypeVar("_Made")
_LARGEST = 1e12
_HARDWARE = SpacecraftConfig()
_FLAT_ORBIT = Elements(1.0)
_ANY_TARGET = Target("any", "asteroid")


def hardware_of(section: Mapping[str, Any]) -> SpacecraftConfig:
    """The configuration with these changes; ValueError names the field that is wrong."""
    return _made(SpacecraftConfig, "spacecraft", _values(section, _HARDWARE, "spacecraft"))


def _values(table: object, defaults: object, where: str) -> dict[str, Any]:
    """The table's values, each of the type that its default has."""
    known = list(type(defaults).__dataclass_fields__)  # type: ignore[attr-defined]
    if not isinstance(table, Mapping):
        raise ValueError(f"{where}: expected a table, found {table!r:.80}")
    for name in table:
        if name not in known:
            raise ValueError(f"{where}: there is no field {name!r}{nearest(name, known)}")
    return {name: _value(value, getattr(defaults, name), name, f"{where}.{name}") for name, value in table.items()}


def _value(value: object, default: object, name: str, where: str) -> Any:
    if name == "orbit":
        elements = _values(value, _FLAT_ORBIT, where)
        if "semimajor_axis_au" not in elements:
            raise ValueError(f"{where}.semimajor_axis_au: missing")
        return _made(Elements, where, elements)
    if name == "targets":
        return _targets(value, where)
    if isinstance(default, tuple):
        if isinstance(value, list) and len(value) == len(default) and all(map(_is_number, value)):
            return tuple(map(float, value))
        raise ValueError(f"{where}: expected {len(default)} numbers, found {value!r:.80}")
    if isinstance(default, str):
        if isinstance(value, str):
            return value
        raise ValueError(f"{where}: expected text, found {value!r:.80}")
    if isinstance(default, int):
        if isinstance(value, int) and not isinstance(value, bool):
            return value
        raise ValueError(f"{where}: expected a whole number, found {value!r:.80}")
    if not _is_number(value):
        raise ValueError(f"{where}: expected a number, found {value!r:.80}")
    return value


def _targets(tables: object, where: str) -> tuple[Target, ...]:
    """The default targets with these changes, and after them those that are new."""
    if not isinstance(tables, Mapping):
        raise ValueError(f"{where}: expected a table for each target, found {tables!r:.80}")
    targets = {target.name: target for target in DEFAULT_TARGETS}
    for name, table in tables.items():
        values = _values(table, _ANY_TARGET, f"{where}.{name}")
        if "name" in values:
            raise ValueError(f"{where}.{name}.name: expected none, the table is the target's by its name")
        if name not in targets and "kind" not in values:
            raise ValueError(f"{where}.{name}.kind: missing, for a target that is new{nearest(name, targets)}")
        targets[name] = replace(targets.get(name, replace(_ANY_TARGET, name=name)), **values)
    return tuple(targets.values())


def _made(kind: Callable[..., _Made], where: str, values: Mapping[str, Any]) -> _Made:
    try:
        return kind(**values)
    except ConfigurationError as error:
        raise ValueError(f"{where}.{error}") from error


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= _LARGEST
