"""How soon one value can follow another: known answers on a small spacecraft, and what the search makes of them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest

from planner.checker import check
from planner.constraints.procedure import ConstraintProcedure
from planner.constraints.standard import STANDARD
from planner.domains import Domain, Values
from planner.language.builder import ModelBuilder
from planner.model.manager import ModelManager
from planner.planning import plan
from planner.problem import Goal, Problem, TokenPattern
from planner.search.engines import ENGINES
from planner.search.outcome import Limits

TURNS = {("a", "b"): 30, ("b", "c"): 40, ("a", "c"): 90, ("a", "a"): 5, ("b", "b"): 5, ("c", "c"): 5}
TURNS |= {(there, here): ticks for (here, there), ticks in TURNS.items()}


def turn_duration() -> ConstraintProcedure:
    def narrow(domains: Sequence[Domain]) -> Sequence[Domain] | None:
        """duration = TURNS[origin, target]."""
        origin, target, duration = domains
        assert isinstance(origin, Values)
        assert isinstance(target, Values)
        left = [(o, t) for o in origin.values() for t in target.values() if TURNS[o, t] in duration]
        if not left:
            return None
        ticks = [TURNS[pair] for pair in left]
        return (
            origin.keep(o for o, _ in left),
            target.keep(t for _, t in left),
            duration.bounded(min(ticks), max(ticks)),
        )

    return ConstraintProcedure("turnTakes", narrow, 3, 3)


def pointing_model() -> ModelManager:
    """Pointing and turning in turns, a picture that needs pointing, and a lamp about which nothing is said."""
    model = ModelBuilder("pointing", STANDARD.with_procedures(turn_duration()))
    model.enumeration("Target", ["a", "b", "c"])
    attitude = model.component("Attitude", ["mode"])
    camera = model.component("Camera", ["mode"])
    lamp = model.component("Lamp", ["mode"])
    for name in ("Attitude", "Camera", "Lamp"):
        model.object(name.lower(), name)
    point = attitude.predicate("point", {"target": "Target"}, attribute="mode", duration=(2, math.inf))
    turn = attitude.predicate("turn", {"origin": "Target", "target": "Target"}, attribute="mode")
    with point.requires() as this:
        this.met_by(turn, target=this.target)
        this.meets(turn, origin=this.target)
    with turn.requires() as this:
        this.require(this.origin != this.target)
        this.constrain("turnTakes", this.origin, this.target, this.duration)
        this.met_by(point, target=this.origin)
        this.meets(point, target=this.target)
    picture = camera.predicate("picture", {"target": "Target"}, attribute="mode", duration=(3, 3))
    with picture.requires() as this:
        this.contained_by(point, target=this.target)
    lamp.predicate("on", attribute="mode")
    return model.finish()


def gap(model: ModelManager, predicate: str, first: str, second: str) -> float:
    declared = model.predicate_named(predicate)
    graph = model.transitions_of(declared.cls, declared.attribute)
    targets = model.enumerations["Target"]
    one, two = (targets.domain(list(letters)) for letters in (first, second))
    return graph.least_gap(declared, [one], declared, [two])


@pytest.mark.parametrize(
    ("first", "second", "ticks"),
    [
        ("a", "b", 30),
        ("a", "c", 72),  # by way of b, where the spacecraft points for 2
        ("c", "a", 72),
        ("a", "a", 62),  # there and back: it does not turn to where it points
        ("a", "bc", 30),
        ("abc", "abc", 30),
    ],
)
def test_the_shortest_way_from_pointing_to_pointing(first: str, second: str, ticks: float) -> None:
    assert gap(pointing_model(), "Attitude.point", first, second) == ticks


def test_pictures_are_as_far_apart_as_their_pointings() -> None:
    model = pointing_model()
    assert gap(model, "Camera.picture", "a", "c") == 72
    assert gap(model, "Camera.picture", "a", "a") == 0
    assert gap(model, "Camera.picture", "ab", "bc") == 0
    graph = model.transitions_of("Camera", "mode")
    assert [(thing.name, attribute) for thing, attribute in graph.around] == [("attitude", "mode")]


def test_a_timeline_without_an_order_is_free() -> None:
    assert pointing_model().transitions_of("Lamp", "mode").is_free


def pictures(*windows: tuple[str, int, int], facts: tuple[TokenPattern, ...] = ()) -> Problem:
    goals = tuple(
        Goal(f"{n}", TokenPattern("Camera.picture", parameters={"target": t}, start=(s, None), end=(None, e)))
        for n, (t, s, e) in enumerate(windows)
    )
    state = () if facts else (TokenPattern("Attitude.point", parameters={"target": "a"}),)
    return Problem((0, 400), state, facts, goals)


@pytest.mark.parametrize("engine", ENGINES)
def test_what_cannot_be_reached_in_time_is_seen_before_the_way_is_tried(engine: str) -> None:
    """From a picture of a to one of c within 60 ticks: whatever is pointed at in between, the way takes 72."""
    result = plan(pointing_model(), pictures(("a", 50, 60), ("c", 60, 115)), engine=engine)
    assert result.plan is not None
    assert result.dropped[0].kind == "outbid"
    assert result.statistics.steps < 200
    reached = plan(pointing_model(), pictures(("a", 50, 60), ("c", 60, 128)), engine=engine)
    assert reached.plan is not None
    assert not reached.dropped
    assert not check(reached.plan, pointing_model(), pictures(("a", 50, 60), ("c", 60, 128)))


def test_a_fact_asks_for_nothing_to_follow() -> None:
    """Somebody else points the spacecraft: after what is said to be true, no turn is needed."""
    facts = tuple(
        TokenPattern("Attitude.point", parameters={"target": t}, start=(s, s), end=(e, e))
        for t, s, e in (("a", 0, 60), ("c", 61, 400))
    )
    problem = pictures(("a", 50, 60), ("c", 60, 115), facts=facts)
    result = plan(pointing_model(), problem, Limits(max_steps=2000))
    assert result.plan is not None
    assert not result.dropped
    assert not check(result.plan, pointing_model(), problem)
