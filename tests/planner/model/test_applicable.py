"""Which configuration constraints apply to values of attributes, and which come and go between two sets of them."""

from __future__ import annotations

import pytest

from planner.constraints.standard import STANDARD
from planner.errors import ModelError
from planner.language.builder import ModelBuilder
from planner.model.applicable import AttributeValue
from planner.model.manager import ModelManager
from planner.model.rules import Guard, Subgoal
from tests.planner.domains_small import camera_model, rover_model

IDA, GASPRA = (AttributeValue.of("Camera.picture", asteroid=name) for name in ("Ida", "Gaspra"))
OFF = AttributeValue.of("Engine.off")


def asked(model: ModelManager, value: AttributeValue) -> list[str]:
    """The predicates that the constraints on a value ask for, a guard that waits as its test."""
    return [
        s.predicate[1] if isinstance(s, Subgoal) else s.test
        for c in model.constraints_on([value])
        for s in c.statements
        if isinstance(s, Subgoal | Guard)
    ]


def test_the_constraint_of_figure_2_applies_to_each_picture() -> None:
    model = camera_model()
    (found,) = model.constraints_on([IDA, OFF])
    assert found.value == IDA
    assert found.rule is model.rules_for("Camera", "picture")[0]
    assert asked(model, IDA) == ["off", "pointAt", "ready", "ready"]
    assert len(model.constraints_on([IDA, GASPRA])) == 2
    assert model.constraints_on([]) == frozenset()


def test_what_comes_and_goes_between_two_sets_of_values() -> None:
    model = camera_model()
    come, go = model.constraint_changes([IDA, OFF], [OFF, GASPRA])
    assert {c.value for c in come} == {GASPRA}
    assert {c.value for c in go} == {IDA}
    assert model.constraint_changes([IDA, OFF], [IDA]) == (frozenset(), frozenset())


def test_parameters_decide_guards() -> None:
    model = rover_model()
    assert asked(model, AttributeValue.of("Rover.at", site="lake")) == ["at"]
    assert asked(model, AttributeValue.of("Rover.at", site="base")) == []
    assert asked(model, AttributeValue.of("Rover.at")) == ["eq"]
    (constraint,) = model.constraints_on([AttributeValue.of("Rover.at")])
    assert [guard.test for guard in constraint.waiting] == ["eq"]


def test_members_of_the_object_decide_guards() -> None:
    builder = ModelBuilder("pumps", STANDARD)
    pump, tank = builder.timeline("Pump", {"stages": "int", "tank": "Tank"}), builder.timeline("Tank", {"size": "int"})
    full = tank.predicate("full")
    run = pump.predicate("run")
    with run.requires() as this:
        with this.when(this.stages == 2) as double:
            double.after(full)
        with this.when(this.start == 5) as five:
            five.meets(run)
    large = builder.object("large", "Tank", {"size": 9})
    for stages in (1, 2):
        builder.object(f"pump{stages}", "Pump", {"stages": stages, "tank": large})
    with run.requires() as this, this.when(this.object == "pump1") as one:
        one.meets(run)
    model = builder.finish()
    # A time is never known of a value; a bare name of a member means the object's.
    assert "full" not in asked(model, AttributeValue.of("Pump.run", "pump1"))
    assert set(asked(model, AttributeValue.of("Pump.run", "pump2"))) == {"full", "eq"}
    assert asked(model, AttributeValue.of("Pump.run")).count("eq") == 3


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (AttributeValue.of("Camera.pictures"), "no predicate named 'pictures'; did you mean picture"),
        (AttributeValue.of("Camera.picture", asteroyd="Ida"), "no parameter 'asteroyd'; did you mean asteroid"),
        (AttributeValue.of("Camera.picture", asteroid="Mars"), "asteroid is 'Mars', expected one of {Gaspra, Ida}"),
        (
            AttributeValue.of("Camera.picture", "engine"),
            "object engine of class Engine has no predicate Camera.picture",
        ),
    ],
)
def test_a_value_that_there_is_not_is_an_error(value: AttributeValue, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        camera_model().constraints_on([value])
