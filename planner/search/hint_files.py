"""Files of solver hints: TOML, one `[[hint]]` table each; `scenarios/examples/rover_battery.hints.toml` is one.

    variables = "fewest-values"    # which of several variables comes first: as without a hint; or "first-stated",
                                   # "fewest-values-per-constraint"

    [[hint]]                       # tokens of this class, or one below it, and this predicate; either may be left out
    class = "Rover"
    predicate = "drive"
    priority = 5                   # -1000 to 1000, 0 without a hint; the flaw with the highest is resolved first
    prefer = "insert"              # into a new slot first; or "codesignate", as without a hint
    slot = "last"                  # of each timeline first; or "first", as without a hint

    [[hint]]                       # a parameter of these tokens, or a local variable of their rules
    predicate = "drive"
    variable = "to"
    values = ["Hill", "Rock"]      # these first; or "min", "max", "least-constraining", "in-order", "random".
                                   # Without `variable`: for all parameters
    filter = true                  # resolved when no other token or variable is left; instead of a priority

`min` and `max` of values that are not numbers are the order of their declaration and its reverse. What a list names
and a domain does not hold is passed over, and so is a variable that does not exist where neither class nor predicate is
given: it might be any of the problem's own.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from planner.constraints.heuristics import VALUE_HEURISTICS, VARIABLE_HEURISTICS
from planner.errors import HintsError, nearest
from planner.search.hints import HIGHEST, LAST, Hint, Hints

SUFFIX = ".hints.toml"


def beside(model: Path) -> Path:
    """Where the hints for a model's file are looked for: `rover.hints.toml` beside `rover.nddl`."""
    return model.with_suffix(SUFFIX)


def load(path: Path, seed: int = 0) -> Hints:
    """The hints of a file; HintsError names the file and every wrong key."""
    try:
        return parse(path.read_text(encoding="utf-8"), str(path), seed)
    except OSError as error:
        raise HintsError(f"{path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise HintsError(f"{path}: not UTF-8 text at byte {error.start}") from error


def parse(text: str, where: str, seed: int = 0) -> Hints:
    """The hints of a text; HintsError lists every wrong key after the name of the file, `where`."""
    try:
        content = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # the second: lists in lists in lists
        raise HintsError(f"{where}: not TOML: {error}") from error
    wrong = [
        f"{key}: unknown key{nearest(key, ['hint', 'variables'])}"
        for key in content
        if key not in ("hint", "variables")
    ]
    variables = content.get("variables", Hints().variables)
    if not isinstance(variables, str) or variables not in VARIABLE_HEURISTICS:
        wrong.append(f"variables: expected one of {', '.join(VARIABLE_HEURISTICS)}, found {variables!r:.80}")
    tables = content.get("hint", [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        wrong.append(f"hint: expected tables [[hint]], found {tables!r:.80}")
    else:
        for number, table in enumerate(tables):
            wrong += [f"hint[{number}]{complaint}" for complaint in _complaints(table)]
    if wrong:
        raise HintsError("\n".join(f"{where}: {complaint}" for complaint in wrong))
    return Hints(tuple(_hint(table) for table in tables), seed, where, variables)


def _is_word(value: object) -> bool:
    return isinstance(value, str) and value != ""


def _is_priority(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and abs(value) <= HIGHEST


def _is_order(value: object) -> bool:
    if isinstance(value, list):
        return bool(value) and all(isinstance(v, str | int | bool) or _is_finite(v) for v in value)
    return value == "random" or (isinstance(value, str) and value in VALUE_HEURISTICS)


def _is_finite(value: object) -> bool:
    return isinstance(value, float) and math.isfinite(value)


_ORDERS = ", ".join(f'"{name}"' for name in (*VALUE_HEURISTICS, "random"))
KEYS: Mapping[str, tuple[Callable[[object], bool], str]] = {
    "class": (_is_word, "a name"),
    "predicate": (_is_word, "a name"),
    "variable": (_is_word, "a name"),
    "priority": (_is_priority, f"a whole number from {-HIGHEST} to {HIGHEST}"),
    "filter": (lambda value: value is True, "true"),
    "values": (_is_order, f"{_ORDERS} or a list of values"),
    "prefer": (lambda value: value in ("codesignate", "insert"), '"codesignate" or "insert"'),
    "slot": (lambda value: value in ("first", "last"), '"first" or "last"'),
}
"""Each key, what its values must be, and how to say that."""
SELECTORS = ("class", "predicate", "variable")


def _complaints(table: Mapping[str, Any]) -> list[str]:
    found: list[str] = []
    for key, value in table.items():
        if key not in KEYS:
            found.append(f".{key}: unknown key{nearest(key, KEYS)}")
        elif not KEYS[key][0](value):
            found.append(f".{key}: expected {KEYS[key][1]}, found {value!r:.80}")
    if "filter" in table and "priority" in table:
        found.append(".filter: expected a filter or a priority, found both")
    if "variable" in table:
        found += [
            f".{key}: is for tokens, and this hint is for a variable" for key in ("prefer", "slot") if key in table
        ]
    if all(key in SELECTORS for key in table):
        found.append(f": expected one of {', '.join(key for key in KEYS if key not in SELECTORS)}, found none")
    return found


def _hint(table: Mapping[str, Any]) -> Hint:
    values = table.get("values")
    return Hint(
        cls=table.get("class"),
        predicate=table.get("predicate"),
        variable=table.get("variable"),
        priority=LAST if "filter" in table else table.get("priority"),
        values=tuple(values) if isinstance(values, list) else values,
        prefer=table.get("prefer"),
        slot=table.get("slot"),
    )
