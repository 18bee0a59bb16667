"""What every component shares: how it answers a failure mode that it does not have."""

from __future__ import annotations

from typing import NoReturn

from sim.errors import ConfigurationError


def refuse_fault(component: object, mode: str) -> NoReturn:
    """Say that `component` has no failure mode `mode`: a row of the fault table names the wrong component."""
    raise ConfigurationError(f"faults: expected a failure mode of {type(component).__name__}, found {mode!r}")
