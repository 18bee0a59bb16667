"""A made-up run of twelve hours, told to a recorder: two plans, a camera that sticks on half-way, images.

Run as a script with a path it records, and kills itself at the hour that is given: `python recorded_run.py out.rrd 7`.
"""

from __future__ import annotations

import math
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from planner.plan import FlexiblePlan, PlanConstraint, PlanTimeline, PlanToken
from scenarios.recording import Camera, Channel, Geom, RunRecorder, Scene

HOUR = 3600
END = 12 * HOUR
EPOCH = 927_072_000.0  # 1999-05-19T00:00:00Z
FAULT, DETECTED, REQUESTED, ADOPTED, HANDOVER = 6 * HOUR, 21_780, 21_840, 22_140, 22_500
NAMES = ("sc.attitude", "engine.thrust", "micas.mode", "micas.imaging", "nav.navigation", "radio.link", "power.load")
UNIT = (1.0, 0.0, 0.0, 0.0)

SCENE = Scene(
    geoms=(
        Geom("bus", "box", (0.6, 0.55, 0.75), (0, 0, 0), UNIT, (0.83, 0.62, 0.2, 1)),
        Geom("array_plus", "box", (0.8, 2.6, 0.02), (0, 3.4, 0), UNIT, (0.13, 0.16, 0.5, 1)),
        Geom("array_minus", "box", (0.8, 2.6, 0.02), (0, -3.4, 0), UNIT, (0.13, 0.16, 0.5, 1)),
        Geom("engine", "cylinder", (0.2, 0.15), (0, 0, -0.85), UNIT, (0.6, 0.62, 0.66, 1)),
        Geom(
            "antenna",
            "cylinder",
            (0.25, 0.03),
            (0.63, 0, 0.3),
            (math.sqrt(0.5), 0, math.sqrt(0.5), 0),
            (0.9, 0.9, 0.9, 1),
        ),
        Geom("tracker", "sphere", (0.12,), (0, 0.4, 0.85), UNIT, (0.3, 0.3, 0.34, 1)),
    ),
    directions={"Sun": (0.9, 0.4, 0.1), "Earth": (0.5, 0.86, 0.05), "Braille": (-0.3, -0.9, 0.3)},
    thrust_axis=(0, 0, 1),
    camera=Camera((0, 0, 0.8), (0, 0, 1)),
)
CHANNELS = (
    Channel("pointing_error_deg", "Attitude", "Pointing error, deg", label="error"),
    *(Channel(f"wheel_{i}_rad_s", "Attitude", "Wheel speeds, rad/s", label=f"wheel {i}") for i in range(4)),
    Channel("control_mode", "Attitude", "Control", state=True, label="control"),
    Channel("thrusters_on", "Attitude", "Control", state=True, label="thrusters"),
    Channel("array_W", "Power", "Power, W", label="array"),
    Channel("load_W", "Power", "Power, W", label="load"),
    Channel("margin_W", "Power", "Power, W", label="margin"),
    Channel("battery_share", "Power", "Battery, charged share", label="charge"),
)


class _Draft:
    """Collects tokens of a plan by their nominal starts; the slack of a start grows with its distance."""

    def __init__(self, first: int) -> None:
        self.first = first
        self.tokens: list[PlanToken] = []
        self.slots: dict[str, list[tuple[str, ...]]] = {name: [] for name in NAMES}
        self.constraints: list[PlanConstraint] = []
        self.nominal: dict[str, tuple[int, int]] = {}

    def slack(self, time: int, name: str) -> int:
        if time <= self.first or time >= END:
            return 0
        return 120 + (time - self.first) // 45 + 60 * NAMES.index(name)

    def line(self, name: str, *steps: tuple[int, str, dict[str, Any], str | None]) -> None:
        times = [max(self.first, step[0]) for step in steps] + [END]
        for (_, predicate, parameters, goal), start, end in zip(steps, times, times[1:], strict=False):
            if end <= self.first:
                continue
            identifier = f"t{len(self.tokens)}"
            bounds = [(t, t + self.slack(t, name)) for t in (start, end)]
            where = name.split(".")
            spread = (max(0, bounds[1][0] - bounds[0][1]), bounds[1][1] - bounds[0][0])
            token = PlanToken(identifier, *where, predicate, parameters, bounds[0], bounds[1], spread, goal=goal)
            self.tokens.append(token)
            if self.slots[name]:
                before = self.slots[name][-1][0]
                self.constraints.append(PlanConstraint(f"{before}.end", f"{identifier}.start", 0, 0, "meets"))
            self.slots[name].append((identifier,))
            self.nominal[identifier] = (start, end)

    def within(self, inner: str, outer: str) -> None:
        """Every token of the first predicate is contained by the token of the second that spans it."""
        for a in (t for t in self.tokens if t.predicate == inner):
            for b in (t for t in self.tokens if t.predicate == outer):
                if self.nominal[b.id][0] <= self.nominal[a.id][0] and self.nominal[a.id][1] <= self.nominal[b.id][1]:
                    self.constraints.append(PlanConstraint(f"{b.id}.start", f"{a.id}.start", 0, None, "contained_by"))
                    self.constraints.append(PlanConstraint(f"{a.id}.end", f"{b.id}.end", 0, None, "contained_by"))

    def plan(self) -> FlexiblePlan:
        lines = tuple(PlanTimeline(*name.split("."), tuple(slots)) for name, slots in self.slots.items())
        objects = tuple(dict.fromkeys(name.split(".")[0] for name in NAMES))
        return FlexiblePlan("made-up", (self.first, END), objects, lines, tuple(self.tokens), tuple(self.constraints))


