"""Which changes of telemetry matter: those of channels that something reads, where they can change an answer."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Mapping

from executive.bindings import Bindings
from executive.conditions import Telemetry
from executive.port import TelemetryValue

_UNBOUNDED = float("inf")


class Subscription:
    """What an executive with these bindings keeps of an observation.

    A channel that is only compared by size with numbers is kept when one of these comparisons changes its answer: the
    flight journal does not hold every count of an analogue sensor, and nothing decided depends on the others.
    """

    def __init__(self, bindings: Bindings) -> None:
        self._channels = bindings.channels()
        self._thresholds = bindings.thresholds()
        self._limits = {
            name: sorted({float(condition.value) for condition in conditions})
            for name, conditions in self._thresholds.items()
        }
        # Between which of its limits each such channel was when it was last kept: strictly between, no answer changes.
        self._spans: dict[str, tuple[float, float]] = {}

    def of(self, changes: Telemetry, before: Telemetry) -> Mapping[str, TelemetryValue]:
        """Those of the changes that matter, given what was kept before."""
        kept: dict[str, TelemetryValue] = {}
        for name, value in changes.items():
            span = self._spans.get(name)
            if span is not None and value.__class__ is float and span[0] < value < span[1]:
                continue
            if self._matters(name, value, before):
                kept[name] = value
                if name in self._limits:
                    self._spans[name] = self._span(name, value)
        return kept

    def _matters(self, name: str, value: TelemetryValue, before: Telemetry) -> bool:
        if name not in self._channels:
            return False
        conditions = self._thresholds.get(name)
        if conditions is None or name not in before:
            return True
        return any(condition.holds({name: value}) is not condition.holds(before) for condition in conditions)

    def _span(self, name: str, value: TelemetryValue) -> tuple[float, float]:
        if not isinstance(value, int | float) or isinstance(value, bool):
            return _UNBOUNDED, -_UNBOUNDED
        limits = self._limits[name]
        below, above = bisect_left(limits, value), bisect_right(limits, value)
        if below < above:
            return value, value
        low = limits[below - 1] if below else -_UNBOUNDED
        return low, limits[above] if above < len(limits) else _UNBOUNDED
