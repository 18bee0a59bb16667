"""From plan to network: what is a requirement, what nature decides, what holds already, and what may last."""

from __future__ import annotations

from dataclasses import replace

from executive.network import PlanNetwork, conflict_of
from planner.constraints.standard import STANDARD
from planner.language.builder import ModelBuilder
from planner.plan import FlexiblePlan, PlanConstraint, PlanToken
from planner.planning import plan as make_plan
from planner.problem import Goal, Problem, TokenPattern
from planner.temporal.controllability import check
from planner.temporal.stnu import Link
from tests.executive.scripted import Draft, layout

STATE = (TokenPattern("Attitude.holding", "acs", {"target": "earth"}), TokenPattern("Camera.idle", "camera"))
PROBLEM = Problem((100, 200), STATE, goals=(Goal("image-vesta", TokenPattern("Camera.imaging")),))
LINE = ("a", "b")


def links(network: PlanNetwork, from_: str, to: str) -> list[tuple[int | None, int | None, bool]]:
    found = []
    for link in network.stnu.links:
        if (link.from_, link.to) == (network.index[from_], network.index[to]):
            assert not isinstance(link.min, float)
            found.append((link.min, link.max, link.contingent))
    return found


def test_durations_constraints_and_horizon() -> None:
    network = PlanNetwork.of(layout(PROBLEM))
    assert links(network, "t4.start", "t4.end") == [(5, 20, True)]
    assert links(network, "t5.start", "t5.end") == [(0, None, False)]
    assert links(network, "t4.end", "t5.start") == [(0, 0, False)]
    assert links(network, "origin", "t1.start") == [(100, 100, False)]
    assert links(network, "origin", "t1.end") == [(100, None, False)]
    assert network.begun == {"t1": 100, "t2": 100}
    assert check(network.stnu).controllable


def test_propagated_ends_of_what_nature_decides_are_no_requirements() -> None:
    """The turn's end is propagated to at most 112; as a promise, no start could keep it against [5, 20]."""
    draft = Draft((100, 200))
    draft.token(LINE, "A.rest", (0, 5))
    turn = draft.token(LINE, "A.turn", (5, 20), contingent=True, master="t1")
    network = PlanNetwork.of(draft.plan())
    assert draft.plan().token(turn).end == (105, 125)
    assert check(network.stnu).controllable
    tight = replace(draft.plan(), tokens=tuple(replace(t, end=(105, 112)) for t in draft.plan().tokens))
    assert check(PlanNetwork.of(tight).stnu).controllable


def test_start_bounds_are_requirements() -> None:
    draft = Draft((0, 100))
    draft.token(LINE, "A.rest")
    draft.token(LINE, "A.work", master="t1")
    tokens = tuple(replace(t, start=(30, 40)) if t.id == "t2" else t for t in draft.plan().tokens)
    network = PlanNetwork.of(replace(draft.plan(), tokens=tokens))
    assert links(network, "origin", "t2.start") == [(30, 40, False)]


def test_codesignated_tokens_share_their_hosts_timepoints() -> None:
    draft = Draft((0, 100))
    draft.token(LINE, "A.rest")
    host = draft.token(LINE, "A.work", (3, 4), master="t1")
    plan = draft.plan()
    merged = replace(plan.token(host), id="t9", goal="g")
    lines = tuple(replace(line, slots=(("t1",), (host, "t9"))) for line in plan.timelines)
    network = PlanNetwork.of(replace(plan, timelines=lines, tokens=(*plan.tokens, merged)))
    assert network.index["t9.start"] == network.index[f"{host}.start"]
    assert network.stnu.timepoints == ("origin", "t1.start", "t1.end", "t2.start", "t2.end")


