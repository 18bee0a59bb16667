"""Which faults a run has: the scenario's own, or those asked for as NAME or NAME@TIME."""

from __future__ import annotations

from collections.abc import Sequence

from planner.errors import nearest
from scenarios.config import FaultSection, Scenario
from scenarios.errors import ScenarioError
from scenarios.times import seconds_of
from sim import FAULTS


def chosen_faults(scenario: Scenario, wanted: Sequence[str] | None) -> tuple[FaultSection, ...]:
    """The faults of a run; None: the scenario's. ScenarioError for an unknown name or a time that cannot be."""
    return scenario.faults if wanted is None else tuple(_chosen(scenario, text) for text in wanted)


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
