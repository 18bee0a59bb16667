"""One plan in execution: the dispatcher says when, the activities say what, telemetry says what became of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from time import perf_counter

from executive import dispatcher as rte
from executive.activities import Activities, RunningToken, decided
from executive.bindings import Bindings, Maintained
from executive.commands import CommandLink
from executive.conditions import Telemetry
from executive.forecast import Forecast, Forecaster
from executive.goals import GoalBook
from executive.journal import Journal
from executive.monitor import Violation
from executive.network import PlanNetwork
from executive.records import DispatchStatistics
from executive.recovery import FaultProtection
from executive.wishes import Wishes
from planner.plan import ORIGIN, PlanToken
from planner.temporal.controllability import DispatchableNetwork


@dataclass(frozen=True, slots=True)
class Happening:
    """What one instant brought: goals whose tokens are over, what went wrong, whether the next plan is asked for."""

    goals: tuple[str, ...] = ()
    violations: tuple[Violation, ...] = ()
    asks_for_plan: bool = False


class Execution:
    """A plan from its hand-over until it is over or given up. Times are seconds, which are the plan's ticks."""

    def __init__(
        self,
        plan_id: str,
        network: PlanNetwork,
        dispatchable: DispatchableNetwork,
        bindings: Bindings,
        link: CommandLink,
        protection: FaultProtection,
        goals: GoalBook,
        journal: Journal,
        statistics: DispatchStatistics,
    ) -> None:
        rte.prepare()
        self.plan_id = plan_id
        self._network = network
        self._names = network.stnu.timepoints
        self._dispatcher = rte.Dispatcher(dispatchable)
        self._activities = Activities(plan_id, bindings, link, protection, journal)
        self._journal = journal
        self._statistics = statistics
        self._next: int | None = None
        self._decided_by: Mapping[int, int] | None = None
        self._place: dict[str, tuple[int, int]] = {}
        self._goals: dict[str, tuple[str, ...]] = {}
        self._wishes = Wishes(network, bindings)
        self._least = goals.least
        for line, timeline in enumerate(network.plan.timelines):
            for number, slot in enumerate(timeline.slots):
                self._place[slot[0]] = (number, line)
                tokens = (network.plan.token(token_id) for token_id in slot)
                self._goals[slot[0]] = tuple(token.goal for token in tokens if token.goal is not None)

    @property
    def horizon_end(self) -> int:
        """The second at which the plan's horizon is over."""
        return self._network.plan.horizon[1]

    def begin(self, telemetry: Telemetry, now: int, before: Execution | None = None) -> Happening:
        """Take over: what holds already has begun. `before`: the plan that is joined, whose running tokens go on."""
        self._dispatcher.execute(self._network.index[ORIGIN], 0)
        violations = []
        continued = {} if before is None else before._continued_by(self._network)
        for token_id, began in self._network.begun.items():
            self._dispatcher.execute(self._network.index[f"{token_id}.start"], began)
            token = self._network.plan.token(token_id)
            if before is not None and (run := continued.get(token_id)) is not None:
                self._goals[token_id] += before._goals[run.token.id]
                self._activities.take_over(before._activities, run, token, now)
            elif token_id in self._place:
                violations += self._activities.begin(token, telemetry, now, began)
        if before is not None:
            self._settle_for(before, now)
        return Happening(violations=tuple(violations))

    def _continued_by(self, network: PlanNetwork) -> dict[str, RunningToken]:
        """Which running token each token that holds at the start of the next plan continues."""
        runs = {(r.token.object, r.token.attribute): r for r in self._activities.running.values() if r.ended is None}
        found = {}
        for token_id in network.begun:
            token = network.plan.token(token_id)
            run = runs.get((token.object, token.attribute))
            if run is not None and run.token.predicate == token.predicate and run.parameters == decided(token):
                found[token_id] = run
        return found

    def _settle_for(self, before: Execution, now: int) -> None:
        """Of the plan before: what has ended is still to be proven, under a name of its own; the rest is stopped."""
        for run in tuple(before._activities.running.values()):
            if run.ended is not None:
                remnant = replace(run.token, id=f"{before.plan_id}/{run.token.id}")
                self._goals[remnant.id] = before._goals[run.token.id]
                self._activities.take_over(before._activities, run, remnant, now)
        before._activities.abort(now)

    def foresee(self, earliest: int | None) -> Forecast | str:
        """What will be running at the end of the horizon, or, given a second, at the first certain one from it on."""
        forecaster = Forecaster(self._network, self._dispatcher, self._activities.running)
        return forecaster.at_end() if earliest is None else forecaster.from_(earliest)

    def hold(self, forecast: Forecast | None) -> None:
        """Let nothing that a hand-over counts on end before it; None: as early as allowed again."""
        if forecast is None:
            self._wishes.release()
        else:
            self._wishes.hold(forecast.held, forecast.handover + 1)

    def departs(self, forecast: Forecast) -> str | None:
        """What is not as was foretold for now; None when everything is."""
        for run in self._activities.running.values():
            line = run.token.object, run.token.attribute
            if line in forecast.idle and run.ended is None:
                return f"expected nothing to be running on {'.'.join(line)}, found {run.token.predicate}"
        for (thing, attribute), token_id in forecast.running.items():
            known = self._activities.running.get(token_id)
            if known is None or known.ended is not None:
                predicate = self._network.plan.token(token_id).predicate
                return f"expected {predicate} ({token_id}) to be running on {thing}.{attribute}"
        return None

    def goals_until(self, forecast: Forecast | None) -> frozenset[str]:
        """The goals that this plan serves up to a hand-over; None: in all."""
        if forecast is None:
            return frozenset(goal for goals in self._goals.values() for goal in goals)
        tokens = (*forecast.over, *forecast.running.values())
        return frozenset(goal for token_id in tokens for goal in self._goals[token_id])

    def observe(self, telemetry: Telemetry, now: int) -> Happening:
        """One observation: what nature ended, what is proven, what went wrong."""
        progressed = self._activities.observe(telemetry, now)
        over = list(progressed.over)
        violations = list(progressed.violations)
        narrowed: dict[int, rte.Window] = {}
        for token in progressed.ended:
            violations += self._observe(self._network.index[f"{token.id}.end"], now, narrowed)
            over += self._activities.end(token.id, telemetry, now)
        self._tell_bounds(narrowed, now)
        return Happening(self._goals_of(over), tuple(violations))

    def dispatch(self, telemetry: Telemetry, now: int) -> Happening:
        """Perform every timepoint that is due, until nothing more can happen at this instant; then its effects.

        What lasts to the end of the horizon is not ended there: it goes on in the next plan, or is stopped.
        """
        violations = self._make_up(now)
        if not self._is_due(now):
            return Happening(violations=tuple(violations))
        before = set(self._activities.running)
        performed = self._perform(now, violations)
        over: list[PlanToken] = []
        asks = False
        for token_id, is_start in sorted(self._split(performed), key=lambda effect: self._order(effect, before)):
            if is_start:
                violations += self._activities.begin(self._network.plan.token(token_id), telemetry, now)
                self._wishes.started(token_id, now)
                asks = asks or self._activities.asks_for_plan(token_id)
            elif token_id in self._activities.running:
                over += self._activities.end(token_id, telemetry, now)
        return Happening(self._goals_of(over), tuple(violations), asks)

    def _is_due(self, now: int) -> bool:
        """Whether there is anything to decide: something has happened since, is wanted otherwise, or it is time."""
        return self._decided_by is not self._wishes.times or (self._next is not None and now >= self._next)

    def held(self) -> Iterable[Maintained]:
        """What running tokens need maintained now."""
        return self._activities.locks.held()

    def _make_up(self, now: int) -> list[Violation]:
        """Put ends off for as long as time was lost that has to be made up for; a violation where the plan ends before.

        What has to last is what goals ask for, not what the plan gives.
        """
        violations = []
        for run in tuple(self._activities.running.values()):
            least = max((self._least(goal) for goal in self._goals.get(run.token.id, ())), default=0)
            if run.ended is not None or least == 0 or (lost := run.lost_by(now)) == 0:
                continue
            end = run.started + least + lost + bool(run.without)
            place = self._network.index[f"{run.token.id}.end"]
            latest = self._dispatcher.window(place).latest
            bounds = [bound for bound in (latest, run.token.end[1]) if bound is not None]
            if any(end > bound for bound in bounds):
                detail = f"{lost} s were lost, and it cannot go on until {end} s: it has to end by {min(bounds)} s"
                violations.append(Violation("short", detail, run.token.id))
            else:
                self._wishes.want(f"{run.token.id}.end", end)
        return violations

    def stuck(self) -> tuple[str, ...]:
        """The timepoints still to come if nothing will bring them about: none is due, and no activity is running."""
        if self._next is not None or self._dispatcher.finished:
            return ()
        if any(run.awaits_nature for run in self._activities.running.values()):
            return ()
        return tuple(name for place, name in enumerate(self._names) if self._dispatcher.time(place) is None)

    def abort(self, now: int, violations: Iterable[Violation] = ()) -> None:
        """Give the plan up: every running activity is stopped safely."""
        self._activities.abort(now, violations)

    def blamed(self, token_id: str) -> tuple[str, ...]:
        """The goals that a token serves: its own, or those of the token whose rule asked for it, and so on upwards."""
        plan = self._network.plan
        if f"{token_id}.end" not in self._network.index:
            return self._goals.get(token_id, ())
        seen: set[str] = set()
        above: str | None = token_id
        while above is not None and above not in seen and f"{above}.end" in self._network.index:
            if goals := self._goals.get(above) or ((goal,) if (goal := plan.token(above).goal) else ()):
                return goals
            seen.add(above)
            above = plan.token(above).master
        return ()

    def lasting_goals(self, horizon_end: int) -> tuple[str, ...]:
        """The goals whose tokens hold now and may hold beyond the end of the horizon."""
        return self._goals_of(
            run.token
            for run in self._activities.running.values()
            if run.ended is None
            and run.starting is None
            and (run.token.end[1] is None or run.token.end[1] >= horizon_end)
        )

    def dues(self, now: int) -> Iterable[int]:
        """The seconds at which waiting alone changes something."""
        yield from self._activities.dues(now)
        if self._next is not None:
            yield self._next

    def _observe(self, timepoint: int, now: int, narrowed: dict[int, rte.Window]) -> list[Violation]:
        """Tell dispatcher and journal what nature did. Timed: this and `_perform` are what the dispatcher costs."""
        self._decided_by = None
        clock = perf_counter()
        happened = self._dispatcher.observe(timepoint, now)
        self._statistics.latencies.append(perf_counter() - clock)
        narrowed.update(self._dispatcher.narrowed)
        narrowed.pop(timepoint, None)
        return self._tell(happened, now)

    def _perform(self, now: int, violations: list[Violation]) -> list[int]:
        """Perform what is due now and journal it; returns which timepoints that was, and adds what they violate."""
        self._decided_by = self._wishes.times
        spared = () if now < self.horizon_end else self._wishes.lasting
        clock = perf_counter()
        performed = self._dispatcher.perform_due(now, self._wishes.times, spared)
        self._statistics.latencies.append(perf_counter() - clock)
        self._next = performed.next
        for happened in performed.happened:
            violations += self._tell(happened, now)
        self._tell_bounds(self._dispatcher.narrowed, now)
        return [timepoint for timepoint, *_ in performed.rows]

    def _tell(self, happened: rte.Happened, now: int) -> list[Violation]:
        """Journal that a timepoint happened; in the executive's words, how it broke its window."""
        window, name = happened.window, self._names[happened.timepoint]
        self._journal.write(now, "timepoint.executed", {"timepoint": name, "bounds": window})
        self._statistics.timepoints += 1
        if (violation := happened.violation) is None:
            return []
        detail = f"{name} at {now} s, expected within [{window.earliest}, {window.latest}]"
        if violation.out_of_order:
            detail += " and after " + ", ".join(self._names[i] for i in violation.out_of_order)
        token_id = name.rpartition(".")[0] or None
        return [Violation("dispatch", detail, token_id)]

    def _tell_bounds(self, narrowed: Mapping[int, rte.Window], now: int) -> None:
        """Journal the windows of timepoints still to come that have changed."""
        if narrowed:
            changes = {self._names[timepoint]: window for timepoint, window in narrowed.items()}
            self._journal.write(now, "bounds", {"changes": changes})

    def _split(self, timepoints: Iterable[int]) -> Iterable[tuple[str, bool]]:
        for timepoint in timepoints:
            token_id, _, which = self._names[timepoint].rpartition(".")
            if token_id in self._place:
                yield token_id, which == "start"

    def _order(self, effect: tuple[str, bool], before: set[str]) -> tuple[bool, int, int, bool]:
        """Effects of one instant: what was running ends before anything starts; tokens of no duration go in order."""
        token_id, is_start = effect
        return (is_start or token_id not in before, *self._place[token_id], not is_start)

    def _goals_of(self, tokens: Iterable[PlanToken]) -> tuple[str, ...]:
        return tuple(goal for token in tokens for goal in self._goals[token.id])
