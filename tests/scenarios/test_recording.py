"""The recording of a whole run, read back: what it says, what survives a kill, and what is refused."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rerun.chunk import RrdReader

from scenarios.pictures import read_moments
from scenarios.recording import Camera, Channel, Geom, Mark, RunRecorder, Scene
from scenarios.recording.lanes import EARLIEST, EXECUTED, LATEST
from scenarios.recording.network import NOW_COLUMN, STEP_X, chosen_tokens
from scenarios.recording.story import SILENT, line
from scenarios.recording.style import elapsed, entity, token_label
from tests.scenarios import recorded_run as run
from tests.scenarios.recorded import HEADER, Recorded, event, labels, plan_of, small, token


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recording") / "run.rrd"
    with run.recorder(path) as recorder:
        run.tell(recorder, run.journal()[0])
    return path


@pytest.fixture(scope="module")
def read(recording: Path) -> Recorded:
    return Recorded(recording)


def test_the_header_tells_plan_planner_fault_and_goals(read: Recorded) -> None:
    before = read.shown(HEADER, run.FAULT - 1)
    assert before == ["in_force:plan-01", "", "", "7 of 15 achieved"]
    assert read.shown(HEADER, run.FAULT)[2] == "fault:micas-stuck-on: not yet detected"
    assert read.shown(HEADER, run.DETECTED)[2] == "fault:micas-stuck-on: detected, camera switch stuck on"
    assert read.shown(HEADER, run.REQUESTED)[:2] == ["in_force:plan-01", "planner:planning: camera stuck on"]
    assert read.shown(HEADER, run.ADOPTED)[:2] == ["in_force:plan-01", "planner:plan-02 ready"]
    after = read.shown(HEADER, run.HANDOVER)
    assert after == ["in_force:plan-02", "", "fault:micas-stuck-on: handled by plan-02", "7 of 15 achieved, 5 dropped"]


def test_planned_bounds_enclose_every_executed_start(read: Recorded) -> None:
    """Execution falls between the lines: earliest is never later than executed, latest never earlier."""
    _, first, second = run.journal()
    for number, name in enumerate(run.NAMES, 1):
        rows = read.lane(f"/mission/{number}_{name}")
        starts: dict[tuple[int, str], int] = {}
        for t, states in rows:
            for which in (EARLIEST, EXECUTED, LATEST):
                starts.setdefault((which, states[which].removeprefix("plan:")), t)
        for (which, state), t in starts.items():
            if which == EXECUTED and state and not state.startswith("failed"):
                plan = first if "plan-01" in state else second
                lower, upper = plan.token(state.rpartition(".")[2]).start
                assert lower is not None
                assert upper is not None
                assert starts[EARLIEST, state] == lower <= t <= upper
                if (LATEST, state) in starts:
                    assert starts[LATEST, state] == upper


def test_goals_go_from_pending_to_their_end(read: Recorded) -> None:
    shown = [*read.shown("/goals/1", run.END - 1), *read.shown("/goals/2", run.END - 1)]
    assert {s.partition(":")[0] for s in shown} == {
        *(f"thrust-{i}" for i in (1, 2, 3)),
        *(f"image-{i}{k}" for i in (1, 2) for k in range(4)),
        *("orbit-1", "orbit-2", "downlink-1", "downlink-2"),
    }
    assert sum(s.endswith(":dropped") for s in shown) == 5
    assert sum(s.endswith(":achieved") for s in shown) == 9
    assert "thrust-3:active" in shown
    start = [*read.shown("/goals/1", 0), *read.shown("/goals/2", 0)]
    assert start.count("thrust-1:active") == 1
    assert sum(s.endswith(":pending") for s in start) == 14


# ---- the whole recording --------------------------------------------------------------------------------------------


def test_layout_is_in_the_file_and_the_file_is_small(recording: Path) -> None:
    assert RrdReader(recording).blueprints()
    assert recording.stat().st_size < 3_000_000


def test_times_of_every_entity_ascend_and_stay_in_the_run(read: Recorded) -> None:
    assert {"/world/spacecraft", "/network", "/situation", "/log", "/camera/chase"} < set(read.times)
    for name, times in read.times.items():
        by_call = name in ("/log", "/log/camera")  # several entries of one second are several rows
        assert times == sorted(times if by_call else set(times)), name
        assert times[0] >= 0, name
        assert times[-1] <= run.END, name


def test_telemetry_rows_and_attitude(read: Recorded) -> None:
    name = "/telemetry/Power/Power_W"
    rows = dict(read.values[name, "scalars"])
    assert list(rows) == list(range(0, run.END + 1, 10))
    values = run.sample(7200)[0]
    assert rows[7200] == pytest.approx([values["array_W"], values["load_W"], values["margin_W"]])
    w, x, y, z = run.sample(14_400)[1]
    assert dict(read.values["/world/spacecraft", "quaternion"])[14_400][0] == pytest.approx([x, y, z, w], abs=1e-6)
    assert read.shown("/states/Attitude/Control", 7300) == ["control: rcs", "thrusters: on"]


def test_the_plume_is_drawn_only_while_the_engine_thrusts(read: Recorded) -> None:
    rows = read.values["/world/spacecraft/thrust", "vectors"]
    changes = [(t, bool(vectors)) for t, vectors in rows]
    assert changes[0] == (0, True)
    assert [on for _, on in changes] == [bool(i % 2 == 0) for i in range(len(changes))]
    assert changes[1] == (2 * run.HOUR, False)
    assert rows[0][1][0] == pytest.approx([0, 0, -run.SCENE.extent() * (0.25 + 0.5 * 0.8)], rel=1e-5)


def test_images_and_their_captions(read: Recorded) -> None:
    images = read.values["/world/spacecraft/camera/image", "blob"]
    assert [t for t, _ in images] == read.times["/log/camera"]
    assert len(images) == 4
    assert bytes(images[0][1][0][:2]) == b"\xff\xd8"  # jpeg
    assert len(read.values["/camera/chase", "blob"]) == 12
    assert read.texts("/log/camera")[0].endswith("beacon image 0, 5 stars found")


def test_bounds_narrow_and_end_at_execution(read: Recorded) -> None:
    names = [name for name in read.times if name.startswith("/bounds/")]
    assert len([n for n in names if "plan-01" in n]) == 8
    for name in names:
        rows = [(t, low, high) for t, (low, high) in read.values[name, "scalars"]]
        known = [row for row in rows if not math.isnan(row[1])]
        assert all(a[1] <= b[1] <= b[2] <= a[2] for a, b in pairwise(known)), name
        assert math.isnan(rows[-1][1]), name
    executed = [(t, low, high) for t, (low, high) in read.values["/bounds/plan-01/3_Thrusting_level_7", "scalars"]]
    assert executed[-2][1] == executed[-2][2]
    assert executed[-1][0] == executed[-2][0] + 1


def test_the_network_shows_the_present_in_one_column(read: Recorded) -> None:
    """At the handover all tokens that start there are in the `now` column, with what comes next right of them."""
    ids = dict(read.values["/network", "node_ids"])
    places = dict(read.values["/network", "positions"])
    first = min(t for t in ids if t >= run.HANDOVER)
    now = {name: place for name, place in zip(ids[first], places[first], strict=True) if name.startswith("t")}
    _, _, second = run.journal()
    for timeline in second.timelines:
        columns = [now[slot[0]][0] for slot in timeline.slots if slot[0] in now]
        assert columns == [(NOW_COLUMN + i) * STEP_X for i in range(len(columns))]


def test_the_log_skips_observations_and_leads_with_elapsed_time(read: Recorded) -> None:
    texts = read.texts()
    assert texts[0].startswith("00:00:00  run started: made-up, seed 4")
    assert texts[-1] == "12:00:00  run ended: degraded"
    assert "06:03:00  fault detected: camera switch stuck on (monitor micas.mode)" in texts


def test_the_situation_page_follows_the_run(read: Recorded) -> None:
    pages = read.values["/situation", "text"]
    page = [row[0] for t, row in pages if t <= run.HANDOVER][-1]
    assert "**Plan in force:** plan-02" in page
    assert "micas-stuck-on: handled by plan-02" in page
    assert "**dropped** (5)" in page
    assert "sc.attitude: **PointAt thrust_vector**" in page


# ---- interrupted, empty and wrong -----------------------------------------------------------------------------------


def test_what_was_flushed_survives_a_kill(tmp_path: Path) -> None:
    path = tmp_path / "killed.rrd"
    command = [sys.executable, "-m", run.__name__, str(path), "7"]
    done = subprocess.run(command, check=False, cwd=Path(run.__file__).parents[2])
    assert done.returncode < 0
    read = Recorded(path)
    assert read.times["/world/spacecraft"][-1] >= 7 * run.HOUR - 3600
    assert read.shown(HEADER, 7 * run.HOUR)[0] == "in_force:plan-02"
    assert labels(read.shown("/mission/1_sc.attitude", run.FAULT))[EXECUTED] == "PointAt thrust_vector"
    assert read_moments(path)[0] == run.DETECTED


def test_a_run_without_events_is_a_readable_recording(tmp_path: Path) -> None:
    with small(tmp_path / "r.rrd") as recorder:
        recorder.close()
    recorder.close()
    assert RrdReader(tmp_path / "r.rrd").blueprints()
    assert read_moments(tmp_path / "r.rrd") == [0]


def test_entries_that_nobody_knows_are_told_and_harmless(tmp_path: Path) -> None:
    with small(tmp_path / "r.rrd") as recorder:
        recorder.event(event(5, "something.new", colour="blue"))
        recorder.event(event(5, "token.finished", token="ghost"))
        recorder.event(event(6, "fault.response", response="none needed"))
        recorder.event(event(7, "bounds", changes={"ghost.start": [1, None]}))
    assert "00:00:05  something.new: colour=blue" in Recorded(tmp_path / "r.rrd").texts()


def test_missing_channels_are_gaps_and_stale_samples_are_left_out(tmp_path: Path) -> None:
    channels = (Channel("a", "Power", "P"), Channel("b", "Power", "P"), Channel("m", "Other", "S", state=True))
    with RunRecorder(tmp_path / "r.rrd", Scene(), 0.0, (0, 100), [], channels) as recorder:
        recorder.telemetry(0, {"a": 1.0, "m": "x"}, run.UNIT)
        recorder.telemetry(0, {"a": 9.0, "b": 9.0}, run.UNIT)
        recorder.telemetry(10, {"b": 2.0, "m": "x"}, run.UNIT)
        recorder.telemetry(20, {"a": 3.0, "b": 4.0}, run.UNIT)
    read = Recorded(tmp_path / "r.rrd")
    rows = read.values["/telemetry/Power/P", "scalars"]
    assert str(rows) == str([(0, [1.0, math.nan]), (10, [math.nan, 2.0]), (20, [3.0, 4.0])])
    assert read.lane("/states/Other/S") == [(0, ["m: x"]), (20, [""])]


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Geom("g", "cone", (1,), (0, 0, 0), run.UNIT, (1, 1, 1, 1)), "'g'.*one of box.*'cone'"),
        (lambda: Geom("g", "box", (1, 2), (0, 0, 0), run.UNIT, (1, 1, 1, 1)), "3 positive sizes"),
    ],
)
def test_wrong_shapes_are_refused(make: Any, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        make()


def test_wrong_images_lanes_and_directions_are_refused(tmp_path: Path) -> None:
    with (
        small(tmp_path / "r.rrd") as recorder,
        pytest.raises(ValueError, match=r"'micas' at 3: expected \(h, w, 3\) of uint8"),
    ):
        recorder.image(3, np.zeros((4, 4), np.uint8), "micas", "")
    with pytest.raises(ValueError, match=r"expected one of sc\.mode, found 'x\.y'"):
        small(tmp_path / "s.rrd", power_lanes=("x.y",))
    with pytest.raises(ValueError, match="not all 0"):
        RunRecorder(tmp_path / "t.rrd", Scene(directions={"Sun": (0, 0, 0)}), 0.0, (0, 1), [], ())


def test_a_scene_without_a_camera_shows_images_all_the_same(tmp_path: Path) -> None:
    with small(tmp_path / "r.rrd") as recorder:
        recorder.image(3, np.zeros((8, 8, 3), np.uint8), "micas", "dark")
    assert [t for t, _ in Recorded(tmp_path / "r.rrd").values["/camera/micas", "blob"]] == [3]


def test_what_was_found_in_an_image_goes_with_it(tmp_path: Path) -> None:
    """Boxes at the middles of the pixels meant; the next image without any takes them away."""
    dark = np.zeros((8, 8, 3), np.uint8)
    with small(tmp_path / "r.rrd") as recorder:
        recorder.image(3, dark, "micas", "two", [Mark("star", 1.0, 2.5), Mark("target", 4.0, 4.0, "rock")])
        recorder.image(5, dark, "micas", "none")
    read = Recorded(tmp_path / "r.rrd")
    assert read.values["/camera/micas/star", "centers"] == [(3, [[1.5, 3.0]]), (5, [])]
    assert read.values["/camera/micas/target", "centers"] == [(3, [[4.5, 4.5]]), (5, [])]
    assert read.values["/camera/micas/target", "labels"] == [(3, ["rock"]), (5, [])]


def test_a_channel_is_recorded_in_the_unit_of_its_title(tmp_path: Path) -> None:
    channels = (Channel("a", "Power", "P (mN)", scale=1000.0), Channel("b", "Power", "P (mN)"))
    with RunRecorder(tmp_path / "r.rrd", Scene(), 0.0, (0, 100), [], channels) as recorder:
        recorder.telemetry(0, {"a": 0.5, "b": 2.0}, run.UNIT)
    assert Recorded(tmp_path / "r.rrd").values["/telemetry/Power/P_mN", "scalars"] == [(0, [500.0, 2.0])]


def test_a_camera_looks_along_its_boresight(tmp_path: Path) -> None:
    scene = Scene(camera=Camera((0, 0, 1), (0, 0, 2)))
    with RunRecorder(tmp_path / "r.rrd", scene, 0.0, (0, 1), [], ()):
        pass
    chunks = [c for c in Recorded(tmp_path / "r.rrd").chunks if str(c.entity_path) == "/world/spacecraft/camera"]
    matrix = next(c.to_record_batch().column("Transform3D:mat3x3").to_pylist()[0][0] for c in chunks)
    columns = np.array(matrix).reshape(3, 3)  # rerun keeps matrices column by column
    assert columns[2] == pytest.approx([0, 0, 1])
    assert np.linalg.det(columns) == pytest.approx(1)


# ---- words ----------------------------------------------------------------------------------------------------------


def test_elapsed_and_labels() -> None:
    assert [elapsed(t) for t in (0, 3661, 86_399, 215_647, -5)] == [
        *("00:00:00", "01:01:01", "23:59:59", "2d 11:54:07", "-00:00:05"),
    ]
    assert (
        token_label("Domain.PointAt", {"target": "targets.Earth", "exact": True, "rate": 2.50})
        == "PointAt Earth rate 2.5"
    )
    assert token_label("Wait", {"left": ("a", "b"), "span": {"min": 0, "max": 3}}) == "Wait"


def test_every_kind_of_entry_has_words() -> None:
    kinds = {
        *("run.started", "plan.requested", "plan.adopted", "plan.failed", "goal", "token.started", "token.finished"),
        *("token.failed", "token.aborted", "command.sent", "command.acknowledged", "command.timeout", "violation"),
        *("standby.entered", "standby.left", "fault.injected", "fault.detected", "fault.response", "run.finished"),
    }
    for kind in kinds:
        told = line({"t": 60, "event": kind})
        assert told is not None
        level, text = told
        assert level in ("TRACE", "DEBUG", "INFO", "WARN", "ERROR")
        assert text.startswith("00:01:00  ")
        assert not text.startswith(f"00:01:00  {kind}:"), "no words of its own"
    assert all(line({"t": 0, "event": kind}) is None for kind in SILENT)


def test_funnels_are_of_goals_that_are_still_open() -> None:
    tokens = [token(f"g{i}", "Do", (i, i + 50), (i + 60, i + 90), goal=f"goal-{i}") for i in range(20)]
    plan = plan_of(token("f", "Off", (0, 9), (9, 9), fact=True), *tokens)
    chosen = chosen_tokens(plan, 60)
    assert [t.id for t in chosen] == ["g11", "g12", "g13", "g14", "g16", "g17", "g18", "g19"]
    assert chosen_tokens(plan_of(token("a", "Off", (0, None), (5, None))), 0) == []


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.text("ab /\\[](){}#:;,.-_é☉\n", max_size=12))
def test_entity_names_are_path_parts_without_escapes(name: str) -> None:
    assert re.fullmatch(r"[A-Za-z0-9_.-]+", entity(name))


def test_what_the_planner_answers_and_what_is_confirmed_are_lines_not_data() -> None:
    answer = {"t": 1, "event": "plan.answered", "content": {"tokens": [1] * 500}, "charged": 685, "steps": 9}
    assert line(answer) == ("DEBUG", "00:00:01  the planner answers with a plan, charged 685 s")
    assert line(answer | {"content": None, "reason": "too late"}) == (
        "DEBUG",
        "00:00:01  the planner answers with no plan: too late, charged 685 s",
    )
    detected = {
        "t": 2,
        "event": "fault.detected",
        "monitor": "switch",
        "diagnosis": "switch stuck",
        "text": "it sticks",
    }
    assert line(detected) == ("ERROR", "00:00:02  fault detected: it sticks (monitor switch)")
