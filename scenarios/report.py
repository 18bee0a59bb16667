"""The report of a run: one HTML page for a person, made from the run folder alone. No scripts, nothing loaded."""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from planner.files import write_whole
from scenarios import charts
from scenarios.errors import RunBrokenError, ScenarioError
from scenarios.folder import RECORDING, REPORT
from scenarios.observer import CHANNELS
from scenarios.recording import story as words
from scenarios.recording.marks import COLOURS, HALF_PX
from scenarios.recording.reading import Picture, Readings, read
from scenarios.recording.scene import IMAGE_PX
from scenarios.recording.telemetry import panels_of
from scenarios.report_style import STYLE
from scenarios.run_story import RunStory
from scenarios.times import clock
from scenarios.words import MEANT, in_words

_MOST_OUTSIDE = 16
_TOLD = ("run.started", "plan.adopted", "plan.failed", "goal", "token.failed", "standby.entered", "run.finished")
_LEAST = ("fault.injected", "fault.detected", "fault.response", "fault.recovered", "fault.cleared")


def write_report(folder: Path, to: Path | None = None) -> Path:
    """Write the report page of a run folder, in the folder or to another file; returns where.

    ScenarioError when the folder is not one of a run, or the file cannot be written. A run that was killed has a
    report too.
    """
    page = page_of(RunStory.load(folder), read(folder / RECORDING))
    target = folder / REPORT if to is None else to
    try:
        write_whole(target, page)
    except OSError as error:
        failure = RunBrokenError if to is None else ScenarioError  # to a file that was asked for: bad input
        raise failure(f"{target}: {error.strerror}") from error
    return target


def page_of(story: RunStory, readings: Readings) -> str:
    """The page's text."""
    start = next(story.events("run.started"), {})
    title = f"{start.get('scenario') or 'run'}, seed {start.get('seed', '?')}"
    body = [
        _head(story, title),
        _section("Goals", _goals(story)),
        _section("Plan against execution", _timeline(story)),
        _section("Faults and responses", _faults(story)),
        _section("Plans", _plans(story)),
        _section("Flight rules", _flight_rules(story)),
        _section("Resources", _grid("plots", _plots(story, readings))),
        _section("Images", _images(readings.pictures)),
        _section("What happened", _events(story)),
    ]
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{STYLE}</style></head><body>\n" + "\n".join(body) + "\n</body></html>\n"
    )


def _section(title: str, content: str) -> str:
    return f"<section><h2>{title}</h2>{content}</section>" if content else ""


def _head(story: RunStory, title: str) -> str:
    summary = story.summary
    outcome = summary.get("outcome", "not finished")
    goals = story.goals()
    achieved = sum(goal["status"] == "achieved" for goal in goals)
    facts = [f"{achieved} of {len(goals)} goals achieved", f"{clock(story.last)} flown", _count(story.plans, "plan")]
    if summary:
        facts.append(f"{summary['replans']} of them forced by faults")
        facts.append(_count(summary["faults"], "fault"))
        facts.append(f"computed in {summary['wall_seconds']:.1f} s")
    about = "".join(f"<p>{escape(text)}</p>" for text in (_about(summary), _meant(outcome, summary)) if text)
    kept = "".join(f'<p class="broken">Not as declared: {escape(words)}</p>' for words in summary.get("unmet", ()))
    badge = f'<span class="badge {escape(outcome.replace(" ", "-"))}">{escape(outcome)}</span>'
    return f"<header><h1>{escape(title)} {badge}</h1>{about}<p>{escape(', '.join(facts))}</p>{kept}</header>"


def _about(summary: Mapping[str, Any]) -> str:
    about = str(summary.get("about", ""))
    return f"{about[:1].upper()}{about[1:]}." if about else ""


def _meant(outcome: str, summary: Mapping[str, Any]) -> str:
    """The outcome in words, and whether it is as good as the scenario promises."""
    meant = MEANT.get(outcome, "")
    if not meant:
        return ""
    promise = "not what" if summary.get("unmet") else "as good as"
    return f"{outcome.capitalize()}: {meant}; {promise} the scenario promises."


def _goals(story: RunStory) -> str:
    rows = [
        [_badge(g["status"]), escape(g["id"]), _time(g["time"]), _text(in_words(g["reason"] or ""), "reason")]
        for g in story.goals()
    ]
    return _table(("", "goal", "at", "why"), rows)


def _timeline(story: RunStory) -> str:
    note = (
        "Of each timeline: planned at the earliest (thin, above), done (thick), planned at the latest (thin, below). "
        "A red end: failed or called off. Times run from the start of the scenario. On narrow screens it scrolls."
    )
    scrolled = '<div class="wide" tabindex="0" role="region" aria-label="timelines">'
    return f'<p class="note">{note}</p>{scrolled}{charts.timeline(story)}</div>'


def _faults(story: RunStory) -> str:
    texts = {e.get("diagnosis"): e.get("text") for e in story.events("fault.detected")}
    faults = story.summary.get("faults")
    if faults is None:
        faults = [{"name": e["name"], "injected": e["t"]} for e in story.events("fault.injected")]
    rows = []
    for fault in faults:
        diagnosis = fault.get("diagnosis")
        meant = texts.get(diagnosis) or diagnosis or ""
        times = [_time(fault.get("injected")), _time(fault.get("detected")) or "not noticed"]
        answer = [escape(fault.get("response") or ""), _time(fault.get("recovered"))]
        consequence = "" if fault.get("injected") is not None else " (not injected)"
        rows.append([escape(fault["name"]) + consequence, *times, _text(meant), *answer])
    return (
        _table(("fault", "occurred", "noticed", "taken for", "response", "recovered"), rows) if rows else "<p>None.</p>"
    )


