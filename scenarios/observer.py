"""What the recording sees of a run: telemetry samples, journal entries, plans and camera pictures. It only listens."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from executive.port import TelemetryValue
from planner.plan import FlexiblePlan
from scenarios.bridge import scene_of
from scenarios.config import Scenario
from scenarios.recording import Channel, RunRecorder
from sim import RenderingUnavailable, Spacecraft

SAMPLE_PERIOD_S = 10
CHASE_PERIOD_S = 1800
IMAGE_SIZE = 256

LANES = (
    "attitude.mode",
    "engine.mode",
    "camera.mode",
    "camera.switch",
    "navigation.activity",
    "radio.mode",
)

CHANNELS = (
    Channel("acs.error_rad", "Attitude", "pointing error (rad)", label="error"),
    *(Channel(f"wheels.speed_{n}_rad_s", "Attitude", "wheel speeds (rad/s)", label=f"wheel {n}") for n in (1, 2, 3, 4)),
    Channel("wheels.momentum_Nms", "Attitude", "wheel momentum (N m s)", label="momentum"),
    Channel("power.array_W", "Power", "power (W)", label="array"),
    Channel("power.load_W", "Power", "power (W)", label="load"),
    Channel("power.margin_W", "Power", "power (W)", label="margin"),
    Channel("battery.soc", "Power", "battery charge (0 to 1)", label="charge"),
    Channel("ips.thrust_N", "Power", "thrust (N)", label="thrust"),
)


class Observer:
    """Feeds a RunRecorder. `images`: how many camera pictures it recorded. `warn`: told once why there are none."""

    def __init__(
        self, scenario: Scenario, spacecraft: Spacecraft, path: Path, render: bool, warn: Callable[[str], None]
    ) -> None:
        self._spacecraft = spacecraft
        self._render = render
        self._warn = warn
        self._images_taken = 0
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
        )

    def look(self, time: int, telemetry: Mapping[str, TelemetryValue]) -> None:
        """Once a second: sample telemetry when due, and picture what the cameras see."""
        if time % SAMPLE_PERIOD_S == 0:
            state = self._spacecraft.state_for_recording()
            thrusting = telemetry["ips.state"] == "thrusting"
            self._recorder.telemetry(time, telemetry, state.attitude_IB, 1.0 if thrusting else 0.0)
        if telemetry["micas.images"] != self._images_taken:
            self._images_taken = int(telemetry["micas.images"])
            self._picture(time, "micas", f"image {self._images_taken} of {telemetry['acs.target']}")
        if time % CHASE_PERIOD_S == 0:
            self._picture(time, "chase", f"{telemetry['acs.target']}, engine {telemetry['ips.state']}")

    def event(self, entry: Mapping[str, Any]) -> None:
        """A journal entry."""
        self._recorder.event(entry)

    def plan(self, plan_id: str, plan: FlexiblePlan, handover: int) -> None:
        """A plan that takes over."""
        self._recorder.plan(plan_id, plan, handover)

    def close(self) -> None:
        """End the recording and give the renderer back."""
        self._recorder.close()
        self._spacecraft.close()

    def _picture(self, time: int, camera: str, caption: str) -> None:
        if not self._render:
            return
        try:
            pixels = self._spacecraft.render(camera, IMAGE_SIZE, IMAGE_SIZE)
        except RenderingUnavailable as error:
            self._render = False
            self._warn(f"the run goes on without pictures: {error}")
            return
        self._recorder.image(time, pixels, "micas" if camera == "micas" else "chase", caption)
        self.images += 1


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
