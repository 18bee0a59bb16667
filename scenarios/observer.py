"""What the recording sees of a run: telemetry samples, journal entries, plans and camera pictures. It only listens."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from executive.port import TelemetryValue
from planner.plan import FlexiblePlan
from scenarios.bridge import scene_of
from scenarios.config import Scenario
from scenarios.recording import Channel, Mark, RunRecorder
from sim import RenderingUnavailable, Spacecraft
from sim.navigation import Frame
from sim.optics import as_grey

SAMPLE_PERIOD_S = 10
CHASE_PERIOD_S = 1800
MOST_CHASE_PICTURES = 48
IMAGE_SIZE = 384

LANES = (
    "attitude.mode",
    "engine.mode",
    "camera.mode",
    "camera.switch",
    "navigation.activity",
    "radio.mode",
)

CHANNELS = (
    Channel("acs.error_rad", "Attitude", "pointing error (degrees)", label="error", scale=math.degrees(1.0)),
    *(Channel(f"wheels.speed_{n}_rad_s", "Attitude", "wheel speeds (rad/s)", label=f"wheel {n}") for n in (1, 2, 3, 4)),
    Channel("wheels.momentum_Nms", "Attitude", "wheel momentum (N m s)", label="momentum"),
    Channel("power.array_W", "Power", "power (W)", label="array"),
    Channel("power.load_W", "Power", "power (W)", label="load"),
    Channel("power.margin_W", "Power", "power (W)", label="margin"),
    Channel("battery.soc", "Power", "battery charge (0 to 1)", label="charge"),
    Channel("ips.thrust_N", "Power", "thrust of the ion engine (mN)", label="thrust", scale=1000.0),
    Channel("ips.xenon_kg", "Propellant", "xenon left (kg)", label="xenon"),
    Channel("rcs.hydrazine_kg", "Propellant", "hydrazine left (kg)", label="hydrazine"),
    Channel("ips.thrust_seconds", "Propellant", "time of thrust so far (h)", label="thrusting", scale=1 / 3600),
)


class Observer:
    """Feeds a RunRecorder. `images`: how many pictures it recorded. `warn`: told once why there are no views."""

    def __init__(
        self, scenario: Scenario, spacecraft: Spacecraft, path: Path, render: bool, warn: Callable[[str], None]
    ) -> None:
        self._spacecraft = spacecraft
        self._render = render
        self._warn = warn
        self._frame: Frame | None = None
        self._drawing = True
        self._chase_period_s = CHASE_PERIOD_S * max(1, ceil(scenario.horizon / CHASE_PERIOD_S / MOST_CHASE_PICTURES))
        self.images = 0
        self._recorder = RunRecorder(
            path,
            scene_of(spacecraft.config),
            scenario.epoch.timestamp(),
            (0, scenario.horizon),
            LANES,
            CHANNELS,
            power_lanes=("engine.mode", "camera.switch"),
            camera_lanes=("camera.mode",),
            about=scenario.summary,
        )

    def look(self, time: int, telemetry: Mapping[str, TelemetryValue]) -> None:
        """Once a second: sample telemetry when due, and picture what the cameras see."""
        if time % SAMPLE_PERIOD_S == 0:
            state = self._spacecraft.state_for_recording()
            thrusting = telemetry["ips.state"] == "thrusting"
            self._recorder.telemetry(time, telemetry, state.attitude_IB, 1.0 if thrusting else 0.0)
        frame = self._spacecraft.last_frame
        if frame is not None and frame is not self._frame:
            self._frame = frame
            self._science(time, frame, int(telemetry["micas.images"]))
        if time % self._chase_period_s == 0:
            self._chase(time, f"{telemetry['acs.target']}, engine {telemetry['ips.state']}")

    def event(self, entry: Mapping[str, Any]) -> None:
        """A journal entry."""
        self._recorder.event(entry)

    def plan(self, plan_id: str, plan: FlexiblePlan, handover: int) -> None:
        """A plan that takes over."""
        self._recorder.plan(plan_id, plan, handover)

    def close(self) -> None:
        """End the recording and give the renderer back."""
        try:
            self._recorder.close()
        finally:
            self._spacecraft.close()

    def _science(self, time: int, frame: Frame, images: int) -> None:
        """A frame of the science camera as it came, dark sky to black, with what was found in it."""
        if not self._render:
            return
        against = {"stars": f"placed by {len(frame.stars)} stars", "attitude": "placed by the attitude"}
        caption = f"{frame.target} {against.get(frame.status, frame.status)}, good: {images}"
        self._recorder.image(time, shown(frame), "micas", caption, found_in(frame))
        self.images += 1

    def _chase(self, time: int, caption: str) -> None:
        """The spacecraft from outside, while there is OpenGL to draw it."""
        if not self._render or not self._drawing:
            return
        try:
            pixels = self._spacecraft.render("chase", IMAGE_SIZE, IMAGE_SIZE)
        except RenderingUnavailable as error:
            self._drawing = False
            self._warn(f"the run goes on without views from outside: {error}")
            return
        self._recorder.image(time, pixels, "chase", caption)
        self.images += 1


def shown(frame: Frame) -> NDArray[np.uint8]:
    """A frame as a picture (n, n, 3), dark sky to black."""
    return np.repeat(as_grey(frame.pixels)[:, :, None], 3, axis=2)


def found_in(frame: Frame) -> list[Mark]:
    """The stars that were recognised, and the target."""
    marks = [Mark("star", column, row) for column, row in frame.stars.tolist()]
    return marks if frame.place is None else [*marks, Mark("target", *frame.place, frame.target)]


class Unobserved:
    """Stands where an observer does in a run of which nothing is kept."""

    images = 0

    def __init__(self, spacecraft: Spacecraft) -> None:
        self._spacecraft = spacecraft

    def look(self, time: int, telemetry: Mapping[str, TelemetryValue]) -> None:
        """Nothing."""

    def event(self, entry: Mapping[str, Any]) -> None:
        """Nothing."""

    def plan(self, plan_id: str, plan: FlexiblePlan, handover: int) -> None:
        """Nothing."""

    def close(self) -> None:
        """Give the renderer back."""
        self._spacecraft.close()
