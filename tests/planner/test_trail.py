"""The trail: whatever is done through it in a level is undone with it, in any nesting."""

from __future__ import annotations

import copy
from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.trail import Trail


class Log:
    """A participant with a log of its own."""

    def __init__(self) -> None:
        self.entries: list[int] = []

    def mark(self) -> int:
        return len(self.entries)

    def undo_to(self, mark: int) -> None:
        del self.entries[mark:]


class World:
    """State of each kind that a trail can change."""

    def __init__(self) -> None:
        self.trail = Trail()
        self.log = Log()
        self.trail.join(self.log)
        self.list = [0, 1, 2]
        self.dictionary: dict[int, int] = {0: 0}
        self.attribute = 0
        self.set: set[int] = set()

    def change(self, kind: int, value: int) -> None:
        trail = self.trail
        if kind == 0:
            trail.set(self.list, value % len(self.list), value)
        elif kind == 1:
            trail.append(self.list, value)
        elif kind == 2:
            trail.assign(self, "attribute", value)
        elif kind == 3 and value not in self.dictionary:
            trail.add(self.dictionary, value, value)
        elif kind == 4:
            trail.set(self.dictionary, 0, value)
        elif kind == 5 and value not in self.set:
            self.set.add(value)
            trail.call(self.set.remove, value)
        elif kind == 6:
            self.log.entries.append(value)

    def picture(self) -> object:
        return copy.deepcopy((self.list, self.dictionary, self.attribute, self.set, self.log.entries))


CHANGES = st.tuples(st.just("change"), st.integers(0, 6), st.integers(0, 9))
STEPS = st.lists(st.one_of(CHANGES, st.just(("push",)), st.tuples(st.just("pop"), st.integers(0, 3))), max_size=40)


def run(steps: list[tuple[str, ...]], world: World) -> None:
    pictures: list[object] = []
    for step in steps:
        match step:
            case ("change", int(kind), int(value)):
                world.change(kind, value)
            case ("push",):
                assert world.trail.push() == len(pictures)
                pictures.append(world.picture())
            case ("pop", int(levels)) if pictures:
                depth = max(0, len(pictures) - 1 - levels)
                world.trail.pop_to(depth)
                assert world.picture() == pictures[depth]
                del pictures[depth:]
        assert world.trail.depth == len(pictures)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(STEPS)
def test_any_nesting_is_undone(steps: list[tuple[str, ...]]) -> None:
    run(steps, World())


def _forget_append(trail: Trail, container: list[int], value: int) -> None:
    container.append(value)


def _forget_set(trail: Trail, container: list[int], key: int, value: int) -> None:
    container[key] = value


def _forget_assign(trail: Trail, thing: object, attribute: str, value: object) -> None:
    setattr(thing, attribute, value)


@pytest.mark.parametrize(
    ("name", "forgetful"), [("append", _forget_append), ("set", _forget_set), ("assign", _forget_assign)]
)
def test_a_forgotten_record_is_seen(monkeypatch: pytest.MonkeyPatch, name: str, forgetful: Callable[..., None]) -> None:
    monkeypatch.setattr(Trail, name, forgetful)
    steps = [("push",), *[("change", kind, 7) for kind in range(7)], ("pop", 0)]
    with pytest.raises(AssertionError):
        run(steps, World())  # type: ignore[arg-type]


def test_levels_that_are_not_open() -> None:
    trail = Trail()
    with pytest.raises(ValueError, match="cannot undo to depth 0: 0 levels are open"):
        trail.pop_to(0)
    trail.push()
    with pytest.raises(ValueError, match="cannot undo to depth 1"):
        trail.pop_to(1)
    with pytest.raises(ValueError, match="before the first level"):
        trail.join(Log())


def test_the_newest_change_is_undone_first() -> None:
    trail = Trail()
    order: list[int] = []
    trail.push()
    for number in range(3):
        trail.call(order.append, number)
    trail.pop_to(0)
    assert order == [2, 1, 0]
