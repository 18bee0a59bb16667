"""Numbers without end get values that keep the plan complete, and stay open where none of those tried does."""

from __future__ import annotations

import pytest

from planner.checker import check
from planner.constraints.standard import STANDARD
from planner.database import PlanDatabase
from planner.domains import Interval
from planner.extraction import extract
from planner.language.nddl.builder import load_text
from planner.search.endless import assign_endless
from planner.search.engines import ENGINES
from planner.search.flaws import next_flaw
from planner.search.outcome import Limits

LAMP = "class Lamp extends Timeline { predicate on { float level; } predicate off {} } Lamp lamp = new Lamp(); "
LAMP += "goal(lamp.on t); leq(t.end, 20);"


def planned(text: str) -> PlanDatabase:
    """The database of a text's plan, with its endless numbers assigned."""
    model, program, report = load_text(text, STANDARD)
    database = PlanDatabase(model, (0, 100))
    program.carry_out(database, report)
    assert ENGINES["chronological"].search(database, Limits(500, 10.0), assign_endless).complete
    assert next_flaw(database) is None
    return database


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("", 0),
        ("leq(3.5, t.level);", 3.5),
        ("leq(t.level, -2.0);", -2),
        ("lt(1.0, t.level); leq(t.level, 3.0); neq(t.level, 3.0); neq(t.level, 1.0);", 2),
        ("neq(t.level, 0.0);", 1),
        ("t.level + 3.0 == 16.0;", 13),
    ],
)
def test_a_number_gets_a_value_that_fits(text: str, value: float) -> None:
    database = planned(LAMP + text)
    plan = extract(database)
    assert plan.tokens[0].parameters == {"level": pytest.approx(value)}
    assert check(plan, database.model) == ()


def test_a_value_that_asks_for_more_than_there_is_in_the_plan_is_not_taken() -> None:
    rule = "Lamp::on { if (level == 0.0 || level == 9.0) { met_by(off o); } }"
    database = planned(rule + LAMP + "eq(t.start, 10);")
    plan = extract(database)
    assert [token.predicate for token in plan.tokens] == ["Lamp.on"]
    assert plan.tokens[0].parameters["level"] != 0
    assert check(plan, database.model) == ()


def test_a_number_stays_open_where_no_value_tried_is_right() -> None:
    odd = " ".join(f"neq(t.level, {value}.0);" for value in (-1, 0, 1))
    (token,) = planned(LAMP + odd).tokens.tokens
    assert token.parameters["level"].domain == Interval(float("-inf"), float("inf"), integer=False)
