"""Lanes: charts of states over time, several lines under one header, written as time goes by.

Every row of an entity repeats all of its lines, rows of one entity have distinct ascending times, and nothing is
written before its time has come: a planned future is drawn only as far as the plan was in force.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import rerun as rr

from planner.plan import PlanToken
from scenarios.recording.stream import Stream
from scenarios.recording.style import DARK_RED, RED, Palette, dim, entity, token_label

EARLIEST, EXECUTED, LATEST = range(3)
REST = ""
_AFTER_ALL = 1 << 60


@dataclass(frozen=True, slots=True)
class Block:
    """What a line shows: `value` identifies it (equal neighbours would merge), `label` is read, `colour` 0xRRGGBBAA."""

    value: str
    label: str
    colour: int


class Lane:
    """One entity of `lines` lines. `put` may name any time from the last written row on; `write` brings rows out."""

    def __init__(self, path: str, lines: int) -> None:
        self.path = path
        self._shown = [REST] * lines
        self._waiting: list[tuple[int, int, int, str]] = []
        self._count = 0
        self._written_to: int | None = None
        self._blocks: dict[str, Block] = {}
        self._styled = 0

    def add_line(self) -> int:
        """One more line at the bottom, empty so far; its index."""
        self._shown.append(REST)
        return len(self._shown) - 1

    def put(self, time: int, line: int, block: Block | None) -> None:
        """From `time` on, `line` shows `block` (None: nothing). Of two at one time the one put last holds.

        A time whose row is already written moves to the next second.
        """
        if self._written_to is not None:
            time = max(time, self._written_to + 1)
        value = REST
        if block is not None:
            value = block.value
            self._blocks[value] = block
        self._waiting.append((time, self._count, line, value))
        self._count += 1

    def withdraw(self, time: int, line: int) -> None:
        """Forget what `line` was to show at `time` and later, as far as it is not written yet."""
        self._waiting = [change for change in self._waiting if change[2] != line or change[0] < time]

    def changes_from(self, time: int, line: int) -> bool:
        """Whether something not yet written is to happen on `line` at `time` or later."""
        return any(change[2] == line and change[0] >= time for change in self._waiting)

    def due(self, before: int) -> dict[int, list[str]]:
        """Take out the rows of all times earlier than `before`: what every line shows, by ascending time.

        A row that repeats the one before it is left out.
        """
        changes = sorted(change for change in self._waiting if change[0] < before)
        self._waiting = [change for change in self._waiting if change[0] >= before]
        rows: dict[int, list[str]] = {}
        first = self._shown if self._written_to is not None else None
        shown = list(self._shown)
        for time, _, line, value in changes:
            shown[line] = value
            rows[time] = list(shown)
        kept = {}
        for time, row in rows.items():
            if row != first:
                kept[time] = first = row
        self._shown = shown
        self._written_to = max(rows, default=self._written_to)
        return kept

    def write(self, stream: Stream, before: int) -> None:
        """Send the rows of all times earlier than `before`."""
        rows = self.due(before)
        if rows:
            self._style(stream)
            states = [value for row in rows.values() for value in row]
            columns = rr.StateChange.columns(state=states).partition([len(row) for row in rows.values()])
            stream.columns(self.path, list(rows), columns)

    def end(self, stream: Stream, time: int) -> None:
        """Send what is due up to `time` and end every line there. A lane without lines writes nothing."""
        self._waiting = [change for change in self._waiting if change[0] < time]
        for line in range(len(self._shown)):
            self.put(time, line, None)
        self.write(stream, _AFTER_ALL)

    def _style(self, stream: Stream) -> None:
        if len(self._blocks) == self._styled:
            return
        self._styled = len(self._blocks)
        blocks = list(self._blocks.values())
        colours = np.array([block.colour for block in blocks], np.uint32)
        names, labels = [block.value for block in blocks], [block.label for block in blocks]
        stream.static(self.path, rr.StateConfiguration(values=names, labels=labels, colors=colours))


class TimelineLane:
    """Plan against execution of one timeline: [planned earliest, executed, planned latest] in every row."""

    def __init__(self, path: str, palette: Palette) -> None:
        self.lane = Lane(path, 3)
        self._palette = palette
        self._running: tuple[str, str] | None = None

    def plan(self, tokens: list[PlanToken], plan_id: str, handover: int) -> None:
        """Draw these host tokens, in their order, from the handover on, instead of what was planned before.

        The earliest line starts and ends tokens at their lower bounds, the latest line at their upper ones; both are
        kept monotone, and an unbounded latest time leaves the line as it is.
        """
        for line in (EARLIEST, LATEST):
            self.stop_plan(handover, line)
        self._draw(tokens, plan_id, handover, EARLIEST)
        self._draw(tokens, plan_id, handover, LATEST)

    def stop_plan(self, time: int, line: int | None = None) -> None:
        """No plan is in force from `time` on."""
        for which in (EARLIEST, LATEST) if line is None else (line,):
            self.lane.withdraw(time, which)
            self.lane.put(time, which, None)

    def _draw(self, tokens: list[PlanToken], plan_id: str, handover: int, line: int) -> None:
        side = 0 if line == EARLIEST else 1
        last = handover
        for token in tokens:
            label = token_label(token.predicate, token.parameters)
            colour = dim(self._palette.colour(token.predicate, token.parameters))
            block = Block(f"plan:{label}#{plan_id}.{token.id}", label, colour)
            for bound, shown in ((token.start[side], block), (token.end[side], None)):
                if bound is None and line == LATEST:
                    return
                last = max(last, last if bound is None else bound)
                self.lane.put(last, line, shown)

    def is_running(self, plan: str, token: str, in_force: str) -> bool:
        """Whether this token is the one that runs: a token that a new plan took over goes on under its name there."""
        if self._running is None:
            return False
        return self._running == (plan, token) or (plan == in_force and self._running[0] != in_force)

    def start(self, time: int, plan: str, token: str, predicate: str, parameters: Mapping[str, object]) -> None:
        """The executive started a token."""
        self._running = (plan, token)
        label = token_label(predicate, parameters)
        colour = self._palette.colour(predicate, parameters)
        self.lane.put(time, EXECUTED, Block(f"{label}#{plan}.{token}", label, colour))

    def end(self, time: int, name: str, outcome: Literal["finished", "failed", "aborted"]) -> None:
        """What ran ended. A failed or aborted `name` stays, red, until something else starts."""
        block = None
        if outcome == "failed":
            block = Block(f"failed:{name}@{time}", f"{name} failed", RED)
        elif outcome == "aborted":
            block = Block(f"aborted:{name}@{time}", f"{name} called off", DARK_RED)
        self._running = None
        self.lane.put(time, EXECUTED, block)

    @property
    def is_idle(self) -> bool:
        """Whether nothing runs."""
        return self._running is None


def lane_paths(root: str, names: tuple[str, ...]) -> list[str]:
    """Entity paths that sort in the given order: `/mission/1_attitude`, and so on after the header lane 0."""
    width = len(str(len(names)))
    return [f"{root}/{i:0{width}d}_{entity(name)}" for i, name in enumerate(names, 1)]
