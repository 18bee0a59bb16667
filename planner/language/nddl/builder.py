"""From statements to a model and the program of a problem: what is declared, in which order it is built.

All objects are created before the plan begins: an object variable of a token ranges over those that come later too
until `close()`, so nothing that a token can see depends on the order.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from planner.constraints.procedure import ProcedureRegistry
from planner.errors import ModelError
from planner.language.nddl.errors import Complaint, Report
from planner.language.nddl.library import CONFIG
from planner.language.nddl.limits import METHODS as LIMITING
from planner.language.nddl.limits import set_limits
from planner.language.nddl.loader import Loader
from planner.language.nddl.model_builder import ModelBuilder
from planner.language.nddl.objects import Objects
from planner.language.nddl.program import PROBLEM, Program
from planner.language.nddl.symbols import Symbols
from planner.language.nddl.syntax import (
    Allocation,
    Assignment,
    Declaration,
    Method,
    New,
    Statement,
    Typedef,
)
from planner.language.nddl.values import is_number
from planner.model.manager import ModelManager


def build(
    name: str,
    statements: Sequence[Statement],
    procedures: ProcedureRegistry,
    report: Report,
    texts: Iterable[str] = (),
) -> tuple[ModelManager, Program]:
    """The model and the problem of a program; NddlError with all that is wrong with it.

    A string variable ranges over `texts`, the strings that the program has.
    """
    report.raise_if_failed()
    model = ModelManager(name, procedures)
    for text in sorted(texts):
        model.strings.add(text)
    model.strings.is_open = False
    symbols = Symbols(report)
    symbols.add_built_in(model)
    symbols.collect(statements)
    report.raise_if_failed()
    builder = ModelBuilder(model, symbols, report)
    objects = Objects(model, symbols)
    builder.types(statements)
    builder.members()
    report.raise_if_failed()
    _create(statements, builder, objects, report)
    builder.predicates()
    report.raise_if_failed()
    builder.rules(statements)
    report.raise_if_failed()
    try:
        model.close()
    except ModelError as error:
        report.complain(Complaint(statements[0].at, str(error)))
    problem = [s for s in statements if isinstance(s, PROBLEM)]
    horizon, max_steps = _config(model, symbols)
    report.raise_if_failed()
    return model, Program(symbols, problem, horizon, max_steps, objects.variables)


def _create(statements: Sequence[Statement], builder: ModelBuilder, objects: Objects, report: Report) -> None:
    """Types, objects and the values of global variables, in the order in which they stand."""
    for statement in statements:
        act = _CREATION.get(type(statement))
        if act is None:
            continue
        try:
            act(statement, builder, objects)
        except Complaint as complaint:
            report.complain(complaint)
        except ModelError as error:
            report.complain(Complaint(statement.at, str(error)))


def _typedef(node: Typedef, builder: ModelBuilder, objects: Objects) -> None:
    builder.typedef(node)


def _allocation(node: Allocation, builder: ModelBuilder, objects: Objects) -> None:
    objects.create(node.new, objects.unnamed(node.new.cls))


def _declaration(node: Declaration, builder: ModelBuilder, objects: Objects) -> None:
    builder.symbols.check_type(node.type, node.at)
    for variable in node.variables:
        if isinstance(variable.value, New):
            thing = objects.create(variable.value, variable.name)
            cls = builder.symbols.class_of(node.type)
            if cls is None or not builder.symbols.is_subclass(thing.cls, cls):
                raise Complaint(variable.at, f"variable {variable.name!r} is of type {node.type}, not {thing.cls}")
            continue
        builder.variable(node.type, variable)
        if variable.value is not None:
            value = objects.literals.value(variable.value)
            if value is not None:
                objects.variables[variable.name] = value
                if is_number(value):
                    builder.symbols.constants[variable.name] = value


def _assignment(node: Assignment, builder: ModelBuilder, objects: Objects) -> None:
    if isinstance(node.value, New):
        if len(node.target.path) != 1 or node.target.path[0] not in builder.symbols.variables:
            raise Complaint(node.at, f"a new object can be given to a global variable, not to {str(node.target)!r}")
        objects.create(node.value, node.target.path[0])


def _method(node: Method, builder: ModelBuilder, objects: Objects) -> None:
    if node.method in LIMITING:
        set_limits(node, objects)


_CREATION: dict[type, Callable[[Any, ModelBuilder, Objects], None]] = {
    Typedef: _typedef,
    Allocation: _allocation,
    Declaration: _declaration,
    Assignment: _assignment,
    Method: _method,
}


def _config(model: ModelManager, symbols: Symbols) -> tuple[tuple[int, int] | None, int | None]:
    """The horizon and the limit on steps of the last PlannerConfig, or object of a class below it."""
    configs = [thing for thing in model.objects.values() if symbols.is_subclass(thing.cls, CONFIG)]
    if not configs:
        return None, None
    members = configs[-1].members
    start, end = members.get("m_horizonStart"), members.get("m_horizonEnd")
    horizon = None
    if _is_finite(start) and _is_finite(end):
        horizon = int(start), int(end)  # type: ignore[arg-type]
    steps = members.get("m_maxPlannerSteps")
    return horizon, int(steps) if _is_finite(steps) else None  # type: ignore[arg-type]


def _is_finite(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def load(
    path: Path,
    procedures: ProcedureRegistry,
    include: Sequence[Path] = (),
    headers: Mapping[str, str] | None = None,
) -> tuple[ModelManager, Program, Report]:
    """The model and the problem of a file; NddlError with all that is wrong with it.

    `procedures`: the constraints that rules may name. `headers`: texts of files that it may include, by name.
    """
    report = Report()
    loader = Loader(report, include, headers)
    model, program = build(path.stem, loader.file(path), procedures, report, loader.texts)
    return model, program, report


def load_text(
    text: str,
    procedures: ProcedureRegistry,
    name: str = "<text>",
    folder: Path = Path(),
    headers: Mapping[str, str] | None = None,
    model_name: str | None = None,
) -> tuple[ModelManager, Program, Report]:
    """The model and the problem of a text; includes are looked for among the headers, then in the folder."""
    report = Report()
    loader = Loader(report, headers=headers)
    model, program = build(model_name or name, loader.text(text, name, folder), procedures, report, loader.texts)
    return model, program, report
