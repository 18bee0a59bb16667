"""Telemetry: rows in preallocated arrays, sent as columns. One entity a panel, so that a sample costs little."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr

from scenarios.recording.lanes import Block, Lane
from scenarios.recording.scene import CRAFT, THRUST, Quaternion, Scene, plume_vectors
from scenarios.recording.stream import Stream
from scenarios.recording.style import AMBER, GREEN, GREY, LINES, Palette, entity

_CAPACITY = 512


@dataclass(frozen=True, slots=True)
class Channel:
    """A telemetry channel and where it is shown.

    `name`: its key in the values of a sample. `tab`: `Attitude`, `Power`, or any other, which becomes a tab of its own.
    `panel`: the plot in that tab, its title with the unit; channels with one tab and panel share it. `state`: the value
    is a word or a flag, drawn as a lane, not a number. `label`: for the legend, else the name. `scale`: what the value
    is multiplied with to have the unit of the title.
    """

    name: str
    tab: str
    panel: str
    state: bool = False
    label: str = ""
    scale: float = 1.0


@dataclass(frozen=True, slots=True)
class Panel:
    """The channels that share a plot, and its entity."""

    tab: str
    title: str
    path: str
    state: bool
    channels: tuple[Channel, ...]


def panels_of(channels: Sequence[Channel]) -> list[Panel]:
    """Panels in order of first mention; numbers and states of one panel are two."""
    groups: dict[tuple[str, str, bool], list[Channel]] = {}
    for channel in channels:
        groups.setdefault((channel.tab, channel.panel, channel.state), []).append(channel)
    found = []
    for (tab, title, state), members in groups.items():
        root = "states" if state else "telemetry"
        found.append(Panel(tab, title, f"/{root}/{entity(tab)}/{entity(title)}", state, tuple(members)))
    return found


class Telemetry:
    """Samples of all channels and of the attitude, buffered until `send`."""

    def __init__(self, stream: Stream, scene: Scene, panels: Sequence[Panel]) -> None:
        self._scene = scene
        self._panels = [panel for panel in panels if not panel.state]
        channels = [channel for panel in self._panels for channel in panel.channels]
        self._names = [channel.name for channel in channels]
        self._scales = np.array([channel.scale for channel in channels])
        self._times = np.zeros(_CAPACITY, np.int64)
        self._values = np.zeros((_CAPACITY, len(self._names)))
        self._attitudes_xyzw = np.zeros((_CAPACITY, 4))
        self._thrusts = np.zeros(_CAPACITY)
        self._filled = 0
        self._last_time: int | None = None
        self._last_thrust = -1.0
        self._states = [_StateLane(panel) for panel in panels if panel.state]
        for panel in self._panels:
            _style(stream, panel)

    def add(
        self,
        stream: Stream,
        time: int,
        values: Mapping[str, float | str | bool],
        attitude_wxyz: Quaternion,
        thrust_share: float,
    ) -> None:
        """Take a sample; one not later than the one before is left out. A channel without value is a gap."""
        if self._last_time is not None and time <= self._last_time:
            return
        if self._filled == _CAPACITY:
            self.send(stream)
        row = self._filled
        self._times[row] = time
        self._values[row] = [values.get(name, np.nan) for name in self._names]
        w, x, y, z = attitude_wxyz
        self._attitudes_xyzw[row] = (x, y, z, w)
        self._thrusts[row] = thrust_share
        for state in self._states:
            state.add(time, values)
        self._filled, self._last_time = row + 1, time

    def send(self, stream: Stream) -> None:
        """Send what is buffered."""
        count, self._filled = self._filled, 0
        if not count:
            return
        times = self._times[:count]
        first = 0
        for panel in self._panels:
            last = first + len(panel.channels)
            block = self._values[:count, first:last] * self._scales[first:last]
            columns = rr.Scalars.columns(scalars=block.ravel()).partition([last - first] * count)
            stream.columns(panel.path, times, columns)
            first = last
        stream.columns(CRAFT, times, rr.Transform3D.columns(quaternion=self._attitudes_xyzw[:count]))
        self._send_thrust(stream, count)
        for state in self._states:
            state.lane.write(stream, int(times[-1]))

    def end(self, stream: Stream, time: int) -> None:
        """Send what is left and end the lanes of states."""
        for state in self._states:
            state.lane.end(stream, time)
        self.send(stream)

    def _send_thrust(self, stream: Stream, count: int) -> None:
        if self._scene.thrust_axis is None:
            return
        thrusts: np.ndarray[Any, np.dtype[np.float64]] = np.clip(self._thrusts[:count], 0.0, 1.0).round(2)
        before = np.concatenate([[self._last_thrust], thrusts[:-1]])
        changed = np.flatnonzero(thrusts != before)
        self._last_thrust = float(thrusts[-1])
        if changed.size:
            arrows = plume_vectors(self._scene, thrusts[changed])
            flat = np.array([arrow for row in arrows for arrow in row]).reshape(-1, 3)
            columns = rr.Arrows3D.columns(vectors=flat).partition([len(row) for row in arrows])
            stream.columns(THRUST, self._times[:count][changed], columns)


class _StateLane:
    """One line for each state channel of a panel."""

    def __init__(self, panel: Panel) -> None:
        self.lane = Lane(panel.path, len(panel.channels))
        self._channels = panel.channels
        self._palette = Palette()
        self._last: dict[str, object] = {}

    def add(self, time: int, values: Mapping[str, float | str | bool]) -> None:
        for line, channel in enumerate(self._channels):
            value = values.get(channel.name)
            if self._last.get(channel.name, _StateLane) == value:
                continue
            self._last[channel.name] = value
            self.lane.put(time, line, None if value is None else self._block(channel, value))

    def _block(self, channel: Channel, value: float | str | bool) -> Block:
        if isinstance(value, bool):
            colour, word = (GREEN, "on") if value else (GREY, "off")
        else:
            word = str(value)
            colour = AMBER if word.lower() in ("unknown", "degraded") else self._palette.colour(word, {})
        text = f"{channel.label or channel.name}: {word}"
        return Block(text, text, colour)


def _style(stream: Stream, panel: Panel) -> None:
    count = len(panel.channels)
    style = rr.SeriesLines(
        names=[channel.label or channel.name for channel in panel.channels],
        colors=np.array([LINES[i % len(LINES)] for i in range(count)], np.uint32),
        widths=[1.5] * count,
    )
    stream.static(panel.path, style)
