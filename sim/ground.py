"""The ground: stations that see the spacecraft as the Earth turns, and data that arrive a light time later."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from sim.quaternion import Vector, dot

SIDEREAL_RAD_S = 7.2921159e-5
OBLIQUITY_RAD = math.radians(23.44)


@dataclass(frozen=True, slots=True)
class Station:
    """A ground station by geographic latitude and east longitude."""

    name: str
    latitude_deg: float
    longitude_deg: float

    def up(self, time_s: float, sidereal_rad: float) -> Vector:
        """Its zenith as a unit vector of the ecliptic frame, the Greenwich meridian at `sidereal_rad` at time 0."""
        angle = math.radians(self.longitude_deg) + sidereal_rad + SIDEREAL_RAD_S * time_s
        latitude = math.radians(self.latitude_deg)
        x, y, z = math.cos(latitude) * math.cos(angle), math.cos(latitude) * math.sin(angle), math.sin(latitude)
        c, s = math.cos(OBLIQUITY_RAD), math.sin(OBLIQUITY_RAD)
        return (x, c * y + s * z, c * z - s * y)

    def elevation_rad(self, direction: Vector, time_s: float, sidereal_rad: float) -> float:
        """Of what lies far off in `direction` (unit vector from the Earth)."""
        return math.asin(max(-1.0, min(1.0, dot(self.up(time_s, sidereal_rad), direction))))


STATIONS: Mapping[str, Station] = MappingProxyType(
    {
        station.name: station
        for station in (
            Station("goldstone", 35.4, -116.9),
            Station("madrid", 40.4, -4.2),
            Station("canberra", -35.4, 149.0),
        )
    }
)
"""The three complexes of the Deep Space Network."""


class GroundSegment:
    """What has arrived of what was sent. Told now and then how much had been sent, it knows it a light time later."""

    def __init__(self) -> None:
        self._on_the_way: deque[tuple[float, float]] = deque([(-math.inf, 0.0), (0.0, 0.0)])

    def __repr__(self) -> str:
        return f"GroundSegment({len(self._on_the_way)} notes)"

    def sent(self, time_s: float, light_time_s: float, total_Mbit: float) -> None:
        """Note how much had been sent by `time_s`, and when that arrives; a stretch of silence takes two notes."""
        arrival_s = time_s + light_time_s
        notes = self._on_the_way
        if len(notes) > 2 and notes[-1][1] == notes[-2][1] == total_Mbit:
            notes.pop()
        notes.append((arrival_s, total_Mbit))

    def received_Mbit(self, time_s: float) -> float:
        """What has arrived by `time_s`, which must not go back."""
        notes = self._on_the_way
        while len(notes) > 2 and notes[1][0] <= time_s:
            notes.popleft()
        (since_s, before), (until_s, after) = notes[0], notes[1]
        if time_s >= until_s:
            return after
        if before == after or until_s <= since_s:
            return before
        return before + (after - before) * max(0.0, time_s - since_s) / (until_s - since_s)
