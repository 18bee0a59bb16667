"""The report page: self-contained, well-formed, and true to the run folder."""

from __future__ import annotations

import re
import shutil
from html import escape
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from scenarios.charts import Axis, timeline
from scenarios.errors import ScenarioError
from scenarios.recording import Mark
from scenarios.recording.reading import read
from scenarios.report import page_of, write_report
from scenarios.run_story import RunStory
from scenarios.words import in_words
from tests.scenarios.conftest import Flown
from tests.scenarios.recorded import event, of_token, plan_of, small, token

VOID = {"meta", "img"}


class Page(HTMLParser):
    """Fails for tags that do not match, collects attributes that load something."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: set[str] = set()
        self.loads: list[str] = []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.loads += [value or "" for name, value in attrs if name in ("src", "href", "srcset", "xlink:href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_tells_the_run(faulted: Flown) -> None:
    text = (faulted.folder / "report.html").read_text()
    page = Page(text)
    assert page.loads == []
    assert "script" not in page.tags
    assert not re.search(r"https?://|url\(|@import", text)
    assert 'name="viewport"' in text
    for goal in faulted.summary["goals"]:
        assert goal["id"] in text
        assert escape(in_words(goal["reason"] or "")) in text
    assert text.count('<span class="badge achieved">') == 6
    for words in ("micas-stuck-on occurs", "plan-02 takes over", escape("the camera's power switch does not go off")):
        assert words in text
    for lane in ("attitude.mode", "engine.mode", "camera.mode", "camera.switch", "navigation.activity", "radio.mode"):
        assert f">{lane}</text>" in text
    for panel in ("power (W)", "battery charge (0 to 1)", "wheel speeds (rad/s)"):
        assert f"<figcaption>{panel}" in text


def test_the_lanes_are_the_journal(faulted: Flown) -> None:
    story = RunStory.load(faulted.folder)
    done = [stretch for lane in story.lanes for stretch in lane.done]
    assert len(done) == len(faulted.of("token.started"))
    assert sum(s.state == "failed" for s in done) == 1
    assert sum(s.state == "aborted" for s in done) == len(faulted.of("token.aborted"))
    (given_up,) = (e["t"] for e in faulted.of("standby.entered") if e["t"] > 0)
    first, second = (e["t"] for e in faulted.of("plan.adopted"))
    assert [(p.start, p.end, p.plan) for p in story.phases] == [
        (0, first, ""),
        (first, given_up, "plan-01"),
        (given_up, second, ""),
        (second, 43_200, "plan-02"),
    ]
    for lane in story.lanes:
        for row in (lane.earliest, lane.latest, lane.done):
            assert all(a.end <= b.start for a, b in pairwise(row))


def test_hostile_words_stay_words(tmp_path: Path) -> None:
    bad = "<script>alert(1)</script>&\"'"
    with small(tmp_path / "run.rrd") as recorder:
        recorder.event(event(0, "run.started", scenario=bad, seed=1))
    story = RunStory(
        [
            event(0, "run.started", scenario=bad, seed=bad),
            event(0, "standby.entered", reason=bad),
            of_token(5, "token.started", bad, bad, bad),
            of_token(9, "token.failed", bad, bad, bad, reason=bad),
            event(9, "fault.injected", name=bad),
            event(9, "fault.detected", monitor=bad, diagnosis=bad, text=bad),
            event(9, "goal", id=bad, status="dropped", reason=bad),
        ],
        {},
        {},
        (0, 100),
        9,
    )
    story.phases, story.lanes = list(story._phases()), list(story._lanes())
    text = page_of(story, read(tmp_path / "run.rrd"))
    assert "script" not in Page(text).tags
    assert "<script" not in text


def test_pictures_are_embedded_as_recorded(tmp_path: Path) -> None:
    pixels = np.random.default_rng(0).integers(0, 255, (32, 32, 3), dtype=np.uint8)
    with small(tmp_path / "run.rrd") as recorder:
        recorder.event(event(0, "run.started", scenario="x", seed=1))
        found = [Mark("star", 3.0, 4.0), Mark("target", 16.25, 15.5, "rock")]
        recorder.image(7, pixels, "micas", "image 1 of a rock", found)
        recorder.image(9, pixels, "chase", "outside")
    readings = read(tmp_path / "run.rrd")
    assert [(p.time, p.camera, p.caption) for p in readings.pictures] == [
        (7, "micas", "image 1 of a rock"),
        (9, "chase", "outside"),
    ]
    assert {(m.kind, m.column, m.row) for m in readings.pictures[0].marks} == {("star", 3, 4), ("target", 16.25, 15.5)}
    assert readings.pictures[1].marks == ()
    assert all(p.blob.startswith(b"\xff\xd8\xff") for p in readings.pictures)
    text = page_of(RunStory([event(0, "run.started", scenario="x", seed=1)], {}, {}, (0, 10), 10), readings)
    sources = Page(text).loads
    assert len(sources) == 2
    assert all(source.startswith("data:image/jpeg;base64,/9j/") for source in sources)


def test_planned_bars_end_where_their_plan_does(faulted: Flown) -> None:
    story = RunStory.load(faulted.folder)
    first = next(phase for phase in story.phases if phase.plan == "plan-01")
    for lane in story.lanes:
        for stretch in (*lane.earliest, *lane.latest):
            assert not (stretch.start < first.end < stretch.end)
    assert Page("<div>" + timeline(story) + "</div>")


def test_the_axis_is_monotone_and_has_few_ticks() -> None:
    for span in (1, 59, 3600, 43_200, 6 * 86_400, 360 * 86_400):
        axis = Axis(0, span)
        ticks = list(axis.ticks())
        assert len(ticks) <= 14
        places = [axis.x(tick) for tick in ticks]
        assert places == sorted(places)


@pytest.mark.parametrize(
    ("name", "content", "complaint"),
    [
        ("journal.jsonl", "", "found no entry"),
        ("journal.jsonl", "{}\n{}\n", r"journal\.jsonl:1: expected an entry"),
        ("journal.jsonl", "{\n{}\n", r"journal\.jsonl:1:\d+: not JSON"),
        ("summary.json", "[]", r"summary\.json: expected a run's summary"),
        ("summary.json", "{", r"summary\.json: expected a run's summary"),
        ("plans/plan-01.json", "{}", r"plan-01\.json"),
    ],
)
def test_a_damaged_folder_is_named(faulted: Flown, tmp_path: Path, name: str, content: str, complaint: str) -> None:
    run = tmp_path / "run"
    shutil.copytree(faulted.folder, run)
    (run / name).write_text(content)
    with pytest.raises(ScenarioError, match=complaint):
        write_report(run, tmp_path / "page.html")
    assert not (tmp_path / "page.html").exists()


def test_a_line_cut_off_by_a_kill_is_left_out(faulted: Flown, tmp_path: Path) -> None:
    run = tmp_path / "run"
    shutil.copytree(faulted.folder, run)
    (run / "summary.json").unlink()
    (run / "run.rrd").unlink()
    text = (run / "journal.jsonl").read_text()
    (run / "journal.jsonl").write_text(text[: len(text) // 2])
    page = write_report(run).read_text()
    assert "not finished" in page
    assert "Resources" not in page


def test_an_unbounded_token_reaches_to_the_end() -> None:
    plan = plan_of(token("a", "sc.on", (0, 0), (10, None)), token("b", "sc.off", (10, None), (20, None)))
    story = RunStory(
        [event(0, "run.started"), event(0, "plan.adopted", plan="plan-01", reason="initial")], {}, {}, (0, 99), 99
    )
    story.plans["plan-01"] = plan
    story.phases = list(story._phases())
    (lane,) = story._lanes()
    assert [(s.start, s.end) for s in lane.earliest] == [(0, 10), (10, 20)]
    assert [(s.start, s.end) for s in lane.latest] == [(0, 99)]
