"""FlexiblePlan: what the planner hands to an executive. Bounds and constraints, never fixed times (paper, section 2).

Time is integer ticks. One sign convention everywhere: a constraint reads `min <= to - from <= max`; None is unbounded.
A timepoint is named `"<token id>.start"`, `"<token id>.end"`, or `"origin"`, which is at tick 0.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from planner.errors import PlanFormatError
from planner.files import write_whole

FORMAT = 1
ORIGIN = "origin"
CODESIGNATED = "codesignated"
"""Why the timepoints of two tokens off timelines that are one are equal."""

Bound = int | None
Bounds = tuple[Bound, Bound]
Value = int | float | str | bool
# A decided parameter is a value; an undecided one is what is left of its domain: a list of values or {"min", "max"}.
ParameterValue = Value | tuple[Value, ...] | Mapping[str, float | None]


@dataclass(frozen=True, slots=True)
class PlanValue:
    """A value that a constraint token allows: a predicate, and what some of its parameters are within."""

    predicate: str
    parameters: Mapping[str, ParameterValue] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class PlanToken:
    """An interval in which an attribute holds one value; or, with `allowed`, a constraint token: an interval in which
    it has only these values and may change among them. That one is in no slot, but lies over some.

    `start`, `end`, `duration`: bounds in ticks. `contingent`: nature decides the duration within its bounds.
    `goal`: the identifier of the goal that this token was stated for, else None. `fact`: true without support.
    `master`: the token whose configuration constraint asked for this one, else None.
    """

    id: str
    object: str
    attribute: str
    predicate: str
    parameters: Mapping[str, ParameterValue]
    start: Bounds
    end: Bounds
    duration: Bounds
    contingent: bool = False
    goal: str | None = None
    fact: bool = False
    master: str | None = None
    allowed: tuple[PlanValue, ...] | None = None


@dataclass(frozen=True, slots=True)
class PlanTimeline:
    """The tokens of one attribute of one object in order. Each slot lists its codesignated tokens, the host first."""

    object: str
    attribute: str
    slots: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True)
class PlanConstraint:
    """`min <= to - from <= max` between two timepoints of host tokens, and the requirement that it stands for."""

    from_: str
    to: str
    min: Bound
    max: Bound
    why: str


@dataclass(frozen=True)
class FlexiblePlan:
    """A complete plan. `constraints` with the tokens' own bounds and durations are its whole temporal network.

    `boundary`: what configuration constraints ask for that may still lie wholly outside the horizon; a plan speaks of
    its horizon only, so these are on no timeline and bind nothing. Their object is empty where it is undecided.
    `variables`: the values of the problem's own variables.
    """

    model: str
    horizon: tuple[int, int]
    objects: tuple[str, ...]
    timelines: tuple[PlanTimeline, ...]
    tokens: tuple[PlanToken, ...]
    constraints: tuple[PlanConstraint, ...]
    boundary: tuple[PlanToken, ...] = ()
    variables: Mapping[str, ParameterValue] = field(default_factory=dict)
    _by_id: dict[str, PlanToken] = field(init=False, repr=False, compare=False, default_factory=dict)

    def __post_init__(self) -> None:
        self._by_id.update((token.id, token) for token in self.tokens)

    def token(self, token_id: str) -> PlanToken:
        """The token of that identifier; KeyError when there is none."""
        return self._by_id[token_id]

    def hosts(self) -> Iterator[PlanToken]:
        """The first token of every slot: one for each activity or state that is to happen."""
        for timeline in self.timelines:
            for slot in timeline.slots:
                yield self._by_id[slot[0]]

    def supports(self, token_id: str) -> tuple[str, ...]:
        """The hosts whose configuration constraints asked for a token of the same slot as this one."""
        found = (self._by_id[one].master for one in self._slot_of(token_id))
        return tuple(dict.fromkeys(self._slot_of(master)[0] for master in found if master is not None))

    def supported_by(self, token_id: str) -> tuple[str, ...]:
        """The hosts that the configuration constraints of the same slot as this token's asked for."""
        asking = self._slot_of(token_id)
        return tuple(dict.fromkeys(self._slot_of(t.id)[0] for t in self.tokens if t.master in asking))

    def _slot_of(self, token_id: str) -> tuple[str, ...]:
        slots = (slot for timeline in self.timelines for slot in timeline.slots)
        return next((slot for slot in slots if token_id in slot), (token_id,))

    def to_json(self) -> dict[str, Any]:
        """The plan file's content."""
        return {
            "format": FORMAT,
            "model": self.model,
            "horizon": list(self.horizon),
            "objects": list(self.objects),
            "timelines": [
                {"object": t.object, "attribute": t.attribute, "slots": [list(slot) for slot in t.slots]}
                for t in self.timelines
            ],
            "tokens": [_token_to_json(t) for t in self.tokens],
            "constraints": [
                {"from": c.from_, "to": c.to, "min": c.min, "max": c.max, "why": c.why} for c in self.constraints
            ],
            "boundary": [_token_to_json(t) for t in self.boundary],
            **({"variables": _parameters_to_json(self.variables)} if self.variables else {}),
        }

    @classmethod
    def from_json(cls, content: object) -> FlexiblePlan:
        """The plan of a plan file's content; PlanFormatError says which field is wrong."""
        reader = _Reader(content, "plan")
        if (found := reader.value("format")) != FORMAT:
            raise PlanFormatError(f"plan.format: expected {FORMAT}, found {found!r}")
        tokens = tuple(_token_from_json(entry) for entry in reader.entries("tokens"))
        boundary = tuple(_token_from_json(entry) for entry in reader.entries("boundary", default=()))
        known = {token.id for token in tokens}
        if len(known | {token.id for token in boundary}) != len(tokens) + len(boundary):
            raise PlanFormatError("plan.tokens: two tokens have the same id")
        for field_name, listed in (("tokens", tokens), ("boundary", boundary)):
            for number, token in enumerate(listed):
                if token.master is not None and token.master not in known:
                    where = f"plan.{field_name}[{number}].master"
                    raise PlanFormatError(f"{where}: {token.master!r} is not a token of the plan")
        points = {ORIGIN} | {f"{i}.{which}" for i in known for which in ("start", "end")}
        timelines = []
        for entry in reader.entries("timelines"):
            slots = tuple(tuple(slot.texts()) for slot in entry.entries("slots"))
            for slot in slots:
                if not slot or not known.issuperset(slot):
                    raise PlanFormatError(f"{entry.path}.slots: {list(slot)!r} is empty or names an unknown token")
            timelines.append(PlanTimeline(entry.text("object"), entry.text("attribute"), slots))
        constraints = []
        for entry in reader.entries("constraints"):
            ends = entry.text("from"), entry.text("to")
            for name, end in zip(("from", "to"), ends, strict=True):
                if end not in points:
                    raise PlanFormatError(f"{entry.path}.{name}: {end!r} is not a timepoint of the plan")
            constraints.append(PlanConstraint(*ends, entry.bound("min"), entry.bound("max"), entry.text("why")))
        lower, upper = reader.pair("horizon")
        if lower is None or upper is None or lower > upper:
            raise PlanFormatError(f"plan.horizon: expected [start, end] with start <= end, found {[lower, upper]!r}")
        return cls(
            model=reader.text("model"),
            horizon=(lower, upper),
            objects=tuple(_Reader(reader.array("objects"), "plan.objects").texts()),
            timelines=tuple(timelines),
            tokens=tokens,
            constraints=tuple(constraints),
            boundary=boundary,
            variables=reader.values("variables", optional=True),
        )

    def save(self, path: Path) -> None:
        """Write the plan file: whole or, when broken off, not at all. OSError when it cannot be written."""
        write_whole(path, json.dumps(self.to_json(), indent=1) + "\n")

    @classmethod
    def load(cls, path: Path) -> FlexiblePlan:
        """Read a plan file; PlanFormatError says the file and the field or the line."""
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise PlanFormatError(f"{path}: {error.strerror}") from error
        except UnicodeDecodeError as error:
            raise PlanFormatError(f"{path}: not UTF-8 text at byte {error.start}") from error
        except json.JSONDecodeError as error:
            raise PlanFormatError(f"{path}:{error.lineno}:{error.colno}: not JSON: {error.msg}") from error
        except RecursionError as error:
            raise PlanFormatError(f"{path}: nested too deeply to be a plan") from error
        try:
            return cls.from_json(content)
        except PlanFormatError as error:
            raise PlanFormatError(f"{path}: {error}") from error


