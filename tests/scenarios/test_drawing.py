"""Drawings of plans: well-formed, complete, and nothing on top of anything else, from five tokens to two hundred."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import combinations, pairwise
from pathlib import Path
from random import Random
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner

from planner.plan import FlexiblePlan, PlanConstraint, PlanTimeline, PlanToken
from scenarios.cli import app
from scenarios.drawing.layout import Box, Layout, boxes_of, lay_out
from scenarios.drawing.links import Edge, Link, _constraints, _leads, links_of, reduced
from scenarios.drawing.strips import OVERLAP, WIDEST, strips_of
from scenarios.drawing.svg import draw
from scenarios.drawing.text import SMALL, bounds, width
from scenarios.plan_verb import plan_file
from tests.planner.test_checker import ds1

EXAMPLES = Path(__file__).parents[2] / "scenarios" / "examples"
NAME = "{http://www.w3.org/2000/svg}"


def invented(seed: int, size: int) -> FlexiblePlan:
    """A plan of that many tokens on timelines, with rooms between some of them and constraints across."""
    random = Random(seed)
    lanes = max(2, size // 20)
    timelines, tokens, constraints = [], [], []
    for lane in range(lanes):
        time, slots = 0, []
        for number in range(size // lanes):
            begin = time + (random.randint(1, 50) if random.random() < 0.3 else 0)
            last, duration = random.randint(1, 400), random.randint(1, 90)
            name = f"t{lane}_{number}"
            values = {"target": "x" * random.randint(1, 60)} if random.random() < 0.5 else {}
            start, time = (begin, begin + last), begin + duration
            goal = "wanted & <bold>" if random.random() < 0.2 else None
            end = (time, time + last)
            token = PlanToken(name, f"thing{lane}", "mode", f"Thing.does_{number % 5}", values, start, end, (1, None))
            tokens.append(PlanToken(**{f: getattr(token, f) for f in token.__slots__} | {"goal": goal}))
            slots.append((name,))
        timelines.append(PlanTimeline(f"thing{lane}", "mode", tuple(slots)))
    for _ in range(size):
        one, two = random.sample(tokens, 2)
        bound = random.choice([(0, None), (0, 0), (0, 30)])
        sides = random.choice(["start", "end"]), random.choice(["start", "end"])
        constraints.append(PlanConstraint(f"{one.id}.{sides[0]}", f"{two.id}.{sides[1]}", *bound, "a <rule>"))
    return FlexiblePlan("invented", (0, 2000), (), tuple(timelines), tuple(tokens), tuple(constraints))


PLANS = {
    **{path.stem: path for path in sorted(EXAMPLES.glob("*.nddl"))},
    "survey": EXAMPLES / "survey" / "survey.nddl",
    **{f"invented-{size}": size for size in (5, 40, 200)},
    "ds1": None,
}


@pytest.fixture(scope="module", params=PLANS)
def plan(request: pytest.FixtureRequest) -> FlexiblePlan:
    """Each of the plans that are drawn here."""
    source = PLANS[request.param]
    if isinstance(source, Path):
        own = [str(path) for path in source.parent.glob("travel.py")]
        found = plan_file(source, procedures=own).plan
        assert found is not None
        return found
    return ds1()[2] if source is None else invented(source, source)


def rectangle(box: Box) -> tuple[float, float, float, float]:
    return box.x, box.y, box.right, box.y + box.high


def words(layout: Layout, links: list[Link]) -> list[tuple[float, float, float, float]]:
    """Where small words outside of boxes stand."""
    found = []
    for lane in layout.lanes:
        for box in lane.boxes if not lane.thin else ():
            start, end = box.edge_text
            y, wide = box.y + box.high, width(start, SMALL)
            left = box.x - wide / 2 if box.joined else box.x + 3
            found.append((left, y, left + wide, y + 10))
            if end:
                found.append((box.right - 3 - width(end, SMALL), y, box.right - 3, y + 10))
    for link in links:
        if link.label_at is not None:
            half = width(link.label, SMALL) / 2
            found.append((link.label_at[0] - half, link.label_at[1] - 8, link.label_at[0] + half, link.label_at[1]))
    return found


def overlap(a: tuple[float, float, float, float], b: tuple[float, float, float, float]) -> bool:
    return a[0] + 0.01 < b[2] and b[0] + 0.01 < a[2] and a[1] + 0.01 < b[3] and b[1] + 0.01 < a[3]


def test_nothing_covers_anything(plan: FlexiblePlan) -> None:
    layout = lay_out(plan)
    boxes = [rectangle(box) for box in boxes_of(layout)]
    assert not [pair for pair in combinations(boxes, 2) if overlap(*pair)]
    texts = words(layout, links_of(plan, layout))
    assert not [pair for pair in combinations(texts, 2) if overlap(*pair)]
    assert not [(text, box) for text in texts for box in boxes if overlap(text, box)]
    assert all(
        box.x >= layout.gutter and box.right < layout.wide and box.y + box.high < layout.high
        for box in boxes_of(layout)
    )


def test_every_word_fits_its_box_and_every_time_its_column(plan: FlexiblePlan) -> None:
    layout = lay_out(plan)
    places: dict[object, float] = {}
    for box in boxes_of(layout):
        assert box.wide >= box.words_wide() - 0.01
        assert places.setdefault(box.columns[0], box.x) == pytest.approx(box.x)
        assert places.setdefault(box.columns[1], box.right) == pytest.approx(box.right)
    times = sorted(places.items(), key=lambda entry: entry[0])  # type: ignore[arg-type, return-value]
    assert [x for _, x in times] == sorted(x for _, x in times)


def test_the_document_is_whole(plan: FlexiblePlan) -> None:
    text = draw(plan)
    root = ElementTree.fromstring(text)
    titles = [e.text or "" for e in root.iter(f"{NAME}title")]
    layout = lay_out(plan)
    shown = {i for title in titles for i in re.findall(r"[\w]+", title.split("\n")[0].rpartition("  ")[2])}
    assert {token.id for token in plan.tokens} <= shown
    for host in plan.hosts():
        assert any(f"start {bounds(host.start)}, end {bounds(host.end)}" in title for title in titles)
    assert "prefers-color-scheme: dark" in text
    assert "http" not in text.replace("http://www.w3.org/2000/svg", "")
    goals = {token.goal for token in plan.tokens if token.goal is not None}
    assert len([g for g in root.iter(f"{NAME}g") if g.get("id") is None]) == len(list(boxes_of(layout)))
    assert all(any(f"goal {goal}" in title for title in titles) for goal in goals)


def test_strips_are_narrow_and_leave_nothing_out(plan: FlexiblePlan) -> None:
    layout = lay_out(plan)
    strips = strips_of(layout)
    if len(strips) == 1:
        assert layout.wide <= WIDEST
        return
    boxes = list(boxes_of(layout))
    assert strips[0].left == min(box.x for box in boxes)
    assert strips[-1].right == max(box.right for box in boxes)
    assert all(one.right == following.left for one, following in pairwise(strips))
    assert all(strip.right - strip.left <= WIDEST - layout.gutter for strip in strips)
    for number, strip in enumerate(strips):
        across = [box for box in boxes if box.x < strip.left - OVERLAP and box.right > strip.left + OVERLAP]
        assert list(strip.continued) == across
        assert number or not across
    text = draw(plan)
    assert text.count('href="#plan"') == len(strips)
    assert text.count('class="lane"') == len(strips) * len(layout.lanes)


def test_a_box_wider_than_a_strip() -> None:
    plan = invented(3, 60)
    long = PlanToken("long", "all", "s", "All.day", {}, (0, 0), (2000, 2000), (1, None))
    lane = PlanTimeline("all", "s", (("long",),))
    layout = lay_out(replace(plan, tokens=(*plan.tokens, long), timelines=(*plan.timelines, lane)))
    strips = strips_of(layout)
    assert len(strips) > 1
    assert all(any(box.token.id == "long" for box in strip.continued) for strip in strips[1:])


def order(links: list[Link], layout: Layout) -> dict[Edge, set[Edge]]:
    """What comes after what, as links and lanes say it."""
    after: dict[Edge, set[Edge]] = {}
    for lane in layout.lanes:
        for box in lane.boxes:
            after.setdefault((id(box), False), set()).add((id(box), True))
        for box, following in zip(lane.boxes, lane.boxes[1:], strict=False):
            if lane.ordered:
                after.setdefault((id(box), True), set()).add((id(following), False))
    for link in links:
        if link.style == "same":
            after.setdefault(link.ends[1], set()).add(link.ends[0])
        if link.style != "asked":
            after.setdefault(link.ends[0], set()).add(link.ends[1])
    return after


def test_links_left_out_are_implied(plan: FlexiblePlan) -> None:
    layout = lay_out(plan)
    every = list(_constraints(plan, layout))
    kept = reduced(every, layout)
    whole, rest = order(every, layout), order(kept, layout)
    for edge, following in whole.items():
        assert all(_leads(rest, edge, other) for other in following)
    for link in kept:
        if link.style == "after" and not link.label:
            without = order([one for one in kept if one.ends != link.ends or one.style != "after"], layout)
            assert not _leads(without, *link.ends)


def test_odd_characters_and_nothing_at_all() -> None:
    token = PlanToken("t0", "a", "s", "A.p", {"v": "a\x01b<&\ud800"}, (None, None), (None, None), (0, None))
    odd = FlexiblePlan("m", (0, 9), ("a",), (PlanTimeline("a", "s", (("t0",),)),), (token,), ())
    ElementTree.fromstring(draw(odd).encode())
    empty = FlexiblePlan("m", (0, 9), (), (), (), ())
    assert "0 tokens" in draw(empty)
    ElementTree.fromstring(draw(empty))


def test_the_command_draws(tmp_path: Path) -> None:
    target = tmp_path / "plan.svg"
    found = CliRunner().invoke(app, ["plan", str(EXAMPLES / "light_switch.nddl"), "--svg", str(target), "--json"])
    assert found.exit_code == 0
    assert "shining" in target.read_text(encoding="utf-8")
    assert [path.name for path in tmp_path.iterdir()] == ["plan.svg"]


def test_the_judge_draws_what_it_judges(tmp_path: Path) -> None:
    plan, target = tmp_path / "plan.json", tmp_path / "plan.svg"
    runner, model = CliRunner(), str(EXAMPLES / "light_switch.nddl")
    assert runner.invoke(app, ["plan", model, "--out", str(plan), "--svg", str(target)]).exit_code == 0
    drawn = target.read_text(encoding="utf-8")
    target.unlink()
    assert runner.invoke(app, ["check", str(plan), model, "--svg", str(target)]).exit_code == 0
    assert target.read_text(encoding="utf-8") == drawn
