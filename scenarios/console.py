"""A run's summary for a person at a terminal: plain lines, broken between words, with colours on a terminal only."""

from __future__ import annotations

import shutil
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.text import Text

from planner.plan import FlexiblePlan
from scenarios.folder import RECORDING, REPORT, SUMMARY
from scenarios.times import clock
from scenarios.words import MEANT, in_words

_COLOURS = {"achieved": "green", "dropped": "yellow", "missed": "red"}
_OUTCOMES = {"completed": "bold green", "degraded": "bold yellow", "standby": "bold red", "failed": "bold red"}
_WIDEST = 120


def print_plan(plan: FlexiblePlan, steps: int, seconds: float) -> None:
    """A plan as its timelines, each slot with its bounds."""
    console = Console(highlight=False, soft_wrap=True)
    console.print(f"{plan.model}: {len(plan.tokens)} tokens, planned in {steps} steps and {seconds:.3f} s")
    for timeline in plan.timelines:
        console.print(f"{timeline.object}.{timeline.attribute}", markup=False)
        for slot in timeline.slots:
            token = plan.token(slot[0])
            values = ", ".join(f"{name}={value}" for name, value in token.parameters.items())
            start, end = (f"{_bound(b[0])} to {_bound(b[1])}" for b in (token.start, token.end))
            console.print(f"  {token.predicate}({values})  start {start}, end {end}", markup=False)


def _bound(bound: int | None) -> str:
    return "any time" if bound is None else str(bound)


def print_summary(summary: dict[str, Any], folder: Path) -> None:
    """Outcome, goals, plans, faults, and where to look."""
    console = Console(highlight=False, markup=False, soft_wrap=True)
    width = min(_WIDEST, shutil.get_terminal_size().columns)
    outcome = summary["outcome"]
    console.print(Text.assemble(f"{summary['scenario']}, seed {summary['seed']}: ", (outcome, _OUTCOMES[outcome])))
    promise = "not what" if summary["unmet"] else "as good as"
    console.print(_wrapped(f"{MEANT[outcome]}; {promise} the scenario promises", width, "  "))
    console.print(_wrapped(f"about: {summary['about']}", width, "  "))
    widest = max((len(goal["id"]) for goal in summary["goals"]), default=0)
    for goal in summary["goals"]:
        at = "" if goal["time"] is None else f" at {clock(goal['time'])}"
        status = (f"{goal['status']:9}", _COLOURS.get(goal["status"], ""))
        console.print(Text.assemble(f"  {goal['id']:{widest}}  ", status, at))
        if goal["reason"]:
            console.print(_wrapped(in_words(goal["reason"]), width, " " * (widest + 4)))
    for line in _lines(summary):
        console.print(_wrapped(line, width))
    for what, name in (("recording", RECORDING), ("report", REPORT), ("summary", SUMMARY)):
        console.print(f"{what:9} {folder / name}")


def _lines(summary: dict[str, Any]) -> Iterator[str]:
    for plan in summary["plans"]:
        start, end = plan["horizon"]
        yield (
            f"{plan['id']}: {clock(start)} to {clock(end)}, {plan['tokens']} tokens, {plan['constraints']} "
            f"constraints, found in {plan['solve_seconds']:.2f} s; why: {plan['reason']}"
        )
    for fault in summary["faults"]:
        yield f"fault {fault_line(fault)}"
    rules = summary["flight_rules"]
    yield f"flight rules broken: {len(rules['violations']) or 'none'}, {rules['checked']} were watched every second"
    for violation in rules["violations"]:
        yield f"  {violation['rule']} from {clock(violation['start'])} to {clock(violation['end'])}"
    yield from (f"not as declared: {words}" for words in summary["unmet"])
    speed = summary["sim"]["realtime_factor"]
    flown, wall = clock(summary["sim"]["sim_seconds"]), summary["wall_seconds"]
    yield f"{flown} flown in {wall:.1f} s, {speed:.0f} times real time"


def fault_line(fault: dict[str, Any]) -> str:
    """One fault of a summary in a line."""
    when = "was not injected" if fault["injected"] is None else f"injected at {clock(fault['injected'])}"
    if fault["detected"] is None:
        return f"{fault['name']}: {when}, not detected"
    diagnosis = f", taken for {fault['diagnosis']}" if fault["diagnosis"] else ""
    return f"{fault['name']}: {when}, detected at {clock(fault['detected'])}{diagnosis}, response: {fault['response']}"


def _wrapped(text: str, width: int, indent: str = "") -> str:
    return textwrap.fill(
        text,
        max(width, len(indent) + 40),
        initial_indent=indent,
        subsequent_indent=indent or "  ",
        break_long_words=False,
        break_on_hyphens=False,
    )
