"""Simple temporal networks with uncertainty, as values: timepoints, requirement links and contingent links.

One sign convention: a link reads `min <= to - from <= max`, None is unbounded. A requirement link is for the executive
to keep; a contingent link is a duration that nature decides within its bounds after `from` has happened (Vidal and
Fargier 1999). Numbers are exact: whatever their decimal text says is scaled to whole ticks by the common denominator of
all of them, because controllability turns on the sign of sums that are often exactly zero.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path
from types import NoneType
from typing import NamedTuple, NoReturn, cast

import numpy as np
from numpy.typing import NDArray

from planner.errors import NetworkFormatError

IntArray = NDArray[np.int64]
Bound = int | float | Decimal | None
TickRow = tuple[int, int, int | None, int | None, bool]

# "No lower bound" and "no upper bound" in `Stnu.table`. The sum of all bounds stays below, so no sum of them overflows.
UNBOUNDED = 1 << 62
# Columns of `Stnu.table`.
FROM, TO, MIN, MAX, CONTINGENT = range(5)

_DECIMAL_PLACES = 40
_LINK_FIELDS = ("from", "to", "min", "max", "contingent")


class Link(NamedTuple):
    """`min <= to - from <= max` between two timepoints given by index; `contingent`: nature decides the duration."""

    from_: int
    to: int
    min: Bound = None
    max: Bound = None
    contingent: bool = False


@dataclass(frozen=True, slots=True)
class Stnu:
    """A simple temporal network with uncertainty.

    Raises NetworkFormatError, naming the link and field, for what cannot be a network: repeated names, a link from a
    timepoint to itself or to one that is not there, a bound that is not a finite number, a contingent link without
    `0 <= min <= max < infinity`, two contingent links that end in the same timepoint, numbers too large for 64 bits.
    A requirement link with min > max is well-formed: nothing can satisfy it, and the check says so.

    `ticks_per_unit`: whole ticks in one unit of the links' bounds. `table`: int64 of shape (links, 5), read-only, with
    columns from, to, min, max (ticks; -UNBOUNDED and UNBOUNDED where there is none) and contingent (0 or 1).
    """

    timepoints: tuple[str, ...]
    links: tuple[Link, ...]
    ticks_per_unit: int = field(init=False, compare=False, repr=False)
    table: IntArray = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        _check_names(self.timepoints)
        _check_links(self.links, len(self.timepoints))
        scale, rows = _to_ticks(self.links)
        table = np.array(rows, dtype=np.int64).reshape(len(rows), 5)
        table.setflags(write=False)
        object.__setattr__(self, "ticks_per_unit", scale)
        object.__setattr__(self, "table", table)

    @classmethod
    def from_ticks(cls, timepoints: Sequence[str], links: Iterable[TickRow]) -> Stnu:
        """The network of whole-tick rows (from, to, min, max, contingent), for callers that have no file."""
        return cls(tuple(timepoints), tuple(map(Link._make, links)))

    @classmethod
    def from_json(cls, content: object) -> Stnu:
        """The network of a file's content. Floats stand for their shortest decimal text (0.1 is a tenth)."""
        if not isinstance(content, dict):
            raise NetworkFormatError(f"network: expected an object, found {type(content).__name__}")
        names = []
        for place, name in enumerate(_list(content, "timepoints")):
            if not isinstance(name, str):
                raise NetworkFormatError(f"timepoints[{place}]: expected text, found {name!r:.80}")
            names.append(name)
        _check_names(names)
        index = {name: place for place, name in enumerate(names)}
        links = tuple(_link(entry, index, f"constraints[{i}]") for i, entry in enumerate(_list(content, "constraints")))
        return cls(tuple(names), links)

    @classmethod
    def load(cls, path: Path) -> Stnu:
        """Read a network file; NetworkFormatError says the file and the field, or the line and column."""
        try:
            content = json.loads(path.read_text("utf-8"), parse_float=Decimal, object_pairs_hook=_object)
        except OSError as error:
            raise NetworkFormatError(f"{path}: {error.strerror}") from error
        except UnicodeDecodeError as error:
            raise NetworkFormatError(f"{path}: not UTF-8 text at byte {error.start}") from error
        except json.JSONDecodeError as error:
            raise NetworkFormatError(f"{path}:{error.lineno}:{error.colno}: not JSON: {error.msg}") from error
        except NetworkFormatError as error:
            raise NetworkFormatError(f"{path}: {error}") from error
        except RecursionError as error:
            raise NetworkFormatError(f"{path}: nested too deeply to be a network") from error
        except ValueError as error:  # the interpreter's limit on the digits of a whole number
            raise NetworkFormatError(f"{path}: a number is too long: {error}") from error
        try:
            return cls.from_json(content)
        except NetworkFormatError as error:
            raise NetworkFormatError(f"{path}: {error}") from error

    def contingent_links(self) -> Iterator[int]:
        """Indices of the contingent links, in order."""
        return (index for index, link in enumerate(self.links) if link.contingent)

    def to_json(self) -> dict[str, object]:
        """The content of a network file. Decimal bounds become floats."""
        return {
            "timepoints": list(self.timepoints),
            "constraints": [
                {
                    "from": self.timepoints[link.from_],
                    "to": self.timepoints[link.to],
                    "min": float(link.min) if isinstance(link.min, Decimal) else link.min,
                    "max": float(link.max) if isinstance(link.max, Decimal) else link.max,
                    "contingent": link.contingent,
                }
                for link in self.links
            ],
        }