def _plans(story: RunStory) -> str:
    rows = []
    for plan in story.summary.get("plans", ()):
        start, end = plan["horizon"]
        size = f"{plan['tokens']} tokens, {plan['constraints']} constraints"
        thought = clock(plan["deliberation_charged"])
        effort = f"{plan['steps']} steps in {plan['solve_seconds']:.2f} s; {thought} of mission time charged for it"
        rows.append([escape(plan["id"]), f"{clock(start)} to {clock(end)}", _text(plan["reason"]), size, effort])
    return _table(("plan", "covers", "why", "size", "planning"), rows) if rows else ""


def _flight_rules(story: RunStory) -> str:
    rules = story.summary.get("flight_rules")
    if rules is None:
        return ""
    if not rules["violations"]:
        return f"<p>All {rules['checked']} kept, as checked every second from telemetry.</p>"
    rows = [[escape(v["rule"]), clock(v["start"]), clock(v["end"])] for v in rules["violations"]]
    return _table(("rule broken", "from", "to"), rows)


def _plots(story: RunStory, readings: Readings) -> Iterator[str]:
    titles = {panel.path: panel.title for panel in panels_of(CHANNELS)}
    order = {path: number for number, path in enumerate(titles)}
    for path, panel in sorted(readings.plots.items(), key=lambda item: order.get(item[0], len(order))):
        title = titles.get(path) or path.rpartition("/")[2].replace("_", " ")
        drawing = charts.plot(panel, title, story) if panel.rows else ""
        if drawing:
            names = panel.names if len(panel.names) > 1 else ()
            keys = "".join(
                f' <span class="key" style="color:{charts.line_colour(n)}">{escape(name)}</span>'
                for n, name in enumerate(names)
            )
            yield f"<figure><figcaption>{escape(title)}{keys}</figcaption>{drawing}</figure>"


def _images(pictures: Sequence[Picture]) -> str:
    science = [p for p in pictures if p.camera == "micas"]
    outside = [p for p in pictures if p.camera == "chase"]
    outside = outside[:: max(1, math.ceil(len(outside) / _MOST_OUTSIDE))]
    words = "What the science camera saw. Orange: the target as it was found; blue: stars that were recognised."
    notes = (words, "The spacecraft from outside, as simulated.")
    return "".join(
        f'<p class="note">{note}</p>{_grid("images", map(_image, row))}'
        for note, row in zip(notes, (science, outside), strict=True)
        if row
    )


def _image(picture: Picture) -> str:
    source = f"data:{picture.media_type};base64,{b64encode(picture.blob).decode('ascii')}"
    text = escape(f"{clock(picture.time)} {picture.caption}")
    place = "science camera" if picture.camera == "micas" else "from outside"
    img = f'<img alt="{place}: {text}" src="{source}">'
    return f'<figure><div class="frame">{img}{_boxes(picture)}</div><figcaption>{text}</figcaption></figure>'


def _boxes(picture: Picture) -> str:
    """What was found in a picture of the science camera, drawn over it."""
    boxes = []
    for mark in picture.marks:
        half, colour = HALF_PX[mark.kind], "#{:02x}{:02x}{:02x}".format(*COLOURS[mark.kind])
        place = f'x="{mark.column - half:.0f}" y="{mark.row - half:.0f}" width="{2 * half:g}" height="{2 * half:g}"'
        boxes.append(f'<rect {place} stroke="{colour}"/>')
    return f'<svg viewBox="0 0 {IMAGE_PX} {IMAGE_PX}" aria-hidden="true">{"".join(boxes)}</svg>' if boxes else ""


def _grid(style: str, figures: Iterable[str]) -> str:
    content = "".join(figures)
    return f'<div class="{style}">{content}</div>' if content else ""


def _events(story: RunStory) -> str:
    lines = []
    for entry in story.events(*_TOLD, *_LEAST):
        told = words.line(story.reasons.retold(entry))
        if told is not None:
            time, _, text = told[1].partition("  ")
            lines.append(f'<li class="{told[0].lower()}"><time>{time}</time> {_text(text)}</li>')
    return f'<ol class="events">{"".join(lines)}</ol>'


def _table(heads: Iterable[str], rows: Sequence[Sequence[str]]) -> str:
    heads = tuple(heads)
    top = "".join(f"<th>{head}</th>" for head in heads)
    lines = []
    for row in rows:
        cells = "".join(f'<td data-head="{head}">{cell}</td>' for head, cell in zip(heads, row, strict=True))
        lines.append(f"<tr>{cells}</tr>")
    return f"<table><thead><tr>{top}</tr></thead><tbody>{''.join(lines)}</tbody></table>"


def _badge(status: str) -> str:
    return f'<span class="badge {escape(status)}">{escape(status)}</span>'


def _text(text: str, style: str = "") -> str:
    return f'<span class="{style}">{escape(text)}</span>' if style and text else escape(text)


def _time(time: int | None) -> str:
    return "" if time is None else clock(time)


def _count(things: Any, name: str) -> str:
    return f"{len(things)} {name}{'' if len(things) == 1 else 's'}"
