"""Journal entries in a reader's words: the level and text of each, and a page that says how things stand."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from scenarios.recording.style import elapsed, token_label

Entry = Mapping[str, Any]
SILENT = frozenset({"observation", "bounds", "timepoint.executed"})


def _fields(entry: Entry, *skip: str) -> str:
    left = (f"{k}={_short(v)}" for k, v in entry.items() if k not in ("t", "event", *skip) and v not in (None, "", {}))
    return ", ".join(left)


def _short(value: object) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{k}={_short(v)}" for k, v in value.items())
    return str(value)


def _token(entry: Entry) -> str:
    if "predicate" not in entry:
        return str(entry.get("token", "?"))
    label = token_label(str(entry["predicate"]), entry.get("parameters") or {})
    return f"{entry.get('object', '?')}.{entry.get('attribute', '?')} {label} ({entry.get('token', '?')})"


def _because(entry: Entry) -> str:
    return f": {entry['reason']}" if entry.get("reason") else ""


def _goal(entry: Entry) -> tuple[str, str]:
    level = "INFO" if entry.get("status") == "achieved" else "WARN"
    return level, f"goal {entry.get('id')} {entry.get('status')}{_because(entry)}"


def _finished(entry: Entry) -> tuple[str, str]:
    verdict = str(entry.get("verdict") or "on_time").replace("_", " ")
    return ("WARN" if verdict == "late" else "DEBUG"), f"ended {verdict}: {_token(entry)}"


def _acknowledged(entry: Entry) -> tuple[str, str]:
    if entry.get("accepted", True):
        return "TRACE", f"command {entry.get('id')} accepted"
    return "WARN", f"command {entry.get('id')} refused{_because(entry)}"


def _adopted(entry: Entry) -> tuple[str, str]:
    tokens = f", {entry['tokens']} tokens" if "tokens" in entry else ""
    handover = int(entry.get("handover", entry["t"]))
    start = f", in force from {elapsed(handover)}" if handover != entry["t"] else ""
    return "INFO", f"plan adopted: {entry.get('plan')}{tokens}{start}{_because(entry)}"


def _requested(entry: Entry) -> tuple[str, str]:
    attempt = f", attempt {entry['attempt']}" if entry.get("attempt", 1) != 1 else ""
    budget = f", {elapsed(int(entry['budget']))} to think" if "budget" in entry else ""
    return "INFO", f"plan requested{attempt}{budget}{_because(entry)}"


def _answered(entry: Entry) -> tuple[str, str]:
    """The planner's answer in a line: the plan itself is in its own file."""
    found = "a plan" if entry.get("content") else f"no plan{_because(entry)}"
    return "DEBUG", f"the planner answers with {found}, charged {entry.get('charged')} s"


def _detected(entry: Entry) -> tuple[str, str]:
    name = entry.get("name") or entry.get("monitor") or "fault"
    told = entry.get("text") or entry.get("diagnosis")
    return "ERROR", f"fault detected: {told} (monitor {name})" if told else f"fault detected: {name}"


_WORDS: dict[str, Callable[[Entry], tuple[str, str]]] = {
    "run.started": lambda e: ("INFO", f"run started: {e.get('scenario')}, seed {e.get('seed')}"),
    "run.finished": lambda e: ("INFO" if e.get("outcome") == "completed" else "WARN", f"run ended: {e.get('outcome')}"),
    "plan.requested": _requested,
    "plan.adopted": _adopted,
    "plan.answered": _answered,
    "plan.failed": lambda e: ("ERROR", f"no plan found{_because(e)}"),
    "goal": _goal,
    "token.started": lambda e: ("DEBUG", f"started: {_token(e)}"),
    "token.confirmed": lambda e: ("DEBUG", f"start confirmed: {_token(e)}"),
    "token.finished": _finished,
    "token.failed": lambda e: ("ERROR", f"failed: {_token(e)}{_because(e)}"),
    "token.aborted": lambda e: ("DEBUG", f"called off: {_token(e)}{_because(e)}"),
    "command.sent": lambda e: (
        "TRACE" if str(e.get("token", "")).startswith("probe") else "DEBUG",
        f"command {e.get('id')}: {e.get('name')}({_short(e.get('arguments') or {})}) for {e.get('token')}",
    ),
    "command.acknowledged": _acknowledged,
    "command.timeout": lambda e: ("DEBUG", f"command {e.get('id')} had no effect in time"),
    "violation": lambda e: ("DEBUG", f"violation, {e.get('kind')}: {_short(e.get('detail'))}"),
    "standby.entered": lambda e: ("WARN", f"standby{_because(e)}"),
    "standby.left": lambda e: ("DEBUG", "standby left"),
    "fault.injected": lambda e: ("ERROR", f"fault occurs, unknown aboard: {e.get('name')}"),
    "fault.detected": _detected,
    "fault.response": lambda e: ("INFO", f"response: {_short(e.get('response'))}"),
    "fault.recovered": lambda e: (
        "INFO",
        f"recovered: {e.get('monitor')}{'' if e.get('cured', True) else ', worked around'}",
    ),
    "fault.cleared": lambda e: ("INFO", f"fault is gone: {e.get('name')}"),
}


def line(entry: Entry) -> tuple[str, str] | None:
    """Log level and text of an entry, the text led by the elapsed time; None for entries the log does not show."""
    event = str(entry.get("event", ""))
    if event in SILENT:
        return None
    words = _WORDS.get(event)
    level, text = words(entry) if words else ("DEBUG", f"{event}: {_fields(entry)}")
    return level, f"{elapsed(int(entry['t']))}  {text}"


def situation(
    time: int,
    *,
    plan: str,
    running: Sequence[tuple[str, str]],
    goals: Mapping[str, str],
    faults: Sequence[tuple[str, str]],
    milestones: Sequence[str],
) -> str:
    """A markdown page of how things stand at `time`: plan, faults, what runs, goals, and what led here."""
    parts = [f"# {elapsed(time)}", f"**Plan in force:** {plan or 'none'}"]
    parts.append("## Faults\n" + ("\n".join(f"- **{text}**" for _, text in faults) or "none known"))
    parts.append("## Running\n" + ("\n".join(f"- {lane}: **{label}**" for lane, label in running) or "nothing"))
    if goals:
        order = ("active", "pending", "achieved", "dropped", "missed")
        groups = [(s, [g for g, status in goals.items() if status == s]) for s in order]
        parts.append("## Goals\n" + "\n".join(f"- **{s}** ({len(g)}): {', '.join(g)}" for s, g in groups if g))
    if milestones:
        parts.append("## What led here\n" + "\n".join(f"- {text}" for text in milestones))
    return "\n\n".join(parts)
