"""From a flexible plan to the network that is checked and dispatched.

The timepoints are the origin and the two ends of every slot's host; codesignated tokens share their host's. A token
outside of all timelines (what a resource is used for) takes part if a constraint speaks of it. The links
are the plan's constraints, the tokens' durations (contingent where nature decides) and the horizon. Bounds of ends are
consequences and stay out: the propagated end of a contingent token, taken as a requirement, would be a promise that
only nature can keep.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from planner.errors import NetworkFormatError
from planner.plan import ORIGIN, Bound, FlexiblePlan, PlanConstraint, PlanTimeline, PlanToken
from planner.temporal.controllability import check
from planner.temporal.stnu import Link, Stnu


@dataclass(frozen=True, slots=True)
class Conflict:
    """Why no strategy keeps a plan whatever nature decides. Without one of these requirements it might.

    `text`: in the words of the domain. `tokens`: the hosts between whose ends the requirements are, in their order;
    `contingent`: those of which nature's choice of duration takes part; `constraints`: the plan's that take part. No
    plan that contains all of these is controllable, so a search may go back to the latest decision behind any of them.
    """

    text: str
    tokens: tuple[str, ...]
    contingent: tuple[str, ...]
    constraints: tuple[PlanConstraint, ...]


def conflict_of(plan: FlexiblePlan) -> Conflict | None:
    """What makes a plan uncontrollable; None when it can be kept whatever nature decides."""
    try:
        network = PlanNetwork.of(plan)
    except NetworkFormatError as error:
        return Conflict(f"the plan is not a network: {error}", (), (), ())
    verdict = check(network.stnu)
    return None if verdict.controllable else network.conflict(verdict.conflict)


@dataclass(frozen=True)
class PlanNetwork:
    """A plan's temporal network in the words of the plan.

    `index`: the timepoint, by any of its names (`"t3.start"`, also of codesignated tokens). `reasons`: for each link of
    `stnu` the requirement that it stands for; `sources`: the plan's constraint or token that makes it. `begun`: hosts
    that hold already, with the tick at which they began; their starts are fixed. `lasting`: ends that nothing waits
    for, so that they need not come as early as they may: those of what timelines end with, unless it is a goal that
    nothing has to follow, and whatever may not end before these.
    Time is ticks from the origin at 0.
    """

    plan: FlexiblePlan
    stnu: Stnu
    index: Mapping[str, int]
    reasons: tuple[str, ...]
    sources: tuple[PlanConstraint | PlanToken, ...]
    begun: Mapping[str, int]
    lasting: frozenset[int]

    @classmethod
    def of(cls, plan: FlexiblePlan) -> PlanNetwork:
        """The network of a plan; NetworkFormatError when the plan's bounds cannot be one."""
        names = [ORIGIN]
        index = {ORIGIN: 0}
        begun: dict[str, int] = {}
        hosts: list[PlanToken] = []
        for slot in (*(slot for timeline in plan.timelines for slot in timeline.slots), *loose(plan)):
            hosts.append(plan.token(slot[0]))
            for which in ("start", "end"):
                index.update((f"{token_id}.{which}", len(names)) for token_id in slot)
                names.append(f"{slot[0]}.{which}")
            if (start := _began(plan, slot)) is not None:
                begun[slot[0]] = start
        rows: list[tuple[Link, str, PlanConstraint | PlanToken]] = []
        for host in hosts:
            rows += [(*row, host) for row in _token_rows(plan, host, index, begun.get(host.id))]
        rows += [(*row, c) for c in plan.constraints if (row := _constraint_row(c, index)) is not None]
        links = tuple(link for link, _, _ in rows)
        reasons, sources = tuple(why for _, why, _ in rows), tuple(source for _, _, source in rows)
        return cls(plan, Stnu(tuple(names), links), index, reasons, sources, begun, _lasting(plan, index, links))

    def conflict(self, links: Iterable[int]) -> Conflict:
        """Some links that cannot be kept together whatever nature does, as what of the plan makes them."""
        chosen = list(dict.fromkeys(links))
        sources = [self.sources[number] for number in chosen]
        ends = [self.stnu.timepoints[place] for i in chosen for place in self.stnu.links[i][:2]]
        return Conflict(
            self.explain(chosen),
            tuple(dict.fromkeys(end.rpartition(".")[0] for end in ends if end != ORIGIN)),
            tuple(dict.fromkeys(s.id for s in sources if isinstance(s, PlanToken) and s.contingent)),
            tuple(dict.fromkeys(s for s in sources if isinstance(s, PlanConstraint))),
        )

    def explain(self, links: Iterable[int]) -> str:
        """The requirements of some links, for people."""
        lines = []
        for number in dict.fromkeys(links):
            link = self.stnu.links[number]
            first, last = self.stnu.timepoints[link.from_], self.stnu.timepoints[link.to]
            low, high = ("any" if bound is None else bound for bound in (link.min, link.max))
            lines.append(f"{self.reasons[number]}: {self._say(first)} to {self._say(last)} in [{low}, {high}]")
        return "; ".join(lines)

    def _say(self, timepoint: str) -> str:
        if timepoint == ORIGIN:
            return timepoint
        token_id, _, which = timepoint.rpartition(".")
        return f"{which} of {self.plan.token(token_id).predicate} ({token_id})"


