"""Which faults a run has: the scenario's own, or those asked for as NAME or NAME@TIME."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from planner.errors import nearest
from scenarios.config import FaultSection, Scenario
from scenarios.errors import ScenarioError
from scenarios.times import seconds_of
from sim import FAULTS, draw_faults


def chosen_faults(scenario: Scenario, wanted: Sequence[str] | None, seed: int = 0) -> tuple[FaultSection, ...]:
    """The faults of a run; None: the scenario's own. ScenarioError for an unknown name or a time that cannot be."""
    return own_faults(scenario, seed) if wanted is None else tuple(_chosen(scenario, text) for text in wanted)


def own_faults(scenario: Scenario, seed: int) -> tuple[FaultSection, ...]:
    """The faults of the scenario's file, with those that come at its rates for this seed."""
    drawn = draw_faults((section.rate() for section in scenario.fault_rates), seed, scenario.horizon)
    by_chance = (FaultSection(name=f.name, at=f.at_s, until=f.end_s, parameters=dict(f.parameters)) for f in drawn)
    return (*scenario.faults, *by_chance)


def _chosen(scenario: Scenario, text: str) -> FaultSection:
    name, at, time = text.partition("@")
    if name not in FAULTS:
        raise ScenarioError(f"--fault {text}: there is no fault named {name!r}{nearest(name, FAULTS)}")
    own = next((fault for fault in scenario.faults if fault.name == name), None)
    if not at:
        if own is None:
            raise ScenarioError(f"--fault {text}: the scenario gives no time for it; write {name}@TIME")
        return own
    try:
        seconds = seconds_of(int(time) if time.isdigit() else time)
    except ValueError as error:
        raise ScenarioError(f"--fault {text}: {error}") from error
    if seconds >= scenario.horizon:
        raise ScenarioError(f"--fault {text}: {seconds} s lies after the horizon of {scenario.horizon} s")
    return FaultSection(name=name, at=seconds) if own is None else own.model_copy(update={"at": seconds})


def table_of_faults() -> list[dict[str, Any]]:
    """A row a fault: name, component, what it does and with which parameters, and these as data."""
    return [
        {
            "name": fault.name,
            "component": fault.component,
            "summary": "; ".join(
                (
                    fault.meaning,
                    *(
                        f"{p.name} = {p.default:g} ({p.minimum:g} to {p.maximum:g}): {p.meaning}"
                        for p in fault.parameters
                    ),
                )
            ),
            "parameters": [asdict(parameter) for parameter in fault.parameters],
        }
        for fault in FAULTS.values()
    ]
