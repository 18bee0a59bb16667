"""A run's summary for a person at a terminal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from scenarios.folder import RECORDING, SUMMARY
from scenarios.times import clock

_COLOURS = {"achieved": "green", "dropped": "yellow", "missed": "red"}


def print_summary(summary: dict[str, Any], folder: Path) -> None:
    """Outcome, goals, plans, faults, and where to look."""
    console = Console(highlight=False)
    rules = summary["flight_rules"]
    console.print(f"[bold]{summary['scenario']}[/bold], seed {summary['seed']}: [bold]{summary['outcome']}[/bold]")
    goals = Table("goal", "status", "at", "reason", box=None, pad_edge=False)
    for goal in summary["goals"]:
        at = "" if goal["time"] is None else clock(goal["time"])
        colour = _COLOURS.get(goal["status"], "white")
        goals.add_row(goal["id"], f"[{colour}]{goal['status']}[/{colour}]", at, escape(goal["reason"] or ""))
    console.print(goals)
    for plan in summary["plans"]:
        start, end = plan["horizon"]
        console.print(
            f"{plan['id']}: {clock(start)} to {clock(end)}, {plan['tokens']} tokens, {plan['constraints']} constraints, "
            f"planned in {plan['solve_seconds']:.2f} s ({escape(plan['reason'])})"
        )
    for fault in summary["faults"]:
        when = "not injected" if fault["injected"] is None else f"injected {clock(fault['injected'])}"
        seen = "not detected" if fault["detected"] is None else f"detected {clock(fault['detected'])}"
        console.print(f"fault {fault['name']}: {when}, {seen}, {fault['diagnosis']}, {fault['response']}")
    console.print(f"flight rules: {len(rules['violations'])} violations of {rules['checked']} rules")
    for violation in rules["violations"]:
        console.print(f"  [red]{violation['rule']}[/red] from {clock(violation['start'])} to {clock(violation['end'])}")
    console.print(f"{summary['wall_seconds']:.1f} s of wall time, {summary['sim']['realtime_factor']:.0f} times real time")
    console.print(f"recording {folder / RECORDING}, summary {folder / SUMMARY}")
