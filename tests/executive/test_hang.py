"""The hang of 18 May 1999: a signal missed between two tasks. What it is, and that it cannot stop this executive."""

from __future__ import annotations

import io
import random
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from executive.bindings import Activity, Bindings, Finish, Standby
from executive.commands import CommandLink
from executive.conclusions import Conclusions
from executive.conditions import Condition
from executive.execution import Execution
from executive.executive import Executive
from executive.goals import GoalBook
from executive.journal import Journal
from executive.network import PlanNetwork
from executive.port import Acknowledgement, Command, Observation, TelemetryValue
from executive.records import DispatchStatistics, Settings
from executive.recovery import FaultProtection
from executive.sends import Confirmation, Send
from executive.sequencer import RESTART, Sequencer, Tasks, exchange
from executive.watchdog import Watchdog
from planner.problem import Goal, PlanningResult, Problem, TokenPattern
from planner.temporal.controllability import DispatchableNetwork, check
from tests.executive.scripted import (
    AT_START,
    Draft,
    Reaction,
    Run,
    ScriptedPlant,
    bindings,
    fly,
    planner,
    reactions,
    turn,
)

# -- the race ----------------------------------------------------------------------------------------------------------
# All interleavings of `executive.sequencer.Tasks`.


def deadlocks(faulty: bool) -> tuple[int, int]:
    """All interleavings: how many states can be reached, and in how many of them both tasks sleep for ever."""
    seen, waiting = {Tasks()}, [Tasks()]
    stuck = 0
    while waiting:
        state = waiting.pop()
        following = [after for task in (0, 1) if (after := state.next(task, faulty)) is not None]
        stuck += not following
        for after in following:
            if after not in seen:
                seen.add(after)
                waiting.append(after)
    return len(seen), stuck


def test_the_missed_signal_stops_both_tasks_in_some_interleavings() -> None:
    states, stuck = deadlocks(faulty=True)
    assert states > 50
    assert stuck > 0


def test_compared_under_the_lock_no_signal_is_missed() -> None:
    states, stuck = deadlocks(faulty=False)
    assert states > 20
    assert stuck == 0


def test_what_is_mended_gets_through_every_order_of_events() -> None:
    assert all(exchange(random.Random(seed), 30, faulty=False) for seed in range(1000))
    hanging = sum(not exchange(random.Random(seed), 30, faulty=True) for seed in range(200))
    assert hanging > 20


# -- an engine whose software has that race ----------------------------------------------------------------------------


class Engine:
    """An engine that is shut down in twelve signals between the two tasks, in an order that a seed decides; with the
    fault or without. A reset starts its software anew."""

    def __init__(self, seed: int, faulty: bool) -> None:
        self.faulty = faulty
        self._rng = random.Random(seed)
        self._tasks: Tasks | None = None
        self._rounds = 0
        self._now = 0
        self._changes: dict[str, TelemetryValue] = {"engine": "thrusting"}
        self._answers: list[Acknowledgement] = []

    def send(self, command: Command) -> None:
        self._answers.append(Acknowledgement(command.id, True))
        if command.name == "engine.stop":
            self._tasks, self._rounds = Tasks(), 0
        if command.name == "engine.reset":
            self._tasks = None
        if command.name in ("engine.reset", "engine.start"):
            self._changes["engine"] = "off" if command.name == "engine.reset" else "thrusting"

    def advance(self, until: int) -> Observation:
        for _ in range(4 * (until - self._now)):
            self._work()
        self._now = until
        changes, self._changes = self._changes, {}
        answers, self._answers = tuple(self._answers), []
        return Observation(until, changes, answers)

    def _work(self) -> None:
        if self._tasks is None:
            return
        task = self._rng.randrange(2)
        after = self._tasks.next(task, self.faulty)
        if after is None:
            return
        self._rounds += self._tasks.at[task] == "signal"
        self._tasks = after
        if self._rounds == 12:
            self._tasks = None
            self._changes["engine"] = "off"


OFF, THRUSTING = (Condition("engine", "==", state) for state in ("off", "thrusting"))
SHUTTING = Bindings(
    (
        Activity("Engine.thrusting", start=(Send("engine.start"),), started=Confirmation((THRUSTING,))),
        Activity("Engine.shuttingDown", contingent=True, start=(Send("engine.stop"),), finish=Finish((OFF,))),
    ),
    Standby((Send("engine.reset"),), Confirmation((OFF,), within=20)),
    lambda telemetry, conclusions: (TokenPattern("Engine.off"),),
    ("engine",),
)


def shut_down(problem: Problem) -> PlanningResult:
    """Thrust for 10 s, then shut down within 60 s."""
    draft = Draft(problem.horizon)
    line = ("engine", "mode")
    draft.token(line, problem.state[0].predicate)
    if problem.goals:
        draft.token(line, "Engine.thrusting", (10, 10), master="t3")
        draft.token(line, "Engine.shuttingDown", (1, 60), contingent=True, goal="off")
        draft.token(line, "Engine.off", master="t3")
    return PlanningResult(draft.plan())


def flown(seed: int, faulty: bool) -> Run:
    wanted = (Goal("off", TokenPattern("Engine.shuttingDown")),)
    return fly(Engine(seed, faulty), SHUTTING, shut_down, wanted, (0, 400), Settings(budget=5, retry_delay=10))


SEEDS = range(12)


def hung(seeds: range, faulty: bool) -> Iterator[Run]:
    for seed in seeds:
        run = flown(seed, faulty)
        if run.told("violation"):
            yield run


