"""How a domain's tokens become commands and telemetry: data, validated when made, the same for every domain."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from executive.conditions import RELATIVE, Condition, Telemetry, is_reference, parameters_of
from executive.errors import BindingsError
from executive.port import TelemetryValue
from planner.problem import TokenPattern

OWN = "executive."
"""What the names of the executive's own channels begin with; no plant has them."""
NEXT_PLAN = f"{OWN}next_plan"
"""Where asking for the next plan stands: "none", "asked", "ready" or "failed"."""

StateFunction = Callable[[Telemetry, frozenset[str]], tuple[TokenPattern, ...]]


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
    commands are sent again, up to `retries` times; then they are unconfirmed, the token fails, and `conclusion`, if
    any, is drawn.
    """

    conditions: tuple[Condition, ...] = ()
    within: int = 5
    persistence: int = 0
    retries: int = 0
    conclusion: Conclusion | None = None


@dataclass(frozen=True, slots=True)
class Finish:
    """What is the end of an activity whose duration nature decides: all conditions for `persistence` seconds.

    It counts only in telemetry after the start was confirmed. Its deadline is the plan's: start plus the longest
    duration. `hold_early`: an end seen before the shortest duration is taken as one at the shortest duration, because
    what it brought about lasts (a device that warmed up early stays warm); otherwise it is a violation.
    """

    conditions: tuple[Condition, ...]
    persistence: int = 0
    hold_early: bool = False
    conclusion: Conclusion | None = None


@dataclass(frozen=True, slots=True)
class Maintained:
    """A property that a running token needs (a property lock): broken once not held for `persistence` seconds."""

    name: str
    conditions: tuple[Condition, ...]
    persistence: int = 0
    conclusion: Conclusion | None = None


@dataclass(frozen=True, slots=True)
class Activity:
    """What the tokens of one predicate (`"Class.predicate"`) mean to the hardware.

    `parameters`: the predicate's parameters that the fields below refer to as `"$name"`; `"$object"`, the name of the
    token's object, is always there. `contingent`: the domain says
    that nature decides the duration, so `finish` is needed. `start`: sent when the token starts, proven by `started`.
    `end`: sent when it ends, proven by `ended`; for a contingent activity that is after its finish was seen.
    `maintained`: locked from the proof of the start to the end. `stop`: brings a running one to a safe halt.
    `asks_for_plan`: its start asks for the plan of the next horizon.
    """

    predicate: str
    parameters: tuple[str, ...] = ()
    contingent: bool = False
    start: tuple[Send, ...] = ()
    started: Confirmation = Confirmation()
    finish: Finish | None = None
    end: tuple[Send, ...] = ()
    ended: Confirmation = Confirmation()
    maintained: tuple[Maintained, ...] = ()
    stop: tuple[Send, ...] = ()
    asks_for_plan: bool = False

    def __post_init__(self) -> None:
        where = f"activity {self.predicate!r}"
        if self.contingent and self.finish is None:
            raise BindingsError(
                f"{where}.finish: a contingent activity needs the conditions that are its end, found none"
            )
        if self.finish is not None and not self.contingent:
            raise BindingsError(f"{where}.finish: only a contingent activity ends by itself, and this one is not")
        if self.finish is not None and not self.finish.conditions:
            raise BindingsError(f"{where}.finish.conditions: expected at least one condition, found none")
        known = {*self.parameters, "object"}
        for name in ("start", "end", "stop"):
            for send in getattr(self, name):
                _check_references(f"{where}.{name} command {send.name!r}", send.arguments.values(), known)
        for name, conditions in self._conditions():
            _check_references(f"{where}.{name}", (c.value for c in conditions), known)
        for name, confirmation in (("started", self.started), ("ended", self.ended)):
            _check_confirmation(f"{where}.{name}", confirmation)
        for lock in self.maintained:
            _check_seconds(f"{where}.maintained {lock.name!r}.persistence", lock.persistence, 0)
            if not lock.conditions:
                raise BindingsError(f"{where}.maintained {lock.name!r}.conditions: expected at least one, found none")
        if self.finish is not None:
            _check_seconds(f"{where}.finish.persistence", self.finish.persistence, 0)

    def _conditions(self) -> Iterable[tuple[str, tuple[Condition, ...]]]:
        yield "started", self.started.conditions
        yield "ended", self.ended.conditions
        if self.finish is not None:
            yield "finish", self.finish.conditions
        for lock in self.maintained:
            yield f"maintained {lock.name!r}", lock.conditions

    def channels(self) -> set[str]:
        """The channels that its conditions read."""
        return {c for _, conditions in self._conditions() for condition in conditions for c in condition.channels()}


def plan_next(predicate: str) -> Activity:
    """The activity whose effect is to ask for the plan of the next horizon; it is over when the planner has answered.

    Nature decides how long that takes: never longer than the deliberation budget, so the domain's bounds must hold it.
    """
    answered = Condition(NEXT_PLAN, "!=", "asked")
    return Activity(predicate, contingent=True, finish=Finish((answered,), hold_early=True), asks_for_plan=True)


@dataclass(frozen=True, slots=True)
class Response:
    """A recovery that a monitor tries: commands, and the seconds within which the symptom must be gone."""

    name: str
    commands: tuple[Send, ...]
    within: int
    attempts: int = 1


@dataclass(frozen=True, slots=True)
class Monitor:
    """Fault protection: the symptom is all `conditions` for `persistence` seconds.

    Each response is tried in order, `attempts` times; when the symptom goes, nothing more happens. When none helped (or
    there is none) the conclusion is drawn; `replan`: the plan in execution is then given up. A monitor that has
    concluded is silent from then on.
    """

    name: str
    conditions: tuple[Condition, ...]
    persistence: int
    conclusion: Conclusion
    responses: tuple[Response, ...] = ()
    replan: bool = True

    def __post_init__(self) -> None:
        where = f"monitor {self.name!r}"
        if not self.conditions:
            raise BindingsError(f"{where}.conditions: expected at least one condition, found none")
        _check_references(f"{where}.conditions", (c.value for c in self.conditions), set())
        for condition in self.conditions:
            if condition.op in RELATIVE:
                raise BindingsError(
                    f"{where}.conditions: {condition.op!r} compares with the start of an activity, a monitor has none"
                )
        _check_seconds(f"{where}.persistence", self.persistence, 0)
        for response in self.responses:
            _check_seconds(f"{where}.responses {response.name!r}.within", response.within, 1)
            _check_seconds(f"{where}.responses {response.name!r}.attempts", response.attempts, 1)
            for send in response.commands:
                _check_references(f"{where}.responses {response.name!r}", send.arguments.values(), set())


@dataclass(frozen=True, slots=True)
class Standby:
    """How to be safe without a plan: commands, and the condition that says that standby is reached.

    `confirmation.within` seconds without proof is a violation and the commands go out again, for as long as it takes.
    """

    commands: tuple[Send, ...]
    confirmation: Confirmation

    def __post_init__(self) -> None:
        for send in self.commands:
            _check_references(f"standby command {send.name!r}", send.arguments.values(), set())
        if not self.confirmation.conditions:
            raise BindingsError(
                "standby.confirmation.conditions: expected what says that standby is reached, found none"
            )
        _check_references("standby.confirmation", (c.value for c in self.confirmation.conditions), set())
        _check_confirmation("standby.confirmation", self.confirmation)


@dataclass(frozen=True)
class Bindings:
    """All that the executive knows of a domain.

    `activities`: at most one for each predicate; a token of any other predicate only takes time. `state(telemetry,
    conclusions)`: the tokens that hold now, from the latest values of the subscribed channels (no others are there) and
    the names of the conclusions drawn so far; a pure function, and of discrete facts only, since a state at hand-over
    that differs from the state planned for costs another plan. `state_channels`: the channels that it reads.
    `observed`: channels that nothing reads but that the journal should hold.
    """

    activities: tuple[Activity, ...]
    standby: Standby
    state: StateFunction
    state_channels: tuple[str, ...] = ()
    monitors: tuple[Monitor, ...] = ()
    observed: tuple[str, ...] = ()
    _by_predicate: dict[str, Activity] = field(init=False, repr=False, compare=False, default_factory=dict)

    def __post_init__(self) -> None:
        for activity in self.activities:
            if activity.predicate in self._by_predicate:
                raise BindingsError(f"bindings.activities: expected one activity for {activity.predicate!r}, found two")
            self._by_predicate[activity.predicate] = activity
        names = [monitor.name for monitor in self.monitors]
        for name in names:
            if names.count(name) > 1:
                raise BindingsError(f"bindings.monitors: expected one monitor {name!r}, found {names.count(name)}")

    def activity(self, predicate: str) -> Activity | None:
        """The activity of that predicate, None when its tokens only take time."""
        return self._by_predicate.get(predicate)

    def channels(self) -> frozenset[str]:
        """Every channel of a plant that a decision or the journal needs."""
        found = {*self.state_channels, *self.observed}
        for activity in self.activities:
            found |= activity.channels()
        for conditions in (self.standby.confirmation.conditions, *(m.conditions for m in self.monitors)):
            found.update(c for condition in conditions for c in condition.channels())
        return frozenset(name for name in found if not name.startswith(OWN))


def _check_references(where: str, values: Iterable[TelemetryValue], known: set[str]) -> None:
    values = tuple(values)
    for name in parameters_of(values):
        if name not in known:
            expected = ", ".join(sorted(f"${k}" for k in known)) or "no parameter"
            raise BindingsError(f"{where}: unknown parameter '${name}', expected {expected}")
    if " command " in where or ".responses " in where:
        for value in values:
            if is_reference(value) and str(value).startswith("@"):
                raise BindingsError(f"{where}: an argument is a value or a '$parameter', found {value!r}")


def _check_seconds(where: str, value: object, least: int) -> None:
    if not isinstance(value, int) or isinstance(value, bool) or value < least:
        raise BindingsError(
            f"{where}: expected a whole number of seconds or times of at least {least}, found {value!r}"
        )


def _check_confirmation(where: str, confirmation: Confirmation) -> None:
    _check_seconds(f"{where}.within", confirmation.within, 1)
    _check_seconds(f"{where}.persistence", confirmation.persistence, 0)
    _check_seconds(f"{where}.retries", confirmation.retries, 0)
    if confirmation.persistence >= confirmation.within:
        raise BindingsError(
            f"{where}: a persistence of {confirmation.persistence} s can never be seen within {confirmation.within} s"
        )
