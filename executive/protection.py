"""Fault protection as data, in three parts that know nothing of each other.

A `Monitor` says what in telemetry (or, through a `Probe`, in answers to commands) speaks for a conclusion. A
`Conclusion` is a name and words. A `Response` says what is done about a conclusion, whoever has drawn it: a monitor, a
command without effect, a lost lock, or a model-based diagnosis (anything that is a `executive.monitor.Diagnoser`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from executive.conditions import Condition
from executive.errors import BindingsError
from executive.port import TelemetryValue
from executive.sends import (
    ACKNOWLEDGED,
    Conclusion,
    Confirmation,
    Send,
    check_arguments,
    check_confirmation,
    check_references,
    check_seconds,
    check_timeless,
)
from planner.problem import TokenPattern

OWN = "executive."
"""What the names of the executive's own channels begin with; no plant has them."""


def probe_channel(name: str) -> str:
    """Where a probe stands: "unknown" (not probed, or not answered yet), "answers" or "silent"."""
    return f"{OWN}probe.{name}"


def concluded_channel(conclusion: Conclusion) -> str:
    """Whether a conclusion stands: a channel of the executive's own, true or false."""
    return f"{OWN}concluded.{conclusion.name}"


@dataclass(frozen=True, slots=True)
class Probe:
    """A question that only a living unit answers, so that silence becomes telemetry: `probe_channel(name)`.

    While all conditions of `while_` hold, `command` is sent every `every` seconds. Any acknowledgement within `within`
    seconds is an answer, a refusal too; without one the unit is silent, and is asked again at once.
    """

    name: str
    command: Send
    every: int
    within: int
    while_: tuple[Condition, ...] = ()

    def __post_init__(self) -> None:
        where = f"probe {self.name!r}"
        check_arguments(where, (self.command,), set())
        check_seconds(f"{where}.within", self.within, 1)
        check_seconds(f"{where}.every", self.every, self.within)
        check_timeless(f"{where}.while_", self.while_)


@dataclass(frozen=True, slots=True)
class Monitor:
    """The symptom that speaks for `conclusion`: all `conditions`, and at least `needed` of the `votes`, for
    `persistence` seconds. Votes are redundant evidence: each on its own might be wrong. A symptom is gone when the
    evidence is, or, if conditions `until` are given, when they all hold.
    """

    name: str
    conditions: tuple[Condition, ...]
    persistence: int
    conclusion: Conclusion
    votes: tuple[Condition, ...] = ()
    needed: int = 0
    until: tuple[Condition, ...] = ()

    def __post_init__(self) -> None:
        where = f"monitor {self.name!r}"
        if not self.conditions and not self.needed:
            raise BindingsError(f"{where}.conditions: expected at least one condition, found none")
        check_timeless(f"{where}.conditions", self.conditions)
        check_timeless(f"{where}.votes", self.votes)
        check_timeless(f"{where}.until", self.until)
        check_seconds(f"{where}.persistence", self.persistence, 0)
        if not isinstance(self.needed, int) or not bool(self.votes) <= self.needed <= len(self.votes):
            raise BindingsError(
                f"{where}.needed: expected {int(bool(self.votes))} to {len(self.votes)} of the votes, "
                f"found {self.needed!r}"
            )


@dataclass(frozen=True, slots=True)
class Step:
    """Commands of a recovery, and what proves that they went through."""

    commands: tuple[Send, ...]
    confirmation: Confirmation = ACKNOWLEDGED


@dataclass(frozen=True, slots=True)
class Recovery:
    """A way back: `steps` one after another, after the last of which the symptom must be gone `within` seconds.

    Tried up to `attempts` times, as long as all conditions of `when` hold at its start. `disturbs`: channels that may
    change on the way; it is not tried while a running token has a lock on one of them.
    """

    name: str
    steps: tuple[Step, ...]
    within: int
    attempts: int = 1
    when: tuple[Condition, ...] = ()
    disturbs: tuple[str, ...] = ()


@dataclass(frozen=True)
class Response:
    """What is done about the conclusion of that name.

    `recoveries` are tried in order. Once one has worked the conclusion is withdrawn, or, with `lasts`, stands (the
    fault is still there, but is worked around). While they are tried, the locks named in `restores` may be broken, and
    the conclusions named in `masks` are not drawn: what speaks for them may come from this fault or from its recovery.
    After `limit` uses in a run they are not tried any more. When there is none left, `otherwise` is concluded if it is
    given, with its own response; where there are no recoveries at all, when what it is concluded from is seen again.

    While the conclusion stands: `vetoes` replaces what channels say by what is believed (None: nothing is known);
    commands whose names begin with one of `forbids` are not sent any more (the device is marked as failed); standby
    does without proof on the channels in `waives`; and `facts` are true in every planning problem.

    `replan`: "now", the plan in execution may not go on; "next", it may, but no plan made before may follow it;
    "never", what is planned does not depend on it.
    """

    conclusion: str
    recoveries: tuple[Recovery, ...] = ()
    limit: int | None = None
    otherwise: Conclusion | None = None
    lasts: bool = False
    restores: tuple[str, ...] = ()
    masks: tuple[str, ...] = ()
    vetoes: Mapping[str, TelemetryValue | None] = field(default_factory=dict)
    forbids: tuple[str, ...] = ()
    waives: tuple[str, ...] = ()
    facts: tuple[TokenPattern, ...] = ()
    replan: Literal["now", "next", "never"] = "now"

    def __post_init__(self) -> None:
        where = f"response to {self.conclusion!r}"
        if self.otherwise is not None and self.otherwise.name == self.conclusion:
            raise BindingsError(f"{where}.otherwise: expected another conclusion, found the same")
        if self.limit is not None:
            check_seconds(f"{where}.limit", self.limit, 1)
        for recovery in self.recoveries:
            place = f"{where}.recoveries {recovery.name!r}"
            check_seconds(f"{place}.within", recovery.within, 1)
            check_seconds(f"{place}.attempts", recovery.attempts, 1)
            check_timeless(f"{place}.when", recovery.when)
            if not recovery.steps:
                raise BindingsError(f"{place}.steps: expected at least one, found none")
            for number, step in enumerate(recovery.steps):
                check_confirmation(f"{place}.steps[{number}].confirmation", step.confirmation)

    def conditions(self) -> Iterable[Condition]:
        """All that its recoveries read."""
        for recovery in self.recoveries:
            yield from recovery.when
            for step in recovery.steps:
                yield from step.confirmation.conditions

    def check_parameters(self, source: str, known: set[str]) -> None:
        """BindingsError when a recovery needs a parameter that what draws the conclusion does not have."""
        for recovery in self.recoveries:
            for step in recovery.steps:
                where = f"response to {self.conclusion!r}, drawn by {source}, recovery {recovery.name!r}"
                check_arguments(where, step.commands, known)
                check_references(where, (c.value for c in step.confirmation.conditions), known)
