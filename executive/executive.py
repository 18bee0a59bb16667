"""The executive: flies a plant through plans, and asks for another plan when one cannot go on.

Simulation clock only: a step is one second, runs until nothing more can happen at that instant, and depends on nothing
but what was observed. Same inputs, same journal.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NoReturn

from executive.bindings import Bindings
from executive.commands import CommandLink
from executive.errors import ExecutiveError
from executive.execution import Execution, Happening
from executive.journal import Journal
from executive.monitor import Conclusions, FaultProtection, FaultRecord, Violation
from executive.port import Plant, TelemetryValue
from executive.records import AdoptedPlan, DispatchStatistics, GoalRecord, Outcome, Settings
from executive.replanner import Failed, GoalBook, Ready, Replanner
from executive.standby import StandbyKeeper
from planner.problem import Goal, Planner, TokenPattern

_NEVER = 1 << 62
# A state that changes while the planner thinks is planned for again at once this often, then after a delay.
_PROMPT_RETRIES = 3
# So many plans in a row that were given up before they achieved a goal are replaced at once, the next after a delay.
_PROMPT_PLANS = 3


class Executive:
    """One run over a horizon `[start, end]` (seconds of simulation clock, which are the planner's ticks).

    The first step observes the plant at the horizon's start: the plant's clock starts a second earlier, or the plant
    takes `advance` to its present time as a look at it. Then `step` by `step`, or `run_until`, and `finish` once.
    It is in standby or executes a plan, never neither.
    """

    def __init__(
        self,
        plant: Plant,
        bindings: Bindings,
        planner: Planner,
        goals: Iterable[Goal],
        horizon: tuple[int, int],
        journal: Journal,
        settings: Settings | None = None,
    ) -> None:
        self._plant = plant
        self._bindings = bindings
        self._horizon = horizon
        self._journal = journal
        self._settings = settings or Settings()
        self._channels = bindings.channels()
        self._telemetry: dict[str, TelemetryValue] = {}
        self._now = horizon[0] - 1
        self._due = horizon[0]
        self._link = CommandLink(plant, journal)
        self._conclusions = Conclusions(journal)
        self._protection = FaultProtection(bindings.monitors, self._link, self._conclusions)
        self._goals = GoalBook(goals, journal)
        self._replanner = Replanner(planner, bindings, self._settings, horizon[1])
        self._statistics = DispatchStatistics()
        self._plans: list[AdoptedPlan] = []
        self._execution: Execution | None = None
        self._keeper: StandbyKeeper | None = None
        self._pending: Ready | Failed | None = None
        self._outcome: Outcome | None = None
        self._fruitless = 0
        self._begin_episode("initial")

    # -- the loop ------------------------------------------------------------------------------------------------------

    def step(self) -> None:
        """One second: observe, identify, monitor, recover or replan, dispatch, command."""
        if not self._observe() and self._now < self._due:
            return
        violations = self._identify()
        while True:
            self._recover(violations)
            violations = self._replan() or self._dispatch()
            if not violations:
                break
        self._due = self._next_due()

    def run_until(self, time: int) -> None:
        """Step until that second, or to the end of the horizon if that is earlier."""
        last = min(time, self._horizon[1])
        while self._now < last:
            self.step()

    def finish(self) -> Outcome:
        """The run is over now: what is open is missed. Journals the outcome once."""
        if self._outcome is None:
            if self._execution is not None and self._now >= self._horizon[1]:
                self._achieve(self._execution.lasting_goals(self._horizon[1]))
            self._goals.missed(self._now)
            self._outcome = self._judge()
            self._journal.write(self._now, "run.finished", {"outcome": self._outcome})
        return self._outcome

    # -- what a summary needs ------------------------------------------------------------------------------------------

    @property
    def now(self) -> int:
        """The second of the latest step."""
        return self._now

    @property
    def goals(self) -> tuple[GoalRecord, ...]:
        """Where each goal stands, in the order given."""
        return self._goals.records

    @property
    def plans(self) -> tuple[AdoptedPlan, ...]:
        """The plans adopted so far, in order."""
        return tuple(self._plans)

    @property
    def dispatch(self) -> DispatchStatistics:
        """Timepoints executed, violations, decision latencies."""
        return self._statistics

    @property
    def faults(self) -> tuple[FaultRecord, ...]:
        """The faults detected so far, in order, with diagnosis and responses."""
        return self._conclusions.faults

    @property
    def conclusions(self) -> frozenset[str]:
        """The names of what has been concluded about devices."""
        return self._conclusions.names

    @property
    def outcome(self) -> Outcome | None:
        """How the run ended; None before `finish`."""
        return self._outcome

    # -- observe, identify, monitor ------------------------------------------------------------------------------------

    def _observe(self) -> bool:
        """Let a second pass; keep and journal what was subscribed to. Whether there was anything."""
        if self._now < self._horizon[0]:
            self._journal.write(
                self._horizon[0],
                "run.started",
                {"scenario": self._settings.scenario, "seed": self._settings.seed, "horizon": list(self._horizon)},
            )
        self._now += 1
        seen = self._plant.advance(self._now)
        if seen.time != self._now:
            _out_of_step(self._now, seen.time)
        if changes := {name: value for name, value in seen.changes.items() if name in self._channels}:
            self._telemetry.update(changes)
            self._journal.write(self._now, "observation", {"changes": changes})
        if seen.acknowledgements:
            self._link.acknowledged(seen.acknowledgements, self._now)
        return bool(changes or seen.acknowledgements)

    def _identify(self) -> list[Violation]:
        """What this observation means to fault protection, to the plan in execution, and to standby."""
        violations = self._protection.update(self._telemetry, self._now)
        if self._execution is not None:
            violations += self._take(self._execution.observe(self._telemetry, self._now))
        elif self._keeper is not None:
            lost = self._keeper.observe(self._telemetry, self._now)
            violations += [] if lost is None else [lost]
        return violations

    # -- recover or replan ---------------------------------------------------------------------------------------------

    def _recover(self, violations: list[Violation]) -> None:
        """Record violations, draw their conclusions; a plan that was violated is given up for standby."""
        for violation in violations:
            self._statistics.count(violation.kind)
            self._journal.write(self._now, "violation", {"kind": violation.kind, "detail": violation.detail})
            if violation.conclusion is not None:
                self._conclusions.draw(violation.conclusion, violation.kind, self._now)
            if self._execution is not None and violation.token is not None:
                said = f"{violation.kind}: {violation.detail}"
                for goal_id in self._execution.blamed(violation.token):
                    self._goals.failed(goal_id, self._now, said, self._settings.goal_attempts)
        if self._execution is not None and violations:
            self._execution.abort(violations, self._now)
            self._execution = None
            self._fruitless += 1
            self._begin_episode("; ".join(f"{v.kind}: {v.detail}" for v in violations))
        if self._execution is None and self._keeper is None:
            self._keeper = StandbyKeeper(self._bindings, self._link, self._journal)
            self._keeper.enter(self._reason, self._telemetry, self._now)

    def _begin_episode(self, reason: str) -> None:
        """From now until a plan is adopted."""
        self._reason = reason
        self._attempt = self._failures = self._mismatches = self._charged = 0
        self._requested: int | None = None
        excess = self._fruitless - _PROMPT_PLANS
        self._retry_at = self._now if excess <= 0 else self._now + self._replanner.delay(excess)

    def _replan(self) -> list[Violation]:
        """In standby: request a plan when standby is reached, wait for it, and hand over to it when it is time."""
        if self._keeper is None:
            return []
        pending = self._pending
        if isinstance(pending, Failed) and self._now >= pending.known:
            self._planning_failed(pending.reason)
        elif isinstance(pending, Ready) and self._now >= pending.handover:
            if (difference := self._difference(pending)) is None:
                return self._adopt(pending)
            self._state_changed(difference)
        if self._pending is None and self._now >= self._retry_at:
            self._keeper.resume(self._telemetry, self._now)
            if self._keeper.is_reached(self._telemetry, self._now):
                self._request()
        return []

    def _request(self) -> None:
        if self._replanner.is_too_late(self._now):
            self._journal.write(self._now, "plan.failed", {"reason": "no time is left before the end of the horizon"})
            self._retry_at = _NEVER
            return
        self._attempt += 1
        self._requested = self._now if self._requested is None else self._requested
        entry = {"reason": self._reason, "attempt": self._attempt, "budget": self._replanner.budget}
        self._journal.write(self._now, "plan.requested", entry)
        state = self._state()
        if isinstance(state, str):
            self._planning_failed(state)
            return
        self._pending = self._replanner.plan(self._now, state, self._goals.unfinished(), self._failures)
        self._charged += self._pending.charged

    def _planning_failed(self, reason: str) -> None:
        self._pending = None
        self._failures += 1
        self._journal.write(self._now, "plan.failed", {"reason": reason})
        self._retry_at = self._now + self._replanner.delay(self._failures)

    def _state_changed(self, difference: str) -> None:
        self._pending = None
        self._mismatches += 1
        self._journal.write(self._now, "plan.failed", {"reason": f"the state at hand-over differs: {difference}"})
        excess = self._mismatches - _PROMPT_RETRIES
        self._retry_at = self._now if excess <= 0 else self._now + self._replanner.delay(excess)

    def _state(self) -> tuple[TokenPattern, ...] | str:
        """The tokens that hold now, or why they cannot be told."""
        try:
            return self._bindings.state(self._telemetry, self._conclusions.names)
        except Exception as error:  # whatever a domain's function does, the executive goes on
            return f"the state cannot be told from telemetry: {type(error).__name__}: {error}"

    def _difference(self, ready: Ready) -> str | None:
        """What keeps a plan from being handed over; None when nothing does."""
        assert self._keeper is not None
        if not self._keeper.is_reached(self._telemetry, self._now):
            return "standby is lost"
        state = self._state()
        if isinstance(state, str):
            return state
        if state == ready.state:
            return None
        gone = [_say(pattern) for pattern in ready.state if pattern not in state]
        new = [_say(pattern) for pattern in state if pattern not in ready.state]
        return f"expected {', '.join(gone) or 'nothing more'}; found {', '.join(new) or 'nothing more'}"

    def _adopt(self, ready: Ready) -> list[Violation]:
        """Hand over from standby to a plan."""
        assert self._keeper is not None
        assert self._requested is not None
        plan_id = f"plan-{len(self._plans) + 1:02d}"
        record = AdoptedPlan(
            plan_id,
            ready.plan,
            self._reason,
            self._requested,
            self._now,
            self._attempt,
            self._charged,
            ready.result.statistics,
        )
        self._plans.append(record)
        entry = {"plan": plan_id, "handover": self._now, "reason": self._reason, "tokens": len(ready.plan.tokens)}
        self._journal.write(self._now, "plan.adopted", entry)
        for goal in ready.result.dropped:
            if goal.kind == "undecided":
                self._goals.left_out(goal.id, f"undecided: {goal.reason}")
            else:
                self._goals.dropped(goal.id, self._now, f"{goal.kind}: {goal.reason}")
        for goal_id in ready.withheld:
            self._goals.left_out(goal_id, f"withheld from {plan_id} after {self._failures} failed plannings")
        self._keeper.leave(self._now)
        self._keeper = self._pending = None
        self._execution = Execution(
            plan_id,
            ready.network,
            ready.dispatchable,
            self._bindings,
            self._link,
            self._journal,
            self._statistics,
        )
        return self._take(self._execution.begin(self._telemetry, self._now))

    # -- dispatch, command ---------------------------------------------------------------------------------------------

    def _dispatch(self) -> list[Violation]:
        """Perform what is due; commands go out on the way."""
        if self._execution is None:
            return []
        return self._take(self._execution.dispatch(self._telemetry, self._now))

    def _take(self, happening: Happening) -> list[Violation]:
        self._achieve(happening.goals)
        return list(happening.violations)

    def _achieve(self, goals: Iterable[str]) -> None:
        for goal_id in goals:
            self._fruitless = 0
            self._goals.achieved(goal_id, self._now)

    def _next_due(self) -> int:
        """The next second at which something happens even if nothing is observed."""
        dues = list(self._protection.dues(self._now))
        if self._execution is not None:
            dues += self._execution.dues(self._now)
        if self._keeper is not None:
            dues += self._keeper.dues(self._now)
            pending = self._pending
            if isinstance(pending, Ready):
                dues.append(pending.handover)
            else:
                dues.append(self._retry_at if pending is None else pending.known)
        return min(dues, default=_NEVER)

    def _judge(self) -> Outcome:
        statuses = {record.status for record in self._goals.records}
        if "missed" not in statuses:
            return "degraded" if "dropped" in statuses else "completed"
        return "standby" if self._execution is None else "failed"


def _say(pattern: TokenPattern) -> str:
    arguments = ", ".join(f"{name}={value}" for name, value in pattern.parameters.items())
    return f"{pattern.object or 'any'} {pattern.predicate}({arguments})"


def _out_of_step(expected: int, found: int) -> NoReturn:
    raise ExecutiveError(f"plant: expected an observation at {expected} s, found one at {found} s")
