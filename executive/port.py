"""The port: all that the executive may know of the hardware. Whatever implements `Plant` can be flown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

TelemetryValue = float | int | str | bool


@dataclass(frozen=True, slots=True)
class Command:
    """A telecommand: its name and arguments are those of the plant's telecommand dictionary. `id` counts from 1."""

    id: int
    name: str
    arguments: Mapping[str, TelemetryValue]


@dataclass(frozen=True, slots=True)
class Acknowledgement:
    """What the receiving terminal said of a command: taken, or not and why. None ever comes from a dead terminal."""

    command_id: int
    accepted: bool
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Observation:
    """What the plant says at one instant.

    `time`: whole seconds of simulation clock. `changes`: the channels whose value differs from the observation before
    (all of them in the first), each rounded to its channel's resolution, so that a journal of changes is the whole
    telemetry. `acknowledgements`: those that arrived since the observation before.
    """

    time: int
    changes: Mapping[str, TelemetryValue]
    acknowledgements: tuple[Acknowledgement, ...] = ()


class Plant(Protocol):
    """The hardware seen by the executive. Commands take effect at once; time passes only in `advance`."""

    def send(self, command: Command) -> None:
        """Put a command on the bus. An unknown one is refused by acknowledgement, never by an exception."""
        ...

    def advance(self, until: int) -> Observation:
        """Let time pass up to `until` (seconds, a whole number later than now) and observe there."""
        ...
