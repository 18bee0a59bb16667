"""RunRecorder: a run told to a Rerun recording while it happens."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Literal

import numpy as np
import rerun as rr

from planner.plan import FlexiblePlan
from scenarios.recording import marks as boxes
from scenarios.recording import story
from scenarios.recording.blueprint import CAMERA_LOG, CHASE, CHASE_CAPTION, LOG, SITUATION, Layout, camera_path
from scenarios.recording.boards import GoalsBoard, HeaderLane
from scenarios.recording.lanes import Lane, TimelineLane, lane_paths
from scenarios.recording.network import BoundsView, NetworkView, hosts_by_timeline
from scenarios.recording.scene import IMAGE_PX, Quaternion, Scene, draw_static
from scenarios.recording.stream import Stream
from scenarios.recording.style import LEVELS, Palette, elapsed, token_label
from scenarios.recording.telemetry import Channel, Telemetry, panels_of
from scenarios.words import Reasons

Pixels = np.ndarray[Any, np.dtype[np.uint8]]
FLUSH_PERIOD = 3600  # simulation seconds: a kill loses no more than the last of these
JPEG_QUALITY = 90
_MILESTONES = frozenset(
    (
        *("run.started", "run.finished", "plan.adopted", "plan.failed", "goal", "token.failed"),
        "standby.entered",
        *("fault.injected", "fault.detected", "fault.response", "fault.recovered", "fault.cleared"),
    )
)
_MILESTONES_SHOWN = 12
_PLANNERS_OWN = "Planner."  # what it is to do itself is no goal of the mission
_OUTCOMES: dict[str, Literal["finished", "failed", "aborted"]] = {
    "token.finished": "finished",
    "token.failed": "failed",
    "token.aborted": "aborted",
}


class RunRecorder:
    """Writes one .rrd file with its layout embedded. It only listens: nothing in a run depends on it.

    `epoch`: Unix seconds of simulation second 0. `horizon`: the mission in simulation seconds; all views open on it.
    `lanes`: timelines as `object.attribute`, top to bottom; tokens of others are not drawn. `power_lanes` and
    `camera_lanes`: those of them that the tabs Power and Camera repeat. `about`: what the run is to show, the first
    line of the log. Times never go back from one call to the next.
    """

    def __init__(
        self,
        path: Path,
        scene: Scene,
        epoch: float,
        horizon: tuple[int, int],
        lanes: Sequence[str],
        telemetry: Sequence[Channel],
        power_lanes: Sequence[str] = (),
        camera_lanes: Sequence[str] = (),
        about: str = "",
    ) -> None:
        names = tuple(lanes)
        paths = dict(zip(names, lane_paths("/mission", names), strict=True))
        for name in (*power_lanes, *camera_lanes):
            if name not in paths:
                raise ValueError(f"recording lanes: expected one of {', '.join(names)}, found {name!r}")
        panels = panels_of(telemetry)
        layout = Layout(*horizon).build(
            scene, list(paths.values()), panels, [paths[n] for n in power_lanes], [paths[n] for n in camera_lanes]
        )
        self._stream = Stream(path, epoch, layout)
        self._scene, self._horizon, self._now = scene, horizon, horizon[0]
        self._palette = Palette()
        self._lanes = {name: TimelineLane(path, self._palette) for name, path in paths.items()}
        self._header, self._goals = HeaderLane(), GoalsBoard()
        self._network, self._bounds = NetworkView(names, self._palette), BoundsView()
        self._telemetry = Telemetry(self._stream, scene, panels)
        self._running: dict[str, str] = {}
        self._goals_of: dict[str, list[str]] = {}
        self._milestones: list[str] = []
        self._coming: tuple[int, str, FlexiblePlan] | None = None
        self._in_force = ""
        self._untold: int | None = None
        self._reason = ""
        self._reasons = Reasons()
        self._next_flush = (horizon[0] // FLUSH_PERIOD + 1) * FLUSH_PERIOD
        self._handlers = self._handler_table()
        self._open = True
        draw_static(self._stream, scene)
        boxes.draw_frame(self._stream, camera_path(scene), IMAGE_PX)
        if about:
            self._log(horizon[0], "INFO", f"{elapsed(horizon[0])}  {about}")
        self._stream.flush()

    def telemetry(
        self,
        time: int,
        values: Mapping[str, float | str | bool],
        pose: Quaternion,
        thrust_share: float = 0.0,
    ) -> None:
        """A sample of all channels.

        `pose`: attitude of the body frame B in the inertial frame N, a quaternion wxyz. `thrust_share`: 0 to 1.
        """
        self._advance(time)
        self._telemetry.add(self._stream, time, values, pose, thrust_share)

    def event(self, entry: Mapping[str, Any]) -> None:
        """A journal entry, as it was written. Kinds that are not known are shown in the log alone."""
        time = int(entry["t"])
        self._advance(time)
        kind = str(entry.get("event", ""))
        self._reasons.tell(entry)
        told = story.line(self._reasons.retold(entry))
        if told is not None:
            level, text = told
            self._log(time, level, text)
            if kind in _MILESTONES:
                self._milestones.append(text)
        handler = self._handlers.get(kind)
        if handler is not None:
            handler(time, entry)
        if kind in _MILESTONES or kind.startswith("token."):
            self._retell(time)

    def plan(self, plan_id: str, plan: FlexiblePlan, handover: int) -> None:
        """A plan takes over at `handover` (simulation seconds) from whatever was in force."""
        timelines = hosts_by_timeline(plan)
        for name, lane in self._lanes.items():
            lane.plan(timelines.get(name, []), plan_id, handover)
        goals = [t for t in plan.tokens if t.goal is not None and not t.predicate.startswith(_PLANNERS_OWN)]
        wanted = sorted((t.start[0] or 0, str(t.goal)) for t in goals)
        self._goals.expect(self._now, dict.fromkeys(goal for _, goal in wanted))
        self._header.goals(self._now, self._goals)
        self._header.plan(plan_id, self._reason, handover)
        self._coming = (handover, plan_id, plan)
        self._take_over()
        self._flush()

    def image(
        self,
        time: int,
        pixels: Pixels,
        camera: Literal["micas", "chase"],
        caption: str,
        found: Sequence[boxes.Mark] = (),
    ) -> None:
        """An image, rows by columns by RGB, of the science camera, with what was found in it, or from outside."""
        if pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.dtype != np.uint8:
            raise ValueError(
                f"image of {camera!r} at {time}: expected (h, w, 3) of uint8, found {pixels.shape} of {pixels.dtype}"
            )
        self._advance(time)
        path = CHASE if camera == "chase" else camera_path(self._scene)
        self._stream.at(time, path, rr.Image(pixels).compress(jpeg_quality=JPEG_QUALITY))
        if camera == "micas":
            boxes.draw(self._stream, time, path, found)
        self._log(time, "DEBUG", f"{elapsed(time)}  {caption}", CAMERA_LOG if camera == "micas" else CHASE_CAPTION)

    def close(self) -> None:
        """Send all that is left and close the file. What a plan still had to come is not drawn. Safe to call twice."""
        if not self._open:
            return
        self._open = False
        end = self._now
        self._telemetry.end(self._stream, end)
        for lane in self._all_lanes():
            lane.end(self._stream, end)
        self._bounds.end(self._stream, end)
        self._network.write(self._stream, end + 1)
        self._tell_situation(end + 1)
        self._stream.close()

    def __enter__(self) -> RunRecorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _log(self, time: int, level: str, text: str, path: str = LOG) -> None:
        self._stream.at(time, path, rr.TextLog(text, level=level, color=LEVELS[level]))

    def _advance(self, time: int) -> None:
        if time > self._now:
            self._now = time
            self._network.write(self._stream, time)
            self._tell_situation(time)
            self._take_over()
            if time >= self._next_flush:
                self._flush()

    def _take_over(self) -> None:
        """Once its time has come, make the coming plan the one whose tokens and timepoints are meant from now on."""
        if self._coming is None or self._coming[0] > self._now:
            return
        (handover, self._in_force, plan), self._coming = self._coming, None
        slots = [slot for timeline in plan.timelines for slot in timeline.slots]
        goals = {slot[0]: [goal for goal in (plan.token(t).goal for t in slot) if goal is not None] for slot in slots}
        self._goals_of = {host: found for host, found in goals.items() if found}
        self._bounds.plan(self._stream, self._in_force, plan, handover)
        self._network.write(self._stream, handover)
        self._network.plan(handover, plan)
        self._header.handed_over(handover, self._in_force)
        self._retell(handover)

    def _flush(self) -> None:
        """Send all rows of times that are over, and bring the file up to date."""
        self._next_flush = (self._now // FLUSH_PERIOD + 1) * FLUSH_PERIOD
        self._telemetry.send(self._stream)
        for lane in self._all_lanes():
            lane.write(self._stream, self._now)
        self._bounds.send(self._stream)
        self._stream.flush()

    def _all_lanes(self) -> list[Lane]:
        return [
            *(timeline.lane for timeline in self._lanes.values()),
            self._header.lane,
            self._header.each_fault,
            *self._goals.lanes,
        ]

    def _handler_table(self) -> dict[str, Callable[[int, Mapping[str, Any]], None]]:
        header, bounds = self._header, self._bounds
        return {
            "run.started": lambda t, e: self._stream.name(f"{e.get('scenario', 'run')}, seed {e.get('seed', '?')}"),
            "plan.requested": self._plan_requested,
            "plan.adopted": lambda t, e: header.adopted(t, str(e.get("plan")), int(e.get("handover", t))),
            "plan.failed": lambda t, e: header.failed(t, self._reasons.say(str(e.get("reason", "")))),
            "goal": self._goal_changed,
            "token.started": self._token_started,
            "token.finished": self._token_ended,
            "token.failed": self._token_ended,
            "token.aborted": self._token_ended,
            "timepoint.executed": lambda t, e: bounds.executed(t, str(e.get("timepoint"))),
            "bounds": lambda t, e: bounds.change(t, e.get("changes") or {}),
            "standby.entered": self._standby_entered,
            "standby.left": lambda t, e: header.standby_left(t),
            "fault.injected": lambda t, e: header.fault_injected(t, str(e.get("name"))),
            "fault.detected": self._fault_detected,
            "fault.response": lambda t, e: header.fault_answered(
                t, e.get("name") or e.get("monitor"), str(e.get("response", ""))
            ),
            "fault.recovered": lambda t, e: header.fault_recovered(t, e.get("monitor"), bool(e.get("cured", True))),
            "fault.cleared": lambda t, e: header.fault_cleared(t, str(e.get("name"))),
        }

    def _plan_requested(self, time: int, entry: Mapping[str, Any]) -> None:
        self._reason = self._reasons.say(str(entry.get("reason", "")))
        self._header.requested(time, self._reason)

    def _goal_changed(self, time: int, entry: Mapping[str, Any]) -> None:
        self._goals.change(time, str(entry.get("id")), str(entry.get("status")))
        self._header.goals(time, self._goals)

    def _fault_detected(self, time: int, entry: Mapping[str, Any]) -> None:
        name = str(entry.get("name") or entry.get("monitor") or "fault")
        self._header.fault_detected(time, name, str(entry.get("text") or entry.get("diagnosis") or ""))

    def _standby_entered(self, time: int, entry: Mapping[str, Any]) -> None:
        self._header.standby(time, self._reasons.waits(str(entry.get("reason", ""))))
        self._in_force, self._coming = "", None
        for lane in self._lanes.values():
            lane.stop_plan(time)

    def _token_started(self, time: int, entry: Mapping[str, Any]) -> None:
        plan, token, lane = self._names_of(entry)
        predicate, parameters = str(entry.get("predicate", "")), entry.get("parameters") or {}
        if plan == self._in_force:
            self._network.mark(time, token, "running")
            for goal in self._goals_of.get(token, ()):
                self._goals.activate(time, goal)
        if lane in self._lanes:
            self._running[lane] = token_label(predicate, parameters)
            self._lanes[lane].start(time, plan, token, predicate, parameters)

    def _token_ended(self, time: int, entry: Mapping[str, Any]) -> None:
        plan, token, lane = self._names_of(entry)
        outcome = _OUTCOMES[str(entry["event"])]
        if plan == self._in_force:
            self._network.mark(time, token, "done" if outcome == "finished" else "failed")
        timeline = self._lanes.get(lane)
        if timeline is None or not (timeline.is_idle or timeline.is_running(plan, token, self._in_force)):
            return
        self._running.pop(lane, None)
        timeline.end(time, token_label(str(entry.get("predicate", "")), entry.get("parameters") or {}), outcome)

    def _names_of(self, entry: Mapping[str, Any]) -> tuple[str, str, str]:
        plan = str(entry.get("plan") or self._in_force)
        return plan, str(entry.get("token")), f"{entry.get('object')}.{entry.get('attribute')}"

    def _retell(self, time: int) -> None:
        if self._untold is None:
            self._untold = time

    def _tell_situation(self, before: int) -> None:
        """Write the page of how things stand, once everything of its second has been told."""
        if self._untold is None or self._untold >= before:
            return
        page = story.situation(
            self._untold,
            plan=self._in_force,
            running=[(lane, self._running[lane]) for lane in self._lanes if lane in self._running],
            goals=self._goals.status,
            faults=self._header.faults(),
            milestones=self._milestones[-_MILESTONES_SHOWN:],
        )
        self._stream.at(self._untold, SITUATION, rr.TextDocument(page, media_type=rr.MediaType.MARKDOWN))
        self._untold = None