def make_plan(first: int, with_camera: bool) -> tuple[FlexiblePlan, dict[str, tuple[int, int]]]:
    """The plan from `first` on and its tokens' nominal times; without the camera the second pass has no images."""
    draft = _Draft(first)
    attitude: list[Any] = [(0, "PointAt", {"target": "thrust_vector"}, None)]
    engine: list[Any] = [(0, "Thrusting", {"level": 6}, "thrust-1")]
    mode: list[Any] = [(0, "Off", {}, None)]
    imaging: list[Any] = [(0, "Idle", {}, None)]
    nav: list[Any] = [(0, "Idle", {}, None)]
    radio: list[Any] = [(0, "Off", {}, None)]
    power: list[Any] = [(0, "Peak", {"watts": 2300}, None)]
    for number, base in ((1, int(2.0 * HOUR)), (2, int(7.0 * HOUR))):
        images = number == 1 or with_camera
        attitude += [(base, "Turning", {"to": "beacon"}, None), (base + 900, "PointAt", {"target": "beacon"}, None)]
        attitude += [
            (base + 6000, "Turning", {"to": "earth"}, None),
            (base + 6900, "PointAt", {"target": "Earth"}, None),
        ]
        attitude += [(base + 12000, "Turning", {"to": "thrust"}, None)]
        attitude += [(base + 12900, "PointAt", {"target": "thrust_vector"}, None)]
        engine += [(base - 600, "Stopping", {}, None), (base - 300, "Standby", {}, None)]
        engine += [
            (base + 12900, "Starting", {}, None),
            (base + 13800, "Thrusting", {"level": 6 + number}, f"thrust-{number + 1}"),
        ]
        if images:
            mode += [
                (base - 900, "WarmingUp", {}, None),
                (base + 600, "Ready", {}, None),
                (base + 6000, "Off", {}, None),
            ]
            for k in range(4):
                start = base + 1200 + 1100 * k
                imaging += [
                    (start, "TakeImage", {"beacon": f"b{number}{k}"}, f"image-{number}{k}"),
                    (start + 420, "Idle", {}, None),
                ]
            nav += [
                (base + 6000, "OpticalNavigation", {}, None),
                (base + 7800, "OrbitDetermination", {}, f"orbit-{number}"),
            ]
            nav += [(base + 9300, "Idle", {}, None)]
        radio += [(base + 6900, "CarrierOn", {}, None), (base + 7500, "Downlink", {"rate": 2100}, f"downlink-{number}")]
        radio += [(base + 11400, "Off", {}, None)]
        power += [(base - 300, "Nominal", {"watts": 900}, None), (base + 6900, "Low", {"watts": 700}, None)]
        power += [(base + 12900, "Peak", {"watts": 2300}, None)]
    for name, steps in zip(NAMES, (attitude, engine, mode, imaging, nav, radio, power), strict=True):
        draft.line(name, *steps)
    draft.within("TakeImage", "PointAt")
    draft.within("TakeImage", "Ready")
    draft.within("Downlink", "PointAt")
    draft.within("Downlink", "Low")
    return draft.plan(), draft.nominal


