"""A command to send, what proves that it worked, and what is concluded without proof: the words of all bindings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from executive.conditions import RELATIVE, Condition, is_reference, parameters_of
from executive.errors import BindingsError
from executive.port import TelemetryValue


@dataclass(frozen=True, slots=True)
class Send:
    """A command to send: its name and arguments; an argument `"$name"` stands for the token's parameter."""

    name: str
    arguments: Mapping[str, TelemetryValue] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Conclusion:
    """What is taken as true of a device from now on: a name that `Bindings.state` understands, and words for people."""

    name: str
    text: str


@dataclass(frozen=True, slots=True)
class Confirmation:
    """What proves that commands worked.

    All `conditions` hold for `persistence` seconds in telemetry observed after the commands went out; with no
    conditions, every command is acknowledged and accepted. Without proof `within` seconds, or at once on a refusal, the
    commands are sent again, up to `retries` times; then they are unconfirmed and `conclusion`, if any, is drawn, or
    `unanswered`, if it is given and not one of them was acknowledged. After a recovery from that they are sent again;
    when none is left the token fails.
    """

    conditions: tuple[Condition, ...] = ()
    within: int = 5
    persistence: int = 0
    retries: int = 0
    conclusion: Conclusion | None = None
    unanswered: Conclusion | None = None

    def conclusions(self) -> tuple[Conclusion, ...]:
        """What may be concluded."""
        return tuple(c for c in (self.conclusion, self.unanswered) if c is not None)


ACKNOWLEDGED = Confirmation()
"""The proof that is asked for where nothing else is said: every command is acknowledged and accepted."""


def check_arguments(where: str, sends: Iterable[Send], known: set[str]) -> None:
    """BindingsError for an argument that is neither a value nor a known parameter."""
    for send in sends:
        place = f"{where} command {send.name!r}"
        check_references(place, send.arguments.values(), known)
        for value in send.arguments.values():
            if is_reference(value) and str(value).startswith("@"):
                raise BindingsError(f"{place}: an argument is a value or a '$parameter', found {value!r}")


def check_references(where: str, values: Iterable[TelemetryValue], known: set[str]) -> None:
    """BindingsError for a reference to a parameter that is not among those `known`."""
    for name in parameters_of(values):
        if name not in known:
            expected = ", ".join(sorted(f"${k}" for k in known)) or "no parameter"
            raise BindingsError(f"{where}: unknown parameter '${name}', expected {expected}")


def check_timeless(where: str, conditions: Iterable[Condition], known: set[str] | None = None) -> None:
    """BindingsError for a condition that only makes sense from the start of an activity on."""
    conditions = tuple(conditions)
    check_references(where, (c.value for c in conditions), known or set())
    for condition in conditions:
        if condition.op in RELATIVE:
            raise BindingsError(
                f"{where}: {condition.op!r} compares with the start of an activity, and there is none here"
            )


def check_seconds(where: str, value: object, least: int) -> None:
    """BindingsError for anything but a whole number of at least `least`."""
    if not isinstance(value, int) or isinstance(value, bool) or value < least:
        raise BindingsError(
            f"{where}: expected a whole number of seconds or times of at least {least}, found {value!r}"
        )


def check_confirmation(where: str, confirmation: Confirmation) -> None:
    """BindingsError for times that cannot be."""
    check_seconds(f"{where}.within", confirmation.within, 1)
    check_seconds(f"{where}.persistence", confirmation.persistence, 0)
    check_seconds(f"{where}.retries", confirmation.retries, 0)
    if confirmation.persistence >= confirmation.within:
        raise BindingsError(
            f"{where}: a persistence of {confirmation.persistence} s can never be seen within {confirmation.within} s"
        )