def _object(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """A JSON object; of a field that is there twice one would silently win."""
    content = dict(pairs)
    if len(content) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise NetworkFormatError(f"the field {twice!r} is there twice in {content!s:.80}")
    return content


def _list(content: dict[str, object], name: str) -> list[object]:
    if name not in content:
        raise NetworkFormatError(f"network: the field {name!r} is missing")
    value = content[name]
    if not isinstance(value, list):
        raise NetworkFormatError(f"{name}: expected a list, found {value!r:.80}")
    return value


def _link(entry: object, index: dict[str, int], path: str) -> Link:
    if not isinstance(entry, dict):
        raise NetworkFormatError(f"{path}: expected an object, found {entry!r:.80}")
    for name in entry:
        if name not in _LINK_FIELDS:  # a misspelt bound must not be an absent one
            raise NetworkFormatError(f"{path}: unknown field {name!r}, expected one of {', '.join(_LINK_FIELDS)}")
    ends = []
    for name in ("from", "to"):
        if name not in entry:
            raise NetworkFormatError(f"{path}: the field {name!r} is missing")
        if not isinstance(entry[name], str) or entry[name] not in index:
            raise NetworkFormatError(f"{path}.{name}: expected the name of a timepoint, found {entry[name]!r:.80}")
        ends.append(index[entry[name]])
    contingent = entry.get("contingent", False)
    if not isinstance(contingent, bool):
        raise NetworkFormatError(f"{path}.contingent: expected true or false, found {contingent!r:.80}")
    return Link(ends[0], ends[1], entry.get("min"), entry.get("max"), contingent)


def _check_names(names: Sequence[object]) -> None:
    if len(set(names)) == len(names):
        return
    first: dict[object, int] = {}
    for place, name in enumerate(names):
        if name in first:
            raise NetworkFormatError(f"timepoints[{place}]: {name!r} is already the name of timepoints[{first[name]}]")
        first[name] = place


def _check_links(links: Sequence[Link], n: int) -> None:
    """Everything but the size of the numbers; the loop is lean because the executive builds networks while it runs."""
    decided_by: dict[int, int] = {}
    for i, (from_, to, lower, upper, contingent) in enumerate(links):
        if type(from_) is not int or not 0 <= from_ < n or type(to) is not int or not 0 <= to < n:
            raise NetworkFormatError(f"constraints[{i}]: expected timepoints below {n}, found {from_!r} and {to!r}")
        if from_ == to:
            raise NetworkFormatError(f"constraints[{i}]: expected two different timepoints, found {from_} twice")
        if type(contingent) is not bool:
            raise NetworkFormatError(f"constraints[{i}].contingent: expected true or false, found {contingent!r}")
        if lower is not None and type(lower) is not int:
            _check_number(lower, f"constraints[{i}].min")
        if upper is not None and type(upper) is not int:
            _check_number(upper, f"constraints[{i}].max")
        if contingent:
            _check_contingent(lower, upper, f"constraints[{i}]")
            if to in decided_by:
                raise NetworkFormatError(
                    f"constraints[{i}].to: expected the only contingent link ending there, "
                    f"found constraints[{decided_by[to]}] before it"
                )
            decided_by[to] = i


def _check_number(value: object, path: str) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float | Decimal):
        raise NetworkFormatError(f"{path}: expected a number or null, found {value!r:.80}")
    finite = value.is_finite() if isinstance(value, Decimal) else math.isfinite(value)
    if not finite:
        raise NetworkFormatError(f"{path}: expected a finite number or null, found {value!r}")


