"""Conditions over telemetry, as data, and the watch that says since when they have held."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Literal, get_args

from executive.errors import BindingsError
from executive.port import TelemetryValue

Telemetry = Mapping[str, TelemetryValue]
Parameters = Mapping[str, TelemetryValue]
Operator = Literal["==", "!=", "<", "<=", ">", ">=", "changed_by", "increased_by"]

_COMPARE: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
# Operators that compare with the value that the channel had when the watch was set.
RELATIVE = ("changed_by", "increased_by")


@dataclass(frozen=True, slots=True)
class Condition:
    """`channel op value`, for example `Condition("ips.state", "==", "standby")`.

    `value` is a literal, `"$name"` (the token's parameter of that name) or `"@channel"` (another channel's value).
    `changed_by`: the channel is at least `value` away from what it was when the watch was set (at the start of the
    activity, or when the command went out); `increased_by`: at least `value` above it. A condition on a channel that
    has not been seen, or that compares by size what is not a number, does not hold.
    """

    channel: str
    op: Operator
    value: TelemetryValue

    def __post_init__(self) -> None:
        if not self.channel:
            raise BindingsError("condition: expected the name of a channel, found an empty one")
        if self.op not in get_args(Operator):
            raise BindingsError(
                f"condition on {self.channel!r}: expected an operator of {', '.join(get_args(Operator))}, "
                f"found {self.op!r}"
            )
        if self.op not in ("==", "!=") and not _is_number(self.value) and not is_reference(self.value):
            raise BindingsError(
                f"condition on {self.channel!r}: {self.op!r} expects a number, '$parameter' or '@channel', "
                f"found {self.value!r}"
            )

    def __str__(self) -> str:
        return f"{self.channel} {self.op} {self.value}"

    @property
    def is_threshold(self) -> bool:
        """Whether it compares a channel by size with a number, so that only the side matters on which the value is."""
        return self.op in _COMPARE and _is_number(self.value)

    def channels(self) -> tuple[str, ...]:
        """The channels that it reads."""
        if isinstance(self.value, str) and self.value.startswith("@"):
            return self.channel, self.value[1:]
        return (self.channel,)

    def bound_to(self, parameters: Parameters) -> Condition:
        """The condition with its parameter's value in place."""
        return replace(self, value=settled(self.value, parameters))

    def holds(self, telemetry: Telemetry, reference: TelemetryValue | None = None) -> bool:
        """Whether it holds now; `reference` is what relative operators compare with."""
        found = telemetry.get(self.channel)
        wanted: TelemetryValue | None = self.value
        if isinstance(wanted, str) and wanted.startswith("@"):
            wanted = telemetry.get(wanted[1:])
        if found is None or wanted is None:
            return False
        if self.op == "==":
            return found == wanted
        if self.op == "!=":
            return found != wanted
        if self.op == "changed_by" and isinstance(found, str | bool):
            return reference is not None and found != reference
        if not _is_number(found) or not _is_number(wanted):
            return False
        if self.op in RELATIVE:
            if not _is_number(reference):
                return False
            moved = float(found) - float(reference or 0)
            return (abs(moved) if self.op == "changed_by" else moved) >= float(wanted)
        return _COMPARE[self.op](float(found), float(wanted))


def is_reference(value: object) -> bool:
    """Whether a value stands for a token's parameter or for another channel."""
    return isinstance(value, str) and len(value) > 1 and value[0] in "$@"


def settled(value: TelemetryValue, parameters: Parameters) -> TelemetryValue:
    """A literal as it is, `"$name"` as the parameter's value."""
    if isinstance(value, str) and len(value) > 1 and value[0] == "$":
        return parameters[value[1:]]
    return value


def parameters_of(values: Iterable[TelemetryValue]) -> tuple[str, ...]:
    """The parameters that the values refer to, in order."""
    return tuple(v[1:] for v in values if isinstance(v, str) and len(v) > 1 and v[0] == "$")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


class Watch:
    """Says whether all of some conditions have held (or, `broken`, failed to hold together) for a number of seconds.

    Set at one instant, when the references of relative conditions are taken; asked at every later observation with
    `update`. `due`: the second at which the answer becomes true if telemetry stays as it is; None when it will not.
    """

    __slots__ = ("_conditions", "_persistence", "_references", "_since", "_wanted")

    def __init__(
        self, conditions: tuple[Condition, ...], persistence: int, telemetry: Telemetry, *, broken: bool = False
    ) -> None:
        self._conditions = conditions
        self._persistence = persistence
        self._references = tuple(telemetry.get(c.channel) if c.op in RELATIVE else None for c in conditions)
        self._wanted = not broken
        self._since: int | None = None

    def update(self, telemetry: Telemetry, now: int) -> bool:
        """Whether it has been so for the whole persistence, up to now (seconds)."""
        return self.hold(self.is_satisfied(telemetry) is self._wanted, now)

    def hold(self, wanted: bool, now: int) -> bool:
        """The same for what was found out elsewhere: whether it has been `wanted` for the whole persistence."""
        if not wanted:
            self._since = None
            return False
        if self._since is None:
            self._since = now
        return now - self._since >= self._persistence

    def due(self, now: int) -> int | None:
        """When it becomes true with unchanged telemetry, if that is later than now."""
        if self._since is None or (due := self._since + self._persistence) <= now:
            return None
        return due

    def is_satisfied(self, telemetry: Telemetry) -> bool:
        """Whether all conditions hold at this instant, for however long."""
        pairs = zip(self._conditions, self._references, strict=True)
        return all(condition.holds(telemetry, reference) for condition, reference in pairs)

    def first_failing(self, telemetry: Telemetry) -> str:
        """The first condition that does not hold, with what was found, for messages."""
        for condition, reference in zip(self._conditions, self._references, strict=True):
            if not condition.holds(telemetry, reference):
                return f"expected {condition}, found {telemetry.get(condition.channel, 'nothing')}"
        return "all conditions hold"
