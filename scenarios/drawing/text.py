"""Words of a drawing: how wide they are, how they are cut, how bounds and values are written."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from planner.plan import Bounds, ParameterValue, PlanToken

LETTER = 11.0
"""Height of ordinary letters, pixels."""
SMALL = 9.0
_NARROW = frozenset("iIljtfr.,:;|'!()[]{} ")
_WIDE = frozenset("mwMWQO@%—")
_LONGEST = 40
INFINITE = "∞"


def width(text: str, size: float = LETTER) -> float:
    """Pixels that a text takes at most, in a wide common sans serif face."""
    ems = sum(0.42 if c in _NARROW else 0.98 if c in _WIDE else 0.7 if c.isupper() else 0.64 for c in text)
    return ems * size


def xml(text: str) -> str:
    """The text as a document may hold it: escaped, and without what no document can."""
    return escape("".join(c if c.isprintable() or c == "\n" else "\N{REPLACEMENT CHARACTER}" for c in text))


def cut(text: str, longest: int = _LONGEST) -> str:
    """The text, or its beginning with an ellipsis."""
    return text if len(text) <= longest else text[: longest - 1] + "…"


def bounds(pair: Bounds) -> str:
    """`7` for a single value, `[3 9]` for a choice."""
    lower, upper = pair
    if lower is not None and lower == upper:
        return str(lower)
    low = f"-{INFINITE}" if lower is None else str(lower)
    return f"[{low} {INFINITE if upper is None else upper}]"


def value(found: ParameterValue) -> str:
    """A parameter's value, or what is left of its domain."""
    if isinstance(found, bool):
        return "true" if found else "false"
    if isinstance(found, int | float):
        return f"{found:g}" if abs(found) < 1e6 else str(found)
    if isinstance(found, str):
        return found
    if isinstance(found, Mapping):
        low, high = found.get("min"), found.get("max")
        return f"[{f'-{INFINITE}' if low is None else f'{low:g}'} {INFINITE if high is None else f'{high:g}'}]"
    return "{" + ", ".join(value(one) for one in found) + "}"


def parameters(token: PlanToken) -> str:
    """`target=earth, level=6`; the name goes without saying where there is one parameter."""
    if len(token.parameters) == 1:
        return value(next(iter(token.parameters.values())))
    return ", ".join(f"{name}={value(found)}" for name, found in token.parameters.items())


def predicate(token: PlanToken) -> str:
    """The predicate without its class."""
    return token.predicate.rpartition(".")[2]
