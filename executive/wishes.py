"""When each timepoint of a plan is wanted inside the window that the plan leaves; the dispatcher keeps to the window.

As early as allowed, but for four reasons to wait: what nothing waits for lasts; an activity's binding prefers another
time; a hand-over counts on it; time that was lost has to be made up for. Of several the latest counts. Whatever would
force a timepoint before its wanted time waits as well, as far as its own window allows.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping

from executive.activities import decided
from executive.bindings import Bindings, Near, Wish
from executive.network import PlanNetwork
from planner.plan import PlanToken
from planner.temporal.stnu import UNBOUNDED, Stnu


class Wishes:
    """The wanted times (seconds) of one plan's timepoints, as `Dispatcher.next_decision` takes them.

    `lasting`: the ends that nothing waits for, wanted after the end of the horizon.
    """

    def __init__(self, network: PlanNetwork, bindings: Bindings) -> None:
        self._network = network
        self.lasting = dict.fromkeys(sorted(network.lasting), network.plan.horizon[1] + 1)
        self._after_start: dict[str, int] = {}
        self._wanted: dict[int, int] = {}
        self._held: Mapping[int, int] = {}
        self._before: dict[int, Mapping[int, int]] = {}
        for token in network.plan.hosts():
            self._prefer(token, bindings)
        self.times: Mapping[int, int] = {}
        self._merge()

    def hold(self, timepoints: Iterable[int], until: int) -> None:
        """Let none of these come before `until`."""
        self._held = dict.fromkeys(timepoints, until)
        self._merge()

    def release(self) -> None:
        """Hold nothing any more."""
        self._held = {}
        self._merge()

    def started(self, token_id: str, now: int) -> None:
        """A token has started: its end may be wanted some time after that."""
        if (seconds := self._after_start.get(token_id)) is not None:
            self.want(f"{token_id}.end", now + seconds)

    def want(self, timepoint: str, time: int) -> None:
        """A timepoint is wanted at `time` at the earliest: no other may force it before."""
        place = self._network.index[timepoint]
        if self._wanted.get(place, time - 1) < time:
            self._delay(place, time)
            self._merge()

    def _prefer(self, token: PlanToken, bindings: Bindings) -> None:
        activity = bindings.activity(token.predicate)
        if activity is None or f"{token.id}.end" not in self._network.index:
            return
        for which, wish, latest in (("start", activity.starts, token.start[1]), ("end", activity.ends, token.end[1])):
            if isinstance(wish, Near) and wish.after_start:
                self._after_start[token.id] = _seconds(wish, token)
            elif (time := self._time(wish, latest, token)) is not None:
                self._delay(self._network.index[f"{token.id}.{which}"], time)

    def _time(self, wish: Wish, latest: int | None, token: PlanToken) -> int | None:
        if wish == "earliest":
            return None
        end = self._network.plan.horizon[1]
        last = end if latest is None else min(latest, end)
        return min(_seconds(wish, token), last) if isinstance(wish, Near) else last

    def _delay(self, place: int, time: int) -> None:
        if place not in self._before:
            found = slack_before(self._network.stnu, place)
            self._before[place] = {other: slack for other, slack in found.items() if slack >= 0}
        for other, slack in self._before[place].items():
            self._wanted[other] = max(self._wanted.get(other, 0), time - slack)

    def _merge(self) -> None:
        times = dict(self._wanted)
        for later in (self._held, self.lasting):
            for place, time in later.items():
                times[place] = max(times.get(place, time), time)
        self.times = times


def slack_before(stnu: Stnu, place: int) -> dict[int, int]:
    """How long after each timepoint `place` may still happen at least, whatever nature does; without those that leave
    it free. Shortest paths to `place` (Bellman and Ford, with a queue) over a consistent network.
    """
    entering: dict[int, list[tuple[int, int]]] = {}
    for from_, to, least, most, contingent in stnu.table.tolist():
        if (latest := least if contingent else most) != UNBOUNDED:
            entering.setdefault(to, []).append((from_, latest))
        if least != -UNBOUNDED:
            entering.setdefault(from_, []).append((to, -least))
    found, waiting = {place: 0}, deque([place])
    while waiting:
        node = waiting.popleft()
        for other, weight in entering.get(node, ()):
            if (slack := found[node] + weight) < found.get(other, slack + 1):
                found[other] = slack
                waiting.append(other)
    return found


def _seconds(wish: Near, token: PlanToken) -> int:
    """What is preferred, by the token's parameter where it says so."""
    if isinstance(wish.seconds, str):
        return round(float(decided(token)[wish.seconds.removeprefix("$")]))
    return wish.seconds
