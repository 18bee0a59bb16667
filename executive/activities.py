"""Running tokens: started, confirmed, finished, failed, unconfirmed, aborted; each is a distinct event.

A token without an activity only takes time. One with an activity sends its commands, waits for their proof, holds its
locks, and, where nature decides its duration, ends when telemetry says so and not before or after its bounds. What goes
wrong is a violation only when no recovery is left to try.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from executive.bindings import Activity, Bindings
from executive.commands import CommandLink, Progress
from executive.conditions import Parameters, Telemetry, Watch
from executive.journal import Journal
from executive.locks import BrokenLock, LockTable
from executive.monitor import Violation
from executive.port import TelemetryValue
from executive.recovery import Case, FaultProtection
from executive.sends import Confirmation, Send
from executive.undertaking import Undertaking
from planner.plan import ParameterValue, PlanToken


@dataclass(eq=False)
class RunningToken:
    """A token from its start until its end has happened and everything sent for it is proven. Times are seconds.

    `cases`: what is being done about broken locks, by name. `without`: since when locks that are made up for have been
    broken. `lost`: what that has cost before.
    """

    token: PlanToken
    activity: Activity | None
    parameters: Parameters
    started: int
    starting: Undertaking | None = None
    ending: Undertaking | None = None
    finish: Watch | None = None
    ended: int | None = None
    cases: dict[str, Case] = field(default_factory=dict)
    without: dict[str, int] = field(default_factory=dict)
    lost: int = 0

    def __repr__(self) -> str:
        return f"RunningToken({self.token.id} since {self.started} s)"

    @property
    def is_over(self) -> bool:
        """It has ended and nothing is left to be proven."""
        return self.ended is not None and self.starting is None and self.ending is None

    @property
    def earliest_end(self) -> int:
        """The first second at which nature may end it."""
        return self.started + (self.token.duration[0] or 0)

    @property
    def deadline(self) -> int | None:
        """The last second at which nature may end it."""
        return None if self.token.duration[1] is None else self.started + self.token.duration[1]

    def lost_by(self, now: int) -> int:
        """For how many seconds it has been without what has to be made up for."""
        return self.lost + sum(now - since for since in self.without.values())

    @property
    def awaits_nature(self) -> bool:
        """Its end is still for nature to decide."""
        return self.token.contingent and self.ended is None


@dataclass(frozen=True, slots=True)
class Progressed:
    """What one observation brought: tokens that nature ended, tokens now over, and what went wrong."""

    ended: tuple[PlanToken, ...] = ()
    over: tuple[PlanToken, ...] = ()
    violations: tuple[Violation, ...] = ()


@dataclass(eq=False)
class Activities:
    """All running tokens of one plan, in the order in which they started."""

    plan_id: str
    bindings: Bindings
    link: CommandLink
    protection: FaultProtection
    journal: Journal
    locks: LockTable = field(default_factory=LockTable)
    running: dict[str, RunningToken] = field(default_factory=dict)

    def begin(self, token: PlanToken, telemetry: Telemetry, now: int, began: int | None = None) -> list[Violation]:
        """Start a token now, or take in one that has been running since `began`."""
        activity = self.bindings.activity(token.predicate)
        parameters = decided(token)
        run = RunningToken(token, activity, parameters, now if began is None else began)
        self.running[token.id] = run
        self._tell(now, "token.started", token)
        if activity is None:
            return []
        if began is None and (activity.start or activity.started.conditions):
            run.starting = self._undertake(activity.start, activity.started, run)
            run.starting.send(telemetry, now)
            return []
        return self._confirmed(run, telemetry, now)

    def take_over(self, other: Activities, run: RunningToken, token: PlanToken, now: int) -> None:
        """Go on with what another plan's token does, under a token of this plan: nothing is stopped or sent again."""
        before = run.token.id
        del other.running[before]
        other.locks.hand_over(before, self.locks, token.id)
        for undertaking in (run.starting, run.ending):
            if undertaking is not None:
                undertaking.serve(token.id)
        run.token = token
        self.running[token.id] = run
        if run.ended is None:
            self._tell(now, "token.started", token, {"continues": f"{other.plan_id}/{before}"})

    def asks_for_plan(self, token_id: str) -> bool:
        """Whether what a running token does is asking for the next plan."""
        run = self.running.get(token_id)
        return run is not None and run.activity is not None and run.activity.asks_for_plan

    def end(self, token_id: str, telemetry: Telemetry, now: int) -> tuple[PlanToken, ...]:
        """The token's end happens now: its locks go, its end commands go out. Returns it if it is over with that."""
        run = self.running[token_id]
        run.ended = now
        self._release(run)
        if run.starting is not None:
            run.starting.no_more_tries()  # starting it again after its end would be worse than not at all
        activity = run.activity
        if activity is not None and (activity.end or activity.ended.conditions):
            run.ending = self._undertake(activity.end, activity.ended, run)
            run.ending.send(telemetry, now)
        return self._if_over(run, now)

    def observe(self, telemetry: Telemetry, now: int) -> Progressed:
        """One observation: confirmations, ends that nature decided, deadlines, locks."""
        ended: list[PlanToken] = []
        over: list[PlanToken] = []
        violations: list[Violation] = []
        for run in tuple(self.running.values()):
            over += self._follow(run, telemetry, now, violations)
            if run.finish is not None and run.awaits_nature:
                ended += self._watch_finish(run, telemetry, now, violations)
            if run.awaits_nature and run.token not in ended and run.deadline is not None and now >= run.deadline:
                violations.append(self._late(run, telemetry))
        violations += self._watch_locks(telemetry, now)
        return Progressed(tuple(ended), tuple(over), tuple(violations))

    def abort(self, now: int, violations: Iterable[Violation] = ()) -> None:
        """Stop everything, the latest first: failed tokens with their reasons, all others aborted."""
        reasons: dict[str, str] = {}
        for violation in violations:
            if violation.token is not None:
                reasons.setdefault(violation.token, f"{violation.kind}: {violation.detail}")
        for run in reversed(tuple(self.running.values())):
            for undertaking in (run.starting, run.ending):
                if undertaking is not None:
                    undertaking.close()
            self._release(run)
            if run.token.id in reasons:
                self._tell(now, "token.failed", run.token, {"reason": reasons[run.token.id]})
            else:
                self._tell(now, "token.aborted", run.token)
            if run.activity is not None:
                self.link.forget(self.link.send(run.activity.stop, run.parameters, run.token.id, now))
        self.running.clear()

    def dues(self, now: int) -> Iterable[int]:
        """The seconds at which waiting alone changes something."""
        for run in self.running.values():
            for undertaking in (run.starting, run.ending):
                if undertaking is not None and (due := undertaking.due(now)) is not None:
                    yield due
            if run.awaits_nature:
                if run.deadline is not None:
                    yield run.deadline
                if run.finish is not None:
                    if (due := run.finish.due(now)) is not None:
                        yield due
                    if run.earliest_end > now:
                        yield run.earliest_end
        yield from self.locks.dues(now)

    def _follow(
        self, run: RunningToken, telemetry: Telemetry, now: int, violations: list[Violation]
    ) -> tuple[PlanToken, ...]:
        """What is known of the commands sent for a token. Returns it if it is over with that."""
        if run.starting is not None and (progress := run.starting.follow(telemetry, now)) != "pending":
            if progress == "confirmed":
                run.starting.close()
                run.starting = None
                self._tell(now, "token.confirmed", run.token)
                if run.ended is None:
                    violations += self._confirmed(run, telemetry, now)
            else:
                violations.append(_unconfirmed(run, "start", run.starting, progress))
        if run.ending is not None and (progress := run.ending.follow(telemetry, now)) != "pending":
            if progress == "confirmed":
                run.ending.close()
                run.ending = None
            else:
                violations.append(_unconfirmed(run, "end", run.ending, progress))
        return self._if_over(run, now)

    def _undertake(self, sends: tuple[Send, ...], confirmation: Confirmation, run: RunningToken) -> Undertaking:
        return Undertaking(self.link, self.protection, sends, confirmation, run.parameters, run.token.id)

    def _watch_locks(self, telemetry: Telemetry, now: int) -> list[Violation]:
        """Locks that are broken, restored, or beyond restoring."""
        for run in self.running.values():
            self._count_losses(run, telemetry, now)
            for name, case in tuple(run.cases.items()):
                if self.locks.kept(run.token.id, name, telemetry):
                    del run.cases[name]
                    if case.is_open:
                        case.recovered(now)
        excused = self.protection.restoring()
        violations = []
        for broken in self.locks.broken(telemetry, now):
            if broken.lock.name not in excused and (lost := self._lost(broken, telemetry, now)) is not None:
                violations.append(lost)
        return violations

    def _lost(self, broken: BrokenLock, telemetry: Telemetry, now: int) -> Violation | None:
        """A lock that is broken is restored if anything is left to try; if not, it is a violation."""
        run = self.running[broken.token]
        lock = broken.lock
        case = run.cases.get(lock.name)
        if case is None:
            case = self.protection.suspect(lock.conclusion, "lock", run.parameters, broken.token, telemetry, now)
            if case is None:
                return Violation("lock", broken.detail, broken.token, lock.conclusion)
            run.cases[lock.name] = case
        elif case.has_failed_by(now):
            case.persists(telemetry, now)
        return None if case.is_open else Violation("lock", broken.detail, broken.token, case.conclusion)

    def _count_losses(self, run: RunningToken, telemetry: Telemetry, now: int) -> None:
        if run.activity is None or run.ended is not None:
            return
        for lock in run.activity.maintained:
            if not lock.made_up:
                continue
            if not self.locks.kept(run.token.id, lock.name, telemetry):
                run.without.setdefault(lock.name, now)
            elif (since := run.without.pop(lock.name, None)) is not None:
                run.lost += now - since

    def _release(self, run: RunningToken) -> None:
        """Its locks go, and what was being done about them is of no interest any more."""
        self.locks.release(run.token.id)
        for case in run.cases.values():
            if case.is_open:
                case.abandon()
        run.cases.clear()

    def _confirmed(self, run: RunningToken, telemetry: Telemetry, now: int) -> list[Violation]:
        """The start is proven: locks are taken and nature may end it."""
        assert run.activity is not None
        if run.activity.finish is not None:
            bound = tuple(c.bound_to(run.parameters) for c in run.activity.finish.conditions)
            run.finish = Watch(bound, run.activity.finish.persistence, telemetry)
        for lock in run.activity.maintained:
            if (conflict := self.locks.take(run.token.id, lock, run.parameters, telemetry)) is not None:
                return [Violation("incompatible", conflict, run.token.id)]
        return []

    def _watch_finish(
        self, run: RunningToken, telemetry: Telemetry, now: int, violations: list[Violation]
    ) -> tuple[PlanToken, ...]:
        assert run.activity is not None
        assert run.activity.finish is not None
        assert run.finish is not None
        if not run.finish.update(telemetry, now):
            return ()
        if now < run.earliest_end:
            if not run.activity.finish.hold_early:
                took, least = now - run.started, run.token.duration[0]
                violations.append(
                    Violation("early", f"ended after {took} s, expected at least {least} s", run.token.id)
                )
            return ()
        if run.deadline is not None and now > run.deadline:
            return ()  # too late to count: the deadline speaks
        return (run.token,)

    def _late(self, run: RunningToken, telemetry: Telemetry) -> Violation:
        missing = "its start is not confirmed" if run.finish is None else run.finish.first_failing(telemetry)
        detail = f"not ended after {run.token.duration[1]} s: {missing}"
        finish = None if run.activity is None else run.activity.finish
        speaks = finish is not None and all(c.bound_to(run.parameters).holds(telemetry) for c in finish.evidence)
        return Violation("late", detail, run.token.id, finish.conclusion if finish is not None and speaks else None)

    def _if_over(self, run: RunningToken, now: int) -> tuple[PlanToken, ...]:
        if not run.is_over:
            return ()
        self._tell(now, "token.finished", run.token, {"verdict": verdict(run), "ended": run.ended})
        del self.running[run.token.id]
        return (run.token,)

    def _tell(self, now: int, event: str, token: PlanToken, more: Mapping[str, object] | None = None) -> None:
        entry = {
            "plan": self.plan_id,
            "token": token.id,
            "object": token.object,
            "attribute": token.attribute,
            "predicate": token.predicate,
            "parameters": {k: list(v) if isinstance(v, tuple) else v for k, v in token.parameters.items()},
        }
        self.journal.write(now, event, entry | dict(more or {}))