def execute(
    plan: FlexiblePlan, plan_id: str, first: int, last: int, rng: np.random.Generator
) -> Iterator[dict[str, Any]]:
    """Journal entries of executing the plan between two times, each start somewhere in its bounds."""
    command = 0
    for timeline in plan.timelines:
        hosts = [plan.token(slot[0]) for slot in timeline.slots]
        times = [t.start[0] + int(0.6 * rng.random() * (t.start[1] - t.start[0])) for t in hosts] + [END]
        for i, token in enumerate(hosts):
            start, end = times[i], times[i + 1]
            common = {
                "plan": plan_id,
                "token": token.id,
                "object": token.object,
                "attribute": token.attribute,
                "predicate": token.predicate,
                "parameters": dict(token.parameters),
            }
            if first <= start < last:
                command += 1
                point, name = f"{token.id}.start", f"{token.object}.{token.predicate}".lower()
                yield {"t": start, "event": "token.started", **common}
                yield {"t": start, "event": "timepoint.executed", "timepoint": point, "bounds": list(token.start)}
                yield {
                    "t": start,
                    "event": "command.sent",
                    "id": command,
                    "name": name,
                    "arguments": {},
                    "token": token.id,
                }
                yield {"t": start + 2, "event": "command.acknowledged", "id": command, "accepted": True, "reason": ""}
                for k in range(1, 9):
                    when = first + (start - first) * k // 9
                    low = token.start[0] + (start - token.start[0]) * k // 9
                    high = token.start[1] - (token.start[1] - start) * k // 9
                    yield {"t": when, "event": "bounds", "changes": {point: [low, high]}}
            if first < end < last:
                yield {"t": end, "event": "token.finished", **common, "verdict": "on_time"}
                if token.goal:
                    yield {"t": end, "event": "goal", "id": token.goal, "status": "achieved", "reason": ""}
            if start < last <= end and plan_id == "plan-01" and token.object == "micas":
                yield {"t": DETECTED, "event": "token.failed", **common, "reason": "switch does not answer"}


def journal() -> tuple[list[tuple[int, str, Any]], FlexiblePlan, FlexiblePlan]:
    """Everything that the recorder is told, in order of time: (time, call, content)."""
    rng = np.random.default_rng(4)
    first, _ = make_plan(0, True)
    second, _ = make_plan(HANDOVER, False)
    entries: list[dict[str, Any]] = [
        {"t": 0, "event": "run.started", "scenario": "made-up", "seed": 4, "horizon": [0, END]},
        {"t": 0, "event": "plan.requested", "reason": "start of the mission", "attempt": 1, "budget": 600},
        {"t": 0, "event": "plan.adopted", "plan": "plan-01", "handover": 0, "reason": "", "tokens": len(first.tokens)},
        *execute(first, "plan-01", 0, HANDOVER, rng),
        {"t": FAULT, "event": "fault.injected", "name": "micas-stuck-on"},
        {"t": DETECTED - 60, "event": "violation", "kind": "unexpected mode", "detail": "micas on, expected off"},
        {
            "t": DETECTED,
            "event": "fault.detected",
            "monitor": "micas.mode",
            "diagnosis": "camera switch stuck on",
        },
        {"t": DETECTED + 30, "event": "fault.response", "response": "power-cycle the switch twice"},
        {"t": REQUESTED, "event": "plan.requested", "reason": "camera stuck on", "attempt": 1, "budget": 600},
        {
            "t": ADOPTED,
            "event": "plan.adopted",
            "plan": "plan-02",
            "handover": HANDOVER,
            "reason": "",
            "tokens": len(second.tokens),
        },
        *(
            {"t": ADOPTED, "event": "goal", "id": f"image-2{k}", "status": "dropped", "reason": "camera stuck on"}
            for k in range(4)
        ),
        {"t": ADOPTED, "event": "goal", "id": "orbit-2", "status": "dropped", "reason": "needs images"},
        *execute(second, "plan-02", HANDOVER, END, rng),
        {"t": END, "event": "goal", "id": "thrust-3", "status": "achieved", "reason": ""},
        {"t": END, "event": "run.finished", "outcome": "degraded"},
    ]
    calls: list[tuple[int, str, Any]] = [(entry["t"], "event", entry) for entry in entries]
    calls += [(0, "plan", ("plan-01", first, 0)), (ADOPTED, "plan", ("plan-02", second, HANDOVER))]
    calls += [(t, "telemetry", sample(t)) for t in range(0, END + 1, 10)]
    for number, start in enumerate(
        e["t"] for e in entries if e["event"] == "token.started" and "beacon" in e["parameters"]
    ):
        calls.append((start + 300, "image", (star_field(number), "micas", f"beacon image {number}, 5 stars found")))
    calls += [(t, "image", (outside(t), "chase", "")) for t in range(0, END, HOUR)]
    order = {"event": 0, "plan": 1, "image": 2, "telemetry": 3}
    rank = {"run.started": 0, "plan.requested": 1, "plan.adopted": 3, "token.finished": 4, "run.finished": 9}
    calls.sort(
        key=lambda c: (
            c[0],
            rank.get(c[2]["event"], 5) if c[1] == "event" else 3.5 if c[1] == "plan" else 8,
            order[c[1]],
        )
    )
    return calls, first, second