def loose(plan: FlexiblePlan) -> list[tuple[str]]:
    """The tokens that are in no slot but in a constraint."""
    placed = {token_id for timeline in plan.timelines for slot in timeline.slots for token_id in slot}
    named = {end.rpartition(".")[0] for c in plan.constraints for end in (c.from_, c.to) if end != ORIGIN}
    return [(token.id,) for token in plan.tokens if token.id in named and token.id not in placed]


def _lasting(plan: FlexiblePlan, index: Mapping[str, int], links: Iterable[Link]) -> frozenset[int]:
    """Ends of timelines' last slots and what must not end before them, where these are ends of the executive's own."""
    after: dict[int, set[int]] = {}
    natural = {link.to for link in links if link.contingent}
    for link in links:
        if link.min is not None and link.min >= 0:
            after.setdefault(link.from_, set()).add(link.to)
        if link.max is not None and link.max <= 0:
            after.setdefault(link.to, set()).add(link.from_)
    ends = {place for name, place in index.items() if name.endswith(".end")} - natural
    found: set[int] = set()
    for timeline in plan.timelines:
        if not timeline.slots or (_is_goal(plan, timeline.slots[-1]) and not _is_open(plan, timeline)):
            continue
        reached = set()
        waiting = [index[f"{timeline.slots[-1][0]}.end"]]
        while waiting:
            if (place := waiting.pop()) not in reached:
                reached.add(place)
                waiting += after.get(place, ())
        if reached <= ends:
            found |= reached
    return frozenset(found)


def _is_goal(plan: FlexiblePlan, slot: tuple[str, ...]) -> bool:
    return any(plan.token(i).goal is not None for i in slot)


def _is_open(plan: FlexiblePlan, timeline: PlanTimeline) -> bool:
    """Whether what has to follow a timeline's last token lies beyond the horizon, until which the token then lasts."""
    return any(
        token.attribute == timeline.attribute
        and token.object in ("", timeline.object)
        and token.master in timeline.slots[-1]
        for token in plan.boundary
    )


def _began(plan: FlexiblePlan, slot: tuple[str, ...]) -> int | None:
    """When a slot's host began, if the problem's state or facts say that it holds at the plan's start."""
    opening = plan.horizon[0]
    host = plan.token(slot[0])
    latest = host.start[1]
    if latest is None:
        return opening if host.start[0] is None and _is_given(plan, slot) else None
    if latest < opening or (latest == opening and _is_given(plan, slot)):
        return latest
    return None


def _is_given(plan: FlexiblePlan, slot: tuple[str, ...]) -> bool:
    """Whether a slot holds a token that nothing in the plan asked for: neither a goal nor another token's rule."""
    return any((token := plan.token(i)).fact or (token.goal is None and token.master is None) for i in slot)


def _constraint_row(c: PlanConstraint, index: Mapping[str, int]) -> tuple[Link, str] | None:
    """The link of a constraint; None for what holds by itself because both timepoints are one."""
    from_, to = index[c.from_], index[c.to]
    if from_ != to:
        return Link(from_, to, c.min, c.max), c.why
    if (c.min or 0) <= 0 <= (0 if c.max is None else c.max):
        return None
    # A timepoint apart from itself stays, as something that nothing can satisfy.
    return Link(0, to or 1, 1, 0), f"{c.why} ({c.from_} to {c.to})"


def _token_rows(
    plan: FlexiblePlan, host: PlanToken, index: Mapping[str, int], began: int | None
) -> list[tuple[Link, str]]:
    start, end = index[f"{host.id}.start"], index[f"{host.id}.end"]
    opening = plan.horizon[0]
    what = f"{host.object}.{host.attribute} {host.predicate}"
    rows: list[tuple[Link, str]] = []
    lower, upper = host.duration
    if host.contingent:
        # What was running before the plan and still is has not ended yet: the elapsed time is taken off.
        least = lower if began is None or began >= opening else max(lower or 0, opening - began)
        rows.append((Link(start, end, least, upper, True), f"duration of {what}, decided by nature"))
    else:
        # Never shorter than nothing, whatever the plan leaves open.
        rows.append((Link(start, end, max(lower or 0, 0), upper), f"duration of {what}"))
        if not host.fact:
            rows.append((Link(0, end, opening, None), "start of the horizon"))
    if began is not None:
        rows.append((Link(0, start, began, began), f"{what} holds already"))
        return rows
    rows.append((Link(0, start, _later(host.start[0], opening), host.start[1]), f"start bounds of {what}"))
    if host.fact and not host.contingent:
        rows.append((Link(0, end, *host.end), f"end bounds of {what}"))
    return rows


def _later(bound: Bound, opening: int) -> int:
    return opening if bound is None else max(bound, opening)
