"""Responses at work: every fault is a case, from its conclusion until a recovery has worked or none is left.

Recovery comes before replanning, and runs beside the plan in execution: what running tokens need maintained stays
maintained (Pell et al., Agents 1998). Recoveries of several faults run at the same time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Literal

from executive.bindings import Bindings, Maintained
from executive.commands import CommandLink, Transmission
from executive.conclusions import Conclusions
from executive.conditions import Parameters, Telemetry
from executive.monitor import Diagnoser, Finding, Violation
from executive.protection import Recovery, Response
from executive.sends import Conclusion

Stage = Literal["acting", "judging", "waiting", "over", "given up"]
HeldLocks = Callable[[], Iterable[Maintained]]
_NO_PARAMETERS: Parameters = {}


class Case:
    """One fault. `conclusion`: what it is taken for. Times are seconds.

    `stage`: "acting" while commands of a recovery go out, "judging" until it shows whether it worked, "waiting" for a
    lock to be released that the next recovery would break, "over" when one worked, "given up" when none is left.
    `told`: the stage at which the plan in execution was last told that it may not go on.
    """

    def __init__(
        self,
        conclusion: Conclusion,
        response: Response,
        source: str,
        place: int,
        parameters: Parameters,
        owner: str,
        link: CommandLink,
        conclusions: Conclusions,
        held: HeldLocks,
    ) -> None:
        self.conclusion = conclusion
        self.stage: Stage = "waiting"
        self.told: Stage | None = None
        self._response = response
        self._source = source
        self._place = place
        self._parameters = parameters
        self._owner = owner
        self._link = link
        self._conclusions = conclusions
        self._held = held
        self._left: list[Recovery] = _attempts(response)
        self._recovery: Recovery | None = None
        self._step = 0
        self._transmission: Transmission | None = None
        self._judged_at = 0

    def __repr__(self) -> str:
        return f"Case({self.conclusion.name}: {self.stage})"

    @property
    def is_open(self) -> bool:
        """Something is still being tried, or will be."""
        return self.stage not in ("over", "given up")

    @property
    def restores(self) -> tuple[str, ...]:
        """The locks that may be broken meanwhile."""
        return self._response.restores if self.is_open else ()

    @property
    def masks(self) -> tuple[str, ...]:
        """The conclusions that are not drawn meanwhile."""
        return self._response.masks if self.is_open else ()

    @property
    def forbids_plan(self) -> bool:
        """The plan depends on the device, and nothing can be tried any more, or nothing as long as the plan goes on."""
        return self.stage in ("waiting", "given up") and self._response.replan == "now"

    def follow(self, telemetry: Telemetry, now: int) -> None:
        """One observation: steps that are proven or not; what had to wait."""
        if self.stage == "waiting":
            self.persists(telemetry, now)
            return  # what has just been sent is not proven by this observation
        if self.stage != "acting":
            return
        assert self._transmission is not None
        progress = self._transmission.follow(telemetry, now)
        if progress == "pending":
            return
        self._transmission.close()
        if progress == "confirmed":
            self._begin_step(self._step + 1, telemetry, now)
        else:
            self.persists(telemetry, now)

    def has_failed_by(self, now: int) -> bool:
        """Whether the recovery had its time, if the symptom is still there."""
        return self.stage == "judging" and now >= self._judged_at

    def persists(self, telemetry: Telemetry, now: int) -> bool:
        """The symptom is there and nothing is being done about it: the next recovery. False when none is left."""
        while True:
            self._left = [r for r in self._left if all(condition.holds(telemetry) for condition in r.when)]
            for recovery in self._left:
                if not self._disturbs(recovery):
                    self._left.remove(recovery)
                    self._begin(recovery, telemetry, now)
                    return True
            if self._left:
                self.stage = "waiting"
                return True
            if not self._escalate(now):
                return False

    def exhaust(self) -> None:
        """Try nothing of what the response offers."""
        self._left = []

    def recovered(self, now: int) -> None:
        """The symptom is gone."""
        self.close()
        self.stage = "over"
        lasts = self._response.lasts
        self._conclusions.settle(self.conclusion, stands=lasts, worked_around=lasts)
        self._conclusions.recovered(self._place, now, cured=not self._response.lasts)

    def abandon(self) -> None:
        """Whatever it was about is not of interest any more."""
        self.close()
        self.stage = "over"
        self._conclusions.settle(self.conclusion, stands=False)

    def close(self) -> None:
        """Wait for no proof any more."""
        if self._transmission is not None:
            self._transmission.close()
            self._transmission = None

    def due(self, now: int) -> int | None:
        """The next second at which waiting alone changes something."""
        if self.stage == "acting" and self._transmission is not None:
            return self._transmission.due(now)
        if self.stage == "judging":
            return self._judged_at
        return now + 1 if self.stage == "waiting" else None

    def _disturbs(self, recovery: Recovery) -> bool:
        channels = set(recovery.disturbs)
        return any(
            channels.intersection(condition.channels())
            for lock in self._held()
            if lock.name not in self._response.restores
            for condition in lock.conditions
        )

    def _begin(self, recovery: Recovery, telemetry: Telemetry, now: int) -> None:
        self._conclusions.responded(self._place, recovery.name, now)
        self._recovery, self.stage = recovery, "acting"
        self._begin_step(0, telemetry, now)

    def _begin_step(self, number: int, telemetry: Telemetry, now: int) -> None:
        assert self._recovery is not None
        self._step = number
        if number == len(self._recovery.steps):
            self._transmission, self.stage = None, "judging"
            self._judged_at = now + self._recovery.within
            return
        step = self._recovery.steps[number]
        self._transmission = Transmission(self._link, step.commands, step.confirmation, self._parameters, self._owner)
        self._transmission.send(telemetry, now)

    def _escalate(self, now: int) -> bool:
        """Nothing is left to try: what is concluded then, if it leaves something to try."""
        otherwise = self._response.otherwise
        self._conclusions.settle(self.conclusion, stands=otherwise is None)
        self.stage = "given up"
        if otherwise is None:
            return False
        self._response = self._conclusions.response(otherwise) or Response(otherwise.name)
        self._left = _attempts(self._response)
        self._conclusions.draw(otherwise, self._source, now, self._place, under_way=bool(self._left))
        self.conclusion = otherwise
        return bool(self._left)


class FaultProtection:
    """All cases of a run, and what the diagnosers find. Asked at every observation, before anything is executed."""

    def __init__(
        self,
        diagnosers: Iterable[Diagnoser],
        bindings: Bindings,
        link: CommandLink,
        conclusions: Conclusions,
        held: HeldLocks,
    ) -> None:
        self._diagnosers = tuple(diagnosers)
        self._bindings = bindings
        self._link = link
        self._conclusions = conclusions
        self._held = held
        self._open: list[Case] = []
        self._found: dict[str, Case] = {}
        self._used: dict[str, int] = {}

    def update(self, telemetry: Telemetry, now: int) -> list[Violation]:
        """What this observation says of all faults; conclusions are drawn and recoveries tried on the way."""
        for case in self._open:
            case.follow(telemetry, now)
        findings = [finding for diagnoser in self._diagnosers for finding in diagnoser.update(telemetry, now)]
        present = {finding.conclusion.name for finding in findings}
        for name in [name for name in self._found if name not in present]:
            case = self._found.pop(name)
            if case.is_open:
                case.recovered(now)
        violations = []
        for finding in findings:
            if not any(finding.conclusion.name in case.masks for case in self._open):
                violations += self._take(finding, telemetry, now)
        self._open = [case for case in self._open if case.is_open]
        return violations

    def suspect(
        self,
        conclusion: Conclusion | None,
        source: str,
        parameters: Parameters,
        owner: str,
        telemetry: Telemetry,
        now: int,
    ) -> Case | None:
        """A token's trouble is taken for something that may be recovered from: the case, its first recovery under way.

        None when nothing can be tried. Whoever asked judges: `Case.recovered`, `persists` or `abandon`.
        """
        response = None if conclusion is None else self._bindings.response(conclusion)
        if conclusion is None or response is None or not response.recoveries or self._is_known(conclusion, response):
            return None
        return self._begin(conclusion, response, source, parameters, owner, telemetry, now)

    def restoring(self) -> frozenset[str]:
        """The names of the locks that may be broken, because recoveries under way are to restore them."""
        return frozenset(name for case in self._open for name in case.restores)

    def dues(self, now: int) -> Iterable[int]:
        """The seconds at which waiting alone changes something."""
        for diagnoser in self._diagnosers:
            yield from diagnoser.dues(now)
        for case in self._open:
            if (due := case.due(now)) is not None:
                yield due

    def _take(self, finding: Finding, telemetry: Telemetry, now: int) -> list[Violation]:
        """What a finding means; a violation where the plan in execution may not go on."""
        conclusion = finding.conclusion
        response = self._bindings.response(conclusion)
        case = self._found.get(conclusion.name)
        if case is not None:
            if case.has_failed_by(now):
                case.persists(telemetry, now)
        elif self._is_known(conclusion, response):
            return []
        elif response is None or not response.recoveries:
            self._conclusions.draw(conclusion, finding.source, now)
            return [_fault(finding.source, conclusion)] if response is None or response.replan == "now" else []
        else:
            owner = f"monitor {finding.source}"
            case = self._begin(conclusion, response, finding.source, _NO_PARAMETERS, owner, telemetry, now)
            self._found[conclusion.name] = case
        if not case.forbids_plan or case.stage == case.told:
            return []
        case.told = case.stage
        return [_fault(finding.source, case.conclusion)]

    def _is_known(self, conclusion: Conclusion, response: Response | None) -> bool:
        """Whether it has been concluded for good, or what follows when it cannot be recovered from."""
        if self._conclusions.stands(conclusion):
            return True
        while response is not None and response.otherwise is not None:
            if self._conclusions.stands(response.otherwise):
                return True
            response = self._bindings.response(response.otherwise)
        return False

    def _begin(
        self,
        conclusion: Conclusion,
        response: Response,
        source: str,
        parameters: Parameters,
        owner: str,
        telemetry: Telemetry,
        now: int,
    ) -> Case:
        place = self._conclusions.draw(conclusion, source, now, under_way=True)
        assert place is not None
        case = Case(conclusion, response, source, place, parameters, owner, self._link, self._conclusions, self._held)
        self._used[conclusion.name] = used = self._used.get(conclusion.name, 0) + 1
        if response.limit is not None and used > response.limit:
            case.exhaust()
        case.persists(telemetry, now)
        self._open.append(case)
        return case


def _attempts(response: Response) -> list[Recovery]:
    return [recovery for recovery in response.recoveries for _ in range(recovery.attempts)]


def _fault(source: str, conclusion: Conclusion) -> Violation:
    return Violation("fault", f"{source}: {conclusion.text}", None, conclusion)
