"""What `remote-agent plan` does: an NDDL file in, a flexible plan or the reason why there is none out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

from executive.network import conflict_of as uncontrollable
from planner.constraints.network import Inconsistency, Owner
from planner.constraints.user import registry_with
from planner.database import PlanDatabase
from planner.errors import ModelError, ProblemError, nearest
from planner.extraction import extract
from planner.language.nddl.builder import load
from planner.language.nddl.errors import Report
from planner.language.nddl.program import Program, is_plain_declaration
from planner.model.manager import ModelManager
from planner.plan import FlexiblePlan
from planner.rationale import rationale
from planner.repair import refusal_of
from planner.search.collector import patient_collector
from planner.search.endless import assign_endless
from planner.search.engines import ENGINES
from planner.search.hint_files import beside
from planner.search.hint_files import load as load_hints
from planner.search.hints import Hints
from planner.search.outcome import Limits, Outcome, Refusal
from planner.temporal.network import TemporalNetworkManager
from scenarios.drawing.svg import save as save_drawing
from scenarios.errors import ScenarioError
from scenarios.explaining.conflict import Conflict, Suspects, Trials, conflict_of
from scenarios.explaining.tokens import Rationale

DEFAULT_HORIZONS = ((0, 100), (0, 1_000), (0, 10_000))
"""For a file that gives none, as ticks: what `new PlannerConfig()` says, then longer ones until there is a plan."""
FEWEST_STEPS = 1000
"""A smaller limit in a file is read as this: how steps are counted differs from planner to planner."""

Verdict = Literal["solved", "unsolvable", "limit"]


@dataclass(frozen=True, slots=True)
class PlanAnswer:
    """The answer. `verdict`: solved; unsolvable, which is proven; or limit, when the limits came first.

    `conflict`: what the statements say that cannot hold together from the beginning. `rejected`: the rejectable tokens
    that the plan leaves out. `model`, `plan`: as objects, for whoever goes on. `explanation`: if asked for, why each
    token is there, or which statements leave no plan.
    """

    verdict: Verdict
    engine: str
    plan: FlexiblePlan | None
    model: ModelManager
    tokens: int
    objects: int
    timelines: int
    constraints: int
    steps: int
    backtracks: int
    load_seconds: float
    solve_seconds: float
    reason: str | None = None
    conflict: tuple[str, ...] = ()
    rejected: tuple[str, ...] = ()
    explanation: Rationale | Conflict | None = None

    @property
    def solved(self) -> bool:
        """There is a plan."""
        return self.verdict == "solved"

    def to_json(self) -> dict[str, Any]:
        """What `--json` prints."""
        return {
            "solved": self.solved,
            "verdict": self.verdict,
            "engine": self.engine,
            "tokens": self.tokens,
            "objects": self.objects,
            "timelines": self.timelines,
            "constraints": self.constraints,
            "steps": self.steps,
            "backtracks": self.backtracks,
            "load_seconds": round(self.load_seconds, 6),
            "solve_seconds": round(self.solve_seconds, 6),
            "reason": self.reason,
            "conflict": list(self.conflict),
            "rejected": list(self.rejected),
            **({} if self.explanation is None else {"explanation": self.explanation.to_json()}),
        }


def plan_file(
    path: Path,
    *,
    engine: str = "portfolio",
    horizon: tuple[int, int] | None = None,
    max_seconds: float = 60.0,
    max_steps: int | None = None,
    include: Sequence[Path] = (),
    procedures: Sequence[str] = (),
    explain: bool = False,
    hints: Path | None = None,
    seed: int = 0,
) -> PlanAnswer:
    """Plan the problem of an NDDL file. `procedures`: files and modules of its own constraint procedures. `explain`:
    say why, which for a problem without a plan takes up to `max_seconds` again. `hints`: a file of solver hints instead
    of the one beside the problem's file, if that is there; `seed`: of random orders in it.

    NddlError (bad input, with file, line and column of all that is wrong) for a text that is no model; UnsupportedError
    where it asks for what this planner does not do; ProblemError for an engine or a horizon that there cannot be;
    ModelError for a procedure that fails; HintsError for hints that are none, or are for another model.
    """
    if engine not in ENGINES:
        raise ProblemError(f"engine: expected one of {', '.join(ENGINES)}, found {engine!r}{nearest(engine, ENGINES)}")
    registry = registry_with(procedures)
    guide = _hints(path, hints, seed)
    _load_kernel()
    with patient_collector():
        started = perf_counter()
        model, program, report = load(path, registry, include)
        guide = None if guide is None else guide.of_model(model)
        given = horizon or program.horizon
        if given is not None and given[0] >= given[1]:
            raise ProblemError(f"horizon: expected a start before the end, found [{given[0]} {given[1]}]")
        limits = _limits(program, max_seconds, max_steps)
        for span in DEFAULT_HORIZONS if given is None else (given,):
            planning = _Planning(model, program, report, span, engine, guide)
            answer = planning.run(limits, started)
            if answer.verdict != "unsolvable":
                break
        return planning.explained(answer, max_seconds) if explain else answer


def write_files(answer: PlanAnswer, out: Path | None, svg: Path | None) -> None:
    """Write the plan file and the drawing that are asked for, if there is a plan; ScenarioError when one cannot be."""
    if answer.plan is not None:
        write_file("--out", out, answer.plan.save)
        write_file("--svg", svg, partial(save_drawing, answer.plan))


def write_file(option: str, path: Path | None, save: Callable[[Path], None]) -> None:
    """Write the file that an option names, if it does; ScenarioError when it cannot be written."""
    if path is None:
        return
    try:
        save(path)
    except OSError as error:
        raise ScenarioError(f"{option} {path}: {error.strerror}") from error


def _load_kernel() -> None:
    """Have the compiled kernel at hand before the clock starts: it is part of the program, not of the file."""
    temporal = TemporalNetworkManager()
    point = temporal.add_timepoint(0, 1)
    temporal.post(temporal.ORIGIN, point, 1, 1)
    temporal.propagate()


def _hints(problem: Path, given: Path | None, seed: int) -> Hints | None:
    """The hints of a file that is named, or else of the one beside the problem's; None where there is none."""
    file = beside(problem) if given is None else given
    return load_hints(file, seed) if given is not None or file.is_file() else None


