"""The executive: flies a plant through plans, and asks for another plan when one cannot go on.

Simulation clock only: a step is one second, runs until nothing more can happen at that instant, and depends on nothing
but what was observed. Same inputs, same journal.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import NoReturn

from executive.adoption import Adoptions, Search
from executive.bindings import MODE, NEXT_PLAN, Bindings, Maintained
from executive.commands import CommandLink
from executive.conclusions import Conclusions, FaultRecord
from executive.conditions import Telemetry
from executive.errors import ExecutiveError
from executive.execution import Execution, Happening
from executive.goals import GoalBook
from executive.inputs import goal_to_json, settings_to_json
from executive.interlude import Interlude
from executive.journal import Journal
from executive.monitor import Diagnoser, Monitors, Violation
from executive.port import Plant, TelemetryValue
from executive.probes import Prober
from executive.records import AdoptedPlan, DispatchStatistics, GoalRecord, Outcome, Settings
from executive.recovery import FaultProtection
from executive.replanner import Ready, Replanner
from executive.subscription import Subscription
from executive.succession import Succession
from executive.watchdog import Watchdog
from planner.problem import Goal, Planner

_NEVER = 1 << 62
# So many plans in a row that were given up before they achieved a goal are replaced at once, the next after a delay.
_PROMPT_PLANS = 3


class Executive:
    """One run over a horizon `[start, end]` (seconds of simulation clock, which are the planner's ticks).

    The first step observes the plant at the horizon's start: the plant's clock starts a second earlier, or the plant
    takes `advance` to its present time as a look at it. Then `step` by `step`, or `run_until`, and `finish` once.
    It is in standby or executes a plan, never neither. `diagnosers`: who explains telemetry beside the domain's
    monitors.
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
        diagnosers: Iterable[Diagnoser] = (),
    ) -> None:
        self._plant = plant
        self._bindings = bindings
        self._horizon = horizon
        self._journal = journal
        self._settings = settings or Settings()
        self._telemetry: Telemetry = {}
        self._begun = False
        self._now = horizon[0] - 1
        self._due = horizon[0]
        self._seen: dict[str, TelemetryValue] = {}
        self._kept = Subscription(bindings)
        self._conclusions = Conclusions(bindings, journal)
        self._link = CommandLink(plant, journal, self._conclusions.forbids)
        self._prober = Prober(bindings.probes, self._link)
        self._protection = FaultProtection(
            (Monitors(bindings.monitors), *diagnosers), bindings, self._link, self._conclusions, self._held_locks
        )
        self._given = tuple(goals)
        self._goals = GoalBook(self._given, journal)
        self._unplanned: list[str] = []
        self._watchdog = Watchdog()
        self._replanner = Replanner(planner, bindings, self._settings, self._conclusions, journal)
        self._statistics = DispatchStatistics()
        self._adoptions = Adoptions(self._goals, journal, horizon[1])
        self._execution: Execution | None = None
        self._succession: Succession | None = None
        self._concluded_before: frozenset[str] = frozenset()
        self._outcome: Outcome | None = None
        self._fruitless = 0
        self._interlude: Interlude | None = self._begin_interlude("initial")

    # -- the loop ------------------------------------------------------------------------------------------------------

    def step(self) -> None:
        """One second: observe, identify, monitor, recover or replan, dispatch, command."""
        if not self._observe() and self._now < self._due:
            return
        violations = self._identify()
        while True:
            self._recover(violations)
            violations = self._replan() or self._dispatch() or self._succeed()
            if not violations:
                break
            if self._watchdog.is_spinning(self._now):
                self._recover(violations)
                break
        self._due = self._next_due()

    def run_until(self, time: int) -> None:
        """Step until that second, or to the end of the horizon if that is earlier."""
        last = min(time, self._horizon[1])
        while self._now < last:
            self.step()

    def add_goal(self, goal: Goal) -> None:
        """A goal comes in, and is known from the next step on. A goal of a known identifier changes nothing."""
        self._begin_journal()
        self._journal.write(self._now + 1, "goal.given", goal_to_json(goal))
        if goal.id not in {record.id for record in self._goals.records}:
            self._goals.add(goal)
            self._unplanned.append(goal.id)
            self._due = self._now + 1

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
        return self._adoptions.plans

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

    def _begin_journal(self) -> None:
        """The executive's first entry: what the run was started with."""
        if self._begun:
            return
        self._begun = True
        entry = {
            "scenario": self._settings.scenario,
            "seed": self._settings.seed,
            "horizon": list(self._horizon),
            "goals": [goal_to_json(goal) for goal in self._given],
            "settings": settings_to_json(self._settings),
        }
        self._journal.write(self._horizon[0], "run.started", entry)

    def _observe(self) -> bool:
        """Let a second pass; keep and journal what was subscribed to. Whether there was anything."""
        self._begin_journal()
        self._now += 1
        seen = self._plant.advance(self._now)
        if seen.time != self._now:
            _out_of_step(self._now, seen.time)
        if changes := self._kept.of(seen.changes, self._seen):
            self._seen.update(changes)
            self._journal.write(self._now, "observation", {"changes": changes})
        if seen.acknowledgements:
            self._link.acknowledged(seen.acknowledgements, self._now)
        return bool(changes or seen.acknowledgements)

    def _identify(self) -> list[Violation]:
        """What this observation means to fault protection, to the plan in execution, and to standby."""
        self._seen[NEXT_PLAN] = "none" if self._succession is None else self._succession.status(self._now)
        self._seen[MODE] = "standby" if self._execution is None else "plan"
        self._seen |= self._conclusions.channels()
        self._seen |= self._prober.update(self._conclusions.believed(self._seen), self._now)
        violations = self._protection.update(self._conclusions.believed(self._seen), self._now)
        self._telemetry = self._conclusions.believed(self._seen)
        if self._execution is not None:
            violations += self._take(self._execution.observe(self._telemetry, self._now))
        elif self._interlude is not None:
            lost = self._interlude.observe(self._telemetry, self._now)
            violations += [] if lost is None else [lost]
        return violations

    def _held_locks(self) -> Iterable[Maintained]:
        """What the plan in execution needs maintained now."""
        return () if self._execution is None else self._execution.held()

    # -- recover or replan ---------------------------------------------------------------------------------------------

    def _recover(self, violations: list[Violation]) -> None:
        """Record violations, draw their conclusions; a plan that was violated is given up for standby."""
        violations = [replace(v, conclusion=self._conclusions.following(v.conclusion)) for v in violations]
        for violation in violations:
            self._statistics.count(violation.kind)
            self._journal.write(self._now, "violation", {"kind": violation.kind, "detail": violation.detail})
            if violation.conclusion is not None:
                self._conclusions.draw(violation.conclusion, violation.kind, self._now)
                if violation.kind != "standby":
                    self._conclusions.replanned(violation.conclusion, self._now)
            if self._execution is not None and violation.token is not None:
                said = f"{violation.kind}: {violation.detail}"
                for goal_id in self._execution.blamed(violation.token):
                    self._goals.failed(goal_id, self._now, said, self._settings.goal_attempts)
        if self._execution is not None and violations:
            self._fruitless += 1
            self._give_up("; ".join(violation.words for violation in violations), violations)
        if self._interlude is not None:
            self._interlude.enter(self._telemetry, self._now)

    def _give_up(self, reason: str, violations: Iterable[Violation] = ()) -> None:
        """No plan any more: everything is stopped, and standby follows."""
        assert self._execution is not None
        if self._succession is not None:
            self._succession.give_up("the plan that it was to follow has been given up", self._now)
            self._succession = None
        self._execution.abort(self._now, violations)
        self._execution = None
        self._interlude = self._begin_interlude(reason)

    def _begin_interlude(self, reason: str) -> Interlude:
        return Interlude(
            reason,
            self._now,
            self._horizon[1],
            self._fruitless - _PROMPT_PLANS,
            self._bindings,
            self._settings,
            self._link,
            self._replanner,
            self._goals,
            self._conclusions,
            self._journal,
        )

    def _replan(self) -> list[Violation]:
        """In standby: seek a plan, and hand over to it when it is time."""
        interlude = self._interlude
        if interlude is None or (ready := interlude.pursue(self._telemetry, self._now)) is None:
            return []
        plan_id = self._adopt(ready, interlude, joined=False)
        interlude.leave(self._now)
        self._interlude = None
        return self._begin(plan_id, ready, None)

    def _succeed(self) -> list[Violation]:
        """While a plan executes: seek the one that follows, and join it; without one the plan ends with its horizon."""
        if self._execution is None:
            return []
        self._seek()
        succession = self._succession
        if succession is not None and (ready := succession.plan_to_join(self._now)) is not None:
            if self._conclusions.planned_for == self._concluded_before:
                before = self._execution
                plan_id = self._adopt(ready, succession, joined=True)
                self._succession = None
                return self._begin(plan_id, ready, before) or self._dispatch() or self._succeed()
            succession.give_up("what has been concluded since was not planned for", self._now)
        if self._execution.horizon_end <= self._now < self._horizon[1]:
            self._achieve(self._execution.lasting_goals(self._execution.horizon_end))
            if self._succession is not None:
                self._succession.give_up("it is not there at the end of the horizon", self._now)
            self._give_up("the plan's horizon is over and the next plan is not there")
            self._recover([])
        return []

    def _seek(self) -> None:
        """What came of the search for the plan that follows; a new search where one is wanted."""
        assert self._execution is not None
        if self._succession is not None:
            self._succession.pursue(self._now)
            if self._succession.is_over and self._succession.joins_at is None:
                self._succession = None
        elif self._unplanned and self._conclusions.planned_for == self._concluded_before:
            end = self._execution.horizon_end
            known = {goal.id for goal in self._goals.unfinished(end)}
            named = [goal_id for goal_id in self._unplanned if goal_id in known]
            self._unplanned = []
            if named:
                self._follow_up(f"new goal: {', '.join(named)}", None, end)

    def _follow_up(self, reason: str, joins_at: int | None, end: int) -> None:
        """Begin to seek the plan that follows the one in execution."""
        assert self._execution is not None
        if self._succession is not None:
            self._succession.give_up("the next horizon is planned instead", self._now)
        self._succession = Succession(
            self._execution, reason, joins_at, end, self._replanner, self._goals, self._journal, self._now
        )
        self._succession.pursue(self._now)

    def _adopt(self, ready: Ready, search: Search, *, joined: bool) -> str:
        """Take a plan into force; returns its name."""
        self._unplanned = [goal_id for goal_id in self._unplanned if goal_id not in ready.considered]
        return self._adoptions.adopt(ready, search, self._now, joined=joined)

    def _begin(self, plan_id: str, ready: Ready, before: Execution | None) -> list[Violation]:
        """Execute a plan from now on, from standby or joined to the one `before`."""
        self._concluded_before = self._conclusions.planned_for
        self._execution = Execution(
            plan_id,
            ready.network,
            ready.dispatchable,
            self._bindings,
            self._link,
            self._protection,
            self._goals,
            self._journal,
            self._statistics,
        )
        return self._take(self._execution.begin(self._telemetry, self._now, before))

    # -- dispatch, command ---------------------------------------------------------------------------------------------

    def _dispatch(self) -> list[Violation]:
        """Perform what is due; commands go out on the way."""
        if self._execution is None:
            return []
        violations = self._take(self._execution.dispatch(self._telemetry, self._now))
        return violations or self._watchdog.stalled(self._execution)

    def _take(self, happening: Happening) -> list[Violation]:
        self._achieve(happening.goals)
        if happening.asks_for_plan and self._execution is not None and not happening.violations:
            waypoint = self._execution.horizon_end
            if waypoint < self._horizon[1]:
                end = self._settings.horizon_end(waypoint, self._horizon[1])
                self._follow_up(f"next horizon from {waypoint} s", waypoint, end)
        return list(happening.violations)

    def _achieve(self, goals: Iterable[str]) -> None:
        for goal_id in goals:
            self._fruitless = 0
            self._goals.achieved(goal_id, self._now)

    def _next_due(self) -> int:
        """The next second at which something happens even if nothing is observed."""
        dues = [*self._protection.dues(self._now), *self._prober.dues(self._now)]
        if self._execution is not None:
            dues += self._execution.dues(self._now)
            dues.append(self._execution.horizon_end)
        if self._succession is not None:
            dues += self._succession.dues()
        if self._interlude is not None:
            dues += self._interlude.dues(self._now)
        return min(dues, default=_NEVER)

    def _judge(self) -> Outcome:
        statuses = {record.status for record in self._goals.records}
        if "missed" not in statuses:
            return "degraded" if "dropped" in statuses else "completed"
        return "standby" if self._execution is None else "failed"


def _out_of_step(expected: int, found: int) -> NoReturn:
    raise ExecutiveError(f"plant: expected an observation at {expected} s, found one at {found} s")