def test_only_what_the_state_gave_has_begun() -> None:
    """A token that a rule asked for may have to start at the very opening: it still has to be started."""
    draft = Draft((50, 100))
    draft.token(LINE, "A.rest", (0, 0))
    draft.token(LINE, "A.work", master="t1")
    plan = draft.plan()
    forced = tuple(replace(t, start=(50, 50)) for t in plan.tokens)
    assert PlanNetwork.of(replace(plan, tokens=forced)).begun == {"t1": 50}
    earlier = tuple(replace(t, start=(20, 30)) for t in plan.tokens if t.id == "t1") + plan.tokens[1:]
    assert PlanNetwork.of(replace(plan, tokens=earlier)).begun == {"t1": 30}
    unbounded = tuple(replace(t, start=(None, None)) for t in plan.tokens)
    assert PlanNetwork.of(replace(plan, tokens=unbounded)).begun == {"t1": 50}


def test_facts_keep_their_bounds() -> None:
    fact = PlanToken("t1", "sun", "light", "Sun.eclipse", {}, (40, 45), (60, 70), (15, 30), fact=True)
    draft = Draft((0, 100), {"t1": fact}, {("sun", "light"): ["t1"]})
    plan = replace(draft.plan(), tokens=(fact,))
    network = PlanNetwork.of(plan)
    assert links(network, "origin", "t1.start") == [(40, 45, False)]
    assert links(network, "origin", "t1.end") == [(60, 70, False)]
    assert network.begun == {}


def loose_plan(end_apart: tuple[int | None, int | None]) -> FlexiblePlan:
    """A last token on a timeline, and a use of a resource with it."""
    draft = Draft((0, 100))
    draft.token(LINE, "A.rest")
    draft.token(LINE, "A.work", master="t1")
    plan = draft.plan()
    use = replace(plan.token("t2"), id="t3", object="power", attribute="", predicate="Reusable.uses")
    idle = replace(use, id="t4")
    same = PlanConstraint("t2.start", "t3.start", 0, 0, "equals")
    end = PlanConstraint("t2.end", "t3.end", *end_apart, "equals")
    return replace(plan, tokens=(*plan.tokens, use, idle), constraints=(*plan.constraints, same, end))


def test_tokens_outside_of_timelines_take_part_if_a_constraint_names_them() -> None:
    network = PlanNetwork.of(loose_plan((0, 0)))
    assert network.stnu.timepoints[-2:] == ("t3.start", "t3.end")
    assert "t4.end" not in network.index


def test_what_lasts() -> None:
    def lasting(plan: FlexiblePlan) -> set[str]:
        network = PlanNetwork.of(plan)
        return {network.stnu.timepoints[place] for place in network.lasting}

    assert lasting(loose_plan((0, 0))) == {"t2.end", "t3.end"}
    assert lasting(loose_plan((0, None))) == {"t2.end", "t3.end"}
    assert lasting(loose_plan((None, 0))) == {"t2.end"}
    plan = loose_plan((0, 0))
    goal = tuple(replace(t, goal="g") if t.id == "t2" else t for t in plan.tokens)
    assert lasting(replace(plan, tokens=goal)) == set()
    natural = tuple(replace(t, contingent=True, duration=(1, 2)) if t.id == "t2" else t for t in plan.tokens)
    assert lasting(replace(plan, tokens=natural)) == set()
    awaited = PlanConstraint("t2.end", "t4.start", 5, 9, "after")
    assert lasting(replace(plan, constraints=(*plan.constraints, awaited))) == set()


def test_a_conflict_is_told_in_the_words_of_the_plan() -> None:
    network = PlanNetwork.of(layout(PROBLEM, latest_end=4))
    verdict = check(network.stnu)
    assert not verdict.controllable
    told = network.explain(verdict.conflict)
    assert "duration of camera.mode Camera.imaging, decided by nature" in told
    assert "image-vesta soon: start of Attitude.holding (t5) to end of Camera.imaging (t3) in [any, 4]" in told
    assert "turning" not in told


