"""Parsing what was printed gives the same tree."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, Phase, given, settings

from planner.language.nddl.errors import Report, Source
from planner.language.nddl.parser import parse
from planner.language.nddl.printer import render
from planner.language.nddl.syntax import Statement
from tests.planner.language.nddl.running import EXAMPLES
from tests.planner.language.nddl.trees import Sample, samples


def read(text: str) -> tuple[Statement, ...]:
    report = Report()
    found = parse(Source("test.nddl", text), report)
    assert not report.found, f"{text}\n{report.found[0]}"
    return found


@settings(
    max_examples=150,
    deadline=None,
    derandomize=True,
    suppress_health_check=list(HealthCheck),
    phases=[Phase.explicit, Phase.generate],  # the trees are small as they come
)
@given(samples())
def test_print_and_parse_is_the_identity(sample: Sample) -> None:
    same = read(sample.text) == sample.program
    assert same


@pytest.mark.parametrize(
    "path", sorted([*EXAMPLES.rglob("*.nddl"), *EXAMPLES.parent.glob("ds1/*.nddl")]), ids=lambda p: p.name
)
def test_examples(path: object) -> None:
    first = read(path.read_text())  # type: ignore[attr-defined]
    assert first
    assert read(render(first)) == first
