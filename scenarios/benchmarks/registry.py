"""The benchmarks by name. A benchmark is a function without arguments that returns its figures, ready for JSON."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module


@dataclass(frozen=True, slots=True)
class Benchmark:
    """`modules`: those of this package whose `measure()` gives the figures; several are nested under their names."""

    name: str
    summary: str
    modules: tuple[str, ...]

    def measure(self) -> dict[str, object]:
        """All figures; takes up to some minutes."""
        figures: dict[str, Callable[[], dict[str, object]]] = {
            name: import_module(f"{__package__}.{name}").measure for name in self.modules
        }
        first, *others = figures
        return figures[first]() | {name: figures[name]() for name in others}


BENCHMARKS = {
    benchmark.name: benchmark
    for benchmark in (
        Benchmark("planner", "planning problems that grow, memory, operations undone", ("planner", "operations")),
        Benchmark("temporal", "the temporal network against a native loop", ("temporal",)),
        Benchmark("executive", "controllability checks, decisions, the dispatcher's share of a run", ("executive",)),
        Benchmark("sim", "the closed loop against the same physics in one C call", ("sim",)),
        Benchmark("run", "wall seconds of a scenario by phase", ("flight",)),
        Benchmark("survival", "50 runs killed at random instants and resumed", ("survival",)),
    )
}
