"""Faults that come by chance: rates, and the script that a seed makes of them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from sim.errors import ConfigurationError
from sim.faults import FAULTS

Range = tuple[float, float]


@dataclass(frozen=True, slots=True)
class FaultRate:
    """A fault of the table that comes at exponential intervals.

    `mean_between_s`: mean time from one to the next. `parameters`: a range for each that should not have its default.
    `lasting_s`: range of how long it lasts, None: for good. Within a range everything is as likely.
    `ConfigurationError` for what the table or common sense forbids.
    """

    name: str
    mean_between_s: float
    parameters: Mapping[str, Range] = field(default_factory=lambda: MappingProxyType({}))
    lasting_s: Range | None = None

    def __post_init__(self) -> None:
        if self.name not in FAULTS:
            raise ConfigurationError(f"fault rates: expected one of {', '.join(FAULTS)}, found {self.name!r}")
        where = f"fault rates, {self.name}"
        if not 0.0 < self.mean_between_s < math.inf:
            raise ConfigurationError(
                f"{where}: expected a mean time between of more than 0, found {self.mean_between_s}"
            )
        known = {parameter.name: parameter for parameter in FAULTS[self.name].parameters}
        for name, (low, high) in self.parameters.items():
            if name not in known:
                raise ConfigurationError(f"{where}: expected parameters {', '.join(known) or 'none'}, found {name!r}")
            if not known[name].minimum <= low <= high <= known[name].maximum:
                allowed = f"{known[name].minimum:g} to {known[name].maximum:g}"
                raise ConfigurationError(f"{where}, {name}: expected a range within {allowed}, found {low:g}, {high:g}")
        if self.lasting_s is not None and not 0.0 < self.lasting_s[0] <= self.lasting_s[1] < math.inf:
            raise ConfigurationError(f"{where}: expected 0 < shortest <= longest, found lasting {self.lasting_s}")


@dataclass(frozen=True, slots=True)
class DrawnFault:
    """A fault to inject: begin and end in whole seconds (no end: for good), and its parameters."""

    name: str
    at_s: int
    end_s: int | None
    parameters: Mapping[str, float]


def draw_faults(rates: Iterable[FaultRate], seed: int, horizon_s: float) -> tuple[DrawnFault, ...]:
    """The faults of a run, in order of time. Each rate has a generator of its own, made of the seed and its name.

    So a rate that is added, taken away or changed leaves the faults of the others as they were. A fault does not come
    again while it lasts.
    """
    drawn: list[DrawnFault] = []
    for rate in rates:
        generator = np.random.default_rng([seed, *rate.name.encode()])
        time_s = 0.0
        while (time_s := time_s + float(generator.exponential(rate.mean_between_s))) < horizon_s:
            parameters = {name: float(generator.uniform(*bounds)) for name, bounds in sorted(rate.parameters.items())}
            at_s, end_s = int(time_s), None
            if rate.lasting_s is not None:
                end_s = at_s + max(1, round(float(generator.uniform(*rate.lasting_s))))
                time_s = float(end_s)
            drawn.append(DrawnFault(rate.name, at_s, end_s, MappingProxyType(parameters)))
            if end_s is None and FAULTS[rate.name].lasts:
                break
    return tuple(sorted(drawn, key=lambda fault: (fault.at_s, fault.name)))


RECYCLES = FaultRate("ips-recycle", 14.4 * 3600.0, MappingProxyType({"seconds": (60.0, 240.0)}))
"""The ion engine's own: 59 short shutdowns in its first 850 hours of thrust."""
