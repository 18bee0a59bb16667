"""How a domain's tokens become commands and telemetry: data, validated when made, the same for every domain."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Literal

from executive.conditions import Condition, Telemetry, is_reference
from executive.errors import BindingsError
from executive.protection import OWN, Monitor, Probe, Response, concluded_channel, probe_channel
from executive.sends import (
    ACKNOWLEDGED,
    Conclusion,
    Confirmation,
    Send,
    check_arguments,
    check_confirmation,
    check_references,
    check_seconds,
)
from planner.problem import TokenPattern

NEXT_PLAN = f"{OWN}next_plan"
"""Where asking for the next plan stands: "none", "asked", "ready" or "failed"."""
MODE = f"{OWN}mode"
"""Whether a plan is being executed: "plan" or "standby"."""

StateFunction = Callable[[Telemetry, frozenset[str]], tuple[TokenPattern, ...]]


@dataclass(frozen=True, slots=True)
class Finish:
    """What is the end of an activity whose duration nature decides: all conditions for `persistence` seconds.

    It counts only in telemetry after the start was confirmed. Its deadline is the plan's: start plus the longest
    duration. `hold_early`: an end seen before the shortest duration is taken as one at the shortest duration, because
    what it brought about lasts (a device that warmed up early stays warm); otherwise it is a violation. `conclusion` is
    drawn when it is late and all of `evidence` holds.
    """

    conditions: tuple[Condition, ...]
    persistence: int = 0
    hold_early: bool = False
    conclusion: Conclusion | None = None
    evidence: tuple[Condition, ...] = ()


@dataclass(frozen=True, slots=True)
class Maintained:
    """A property that a running token needs (a property lock): broken once not held for `persistence` seconds.

    `conclusion` is then drawn, and what the response to it cannot restore makes the token fail. `made_up`: the time
    without the property is added at the token's end, as far as the plan allows; more than it allows is a violation.
    """

    name: str
    conditions: tuple[Condition, ...]
    persistence: int = 0
    conclusion: Conclusion | None = None
    made_up: bool = False


@dataclass(frozen=True, slots=True)
class Near:
    """As near as the window allows to a preferred time: `seconds` of simulation clock, or, with `after_start` (for
    ends), after the token's start. `"$name"`: what the token's parameter of that name says.
    """

    seconds: int | str
    after_start: bool = False


Wish = Literal["earliest", "latest"] | Near
"""When to perform a timepoint inside the window that the plan leaves."""


@dataclass(frozen=True, slots=True)
class Activity:
    """What the tokens of one predicate (`"Class.predicate"`) mean to the hardware.

    `parameters`: the predicate's parameters that the fields below refer to as `"$name"`; `"$object"`, the name of the
    token's object, is always there. `contingent`: the domain says
    that nature decides the duration, so `finish` is needed. `start`: sent when the token starts, proven by `started`.
    `end`: sent when it ends, proven by `ended`; for a contingent activity that is after its finish was seen.
    `maintained`: locked from the proof of the start to the end. `stop`: brings a running one to a safe halt.
    `asks_for_plan`: its start asks for the plan of the next horizon. `starts`, `ends`: when that is done inside the
    window that the plan leaves, where it is the executive's to choose.
    """

    predicate: str
    parameters: tuple[str, ...] = ()
    contingent: bool = False
    start: tuple[Send, ...] = ()
    started: Confirmation = ACKNOWLEDGED
    finish: Finish | None = None
    end: tuple[Send, ...] = ()
    ended: Confirmation = ACKNOWLEDGED
    maintained: tuple[Maintained, ...] = ()
    stop: tuple[Send, ...] = ()
    asks_for_plan: bool = False
    starts: Wish = "earliest"
    ends: Wish = "earliest"

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
        _check_wishes(where, self.starts, self.ends, self.contingent, known)
        for name in ("start", "end", "stop"):
            check_arguments(f"{where}.{name}", getattr(self, name), known)
        for name, conditions in self.conditions():
            check_references(f"{where}.{name}", (c.value for c in conditions), known)
        for name, confirmation in (("started", self.started), ("ended", self.ended)):
            check_confirmation(f"{where}.{name}", confirmation)
        for lock in self.maintained:
            check_seconds(f"{where}.maintained {lock.name!r}.persistence", lock.persistence, 0)
            if not lock.conditions:
                raise BindingsError(f"{where}.maintained {lock.name!r}.conditions: expected at least one, found none")
        if self.finish is not None:
            check_seconds(f"{where}.finish.persistence", self.finish.persistence, 0)

    def conditions(self) -> Iterable[tuple[str, tuple[Condition, ...]]]:
        """All that it reads, by the name of the field."""
        yield "started", self.started.conditions
        yield "ended", self.ended.conditions
        if self.finish is not None:
            yield "finish", self.finish.conditions
        for lock in self.maintained:
            yield f"maintained {lock.name!r}", lock.conditions

    def conclusions(self) -> Iterable[Conclusion]:
        """What may be concluded when it fails."""
        yield from (*self.started.conclusions(), *self.ended.conclusions())
        for source in (self.finish, *self.maintained):
            if source is not None and source.conclusion is not None:
                yield source.conclusion

    def channels(self) -> set[str]:
        """The channels that its conditions read."""
        return {c for _, conditions in self.conditions() for condition in conditions for c in condition.channels()}


def plan_next(predicate: str) -> Activity:
    """The activity whose effect is to ask for the plan of the next horizon; it is over when the planner has answered.

    Nature decides how long that takes: never longer than the deliberation budget, so the domain's bounds must hold it.
    """
    answered = Condition(NEXT_PLAN, "!=", "asked")
    return Activity(predicate, contingent=True, finish=Finish((answered,), hold_early=True), asks_for_plan=True)


@dataclass(frozen=True, slots=True)
class Standby:
    """How to be safe without a plan: commands, and the condition that says that standby is reached.

    `confirmation.within` seconds without proof is a violation and the commands go out again, for as long as it takes.
    """

    commands: tuple[Send, ...]
    confirmation: Confirmation

    def __post_init__(self) -> None:
        check_arguments("standby", self.commands, set())
        if not self.confirmation.conditions:
            raise BindingsError(
                "standby.confirmation.conditions: expected what says that standby is reached, found none"
            )
        check_references("standby.confirmation", (c.value for c in self.confirmation.conditions), set())
        check_confirmation("standby.confirmation", self.confirmation)


@dataclass(frozen=True)
class Bindings:
    """All that the executive knows of a domain.

    `activities`: at most one for each predicate; a token of any other predicate only takes time. `state(telemetry,
    conclusions)`: the tokens that hold now, from the latest values of the subscribed channels (no others are there) and
    the names of the conclusions drawn so far; a pure function, and of discrete facts only, since a state at hand-over
    that differs from the state planned for costs another plan. `state_channels`: the channels that it reads.
    `observed`: channels that nothing reads but that the journal should hold. `probes`, `monitors`, `responses`: fault
    protection, see `executive.protection`; at most one response for each conclusion.
    """

    activities: tuple[Activity, ...]
    standby: Standby
    state: StateFunction
    state_channels: tuple[str, ...] = ()
    monitors: tuple[Monitor, ...] = ()
    observed: tuple[str, ...] = ()
    probes: tuple[Probe, ...] = ()
    responses: tuple[Response, ...] = ()
    _by_predicate: dict[str, Activity] = field(init=False, repr=False, compare=False, default_factory=dict)
    _by_conclusion: dict[str, Response] = field(init=False, repr=False, compare=False, default_factory=dict)

    def __post_init__(self) -> None:
        _check_unique("activities", "activity for", [activity.predicate for activity in self.activities])
        _check_unique("monitors", "monitor", [monitor.name for monitor in self.monitors])
        _check_unique("probes", "probe", [probe.name for probe in self.probes])
        _check_unique("responses", "response to", [response.conclusion for response in self.responses])
        self._by_predicate.update((activity.predicate, activity) for activity in self.activities)
        self._by_conclusion.update((response.conclusion, response) for response in self.responses)
        for activity in self.activities:
            known = {*activity.parameters, "object"}
            for conclusion in activity.conclusions():
                self._check_responses(f"activity {activity.predicate!r}", conclusion, known)
        for monitor in self.monitors:
            self._check_responses(f"monitor {monitor.name!r}", monitor.conclusion, set())
        own = {NEXT_PLAN, MODE, *(probe_channel(probe.name) for probe in self.probes)}
        own.update(concluded_channel(conclusion) for conclusion in self.conclusions())
        for name in self._read():
            if name.startswith(OWN) and name not in own:
                raise BindingsError(f"bindings: condition on {name!r}: the executive has no such channel")

    def _check_responses(self, source: str, conclusion: Conclusion, known: set[str]) -> None:
        """Follow what may be concluded in turn: it must come to an end, and every recovery must find its parameters."""
        seen: set[str] = set()
        following: Conclusion | None = conclusion
        while following is not None and (response := self.response(following)) is not None:
            if following.name in seen:
                raise BindingsError(f"bindings.responses: {following.name!r} leads back to itself by 'otherwise'")
            seen.add(following.name)
            response.check_parameters(source, known)
            following = response.otherwise

    def activity(self, predicate: str) -> Activity | None:
        """The activity of that predicate, None when its tokens only take time."""
        return self._by_predicate.get(predicate)

    def conclusions(self) -> Iterable[Conclusion]:
        """All that may be concluded by activities, monitors and responses."""
        for activity in self.activities:
            yield from activity.conclusions()
        yield from (monitor.conclusion for monitor in self.monitors)
        yield from (response.otherwise for response in self.responses if response.otherwise is not None)
        yield from self.standby.confirmation.conclusions()

    def response(self, conclusion: Conclusion) -> Response | None:
        """What is done about a conclusion, None when nothing but planning anew."""
        return self._by_conclusion.get(conclusion.name)

    def channels(self) -> frozenset[str]:
        """Every channel of a plant that a decision or the journal needs."""
        return frozenset(name for name in self._read() if not name.startswith(OWN))

    def thresholds(self) -> dict[str, tuple[Condition, ...]]:
        """The channels that are only ever compared by size with numbers, and with which: all that matters of them is
        on which side they are.
        """
        found: dict[str, list[Condition]] = {}
        others = {*self.state_channels, *self.observed}
        for condition in self._conditions():
            if condition.is_threshold:
                found.setdefault(condition.channel, []).append(condition)
            else:
                others.update(condition.channels())
        return {name: tuple(conditions) for name, conditions in found.items() if name not in others}

    def _read(self) -> set[str]:
        read = {*self.state_channels, *self.observed}
        read.update(channel for condition in self._conditions() for channel in condition.channels())
        return read

    def _conditions(self) -> Iterable[Condition]:
        for activity in self.activities:
            for _, conditions in activity.conditions():
                yield from conditions
        yield from self.standby.confirmation.conditions
        for monitor in self.monitors:
            yield from (*monitor.conditions, *monitor.votes, *monitor.until)
        for probe in self.probes:
            yield from probe.while_
        for response in self.responses:
            yield from response.conditions()


def _check_wishes(where: str, starts: Wish, ends: Wish, contingent: bool, known: set[str]) -> None:
    for name, wish in (("starts", starts), ("ends", ends)):
        if isinstance(wish, Near):
            if isinstance(wish.seconds, str):
                check_references(f"{where}.{name}", (wish.seconds,), known)
            if not is_reference(wish.seconds):
                check_seconds(f"{where}.{name}.seconds", wish.seconds, 0)
        elif wish not in ("earliest", "latest"):
            raise BindingsError(f"{where}.{name}: expected 'earliest', 'latest' or Near(...), found {wish!r}")
    if isinstance(starts, Near) and starts.after_start:
        raise BindingsError(f"{where}.starts: only an end can be wanted some time after the start")
    if contingent and ends != "earliest":
        raise BindingsError(f"{where}.ends: nature decides when a contingent activity ends, found {ends!r}")


def _check_unique(field_name: str, what: str, names: list[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            raise BindingsError(f"bindings.{field_name}: expected one {what} {name!r}, found {names.count(name)}")
