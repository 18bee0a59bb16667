"""Problems of Deep Space 1 that searches once lost themselves in."""

from __future__ import annotations

import pytest

from executive.network import conflict_of
from planner.checker import check
from planner.planning import plan
from planner.problem import Goal, Problem, TokenPattern
from planner.search.engines import ENGINES
from planner.search.outcome import Limits
from scenarios.config import load
from scenarios.ds1.bindings import FOREVER_S
from scenarios.goals import model_of

STATE = (
    TokenPattern("Attitude.point", parameters={"target": "earth"}),
    TokenPattern("Engine.standby"),
    TokenPattern("Camera.off"),
    TokenPattern("Camera.switchedOff"),
    TokenPattern("Engine.works", end=(FOREVER_S, None)),
)
GOALS = (
    Goal(
        "session",
        TokenPattern("Navigation.session", parameters={"target": "asteroid_b"}, start=(2400, None), end=(None, 7200)),
    ),
    Goal("downlink", TokenPattern("Radio.downlink", start=(5400, None), end=(None, 10800), duration=(600, None))),
)


@pytest.mark.parametrize("engine", ENGINES)
def test_no_longer_and_longer_chains_of_turns(engine: str) -> None:
    """The downlink cannot share the first pointing at earth: 20,000 steps of intermediate pointings did not show it."""
    model, problem = model_of(load("opnav-12h"), "opnav-12h"), Problem((0, 10800), STATE, (), GOALS)
    result = plan(model, problem, Limits(max_steps=1000), conflict_of, engine)
    assert result.plan is not None, result.reason
    assert not result.dropped
    assert not check(result.plan, model, problem)
    assert conflict_of(result.plan) is None