def _limits(program: Program, max_seconds: float, max_steps: int | None) -> Limits:
    if max_steps is None:
        max_steps = Limits().max_steps if program.max_steps is None else max(program.max_steps, FEWEST_STEPS)
    return Limits(max_steps, max_seconds)


def judge(database: PlanDatabase) -> Refusal | None:
    """Where nature decides durations, a plan has to hold whatever they turn out to be."""
    assign_endless(database)
    if not any(token.contingent for token in database.tokens.tokens):
        return None
    conflict = uncontrollable(extract(database))
    return None if conflict is None else refusal_of(database, conflict)


class _Planning:
    def __init__(
        self,
        model: ModelManager,
        program: Program,
        report: Report,
        horizon: tuple[int, int],
        engine: str,
        hints: Hints | None,
    ) -> None:
        self.model = model
        self.hints = hints
        self.program = program
        self.report = report
        self.engine = engine
        self.suspects = Suspects()
        try:
            self.database = PlanDatabase(model, horizon)
        except ModelError as error:
            raise ProblemError(str(error)) from error

    def run(self, limits: Limits, started: float) -> PlanAnswer:
        database = self.database
        outcome = Outcome()
        loaded = solving = 0.0
        conflict: list[Owner] = []
        try:
            self.program.carry_out(database, self.report)
            loaded = perf_counter()
            outcome = ENGINES[self.engine].search(database, limits, judge, self._dead_end, self.hints)
        except Inconsistency as inconsistency:
            conflict = database.network.explain(inconsistency)
            self.suspects = Suspects(tuple(conflict), at_once=True)
            outcome.exhausted = True
        solving = perf_counter()
        loaded = loaded or solving
        return self.answer(outcome, conflict, loaded - started, solving - loaded)

    def _dead_end(self, owners: Sequence[Owner]) -> str:
        """Note who met at the dead end that is nearest to the problem so far, and say it."""
        self.suspects = Suspects(tuple(owners))
        return _described(owners)

    def answer(self, outcome: Outcome, conflict: list[Owner], load: float, solve: float) -> PlanAnswer:
        plan = extract(self.database) if outcome.complete else None
        verdict: Verdict = "solved" if plan is not None else "unsolvable" if outcome.exhausted else "limit"
        reason = None if plan is not None else _reason(outcome, conflict)
        rejected = [t.name for t in self.database.tokens.tokens if t.state.name == "REJECTED"]
        return PlanAnswer(
            verdict=verdict,
            engine=self.engine,
            plan=plan,
            model=self.model,
            tokens=len(plan.tokens) if plan is not None else len(self.database.tokens.tokens),
            objects=len(self.model.objects),
            timelines=len(self.database.tokens.timelines),
            constraints=len(plan.constraints) if plan is not None else 0,
            steps=outcome.steps,
            backtracks=outcome.backtracks,
            load_seconds=load,
            solve_seconds=solve,
            reason=reason,
            conflict=tuple(_named(conflict)),
            rejected=tuple(rejected),
        )

    def explained(self, answer: PlanAnswer, max_seconds: float) -> PlanAnswer:
        """The answer with the reason why it is what it is. Finding that may prove that there is no plan."""
        if answer.plan is not None:
            return replace(answer, explanation=Rationale(answer.plan, rationale(self.database)))
        limits = Limits(answer.steps, max_seconds)
        proven = answer.verdict == "unsolvable"
        span = self.database.horizon
        trials = Trials(self.model, self.program, span, self.engine, judge, limits)
        found = conflict_of(trials, self.suspects, proven)
        if found.proven and not proven:
            answer = replace(answer, verdict="unsolvable", reason="no plan exists: a part of the problem has none")
        return replace(answer, explanation=found)


def _described(owners: Sequence[Owner]) -> str:
    return "; ".join(name.rstrip(";") for name in _named(owners))


def _named(owners: Sequence[Owner]) -> list[str]:
    """Those who are to blame, each once; that a variable exists is no reason."""
    blamed = [owner for owner in owners if not is_plain_declaration(owner)]
    return list(dict.fromkeys(map(str, blamed or owners)))


def _reason(outcome: Outcome, conflict: Sequence[Owner]) -> str:
    if conflict:
        return "the initial state is inconsistent: " + _described(conflict)
    verdict = "no plan exists" if outcome.exhausted else f"no plan found within the limits ({outcome.steps} steps)"
    if outcome.refusal is not None:
        return f"{verdict} that holds whatever nature decides; in conflict: {outcome.refusal}"
    return verdict if outcome.conflict is None else f"{verdict}; in conflict: {outcome.conflict[1]}"
