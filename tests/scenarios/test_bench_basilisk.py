"""The slew that is flown beside Basilisk: against what Basilisk gave, and against itself where it is installed."""

from __future__ import annotations

import sys

import pytest

from scenarios.benchmarks import basilisk
from sim.assembly import load_assembly

# Attitude (MRP) at the end of the slew in Basilisk 2.12.1.
BASILISK_END = (0.19911977, 0.29248136, 0.09693966)


def test_our_slew_ends_where_that_of_basilisk_does() -> None:
    taken, end = basilisk.fly_ours(load_assembly(basilisk.STEP_S))
    assert taken > 0.0
    assert end.tolist() == pytest.approx(BASILISK_END, abs=1e-8)


def test_without_basilisk_there_is_a_reason_instead_of_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "Basilisk", None)
    figures = basilisk.figures(repeats=1)
    assert "pip install bsk" in figures.pop("reason")
    assert set(figures.values()) == {None}


def test_with_basilisk_both_slews_are_the_same() -> None:
    pytest.importorskip("Basilisk", reason="needs bsk")
    assert basilisk.figures(repeats=1)["attitudes_apart_rad"] < 1e-9