def sample(time: int) -> tuple[dict[str, float | str | bool], tuple[float, float, float, float], float]:
    """Telemetry values, attitude (wxyz) and thrust share at a time."""
    phase = (time / HOUR - 2.0) % 5.0
    slewing = any(s <= phase * HOUR < s + 900 for s in (0, 6000, 12000)) and time > 2 * HOUR
    thrust = 0.0 if time > 2 * HOUR - 600 and phase * HOUR < 13800 else 0.8
    angle = 0.4 * math.sin(2 * math.pi * time / END) + (0.6 if thrust == 0.0 else 0.0)
    array = 2450.0 - 0.004 * time
    load = 2300.0 if thrust else 900.0 + (240.0 if time > FAULT else 0.0)
    values: dict[str, float | str | bool] = {
        "pointing_error_deg": 25.0 * math.sin(math.pi * (phase * HOUR % 6000) / 900) if slewing else 0.05,
        **{f"wheel_{i}_rad_s": 80 * math.sin(time / 9000 + i) + i for i in range(4)},
        "control_mode": "rcs" if slewing else "wheels",
        "thrusters_on": slewing,
        "array_W": array,
        "load_W": load,
        "margin_W": array - load,
        "battery_share": 0.9 - 0.1 * math.sin(time / 7000),
    }
    return values, (math.cos(angle / 2), 0.0, math.sin(angle / 2), 0.0), thrust


def star_field(seed: int) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """A noisy picture of stars, 256 x 256."""
    rng = np.random.default_rng(seed)
    grey = rng.normal(18, 4, (256, 256))
    rows, columns = np.mgrid[0:256, 0:256]
    for _ in range(12):
        row, column, bright = rng.uniform(0, 256), rng.uniform(0, 256), rng.uniform(60, 235)
        grey += bright * np.exp(-((rows - row) ** 2 + (columns - column) ** 2) / 4.0)
    return np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[:, :, None], 3, axis=2)


def outside(time: int) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """A picture of a box against black, turned a little as time passes, 256 x 256."""
    rows, columns = np.mgrid[-128:128, -128:128]
    angle = time / 20_000
    u, v = rows * math.cos(angle) + columns * math.sin(angle), columns * math.cos(angle) - rows * math.sin(angle)
    picture = np.zeros((256, 256, 3), np.uint8)
    picture[(abs(u) < 30) & (abs(v) < 30)] = (200, 150, 60)
    picture[(abs(u) < 20) & (abs(v) >= 34) & (abs(v) < 110)] = (40, 50, 140)
    return picture


def recorder(path: Path) -> RunRecorder:
    """A recorder of the run's timelines and channels."""
    lanes = {"power_lanes": ("engine.thrust", "power.load"), "camera_lanes": ("micas.mode", "micas.imaging")}
    return RunRecorder(path, SCENE, EPOCH, (0, END), NAMES, CHANNELS, lanes["power_lanes"], lanes["camera_lanes"])


def tell(to: RunRecorder, calls: list[tuple[int, str, Any]], until: int = END) -> None:
    """Make the calls up to a time."""
    for time, kind, content in calls:
        if time > until:
            return
        if kind == "event":
            to.event(content)
        elif kind == "plan":
            to.plan(*content)
        elif kind == "telemetry":
            to.telemetry(time, *content)
        else:
            to.image(time, *content)


if __name__ == "__main__":
    killed = recorder(Path(sys.argv[1]))
    tell(killed, journal()[0], int(sys.argv[2]) * HOUR)
    os.kill(os.getpid(), signal.SIGKILL)
