"""What of a plan in execution will be running at a hand-over to come, and the problem state that this is.

Only what is certain is foretold. A token that nature ends must surely be running at the hand-over: begun by now, and
not able to end before. What the executive itself would begin or end is held until then. A timeline may have gaps.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

from executive.activities import RunningToken, decided
from executive.dispatcher import Dispatcher
from executive.network import PlanNetwork
from planner.plan import PlanTimeline, PlanToken
from planner.problem import TokenPattern

Line = tuple[str, str]
_NEVER = 1 << 62


@dataclass(frozen=True)
class Forecast:
    """`state`: of the problem that begins at `handover` (seconds). `running`: by timeline, the host running then.

    `idle`: the timelines on which nothing will be running. `over`: the hosts that will be over by then. `held`: the
    executive's own timepoints that must not come before that.
    """

    handover: int
    state: tuple[TokenPattern, ...]
    running: Mapping[Line, str]
    idle: frozenset[Line]
    over: frozenset[str]
    held: tuple[int, ...]


@dataclass(frozen=True)
class Forecaster:
    """Looks ahead in one plan. `runs`: what is running now, by token."""

    network: PlanNetwork
    dispatcher: Dispatcher
    runs: Mapping[str, RunningToken]

    def at_end(self) -> Forecast | str:
        """At the end of the plan's horizon, when all that may be over is over; or why that is not certain."""
        return self._foretell(self.network.plan.horizon[1], self._last)

    def from_(self, earliest: int) -> Forecast | str:
        """At the first instant not before `earliest` at which it is certain; or why there is none."""
        handover = earliest
        while handover < self.network.plan.horizon[1]:
            later = max((self._straddles(line, handover) for line in self._lines()), default=handover)
            if later <= handover:
                return self._foretell(handover, partial(self._place, time=handover))
            handover = later
        return "nothing is certain before the end of the plan"

    def _lines(self) -> tuple[PlanTimeline, ...]:
        """The timelines that are not facts: facts are told to the planner anew."""
        plan = self.network.plan
        return tuple(line for line in plan.timelines if line.slots and not plan.token(line.slots[-1][0]).fact)

    def _bounds(self, timepoint: str, known: tuple[int | None, int | None]) -> tuple[int, int]:
        """Between which seconds a timepoint happens or has happened; `known`: what the plan says."""
        place = self.network.index[timepoint]
        if (time := self.dispatcher.time(place)) is not None:
            return time, time
        window = self.dispatcher.window(place)
        lower = max(-_NEVER if bound is None else bound for bound in (window.earliest, known[0]))
        upper = min(_NEVER if bound is None else bound for bound in (window.latest, known[1]))
        return lower, upper

    def _end(self, host: str) -> tuple[int, int]:
        return self._bounds(f"{host}.end", self.network.plan.token(host).end)

    def _place(self, line: PlanTimeline, time: int) -> tuple[int, bool]:
        """The first slot that is not surely over by then (their number if all are), and whether it has surely begun."""
        for number, slot in enumerate(line.slots):
            if self._end(slot[0])[1] > time:
                start = self._bounds(f"{slot[0]}.start", self.network.plan.token(slot[0]).start)
                joined = number > 0 and self._are_joined(line.slots[number - 1][0], slot[0])
                return number, joined or start[1] <= time
        return len(line.slots), False

    def _last(self, line: PlanTimeline) -> tuple[int, bool]:
        """The last slot if it lasts to the end of the horizon or beyond; or that all are over by then."""
        last, end = line.slots[-1][0], self.network.plan.horizon[1]
        if self.network.plan.token(last).contingent:
            lasts = self._end(last)[1] > end
        else:
            lasts = self.network.index[f"{last}.end"] in self.network.lasting
        return (len(line.slots) - 1, True) if lasts else (len(line.slots), False)

    def _are_joined(self, before: str, after: str) -> bool:
        """Whether a token begins the instant that the one before it ends."""
        first, second = self.network.index[f"{before}.end"], self.network.index[f"{after}.start"]
        return any(
            (link.from_, link.to) in ((first, second), (second, first)) and link.min == link.max == 0
            for link in self.network.stnu.links
        )

    def _straddles(self, line: PlanTimeline, time: int) -> int:
        """When what nature decides on that timeline around `time` is over at the latest; `time` if it is certain."""
        number, begun = self._place(line, time)
        if not begun:
            return time
        host = line.slots[number][0]
        if not self.network.plan.token(host).contingent or self._surely_runs(host, time):
            return time
        return self._end(host)[1]

    def _surely_runs(self, host: str, time: int) -> bool:
        """Whether what nature ends has begun and cannot end by then."""
        return host in self.runs and self._end(host)[0] > time

    def _foretell(self, handover: int, place: Callable[[PlanTimeline], tuple[int, bool]]) -> Forecast | str:
        state: list[TokenPattern] = []
        running: dict[Line, str] = {}
        idle: set[Line] = set()
        over: set[str] = set()
        held: list[int] = []
        for line in self._lines():
            number, begun = place(line)
            over.update(slot[0] for slot in line.slots[:number])
            held += self._to_come(line, number, begun)
            if not begun:
                idle.add((line.object, line.attribute))
                continue
            host = self.network.plan.token(line.slots[number][0])
            if host.contingent and not self._surely_runs(host.id, handover):
                return f"{host.object} {host.predicate} ({host.id}) may or may not be over at {handover} s"
            state.append(self._pattern(host, handover))
            running[line.object, line.attribute] = host.id
        return Forecast(handover, tuple(state), running, frozenset(idle), frozenset(over), tuple(held))

    def _to_come(self, line: PlanTimeline, number: int, begun: bool) -> list[int]:
        """The timepoints on a timeline from that slot on that are the executive's to perform."""
        hosts = [self.network.plan.token(slot[0]) for slot in line.slots[number:]]
        names = [f"{host.id}.start" for host in hosts[begun:]]
        names += [f"{host.id}.end" for host in hosts if not host.contingent]
        return [self.network.index[name] for name in names]

    def _pattern(self, host: PlanToken, handover: int) -> TokenPattern:
        """A token of the next problem. One that is running now keeps its true start: what it had to begin with, or how
        long it may still last, follows from that. It lasts into the horizon, so that what it needs has to last as well;
        and what lasts beyond the plan's horizon whatever is done lasts as long in the next."""
        parameters = {name: value for name, value in decided(host).items() if name in host.parameters}
        beyond = host.end[0] is not None and host.end[0] > self.network.plan.horizon[1]
        lasts = (host.end[0] if beyond else handover + 1, None)
        run = self.runs.get(host.id)
        if run is None:
            return TokenPattern(host.predicate, host.object, parameters, end=lasts)
        began, contingent = (run.started, run.started), True if host.contingent else None
        duration = host.duration if host.contingent else (None, None)
        return TokenPattern(host.predicate, host.object, parameters, began, lasts, duration, contingent)
