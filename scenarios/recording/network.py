"""The plan as a network: the tokens round the present and what binds them; and start bounds narrowing with time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import rerun as rr

from planner.plan import Bounds, FlexiblePlan, PlanToken
from scenarios.recording.stream import Stream
from scenarios.recording.style import GREY, LINES, RED, Palette, dim, entity, lighten, token_label

NETWORK = "/network"
BOUNDS = "/bounds"
COLUMNS = 9
NOW_COLUMN = 2
STEP_X, STEP_Y = 190.0, 62.0
_LABEL_LENGTH = 26
_MOST_TIMEPOINTS = 8


def hosts_by_timeline(plan: FlexiblePlan) -> dict[str, list[PlanToken]]:
    """Host tokens in slot order under `object.attribute`."""
    return {f"{t.object}.{t.attribute}": [plan.token(slot[0]) for slot in t.slots] for t in plan.timelines}


@dataclass
class NetworkView:
    """The plan in force at the cursor: for each lane the last tokens, the present one, and the next ones.

    The present stands in one column for all lanes. Drawn again when a token starts or ends, once a second at most.
    """

    lanes: tuple[str, ...]
    palette: Palette
    _tokens: dict[str, list[PlanToken]] = field(default_factory=dict)
    _pairs: tuple[tuple[str, str], ...] = ()
    _state: dict[str, str] = field(default_factory=dict)
    _changed_at: int | None = None

    def plan(self, time: int, plan: FlexiblePlan) -> None:
        """Show this plan from `time` on."""
        timelines = hosts_by_timeline(plan)
        self._tokens = {lane: timelines.get(lane, []) for lane in self.lanes}
        pairs: dict[frozenset[str], tuple[str, str]] = {}
        for constraint in plan.constraints:
            ends = constraint.from_.rpartition(".")[0], constraint.to.rpartition(".")[0]
            pairs.setdefault(frozenset(ends), ends)
        self._pairs = tuple(pairs.values())
        self._state = {}
        self._changed_at = time

    def mark(self, time: int, token: str, state: str) -> None:
        """A token is `running`, `done` or `failed`."""
        self._state[token] = state
        if self._changed_at is None:
            self._changed_at = time

    def write(self, stream: Stream, before: int) -> None:
        """Draw what changed earlier than `before`."""
        if self._changed_at is not None and self._changed_at < before:
            self.draw(stream, self._changed_at)
            self._changed_at = None

    def draw(self, stream: Stream, time: int) -> None:
        """Send the picture of this instant."""
        ids, labels, colours, positions = _Header(self.lanes).nodes()
        shown: dict[str, int] = {}
        edges: list[tuple[str, str]] = []
        for row, lane in enumerate(self.lanes):
            previous: str | None = None
            for column, token in self._window(self._tokens.get(lane, [])):
                shown[token.id] = row
                ids.append(token.id)
                labels.append(self._label(token))
                colours.append(self._colour(token))
                positions.append((column * STEP_X, (row + 1) * STEP_Y))
                if previous is not None:
                    edges.append((previous, token.id))
                previous = token.id
        edges += [(a, b) for a, b in self._pairs if a in shown and b in shown and shown[a] != shown[b]]
        nodes = rr.GraphNodes(ids, labels=labels, colors=np.array(colours, np.uint32), positions=positions)
        stream.at(time, NETWORK, nodes, rr.GraphEdges(edges, graph_type="directed"))

    def _window(self, tokens: Sequence[PlanToken]) -> list[tuple[int, PlanToken]]:
        states = [self._state.get(token.id, "") for token in tokens]
        running = [i for i, state in enumerate(states) if state == "running"]
        ended = [i for i, state in enumerate(states) if state in ("done", "failed")]
        focus = running[-1] if running else (ended[-1] + 1 if ended else 0)
        first = max(0, focus - NOW_COLUMN)
        return [
            (i - focus + NOW_COLUMN, tokens[i]) for i in range(first, min(len(tokens), focus + COLUMNS - NOW_COLUMN))
        ]

    def _label(self, token: PlanToken) -> str:
        label = token_label(token.predicate, token.parameters)
        return label if len(label) <= _LABEL_LENGTH else label[: _LABEL_LENGTH - 1] + "…"

    def _colour(self, token: PlanToken) -> int:
        state = self._state.get(token.id, "")
        if state == "failed":
            return RED
        colour = self.palette.colour(token.predicate, token.parameters)
        if state == "running":
            return 0xFFFFFFFF
        return dim(lighten(colour), 0.75) if state == "done" else lighten(colour)


@dataclass(frozen=True, slots=True)
class _Header:
    lanes: tuple[str, ...]

    def nodes(self) -> tuple[list[str], list[str], list[int], list[tuple[float, float]]]:
        """Names of lanes at the left, `done`, `now` and `next` above the columns, and what red means."""
        grey = lighten(GREY)
        ids, labels, colours, positions = [], [], [], []
        for name, column in (("done", 0.5), ("now", float(NOW_COLUMN)), ("next", NOW_COLUMN + 1.0)):
            ids.append(f"column {name}")
            labels.append(name)
            colours.append(0xFFFFFFFF if name == "now" else grey)
            positions.append((column * STEP_X, 0.0))
        ids.append("column failed")
        labels.append("red: failed or called off")
        colours.append(RED)
        positions.append((-1.0 * STEP_X, 0.0))
        for row, lane in enumerate(self.lanes):
            ids.append(f"lane {lane}")
            labels.append(lane)
            colours.append(grey)
            positions.append((-1.1 * STEP_X, (row + 1) * STEP_Y))
        return ids, labels, colours, positions


@dataclass
class _Funnel:
    """Bounds of one timepoint in minutes after its first lower bound, by the time they became so."""

    path: str
    base: int
    since: int
    rows: dict[int, tuple[float, float]] = field(default_factory=dict)
    open: bool = True

    def add(self, time: int, bounds: Bounds) -> None:
        lower, upper = bounds
        low = np.nan if lower is None else (lower - self.base) / 60
        high = np.nan if upper is None else (upper - self.base) / 60
        self.rows[max(time, self.since)] = (low, high)

    def close(self, time: int) -> None:
        self.rows[max(time, self.since) + 1] = (np.nan, np.nan)
        self.open = False

    def send(self, stream: Stream) -> None:
        if self.rows:
            times = sorted(self.rows)
            values = np.array([self.rows[t] for t in times])
            stream.columns(self.path, times, rr.Scalars.columns(scalars=values.ravel()).partition([2] * len(times)))
            self.since = times[-1] + 1
            self.rows = {}


class BoundsView:
    """Funnels: earliest and latest start of chosen tokens, closing as the executive learns, ended by execution.

    What the next plan has again keeps its colour, and its line in the legend.
    """

    def __init__(self) -> None:
        self._funnels: dict[str, _Funnel] = {}
        self._colours: dict[str, int] = {}

    def plan(self, stream: Stream, plan_id: str, plan: FlexiblePlan, handover: int) -> None:
        """Close the funnels of the plan before, and open those of this one."""
        for funnel in self._funnels.values():
            if funnel.open:
                funnel.close(handover)
            funnel.send(stream)
        self._funnels = {}
        for number, token in enumerate(chosen_tokens(plan, handover)):
            base = token.start[0]
            assert base is not None
            label = token_label(token.predicate, token.parameters)
            path = f"{BOUNDS}/{entity(plan_id)}/{number}_{entity(label)}"
            colour = self._colours.setdefault(label, LINES[len(self._colours) % len(LINES)])
            style = rr.SeriesLines(
                names=[label] * 2,
                colors=np.array([colour, colour], np.uint32),
                widths=[2.0, 2.0],
                interpolation_mode="StepAfter",
            )
            stream.static(path, style)
            funnel = _Funnel(path, base, handover)
            funnel.add(handover, token.start)
            self._funnels[f"{token.id}.start"] = funnel

    def change(self, time: int, changes: Mapping[str, Sequence[int | None]]) -> None:
        """Bounds became narrower."""
        for timepoint, bounds in changes.items():
            funnel = self._funnels.get(timepoint)
            if funnel is not None and funnel.open:
                funnel.add(time, (bounds[0], bounds[1]))

    def executed(self, time: int, timepoint: str) -> None:
        """The timepoint happened."""
        funnel = self._funnels.get(timepoint)
        if funnel is not None and funnel.open:
            funnel.add(time, (time, time))
            funnel.close(time)

    def send(self, stream: Stream) -> None:
        """Send what is known so far."""
        for funnel in self._funnels.values():
            funnel.send(stream)

    def end(self, stream: Stream, time: int) -> None:
        """Send what is left; a funnel still open holds its bounds to the end."""
        for funnel in self._funnels.values():
            if funnel.open:
                funnel.close(time - 1)
        self.send(stream)


def chosen_tokens(plan: FlexiblePlan, handover: int) -> list[PlanToken]:
    """At most eight host tokens whose start is open at the handover, spread over the plan; goals' own if any."""
    slots = [slot for timeline in plan.timelines for slot in timeline.slots]
    goals = {slot[0] for slot in slots if any(plan.token(t).goal for t in slot)}
    free = [t for t in plan.hosts() if _is_open(t, handover) and not t.predicate.startswith("Planner.")]
    wanted = [t for t in free if t.id in goals] or free
    wanted.sort(key=lambda t: (t.start[0] or 0, t.id))
    if len(wanted) > _MOST_TIMEPOINTS:
        picks = np.linspace(0, len(wanted) - 1, _MOST_TIMEPOINTS).round().astype(int)
        wanted = [wanted[i] for i in picks]
    return wanted


def _is_open(token: PlanToken, handover: int) -> bool:
    lower, upper = token.start
    return not token.fact and lower is not None and upper is not None and upper > max(lower, handover)