def _unconfirmed(run: RunningToken, which: str, undertaking: Undertaking, progress: Progress) -> Violation:
    kind: Literal["refused", "unconfirmed"] = "refused" if progress == "refused" else "unconfirmed"
    return Violation(kind, f"{which}: {undertaking.complaint()}", run.token.id, undertaking.conclusion)


def verdict(run: RunningToken) -> Literal["early", "on_time", "late"]:
    """How a token's end compares with the bounds that its plan gave it at adoption."""
    assert run.ended is not None
    lower, upper = run.token.end
    if lower is not None and run.ended < lower:
        return "early"
    if upper is not None and run.ended > upper:
        return "late"
    return "on_time"


def decided(token: PlanToken) -> dict[str, TelemetryValue]:
    """A token's parameters as values, and its object. Of what the plan left open, the first (or least) is taken."""
    values: dict[str, TelemetryValue] = {"object": token.object}
    for name, value in token.parameters.items():
        values[name] = _decide(value)
    return values


def _decide(value: ParameterValue) -> TelemetryValue:
    if isinstance(value, tuple):
        return value[0] if value else ""
    if isinstance(value, Mapping):
        bounds = [bound for bound in (value.get("min"), value.get("max")) if bound is not None]
        return bounds[0] if bounds else 0.0
    return value
