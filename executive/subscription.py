"""Which changes of telemetry matter: those of channels that something reads, where they can change an answer."""

from __future__ import annotations

from collections.abc import Mapping

from executive.bindings import Bindings
from executive.conditions import Telemetry
from executive.port import TelemetryValue


class Subscription:
    """What an executive with these bindings keeps of an observation.

    A channel that is only compared by size with numbers is kept when one of these comparisons changes its answer: the
    flight journal does not hold every count of an analogue sensor, and nothing decided depends on the others.
    """

    def __init__(self, bindings: Bindings) -> None:
        self._channels = bindings.channels()
        self._thresholds = bindings.thresholds()

    def of(self, changes: Telemetry, before: Telemetry) -> Mapping[str, TelemetryValue]:
        """Those of the changes that matter, given what was kept before."""
        return {name: value for name, value in changes.items() if self._matters(name, value, before)}

    def _matters(self, name: str, value: TelemetryValue, before: Telemetry) -> bool:
        if name not in self._channels:
            return False
        conditions = self._thresholds.get(name)
        if conditions is None or name not in before:
            return True
        return any(condition.holds({name: value}) is not condition.holds(before) for condition in conditions)
