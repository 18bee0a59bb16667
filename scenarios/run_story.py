"""A run folder read back: what was planned, what was done, what went wrong. From journal, plans, summary."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from planner.errors import PlanFormatError
from planner.plan import FlexiblePlan, PlanToken
from scenarios.errors import ScenarioError
from scenarios.folder import JOURNAL, PLANS, SUMMARY
from scenarios.words import Reasons

Entry = Mapping[str, Any]
_ENDS = {"token.finished": "finished", "token.failed": "failed", "token.aborted": "aborted"}


@dataclass(frozen=True, slots=True)
class Stretch:
    """Something that lasts from `start` to `end` (seconds). `state`: how it ended, or what it is."""

    start: int
    end: int
    predicate: str
    parameters: Mapping[str, Any]
    state: str = "finished"
    note: str = ""


@dataclass
class Lane:
    """One timeline: what its plans foresaw at the earliest and at the latest, and what was done."""

    name: str
    earliest: list[Stretch] = field(default_factory=list)
    latest: list[Stretch] = field(default_factory=list)
    done: list[Stretch] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Phase:
    """A stretch of time under one plan, or in standby (`plan` is empty). `why`: what it follows from."""

    start: int
    end: int
    plan: str
    why: str


@dataclass
class RunStory:
    """A run as its folder tells it. `summary` is empty for a run that did not come to its end."""

    entries: list[dict[str, Any]]
    summary: dict[str, Any]
    plans: dict[str, FlexiblePlan]
    horizon: tuple[int, int]
    last: int
    lanes: list[Lane] = field(default_factory=list)
    phases: list[Phase] = field(default_factory=list)
    reasons: Reasons = field(default_factory=Reasons)

    @classmethod
    def load(cls, folder: Path) -> RunStory:
        """Read a run folder; ScenarioError says which file is missing or is not what it should be."""
        entries = _journal(folder / JOURNAL)
        start = entries[0]
        horizon = start.get("horizon") or [0, entries[-1]["t"]]
        summary = _summary(folder / SUMMARY)
        story = cls(entries, summary, _plans(folder), (horizon[0], horizon[1]), entries[-1]["t"])
        for entry in entries:
            story.reasons.tell(entry)
        story.phases = list(story._phases())
        story.lanes = list(story._lanes())
        return story

    def events(self, *kinds: str) -> Iterator[dict[str, Any]]:
        """The journal's entries of these kinds."""
        return (entry for entry in self.entries if entry["event"] in kinds)

    def goals(self) -> list[dict[str, Any]]:
        """Goals with status, time and reason: the summary's, or what the journal of an unfinished run says."""
        if self.summary:
            return list(self.summary["goals"])
        told = {e["id"]: e for e in self.events("goal")}
        known = dict.fromkeys(t.goal for plan in self.plans.values() for t in plan.tokens if t.goal)
        none = {"status": "open", "t": None, "reason": None}
        rows = [(goal, told.get(goal, none)) for goal in [*known, *(g for g in told if g not in known)]]
        return [{"id": goal, "status": e["status"], "time": e["t"], "reason": e["reason"]} for goal, e in rows]

    def _phases(self) -> Iterator[Phase]:
        begun: tuple[int, str, str] | None = None
        for entry in self.events("standby.entered", "plan.adopted"):
            if begun is not None:
                yield Phase(begun[0], entry["t"], begun[1], begun[2])
            begun = (entry["t"], str(entry.get("plan", "")), str(self.reasons.retold(entry)["reason"]))
        if begun is not None:
            yield Phase(begun[0], self.last, begun[1], begun[2])

    def _lanes(self) -> Iterator[Lane]:
        lanes: dict[str, Lane] = {}
        for plan_id, plan in self.plans.items():
            phase = next((p for p in self.phases if p.plan == plan_id), None)
            for timeline in plan.timelines:
                name = f"{timeline.object}.{timeline.attribute}"
                lane = lanes.setdefault(name, Lane(name))
                if phase is not None:
                    tokens = [plan.token(slot[0]) for slot in timeline.slots]
                    lane.earliest += _foreseen(tokens, phase, 0)
                    lane.latest += _foreseen(tokens, phase, 1)
        for name, stretch in self._done():
            lanes.setdefault(name, Lane(name)).done.append(stretch)
        yield from lanes.values()

    def _done(self) -> Iterator[tuple[str, Stretch]]:
        running: dict[tuple[str, str], dict[str, Any]] = {}
        for entry in self.events("token.started", *_ENDS):
            key = (str(entry.get("plan")), entry["token"])
            if entry["event"] == "token.started":
                plan, _, token = str(entry.get("continues", "")).partition("/")
                if (before := running.pop((plan, token), None)) is not None:
                    yield _stretch(before, entry["t"], "finished", "goes on under the next plan")
                running[key] = entry
                continue
            if key not in running:  # a plan that joins takes running tokens over, under names of its own
                key = next((k for k, e in running.items() if _same_timeline(e, entry)), key)
            if (started := running.pop(key, None)) is not None:
                end, state = entry.get("ended", entry["t"]), _ENDS[entry["event"]]
                yield _stretch(started, end, state, str(entry.get("reason", "")))
        for started in running.values():
            yield _stretch(started, self.last, "running", "")


def _same_timeline(one: Entry, other: Entry) -> bool:
    return all(one.get(name) == other.get(name) for name in ("object", "attribute", "predicate"))


def _stretch(started: Entry, end: int, state: str, note: str) -> tuple[str, Stretch]:
    name = f"{started['object']}.{started['attribute']}"
    return name, Stretch(started["t"], end, started["predicate"], started["parameters"], state, note)


def _foreseen(tokens: list[PlanToken], phase: Phase, side: int) -> Iterator[Stretch]:
    """The tokens at their lower (0) or upper (1) bounds, as far as the plan was in force."""
    last = phase.start
    for token in tokens:
        start, end = token.start[side], token.end[side]
        if start is None:
            return
        start = max(last, start)
        last = max(start, phase.end if end is None else end)
        if start < min(last, phase.end):
            yield Stretch(start, min(last, phase.end), token.predicate, token.parameters, "planned")


def _journal(path: Path) -> list[dict[str, Any]]:
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise ScenarioError(f"{path}: expected the journal of a run: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ScenarioError(f"{path}: not UTF-8 text at byte {error.start}") from error
    entries = []
    for number, line in enumerate(lines, 1):
        try:
            entry = json.loads(line)
        except json.JSONDecodeError as error:
            if number == len(lines):
                break  # the line that was being written when the run was killed
            raise ScenarioError(f"{path}:{number}:{error.colno}: not JSON: {error.msg}") from error
        if not isinstance(entry, dict) or not isinstance(entry.get("t"), int) or "event" not in entry:
            raise ScenarioError(f"{path}:{number}: expected an entry with `t` and `event`, found {line:.80}")
        entries.append(entry)
    if not entries:
        raise ScenarioError(f"{path}: expected the journal of a run, found no entry")
    return entries


def _summary(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise ScenarioError(f"{path}: expected a run's summary: {error}") from error
    if not isinstance(content, dict) or not {"goals", "faults", "plans", "outcome"} <= content.keys():
        raise ScenarioError(f"{path}: expected a run's summary, found something else")
    return content


def _plans(folder: Path) -> dict[str, FlexiblePlan]:
    try:
        return {path.stem: FlexiblePlan.load(path) for path in sorted((folder / PLANS).glob("plan-*.json"))}
    except PlanFormatError as error:
        raise ScenarioError(str(error)) from error