def test_a_timepoint_apart_from_itself_is_never_satisfied() -> None:
    draft = Draft((0, 100))
    host = draft.token(LINE, "A.rest")
    plan = draft.plan()
    lines = tuple(replace(line, slots=((host, "t9"),)) for line in plan.timelines)
    plan = replace(plan, tokens=(*plan.tokens, replace(plan.token(host), id="t9")), timelines=lines)
    same = PlanConstraint(f"{host}.start", "t9.start", 0, 3, "same")
    apart = PlanConstraint(f"{host}.start", "t9.start", 1, 3, "apart")
    assert check(PlanNetwork.of(replace(plan, constraints=(same,))).stnu).controllable
    network = PlanNetwork.of(replace(plan, constraints=(apart,)))
    verdict = check(network.stnu)
    assert not verdict.controllable
    assert "apart (t1.start to t9.start)" in network.explain(verdict.conflict)
    assert Link(0, 1, 1, 0) in network.stnu.links


def test_a_conflict_is_what_of_the_plan_makes_it() -> None:
    """The image may take 8 ticks and has to be over within 4 of the turn: that and its being held on target."""
    plan = layout(PROBLEM, latest_end=4)
    conflict = conflict_of(plan)
    assert conflict is not None
    assert conflict.tokens == ("t3", "t5")
    assert conflict.contingent == ("t3",)
    assert [(c.from_, c.to, c.min, c.max, c.why) for c in conflict.constraints] == [
        ("t5.start", "t3.start", 0, None, "image-vesta while holding"),
        ("t5.start", "t3.end", None, 4, "image-vesta soon"),
    ]
    assert "duration of camera.mode Camera.imaging, decided by nature" in conflict.text
    kept = tuple(c for c in plan.constraints if c not in conflict.constraints)
    for constraint in conflict.constraints:
        without = replace(plan, constraints=(*kept, *(c for c in conflict.constraints if c != constraint)))
        assert conflict_of(without) is None


def test_a_controllable_plan_has_no_conflict() -> None:
    assert conflict_of(layout(PROBLEM)) is None


def test_a_plan_that_is_no_network_is_a_conflict() -> None:
    plan = layout(PROBLEM)
    tokens = tuple(replace(t, duration=(9, 3)) if t.id == "t3" else t for t in plan.tokens)
    conflict = conflict_of(replace(plan, tokens=tokens))
    assert conflict is not None
    assert conflict.text.startswith("the plan is not a network: ")


def test_the_elapsed_time_of_what_is_running_is_taken_off() -> None:
    """An image that began 8 ticks before the plan and is not over lasts at least those 8, and still at most 40."""
    draft = Draft((100, 200))
    pattern = TokenPattern("Camera.imaging", start=(92, 92), duration=(3, 40), contingent=True)
    draft.given(LINE, pattern)
    draft.token(LINE, "Camera.idle", master="t1")
    network = PlanNetwork.of(draft.plan())
    assert links(network, "origin", "t1.start") == [(92, 92, False)]
    assert links(network, "t1.start", "t1.end") == [(8, 40, True)]
    assert network.begun == {"t1": 92}
    assert check(network.stnu).controllable


def test_a_constraint_token_ties_what_it_keeps_apart() -> None:
    """It is on no timeline; the network has its ends, since the order of other tokens hangs on them."""
    builder = ModelBuilder("lamps", STANDARD)
    lamp, stage = builder.timeline("Lamp"), builder.timeline("Stage")
    dark = lamp.predicate("dark")
    lamp.predicate("bright", duration=(5, 5))
    with stage.predicate("play", duration=(10, 20)).requires() as this:
        this.throughout(dark)
    for name in ("lamp", "stage"):
        builder.object(name, name.capitalize())
    goals = Goal("play", TokenPattern("Stage.play")), Goal("bright", TokenPattern("Lamp.bright"))
    plan = make_plan(builder.finish(), Problem((0, 60), goals=goals)).plan
    assert plan is not None
    network = PlanNetwork.of(plan)
    kept = next(t.id for t in plan.tokens if t.allowed is not None)
    lit = next(t.id for t in plan.tokens if t.goal == "bright")
    play = next(t.id for t in plan.tokens if t.goal == "play")
    assert links(network, f"{play}.start", f"{kept}.start") == [(0, 0, False)]
    assert links(network, f"{lit}.end", f"{kept}.start") == [(0, None, False)]
    assert check(network.stnu).controllable