def _token_to_json(token: PlanToken) -> dict[str, Any]:
    content: dict[str, Any] = {
        "id": token.id,
        "object": token.object,
        "attribute": token.attribute,
        "predicate": token.predicate,
        "parameters": _parameters_to_json(token.parameters),
        "start": list(token.start),
        "end": list(token.end),
        "duration": list(token.duration),
        "contingent": token.contingent,
        "goal": token.goal,
    }
    if token.fact:
        content["fact"] = True
    if token.master is not None:
        content["master"] = token.master
    if token.allowed is not None:
        content["allowed"] = [
            {"predicate": value.predicate, "parameters": _parameters_to_json(value.parameters)}
            for value in token.allowed
        ]
    return content


def _parameters_to_json(parameters: Mapping[str, ParameterValue]) -> dict[str, Any]:
    return {name: list(value) if isinstance(value, tuple) else value for name, value in parameters.items()}


def _token_from_json(entry: _Reader) -> PlanToken:
    allowed = None
    if isinstance(entry.content, dict) and "allowed" in entry.content:
        allowed = tuple(PlanValue(v.text("predicate"), v.values("parameters")) for v in entry.entries("allowed"))
    return PlanToken(
        id=entry.text("id"),
        object=entry.text("object"),
        attribute=entry.text("attribute"),
        predicate=entry.text("predicate"),
        parameters=entry.values("parameters"),
        start=entry.pair("start"),
        end=entry.pair("end"),
        duration=entry.pair("duration"),
        contingent=entry.flag("contingent"),
        goal=entry.optional_text("goal"),
        fact=entry.flag("fact", default=False),
        master=entry.optional_text("master"),
        allowed=allowed,
    )