def test_with_the_fault_the_activity_that_never_ends_is_caught_at_its_deadline() -> None:
    """Whatever hangs down there: at the last allowed second the executive acts, and a new plan follows."""
    runs = list(hung(SEEDS, faulty=True))
    assert runs
    for run in runs:
        first = run.told("violation")[0]
        began = next(e for e in run.told("token.started") if e["predicate"] == "Engine.shuttingDown")
        assert (first["kind"], int(str(first["t"])) - int(str(began["t"]))) == ("late", 60)
        assert str(first["detail"]) == "not ended after 60 s: expected engine == off, found thrusting"
        assert len(run.executive.plans) >= 2
        assert run.executive.now == 400


def test_without_the_fault_nothing_ever_hangs() -> None:
    assert not list(hung(SEEDS, faulty=False))


# -- a sequencer with that race between the executive and the plant ----------------------------------------------------


def sequenced(faulty: bool) -> tuple[Sequencer, ScriptedPlant]:
    plant = ScriptedPlant(AT_START, {"end": [Reaction()], "look": [Reaction()]})
    plant.advance(0)
    return Sequencer(plant, 1, faulty, ("end",)), plant


def test_a_hung_sequencer_passes_nothing_on_until_it_is_restarted() -> None:
    sequencer, plant = sequenced(faulty=True)
    for number, name in enumerate(("look", "end", "look", "end", RESTART, "end", "look"), 1):
        sequencer.send(Command(number, name, {}))
    assert [command.id for command in plant.sent] == [1, 6, 7]
    assert [a.command_id for a in sequencer.advance(1).acknowledgements] == [5, 1, 6, 7]


def test_a_mended_sequencer_passes_everything_on() -> None:
    sequencer, plant = sequenced(faulty=False)
    for number in range(1, 6):
        sequencer.send(Command(number, "end", {}))
    assert [command.id for command in plant.sent] == [1, 2, 3, 4, 5]


# -- the executive itself ----------------------------------------------------------------------------------------------


def _execution(plan_id: str, network: PlanNetwork, dispatchable: DispatchableNetwork) -> Execution:
    journal = Journal(io.StringIO())
    link = CommandLink(ScriptedPlant(AT_START, reactions()), journal)
    protection = FaultProtection((), bindings(), link, Conclusions(bindings(), journal), tuple)
    goals = GoalBook((), journal)
    return Execution(plan_id, network, dispatchable, bindings(), link, protection, goals, journal, DispatchStatistics())


def test_a_plan_in_which_nothing_can_happen_is_given_up() -> None:
    """No controllable network can stall; so the dispatcher's own is spoilt: two ends wait for each other."""
    draft = Draft((0, 100))
    for line in ("a", "b"):
        draft.token((line, "x"), "Work.rest", (1, 10))
    network = PlanNetwork.of(draft.plan())
    dispatchable = check(network.stnu).network
    assert dispatchable is not None
    names = list(dispatchable.timepoints)
    both = names.index("t1.end"), names.index("t2.end")
    circle = [[both[0], both[1], -1], [both[1], both[0], -1]]
    rows = sorted([row for row in dispatchable.edges.tolist() if tuple(row[:2]) not in (both, both[::-1])] + circle)
    spoilt = replace(dispatchable, edges=np.array(rows, dtype=np.int64))
    stuck, sound = _execution("stuck", network, spoilt), _execution("sound", network, dispatchable)
    for execution in (stuck, sound):
        execution.begin(AT_START, 0)
        execution.dispatch(AT_START, 0)
    assert [(v.kind, v.detail) for v in Watchdog().stalled(stuck)] == [
        ("stalled", "nothing can happen any more, and still to come are t1.end, t2.end")
    ]
    assert not Watchdog().stalled(sound)


def test_an_instant_comes_to_rest() -> None:
    watchdog = Watchdog(most_rounds=3)
    assert [watchdog.is_spinning(5) for _ in range(5)] == [False, False, False, True, True]
    assert not watchdog.is_spinning(6)


def test_a_planner_of_broken_plans_cannot_keep_an_instant_from_ending() -> None:
    """Plans that are violated the second they begin: the clock goes on, and standby stays in reach."""

    def greedy(problem: Problem) -> PlanningResult:
        draft = Draft(problem.horizon)
        for thing, target in (("acs", "earth"), ("acs2", "vesta")):
            draft.token((thing, "attitude"), "Attitude.holding", (50, None), {"target": target})
        return PlanningResult(draft.plan())

    run = fly(ScriptedPlant(AT_START, reactions()), plan=greedy, wanted=(), settings=Settings(budget=1, retry_delay=1))
    assert run.executive.now == 120
    assert run.executive.outcome == "completed"


# -- early out ---------------------------------------------------------------------------------------------------------


def test_an_early_end_reaches_its_neighbours_in_the_same_second() -> None:
    """The turn may take 5 to 20 s and takes 5: what follows begins then, and every window that it bounds narrows."""
    run = fly(ScriptedPlant(AT_START, reactions(turn=[turn(5)])))
    end = run.times()["t4.end"]
    assert end == 11
    assert run.times()["t5.start"] == run.times()["t3.start"] == end
    told = [e["changes"] for e in run.told("bounds") if e["t"] == end]
    assert isinstance(told[0], dict)
    assert told[0]["t3.start"][0] == end
    assert run.times()["t3.end"] == end + 4


def test_planner_is_never_awaited() -> None:
    """There is nobody to wait for: the planner is called and answers within the step; its time is only counted."""
    stream = io.StringIO()
    executive = Executive(
        ScriptedPlant(AT_START, reactions()), bindings(), planner, (), (0, 20), Journal(stream), Settings(budget=5)
    )
    steps = 0
    while executive.now < 20:
        executive.step()
        steps += 1
    assert steps == 21
