"""The operations one by one: verdicts, names, what goes and what comes back."""

from __future__ import annotations

import pytest

from planner.domains import Interval
from planner.operations import Operation, Operations, Refusal
from planner.operations.retraction import Retraction
from planner.tokens.token import Token
from tests.planner.operations.worlds import altern, camera, switches


def issued(done: Operation | Refusal) -> Operation:
    assert isinstance(done, Operation)
    return done


def named(operations: Operations, name: str) -> Token:
    found = operations.database.tokens.named(name)
    assert found is not None
    return found


def test_what_a_token_asks_for_goes_with_it_and_operations_on_it_sleep() -> None:
    operations = Operations(camera())
    picture = issued(operations.insert("ida", "camera"))
    assert {"ida/off0", "ida/ready4"} <= set(operations.open_tokens())
    off = issued(operations.insert("ida/off0", "engine"))
    operations.undo(picture)
    assert "ida/off0" not in operations.open_tokens()
    assert operations.dormant == (off,)
    again = issued(operations.insert("ida", "camera"))
    assert operations.in_force == (off, again)


def test_an_inconsistent_operation_is_refused_and_explained() -> None:
    operations = Operations(altern())
    operations.insert("first", "rover")
    before = operations.open_tokens()
    refused = operations.insert("last", "rover", 0)
    assert isinstance(refused, Refusal)
    assert not refused
    assert refused.explanation
    assert operations.open_tokens() == before
    assert len(operations.issued) == 1


def test_what_makes_no_sense_is_an_error() -> None:
    operations = Operations(altern())
    first = issued(operations.insert("first", "rover"))
    with pytest.raises(ValueError, match="expected an open token, found it active"):
        operations.insert("first", "rover")
    with pytest.raises(ValueError, match="'nothing': expected the name of a single token"):
        operations.insert("nothing", "rover")
    with pytest.raises(ValueError, match="expected a position from 0 to 1, found 2"):
        operations.insert("last", "rover", 2)
    operations.undo(first)
    with pytest.raises(ValueError, match="expected an operation that is not undone"):
        operations.undo(first)


def duration_decides() -> tuple[Operations, Operation]:
    """A step whose size equals its duration, which its end decides."""
    operations = Operations(switches())
    operations.insert("two", "line2")
    operations.insert("two/2:step0", "line2")
    token = named(operations, "two/2:step0")
    operations.restrict(token.start, Interval(2, 2))
    end = issued(operations.restrict(token.end, Interval(5, 5)))
    operations.restrict(named(operations, "one").end, Interval(0, 30))
    assert repr(token.parameters["size"].domain) == "[3 3]"
    return operations, end


def test_what_was_derived_from_times_goes_with_them() -> None:
    operations, end = duration_decides()
    operations.undo(end)
    assert repr(named(operations, "two/2:step0").parameters["size"].domain) == "[1 5]"


def test_a_reader_of_times_forgotten_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Retraction, "_review_readers_of_time", lambda _: None)
    with pytest.raises(AssertionError, match=r"\[3 3\]"):
        test_what_was_derived_from_times_goes_with_them()


def test_the_order_on_a_timeline_stays_when_what_lay_between_goes() -> None:
    operations = Operations(camera())
    operations.insert("thrusting", "engine")
    middle = issued(operations.insert("again", "engine", 1))
    operations.insert("ida", "camera")
    operations.insert("ida/off0", "engine", 2)
    operations.undo(middle)
    [line] = [t for t in operations.database.tokens.timelines.values() if t.sequence and t.object.name == "engine"]
    assert [token.name for token in line.sequence] == ["thrusting", "ida/off0"]
    thrusting, off = line.sequence
    assert operations.database.temporal.distance(thrusting.end.timepoint, off.start.timepoint)[0] >= 0
