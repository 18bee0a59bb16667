"""What a recording is given of an instant."""

from __future__ import annotations

from dataclasses import dataclass

from sim.quaternion import Quaternion, Vector


@dataclass(frozen=True, slots=True)
class RecordedState:
    """The raw state at an instant, for recordings: nothing rounded, nothing that the flight side may see."""

    time_s: float
    position_I_m: Vector
    velocity_I_m_s: Vector
    attitude_IB: Quaternion
    rate_B_rad_s: Vector
    wheel_speeds_rad_s: tuple[float, ...]
    wing_angles_rad: tuple[float, ...]
    mass_kg: float
    thrust_I_N: Vector
    sun_direction_I: Vector
    sun_distance_au: float
    heliocentric_position_I_m: Vector
    active_faults: tuple[str, ...]
