"""What of a plan in execution will be running at a hand-over to come, and the problem state that this is.

Only what is certain is foretold. A token that nature ends must surely be running at the hand-over: begun by now, and
not able to end before. What the executive itself would end is held until then.
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

    `over`: the hosts that will be over by then. `held`: the executive's own timepoints that must not come before that.
    """

    handover: int
    state: tuple[TokenPattern, ...]
    running: Mapping[Line, str]
    over: frozenset[str]
    held: tuple[int, ...]


@dataclass(frozen=True)
class Forecaster:
    """Looks ahead in one plan. `runs`: what is running now, by token."""

    network: PlanNetwork
    dispatcher: Dispatcher
    runs: Mapping[str, RunningToken]

    def at_end(self) -> Forecast | str:
        """At the end of the plan's horizon, when everything has come to its last token; or why that is not certain."""
        end = self.network.plan.horizon[1]
        return self._foretell(end, lambda line: len(line.slots) - 1)

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

    def _end(self, host: str) -> tuple[int, int]:
        """Between which seconds a token ends or has ended."""
        place = self.network.index[f"{host}.end"]
        if (known := self.dispatcher.time(place)) is not None:
            return known, known
        window, token = self.dispatcher.window(place), self.network.plan.token(host)
        lower = max(-_NEVER if bound is None else bound for bound in (window.earliest, token.end[0]))
        upper = min(_NEVER if bound is None else bound for bound in (window.latest, token.end[1]))
        return lower, upper

    def _place(self, line: PlanTimeline, time: int) -> int:
        """The first slot that is not surely over by then; the last if all are."""
        return next((i for i, slot in enumerate(line.slots) if self._end(slot[0])[1] > time), len(line.slots) - 1)

    def _straddles(self, line: PlanTimeline, time: int) -> int:
        """When what nature decides on that timeline around `time` is over at the latest; `time` if it is certain."""
        host = line.slots[self._place(line, time)][0]
        if not self.network.plan.token(host).contingent or self._surely_runs(host, time):
            return time
        return self._end(host)[1]

    def _surely_runs(self, host: str, time: int) -> bool:
        """Whether what nature ends has begun and cannot end by then."""
        return host in self.runs and self._end(host)[0] > time

    def _foretell(self, handover: int, place: Callable[[PlanTimeline], int]) -> Forecast | str:
        state: list[TokenPattern] = []
        running: dict[Line, str] = {}
        over: set[str] = set()
        held: list[int] = []
        for line in self._lines():
            number = place(line)
            host = self.network.plan.token(line.slots[number][0])
            if host.contingent and not self._surely_runs(host.id, handover):
                return f"{host.object} {host.predicate} ({host.id}) may or may not be over at {handover} s"
            state.append(self._pattern(host, handover))
            running[line.object, line.attribute] = host.id
            over.update(slot[0] for slot in line.slots[:number])
            held += self._to_come(line, number)
        return Forecast(handover, tuple(state), running, frozenset(over), tuple(held))

    def _to_come(self, line: PlanTimeline, number: int) -> list[int]:
        """The timepoints on a timeline from the end of that slot on that are the executive's to perform."""
        hosts = [self.network.plan.token(slot[0]) for slot in line.slots[number:]]
        names = [f"{host.id}.start" for host in hosts[1:]]
        names += [f"{host.id}.end" for host in hosts if not host.contingent]
        return [self.network.index[name] for name in names]

    def _pattern(self, host: PlanToken, handover: int) -> TokenPattern:
        """A token of the next problem. What still has to last, or may not last on, keeps the time of its true start."""
        parameters = {name: value for name, value in decided(host).items() if name in host.parameters}
        lower, upper = host.duration
        run = self.runs.get(host.id)
        if run is None or (not host.contingent and upper is None and run.started + (lower or 0) <= handover):
            return TokenPattern(host.predicate, host.object, parameters)
        began = (run.started, run.started)
        return TokenPattern(
            host.predicate, host.object, parameters, began, (handover, None), host.duration, host.contingent
        )
