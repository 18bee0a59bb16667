"""Why a problem has no plan: few of its statements that leave none, and whether each of them is needed for that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

from planner.constraints.network import Inconsistency, Owner
from planner.cores import Core, smallest_core
from planner.database import PlanDatabase
from planner.errors import PlannerError
from planner.language.nddl.errors import Report
from planner.language.nddl.program import Program, Stated
from planner.model.manager import ModelManager
from planner.search.engines import ENGINES
from planner.search.outcome import Acceptance, Limits
from planner.tokens.instance import RuleInstance
from scenarios.explaining.statements import Requirements, chosen_statements, written

_STEPS_AT_LEAST = 20_000
_TIMES_AS_MANY = 4
_SHARE = 0.3
"""Of the time that is left, how much one trial may take."""


@dataclass(frozen=True, slots=True)
class Place:
    """A statement of the problem and where it stands."""

    file: str
    line: int
    column: int
    text: str


@dataclass(frozen=True, slots=True)
class Conflict:
    """Statements that leave no plan.

    `minimal`: without any one of them, and with the problem's facts, there is a plan of the others; or where they
    contradict each other `at_once`, before any search, the others do not. `through`: the rules by which they meet, at
    the dead end that the search found nearest to the problem; `dead_end`: that one in words, where no rule had a part
    in it. `proven`: whether there is a conflict; the limits may have come first.
    """

    statements: tuple[Place, ...]
    through: tuple[str, ...]
    horizon: tuple[int, int]
    proven: bool
    minimal: bool
    at_once: bool
    trials: int
    dead_end: str | None = None

    def to_json(self) -> dict[str, Any]:
        """What `--json` prints."""
        return {
            "statements": [
                {"file": s.file, "line": s.line, "column": s.column, "text": s.text} for s in self.statements
            ],
            "through": list(self.through),
            "dead_end": self.dead_end,
            "horizon": list(self.horizon),
            "proven": self.proven,
            "minimal": self.minimal,
            "at_once": self.at_once,
            "trials": self.trials,
        }

    def lines(self) -> list[str]:
        """What a person reads."""
        horizon = f"given the facts, within the horizon [{self.horizon[0]} {self.horizon[1]}]"
        if not self.proven:
            return [f"no part of the problem was proven to have no plan, {horizon} ({self.trials} trials)"]
        if not self.statements:
            return [f"the model alone leaves no plan, {horizon}"]
        head = "this statement leaves" if len(self.statements) == 1 else "these statements together leave"
        needed = "whether fewer would do is not proven"
        if self.minimal:
            needed = "without any one of them there is a plan of the others"
            needed = "each of them is needed for the contradiction" if self.at_once else needed
        found = [f"{head} no plan, {horizon}; {needed}:"]
        found += [f"  {s.file}:{s.line}:{s.column}: {s.text}" for s in self.statements]
        found += ["they meet through:", *(f"  {rule}" for rule in self.through)] if self.through else []
        return found if self.dead_end is None else [*found, f"at the dead end nearest to the problem {self.dead_end}"]


@dataclass(frozen=True, slots=True)
class Suspects:
    """The owners of what met at a dead end. `at_once`: they contradict each other before any search."""

    owners: tuple[Owner, ...] = ()
    at_once: bool = False


class Trials:
    """Parts of a problem tried: do they propagate, do they have a plan that `accept` does not refuse.

    `limits`: the steps of the search that failed, and seconds for all trials together.
    """

    def __init__(
        self,
        model: ModelManager,
        program: Program,
        horizon: tuple[int, int],
        engine: str,
        accept: Acceptance,
        limits: Limits,
    ) -> None:
        self.model = model
        self.requirements = Requirements(program, model)
        self.facts = self.requirements.stated("fact")
        self.horizon = horizon
        self.engine = ENGINES[engine]
        self.accept = accept
        self.steps = max(_STEPS_AT_LEAST, _TIMES_AS_MANY * limits.max_steps)
        self.deadline = perf_counter() + limits.max_seconds
        self.count = 0
        self.met: list[Owner] = []
        self.dead_end: str | None = None

    def clash(self, chosen: Sequence[int]) -> bool | None:
        """Whether requirements contradict each other before any search."""
        return self._tried(chosen, search=False)

    def fails(self, chosen: Sequence[int], without: int = -1) -> bool | None:
        """Whether requirements leave no plan, given all facts of the problem but that one.

        Facts stand, since they are not wishes only: what they say is true needs no support, and leaving one out may be
        what leaves no plan.
        """
        return self._tried([*chosen, *(n for n in self.facts if n != without)], search=True)

    def _tried(self, chosen: Sequence[int], search: bool) -> bool | None:
        left = self.deadline - perf_counter()
        if left <= 0:
            return None
        self.count += 1
        database = PlanDatabase(self.model, self.horizon)
        met: list[Owner] = []
        try:
            self.requirements.program_of(chosen).carry_out(database, Report())
            if not search:
                return False
            limits = Limits(self.steps, left * _SHARE)
            outcome = self.engine.search(database, limits, self.accept, lambda owners: _keep(met, owners))
        except Inconsistency as inconsistency:
            self.met, self.dead_end = database.network.explain(inconsistency), None
            return True
        except PlannerError:
            return None  # what is left out was needed for the rest to mean anything
        if outcome.exhausted:
            nearest = outcome.refusal or ("" if outcome.conflict is None else outcome.conflict[1])
            self.met, self.dead_end = ([], nearest) if nearest else (met, None)
            return True
        return False if outcome.complete else None


def _keep(met: list[Owner], owners: Sequence[Owner]) -> str:
    met[:] = owners
    return ""


def conflict_of(trials: Trials, suspects: Suspects, is_proven: bool) -> Conflict:
    """The conflict of a problem that was not solved.

    `suspects`: those that met in the initial state, or else at the dead end that the search found nearest to the
    problem. `is_proven`: it is known that there is no plan.
    """
    requirements, horizon = trials.requirements, trials.horizon
    core = _of_suspects(requirements, trials, suspects)
    if core is None and is_proven:
        core = list(requirements.numbers)
    elif core is None:
        core = _failing_part(requirements, trials)
    if core is None:
        return Conflict((), (), horizon, proven=False, minimal=False, at_once=False, trials=trials.count)
    first = smallest_core(core, trials.clash) if suspects.at_once else None
    smallest = _smallest(trials, core if first is None else first.members)
    at_once = first is not None and (not smallest.minimal or not smallest.members)
    chosen = first if first is not None and at_once else smallest
    statements = chosen_statements(requirements, chosen.members)
    places = tuple(Place(s.at.file, s.at.line, s.at.column, written(s)) for s in statements)
    rules = _rules(trials.met)
    return Conflict(places, rules, horizon, True, chosen.minimal, at_once, trials.count, trials.dead_end)


def _smallest(trials: Trials, core: Sequence[int]) -> Core[int]:
    """Few requirements of a core that leave no plan, with the facts that are needed for that."""
    wishes = smallest_core([n for n in core if n not in trials.facts], trials.fails)
    needed = [n for n in trials.facts if trials.fails(wishes.members, without=n) is False]
    trials.fails(wishes.members)  # for what met at its dead end
    return Core(tuple(sorted({*wishes.members, *needed})), wishes.minimal)


def _of_suspects(requirements: Requirements, trials: Trials, suspects: Suspects) -> list[int] | None:
    """The statements among the suspects, if they fail on their own."""
    found = (requirements.number_at(s.statement.at) for s in map(_stated, suspects.owners) if s is not None)
    named = requirements.closed({n for n in found if n is not None})
    fails = trials.clash if suspects.at_once else trials.fails
    return named if named and fails(named) else None


def _failing_part(requirements: Requirements, trials: Trials) -> list[int] | None:
    """Requirements that are proven to have no plan: with one goal alone, or all of them by a longer search."""
    goals = set(requirements.stated("goal"))
    every = list(requirements.numbers)
    parts = [[n for n in every if n not in goals or n == goal] for goal in sorted(goals)] if len(goals) > 1 else []
    return next((part for part in (*parts, every) if trials.fails(part)), None)


def _stated(owner: Owner) -> Stated | None:
    label = owner.label if isinstance(owner, RuleInstance) else None
    return label if isinstance(label, Stated) else None


def _rules(owners: Sequence[Owner]) -> tuple[str, ...]:
    """The rules among the owners, each once."""
    instances = [o for o in owners if isinstance(o, RuleInstance) and o.token is not None]
    return tuple(dict.fromkeys(str(o.label) for o in instances if not isinstance(o.label, Stated)))
