"""Reading a recording back, and small plans and entries to record."""

from __future__ import annotations

import re
import warnings
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
from rerun.chunk import RrdReader

from planner.plan import FlexiblePlan, PlanTimeline, PlanToken
from scenarios.recording import RunRecorder, Scene

HEADER = "/mission/0_plan_planner_fault_goals"


class Recorded:
    """All rows of a recording: times in simulation seconds, and values by entity path and component."""

    def __init__(self, path: Path) -> None:
        self.times: dict[str, list[int]] = defaultdict(list)
        self.values: dict[tuple[str, str], list[tuple[int, Any]]] = defaultdict(list)
        self.static: dict[str, set[str]] = defaultdict(set)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self.chunks = list(RrdReader(path).stream())
        for chunk in self.chunks:
            batch, name = chunk.to_record_batch(), str(chunk.entity_path)
            if chunk.is_static:
                self.static[name].update(batch.schema.names)
                continue
            assert "sim_time" in batch.schema.names
            nanoseconds = np.array(batch.column("sim_time").cast("int64").to_pylist(), np.int64)
            assert not (nanoseconds % 1_000_000_000).any()
            seconds = (nanoseconds // 1_000_000_000).tolist()
            self.times[name] += seconds
            for column in batch.schema.names:
                if ":" in column:
                    rows = zip(seconds, batch.column(column).to_pylist(), strict=True)
                    self.values[name, column.split(":")[1]] += [row for row in rows if row[1] is not None]

    def lane(self, name: str) -> list[tuple[int, list[str]]]:
        rows = self.values[name, "state"]
        assert [t for t, _ in rows] == sorted({t for t, _ in rows}), f"{name}: times must ascend"
        return rows

    def shown(self, name: str, time: int) -> list[str]:
        return [states for t, states in self.lane(name) if t <= time][-1]

    def texts(self, name: str = "/log") -> list[str]:
        return [row[0] for _, row in self.values[name, "text"]]


def token(name: str, predicate: str, start: Any, end: Any, **fields: Any) -> PlanToken:
    return PlanToken(name, "sc", "mode", predicate, {}, start, end, (0, None), **fields)


def plan_of(*tokens: PlanToken) -> FlexiblePlan:
    line = PlanTimeline("sc", "mode", tuple((t.id,) for t in tokens))
    return FlexiblePlan("small", (0, 1000), ("sc",), (line,), tokens, ())


def event(time: int, kind: str, **fields: Any) -> dict[str, Any]:
    return {"t": time, "event": kind, **fields}


def of_token(time: int, kind: str, plan: str, name: str, predicate: str, **fields: Any) -> dict[str, Any]:
    common = {"plan": plan, "token": name, "object": "sc", "attribute": "mode", "predicate": predicate}
    return event(time, kind, **common, parameters={}, **fields)


def small(path: Path, horizon: tuple[int, int] = (0, 1000), **fields: Any) -> RunRecorder:
    return RunRecorder(path, Scene(), 0.0, horizon, ["sc.mode"], (), **fields)


def labels(states: list[str]) -> list[str]:
    """What a row shows without the identity of tokens."""
    return [re.sub(r"[#@].*", "", state) for state in states]
