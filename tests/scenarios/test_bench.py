"""`remote-agent bench`: figures as a table and as JSON, on a benchmark that costs nothing."""

from __future__ import annotations

import json

import pytest

from scenarios.benchmarks import registry
from scenarios.tables import lines
from tests.scenarios.commands import remote_agent

FIGURES = {"ratio": 0.98765, "by_size": {"10": 1, "200": 2.5}, "rows": [{"n": 10, "us": 1.25}, {"n": 200, "us": 3}]}


def test_figures_as_text() -> None:
    assert list(lines(FIGURES)) == [
        "ratio: 0.9877",
        "by_size:",
        "  10: 1",
        "  200: 2.5",
        "rows:",
        "    n    us",
        "   10  1.25",
        "  200     3",
    ]


def test_unknown_benchmark() -> None:
    ended = remote_agent("bench", "temporl", "--json")
    assert ended.status == 2
    assert ended.out == ""
    assert "did you mean temporal?" in ended.err


def test_several_modules_are_nested(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenarios.benchmarks.temporal.measure", lambda: {"us_per_op": {"200": 1.0}})
    monkeypatch.setattr("scenarios.benchmarks.operations.measure", lambda: {"rows": []})
    both = registry.Benchmark("both", "", ("temporal", "operations"))
    assert json.loads(json.dumps(both.measure())) == {"us_per_op": {"200": 1.0}, "operations": {"rows": []}}