def _check_contingent(lower: Bound, upper: Bound, path: str) -> None:
    for name, value in (("min", lower), ("max", upper)):
        if value is None:
            raise NetworkFormatError(f"{path}.{name}: expected a finite number on a contingent link, found none")
    assert lower is not None
    assert upper is not None
    if lower < 0:
        raise NetworkFormatError(f"{path}.min: expected at least 0 on a contingent link, found {lower}")
    if _exact(lower, path) > _exact(upper, path):
        raise NetworkFormatError(f"{path}: expected min <= max on a contingent link, found {lower} > {upper}")


def _exact(value: int | float | Decimal, path: str) -> int | Decimal:
    """The number that the decimal text says; exact, so within a sane range of digits."""
    if isinstance(value, int):
        return value
    number = value if isinstance(value, Decimal) else Decimal(float.__repr__(value))
    exponent = number.as_tuple().exponent
    assert isinstance(exponent, int)
    if exponent < -_DECIMAL_PLACES or number.adjusted() > _DECIMAL_PLACES:
        _overflow(path, value)
    return number


def _overflow(path: str, found: object) -> NoReturn:
    raise NetworkFormatError(
        f"{path}: the bounds do not fit 64-bit integers once scaled to a common denominator, "
        f"expected their sum below 2**62 ticks, found {found!r:.80}"
    )


def _to_ticks(links: Sequence[Link]) -> tuple[int, list[tuple[int, int, int, int, int]]]:
    """Ticks a unit, and the rows of the table."""
    if _all_whole(links):
        whole = cast("Sequence[TickRow]", links)
        if sum(abs(bound) for _, _, low, high, _ in whole for bound in (low, high) if bound) < UNBOUNDED:
            return 1, [
                (from_, to, -UNBOUNDED if low is None else low, UNBOUNDED if high is None else high, int(contingent))
                for from_, to, low, high, contingent in whole
            ]
    exact: dict[tuple[int, str], int | Decimal] = {
        (i, name): _exact(value, f"constraints[{i}].{name}")
        for i, link in enumerate(links)
        for name, value in (("min", link.min), ("max", link.max))
        if value is not None and type(value) is not int
    }
    scale = math.lcm(*(number.as_integer_ratio()[1] for number in exact.values()))
    rows, total = [], 0
    for i, (from_, to, lower, upper, contingent) in enumerate(links):
        low, high = -UNBOUNDED, UNBOUNDED
        if lower is not None:
            low = _scaled(exact.get((i, "min"), lower), scale)
            total += abs(low)
        if upper is not None:
            high = _scaled(exact.get((i, "max"), upper), scale)
            total += abs(high)
        if total >= UNBOUNDED:
            _overflow(f"constraints[{i}]", f"[{lower}, {upper}]")
        rows.append((from_, to, low, high, int(contingent)))
    return scale, rows


def _all_whole(links: Sequence[Link]) -> bool:
    types = {type(link[2]) for link in links} | {type(link[3]) for link in links}
    return types <= {int, NoneType}


def _scaled(value: int | float | Decimal, scale: int) -> int:
    if scale == 1 and type(value) is int:
        return value
    numerator, denominator = value.as_integer_ratio()
    return numerator * (scale // denominator)