@dataclass(frozen=True, slots=True)
class _Reader:
    """A JSON object with its path, so that every complaint says where."""

    content: object
    path: str

    def value(self, name: str) -> object:
        if not isinstance(self.content, dict):
            raise PlanFormatError(f"{self.path}: expected an object, found {type(self.content).__name__}")
        if name not in self.content:
            raise PlanFormatError(f"{self.path}: the field {name!r} is missing")
        return self.content[name]

    def text(self, name: str) -> str:
        value = self.value(name)
        if not isinstance(value, str):
            raise PlanFormatError(f"{self.path}.{name}: expected text, found {value!r}")
        return value

    def optional_text(self, name: str) -> str | None:
        if isinstance(self.content, dict) and self.content.get(name) is None:
            return None
        return self.text(name)

    def flag(self, name: str, default: bool | None = None) -> bool:
        if default is not None and isinstance(self.content, dict) and name not in self.content:
            return default
        value = self.value(name)
        if not isinstance(value, bool):
            raise PlanFormatError(f"{self.path}.{name}: expected true or false, found {value!r}")
        return value

    def array(self, name: str) -> list[Any]:
        value = self.value(name)
        if not isinstance(value, list):
            raise PlanFormatError(f"{self.path}.{name}: expected a list, found {value!r}")
        return value

    def texts(self) -> list[str]:
        """This very value as a list of texts."""
        if not isinstance(self.content, list):
            raise PlanFormatError(f"{self.path}: expected a list, found {self.content!r}")
        for number, entry in enumerate(self.content):
            if not isinstance(entry, str):
                raise PlanFormatError(f"{self.path}[{number}]: expected text, found {entry!r}")
        return self.content

    def entries(self, name: str, default: Sequence[object] | None = None) -> list[_Reader]:
        if default is not None and isinstance(self.content, dict) and name not in self.content:
            return [_Reader(entry, self.path) for entry in default]
        return [_Reader(entry, f"{self.path}.{name}[{i}]") for i, entry in enumerate(self.array(name))]

    def values(self, name: str, optional: bool = False) -> dict[str, ParameterValue]:
        """Values by name."""
        if optional and isinstance(self.content, dict) and name not in self.content:
            return {}
        found, place = self.value(name), f"{self.path}.{name}"
        if not isinstance(found, dict):
            raise PlanFormatError(f"{place}: expected an object, found {found!r}")
        return {key: _parameter(value, f"{place}.{key}") for key, value in found.items()}

    def bound(self, name: str) -> Bound:
        return _bound(self.value(name), f"{self.path}.{name}")

    def pair(self, name: str) -> Bounds:
        value = self.array(name)
        if len(value) != 2:
            raise PlanFormatError(f"{self.path}.{name}: expected [lower, upper], found {value!r}")
        return _bound(value[0], f"{self.path}.{name}[0]"), _bound(value[1], f"{self.path}.{name}[1]")


def _parameter(value: object, path: str) -> ParameterValue:
    if isinstance(value, list):
        return tuple(_scalar(entry, f"{path}[{number}]") for number, entry in enumerate(value))
    if isinstance(value, dict):
        for name in ("min", "max"):
            _Reader(value, path).value(name)
        if len(value) > 2:
            raise PlanFormatError(f"{path}: expected the fields 'min' and 'max', found {list(value)!r}")
        return {name: None if end is None else _number(end, f"{path}.{name}") for name, end in value.items()}
    return _scalar(value, path)


def _scalar(value: object, path: str) -> Value:
    if isinstance(value, bool | int | float | str):
        return value
    raise PlanFormatError(f"{path}: expected a value (number, text, true or false), found {value!r}")


def _number(value: object, path: str) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return value
    raise PlanFormatError(f"{path}: expected a number or null, found {value!r}")


def _bound(value: object, path: str) -> Bound:
    if value is None or (isinstance(value, int) and not isinstance(value, bool)):
        return value
    raise PlanFormatError(f"{path}: expected a whole number of ticks or null, found {value!r}")
