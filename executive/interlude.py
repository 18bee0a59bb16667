"""From the loss of one plan to the hand-over to the next: standby meanwhile, and plannings until one succeeds."""

from __future__ import annotations

from collections.abc import Iterable

from executive.bindings import Bindings
from executive.commands import CommandLink
from executive.conclusions import Conclusions
from executive.conditions import Telemetry
from executive.goals import GoalBook
from executive.journal import Journal
from executive.monitor import Violation
from executive.records import Settings
from executive.replanner import Failed, Ready, Replanner, Request
from executive.standby import StandbyKeeper
from planner.problem import TokenPattern

_NEVER = 1 << 62
# A state that changes while the planner thinks is planned for again at once this often, then after a delay.
_PROMPT_RETRIES = 3


class Interlude:
    """One stay in standby. Times are seconds; `fruitless`: plans in a row that achieved nothing, beyond those forgiven.

    `reason`: why there is no plan. `attempts`, `charged`, `failures`: of planning, so far. `requested`: when first.
    """

    def __init__(
        self,
        reason: str,
        now: int,
        run_end: int,
        fruitless: int,
        bindings: Bindings,
        settings: Settings,
        link: CommandLink,
        replanner: Replanner,
        goals: GoalBook,
        conclusions: Conclusions,
        journal: Journal,
    ) -> None:
        self.reason = reason
        self.attempts = self.failures = self.charged = 0
        self.requested: int | None = None
        self._run_end = run_end
        self._bindings = bindings
        self._settings = settings
        self._keeper = StandbyKeeper(bindings, link, conclusions, journal)
        self._entered = False
        self._replanner = replanner
        self._goals = goals
        self._conclusions = conclusions
        self._journal = journal
        self._mismatches = 0
        self._pending: Ready | Failed | None = None
        self._retry_at = now if fruitless <= 0 else now + replanner.delay(fruitless)

    def enter(self, telemetry: Telemetry, now: int) -> None:
        """Bring the hardware to standby, once."""
        if not self._entered:
            self._entered = True
            self._keeper.enter(self.reason, telemetry, now)

    def observe(self, telemetry: Telemetry, now: int) -> Violation | None:
        """One observation: standby that cannot be reached is a violation."""
        return self._keeper.observe(telemetry, now) if self._entered else None

    def pursue(self, telemetry: Telemetry, now: int) -> Ready | None:
        """Request a plan when standby is reached, and wait for it; the plan when it is time to hand over."""
        pending = self._pending
        if isinstance(pending, Failed) and now >= pending.known:
            self._replanner.learn(pending)
            self._planning_failed(pending.reason, now)
        elif isinstance(pending, Ready) and now >= pending.handover:
            if (difference := self._difference(pending, telemetry, now)) is None:
                return pending
            self._state_changed(difference, now)
        if self._pending is None and now >= self._retry_at:
            self._keeper.resume(telemetry, now)
            if self._keeper.is_reached(telemetry, now):
                self._request(telemetry, now)
        return None

    def leave(self, now: int) -> None:
        """A plan takes over."""
        self._keeper.leave(now)

    def dues(self, now: int) -> Iterable[int]:
        """The seconds at which waiting alone changes something."""
        yield from self._keeper.dues(now)
        pending = self._pending
        if isinstance(pending, Ready):
            yield pending.handover
        else:
            yield self._retry_at if pending is None else pending.known

    def _request(self, telemetry: Telemetry, now: int) -> None:
        handover = now + self._replanner.budget
        if handover >= self._run_end:
            self._journal.write(now, "plan.failed", {"reason": "no time is left before the end of the horizon"})
            self._retry_at = _NEVER
            return
        self.attempts += 1
        self.requested = now if self.requested is None else self.requested
        entry = {"reason": self.reason, "attempt": self.attempts, "budget": self._replanner.budget}
        self._journal.write(now, "plan.requested", entry)
        state = self._state(telemetry)
        if isinstance(state, str):
            self._planning_failed(state, now)
            return
        end = self._settings.horizon_end(handover, self._run_end)
        goals = self._goals.unfinished(end)
        self._pending = self._replanner.plan(Request(now, handover, end, state, goals, self.failures))
        self.charged += self._pending.charged

    def _planning_failed(self, reason: str, now: int) -> None:
        self._pending = None
        self.failures += 1
        self._journal.write(now, "plan.failed", {"reason": reason})
        self._retry_at = now + self._replanner.delay(self.failures)

    def _state_changed(self, difference: str, now: int) -> None:
        self._pending = None
        self._mismatches += 1
        self._journal.write(now, "plan.failed", {"reason": f"the state at hand-over differs: {difference}"})
        excess = self._mismatches - _PROMPT_RETRIES
        self._retry_at = now if excess <= 0 else now + self._replanner.delay(excess)

    def _state(self, telemetry: Telemetry) -> tuple[TokenPattern, ...] | str:
        """The tokens that hold now, or why they cannot be told."""
        try:
            return self._bindings.state(telemetry, self._conclusions.names)
        except Exception as error:  # whatever a domain's function does, the executive goes on
            return f"the state cannot be told from telemetry: {type(error).__name__}: {error}"

    def _difference(self, ready: Ready, telemetry: Telemetry, now: int) -> str | None:
        """What keeps a plan from being handed over; None when nothing does."""
        if not self._keeper.is_reached(telemetry, now):
            return "standby is lost"
        state = self._state(telemetry)
        if isinstance(state, str):
            return state
        if state == ready.state:
            return None
        gone = [_say(pattern) for pattern in ready.state if pattern not in state]
        new = [_say(pattern) for pattern in state if pattern not in ready.state]
        return f"expected {', '.join(gone) or 'nothing more'}; found {', '.join(new) or 'nothing more'}"


def _say(pattern: TokenPattern) -> str:
    arguments = ", ".join(f"{name}={value}" for name, value in pattern.parameters.items())
    return f"{pattern.object or 'any'} {pattern.predicate}({arguments})"
