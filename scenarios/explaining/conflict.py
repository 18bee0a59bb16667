"""Why a problem has no plan: few of its statements that leave none, and whether each of them is needed for that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

from planner.constraints.network import Inconsistency, Owner
from planner.cores import smallest_core
from planner.database import PlanDatabase
from planner.errors import PlannerError
from planner.language.nddl.errors import Report
from planner.language.nddl.program import Program, Stated
from planner.model.manager import ModelManager
from planner.search.engines import ENGINES
from planner.search.outcome import Limits
from planner.tokens.instance import RuleInstance
from scenarios.explaining.statements import Requirements, chosen_statements, written

_STEPS_AT_LEAST = 2000
_TIMES_AS_MANY = 4


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

    `minimal`: without any one of them there is a plan of the others. `through`: the rules by which they meet, at the
    dead end that the search found nearest to the problem; `dead_end`: that one in words, where no rule had a part in
    it. `proven`: whether there is a conflict at all; the limits may have come first.
    """

    statements: tuple[Place, ...]
    through: tuple[str, ...]
    horizon: tuple[int, int]
    proven: bool
    minimal: bool
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
            "trials": self.trials,
        }

    def lines(self) -> list[str]:
        """What a person reads."""
        horizon = f"within the horizon [{self.horizon[0]} {self.horizon[1]}]"
        if not self.proven:
            return [f"no part of the problem was proven to have no plan {horizon} ({self.trials} trials)"]
        if not self.statements:
            return [f"the model alone leaves no plan {horizon}"]
        one = len(self.statements) == 1
        needed = "without it there is a plan of the rest" if one else "without any one of them the others have a plan"
        open_ = "whether fewer would do is not proven: a trial reached its limits"
        head = "this statement leaves" if one else "these statements together leave"
        found = [f"{head} no plan {horizon}; {needed if self.minimal else open_}:"]
        found += [f"  {s.file}:{s.line}:{s.column}: {s.text}" for s in self.statements]
        found += ["they meet through:", *(f"  {rule}" for rule in self.through)] if self.through else []
        return found if self.dead_end is None else [*found, f"at the dead end nearest to the problem {self.dead_end}"]


class _Trials:
    """Parts of a problem tried: do they propagate, do they have a plan."""

    def __init__(
        self, model: ModelManager, requirements: Requirements, horizon: tuple[int, int], engine: str, limits: Limits
    ) -> None:
        self.model = model
        self.requirements = requirements
        self.horizon = horizon
        self.engine = ENGINES[engine]
        self.limits = limits
        self.deadline = perf_counter() + limits.max_seconds
        self.count = 0
        self.met: list[Owner] = []
        self.dead_end: str | None = None

    def clash(self, chosen: Sequence[int]) -> bool | None:
        """Whether requirements contradict each other before any search."""
        return self._tried(chosen, search=False)

    def fails(self, chosen: Sequence[int]) -> bool | None:
        """Whether requirements leave no plan."""
        return self._tried(chosen, search=True)

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
            limits = Limits(self.limits.max_steps, left)
            outcome = self.engine.search(database, limits, None, lambda owners: _keep(met, owners))
        except Inconsistency as inconsistency:
            self.met, self.dead_end = database.network.explain(inconsistency), None
            return True
        except PlannerError:
            return None  # what is left out was needed for the rest to mean anything
        if outcome.exhausted:
            nearest = "" if outcome.conflict is None else outcome.conflict[1]
            self.met, self.dead_end = ([], nearest) if nearest else (met, None)
            return True
        return False if outcome.complete else None


def _keep(met: list[Owner], owners: Sequence[Owner]) -> str:
    met[:] = owners
    return ""


def conflict_of(
    model: ModelManager,
    program: Program,
    horizon: tuple[int, int],
    engine: str,
    limits: Limits,
    suspects: Sequence[Owner],
    verdict_proven: bool,
) -> Conflict:
    """The conflict of a problem that was not solved.

    `suspects`: the owners that the inconsistency of its initial state was traced to, if it has one. `verdict_proven`:
    it is known that there is no plan. `limits`: steps of the search that failed, and seconds for all that is done here.
    """
    requirements = Requirements(program)
    steps = max(_STEPS_AT_LEAST, _TIMES_AS_MANY * limits.max_steps)
    trials = _Trials(model, requirements, horizon, engine, Limits(steps, limits.max_seconds))
    core: list[int] | None = list(requirements.numbers)
    if suspects:
        core = _of_initial_state(requirements, trials, suspects)
    elif not verdict_proven:
        core = _failing_part(requirements, trials)
    if core is None:
        return Conflict((), (), horizon, False, False, trials.count)
    smallest = smallest_core(core, trials.fails)
    trials.fails(smallest.members)
    statements = chosen_statements(requirements, smallest.members)
    places = tuple(Place(s.at.file, s.at.line, s.at.column, written(s)) for s in statements)
    rules = _rules(trials.met)
    return Conflict(places, rules, horizon, True, smallest.minimal, trials.count, trials.dead_end)


def _of_initial_state(requirements: Requirements, trials: _Trials, suspects: Sequence[Owner]) -> list[int]:
    """Few requirements that contradict each other without any search."""
    found = (requirements.number_at(s.statement.at) for s in map(_stated, suspects) if s is not None)
    named = requirements.closed({n for n in found if n is not None})
    every = list(requirements.numbers)
    return list(smallest_core(named if trials.clash(named) else every, trials.clash).members)


def _failing_part(requirements: Requirements, trials: _Trials) -> list[int] | None:
    """Requirements that are proven to have no plan: with one goal alone, or all of them by a longer search."""
    goals = set(requirements.goals())
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
