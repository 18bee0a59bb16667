"""When timepoints are wanted inside their windows: as early as may be, as late, or near a preferred time."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from executive.bindings import Activity, Bindings, Near, Standby, Wish
from executive.conditions import Condition
from executive.errors import BindingsError
from executive.records import Settings
from executive.sends import Confirmation
from executive.simulate import simulate
from executive.wishes import slack_before
from planner.problem import PlanningResult
from planner.temporal.stnu import Stnu
from tests.executive.scripted import Draft, Run, ScriptedPlant, fly
from tests.strategies_stnu import tight_network

SAFE = Standby((), Confirmation((Condition("safe", "==", True),)))


def work(starts: Wish = "earliest", ends: Wish = "earliest", duration: tuple[int, int | None] = (10, 30)) -> Run:
    """Rest for 4 to 40 s, then work, then rest; a lamp shines exactly while the work lasts, and one surely after it."""
    draft = Draft((6, 200))
    draft.token(("unit", "mode"), "Unit.rest", (4, 40))
    done = draft.token(("unit", "mode"), "Unit.work", duration, {"best": 33}, master="t1")
    draft.token(("unit", "mode"), "Unit.rest", master="t1")
    draft.token(("lamp", "mode"), "Lamp.dark", (0, None))
    shining = draft.token(("lamp", "mode"), "Lamp.shine", (0, None), master="t4")
    draft.token(("lamp", "mode"), "Lamp.dark", (0, None), master="t4")
    draft.at(f"{done}.start", f"{shining}.start", 0, 0, "starts")
    draft.at(f"{done}.end", f"{shining}.end", 0, 0, "ends")
    bindings = Bindings(
        (Activity("Unit.work", ("best",), starts=starts, ends=ends),), SAFE, lambda telemetry, conclusions: ()
    )
    plant = ScriptedPlant({"safe": True}, {})
    return fly(plant, bindings, lambda problem: PlanningResult(draft.plan()), (), (0, 200), Settings(budget=5))


CASES: dict[str, tuple[Wish, Wish, int, int]] = {
    "as early as allowed": ("earliest", "earliest", 10, 20),
    "late start": ("latest", "earliest", 46, 56),
    "a late end has a late start": ("earliest", "latest", 46, 76),
    "both late": ("latest", "latest", 46, 76),
    "near a time inside the window": (Near(25), "earliest", 25, 35),
    "near a time before the window": (Near(3), "earliest", 10, 20),
    "near a time after the window": (Near(99), "earliest", 46, 56),
    "what the parameter says": (Near("$best"), "earliest", 33, 43),
    "so long after the start": (Near(25), Near(17, after_start=True), 25, 42),
    "longer than allowed": ("earliest", Near(55, after_start=True), 10, 40),
    "an end that its start has to wait for": ("earliest", Near(60), 30, 60),
}


@pytest.mark.parametrize("case", CASES)
def test_the_wanted_time_is_kept_as_far_as_the_window_allows(case: str) -> None:
    """Also what is tied to the timepoint waits: left to itself the lamp would come, and force it, at the earliest."""
    starts, ends, start, end = CASES[case]
    run = work(starts, ends)
    times = run.times()
    assert (times["t2.start"], times["t2.end"]) == (start, end)
    assert (times["t5.start"], times["t5.end"]) == (start, end)
    assert run.executive.dispatch.violations == {}


def test_an_end_without_a_bound_lasts_to_the_end_of_the_horizon_if_it_is_wanted_late() -> None:
    assert work(ends="latest", duration=(10, None)).times()["t2.end"] == 200


@given(st.integers(0, 10**6), st.integers(4, 40))
@settings(max_examples=40, deadline=None)
def test_no_wish_breaks_a_plan(seed: int, timepoints: int) -> None:
    """Whatever is wanted when, and whatever nature does: all requirements hold."""
    stnu, rng = tight_network(seed, timepoints), random.Random(seed)
    wanted = {place: rng.randint(-20, 200) for place in range(len(stnu.timepoints)) if rng.random() < 0.5}
    for place, time in list(wanted.items()):
        for other, slack in slack_before(stnu, place).items():
            wanted[other] = max(wanted.get(other, time - slack), time - slack)
    result = simulate(stnu, 10, seed=seed, choice=wanted)
    assert (result.satisfied, result.violations) == (10, {})


def test_slack_is_the_shortest_distance() -> None:
    stnu = Stnu.from_ticks(("a", "b", "c", "d"), [(0, 1, 2, 5, False), (1, 2, 3, 8, True), (2, 3, 0, 4, False)])
    assert slack_before(stnu, 3) == {3: 0, 2: 4, 1: 7, 0: 12}
    assert slack_before(stnu, 0) == {0: 0, 1: -2, 2: -5, 3: -5}


WRONG = {
    "another word": (lambda: Activity("A.x", starts="soon"), "activity 'A.x'.starts: expected 'earliest', 'latest'"),
    "before time began": (
        lambda: Activity("A.x", ends=Near(-1)),
        "activity 'A.x'.ends.seconds: .* at least 0, found -1",
    ),
    "no such parameter": (
        lambda: Activity("A.x", starts=Near("$y")),
        r"'A.x'.starts: unknown parameter '\$y'",
    ),
    "a start after itself": (
        lambda: Activity("A.x", starts=Near(5, after_start=True)),
        "activity 'A.x'.starts: only an end can be wanted some time after the start",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_wishes_that_cannot_be_are_refused(case: str) -> None:
    make, message = WRONG[case]
    with pytest.raises(BindingsError, match=message):
        make()
