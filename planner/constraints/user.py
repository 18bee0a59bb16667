"""Constraint procedures of a model's own: Python callables, found by name in a file or a module.

    # travel.py                                   remote-agent plan rover.nddl --procedures travel.py
    import math

    def travelTime(distance, speed, duration):
        "duration >= distance / speed"
        return distance, speed, duration.bounded(distance.lower / speed.upper, math.inf)

Every public function that the file defines is a constraint of its name, with as many arguments as the function has.
It is given domains (`Interval`: lower, upper, bounded; `Values`: values, keep) and gives the narrowed ones back in the
same order, or None when there is no solution. What `ConstraintProcedure` says of a narrowing holds for it: bounds may
be infinite, and no allowed value is taken away. A module may hold values of `ConstraintProcedure` as well.
"""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from planner.constraints.procedure import ConstraintProcedure, ProcedureRegistry
from planner.constraints.standard import STANDARD
from planner.domains import Domain, Interval, Values
from planner.errors import ModelError


def registry_with(sources: Iterable[str]) -> ProcedureRegistry:
    """The standard procedures and those of these files (`*.py`) or modules; ModelError says what is wrong with one."""
    found = [procedure for source in sources for procedure in procedures_of(source)]
    return STANDARD.with_procedures(*found)


def procedures_of(source: str) -> tuple[ConstraintProcedure, ...]:
    """The procedures of a file or a module, by its path or its dotted name."""
    module = _from_file(Path(source)) if source.endswith(".py") else _by_name(source)
    found = tuple(_procedures(module, source))
    if not found:
        raise ModelError(f"procedures {source}: expected public functions, found none")
    return found


def _procedures(module: ModuleType, source: str) -> Iterator[ConstraintProcedure]:
    for name, value in vars(module).items():
        if isinstance(value, ConstraintProcedure):
            yield value
        elif inspect.isfunction(value) and value.__module__ == module.__name__ and not name.startswith("_"):
            yield _procedure(name, value, source)


def _procedure(name: str, function: Callable[..., Any], source: str) -> ConstraintProcedure:
    minimum, maximum = 0, 0
    for parameter in inspect.signature(function).parameters.values():
        if parameter.kind in (parameter.KEYWORD_ONLY, parameter.VAR_KEYWORD):
            raise ModelError(f"procedures {source}: {name}: expected positional parameters, found {parameter}")
        if parameter.kind is parameter.VAR_POSITIONAL:
            return ConstraintProcedure(name, _narrowing(name, function, source), minimum, None)
        minimum += parameter.default is parameter.empty
        maximum += 1
    return ConstraintProcedure(name, _narrowing(name, function, source), minimum, maximum)


def _narrowing(
    name: str, function: Callable[..., Any], source: str
) -> Callable[[Sequence[Domain]], Sequence[Domain] | None]:
    where = f"constraint {name} ({source})"

    def narrow(domains: Sequence[Domain]) -> Sequence[Domain] | None:
        try:
            found = function(*domains)
        except Exception as error:  # whatever a model's own code does wrong is bad input
            file = inspect.getfile(function)
            line = [f.lineno for f in traceback.extract_tb(error.__traceback__) if f.filename == file][-1:]
            given = ", ".join(map(repr, domains))
            place = f" in line {line[0]}" if line else ""
            raise ModelError(f"{where}: {type(error).__name__}{place} for ({given}): {error}") from error
        if found is None:
            return None
        expected = f"expected None or {len(domains)} domains, one for each argument"
        if not isinstance(found, Sequence) or len(found) != len(domains):
            raise ModelError(f"{where}: {expected}, found {found!r:.80}")
        if not all(isinstance(one, Interval | Values) for one in found):
            raise ModelError(f"{where}: {expected}, found {found!r:.80}")
        return found

    narrow.__doc__ = function.__doc__
    return narrow


def _from_file(path: Path) -> ModuleType:
    name = f"_procedures_of_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None or not path.is_file():
        raise ModelError(f"procedures {path}: expected a Python file, found none")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # where a dataclass of the file looks for its names
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise ModelError(_import_failed(str(path), error)) from error
    return module


def _by_name(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except Exception as error:
        hint = " (a file is named with its .py)" if isinstance(error, ModuleNotFoundError) else ""
        raise ModelError(_import_failed(name, error) + hint) from error


def _import_failed(source: str, error: Exception) -> str:
    where = f" in line {error.lineno}" if isinstance(error, SyntaxError) and error.lineno else ""
    text = error.msg if isinstance(error, SyntaxError) else str(error)
    return f"procedures {source}: {type(error).__name__}{where}: {text}"
