"""Everything that a scenario may choose of the spacecraft and its surroundings, with defaults after Deep Space 1.

Numbers marked "assumption" were never published for the flight; they are this project's choice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from sim.errors import ConfigurationError
from sim.ground import STATIONS
from sim.orbits import Elements
from sim.quaternion import Vector, dot

TARGET_KINDS = ("earth", "thrust", "asteroid")
ATTITUDE_SOURCES = ("estimator", "truth")


@dataclass(frozen=True, slots=True)
class Target:
    """Something to point at. `kind` says which body axis goes there: antenna, thrust or camera boresight.

    `direction_I`: its direction in the inertial frame at time 0 (any length but null). `angular_diameter_rad`: what the
    camera sees of it then, 0 for a point. `distance_au`: how far off it is then, on a circular orbit about the Sun; 0:
    at infinity, the direction never changes. `orbit`: a body's elements, instead of direction and distance.
    `magnitude`: of a point, or of each pixel of a disc.
    """

    name: str
    kind: str
    direction_I: Vector = (1.0, 0.0, 0.0)
    angular_diameter_rad: float = 0.0
    distance_au: float = 0.0
    orbit: Elements | None = None
    magnitude: float = 9.0


# Assumption: one sky of a cruise year. At time 0 the Sun on +X of the inertial frame, whose X-Y plane is the ecliptic;
# thrust headings across the Sun line, asteroids on the night side, none near the Sun. The Earth is 1 AU from the Sun.
DEFAULT_TARGETS = (
    Target("earth", "earth", (0.7660, 0.6428, 0.0), 0.0, 1.534),
    Target("thrust_a", "thrust", (0.1045, 0.9945, 0.0)),
    Target("thrust_b", "thrust", (-0.2079, 0.9744, 0.0872)),
    Target("asteroid_a", "asteroid", (-0.8660, 0.4830, 0.1294), 1.2e-3, 0.5),
    Target("asteroid_b", "asteroid", (-0.9397, -0.3368, 0.0602), 8.0e-4, 1.2),
    Target("asteroid_c", "asteroid", (-0.6428, 0.7544, -0.1330), 5.0e-4, 0.8),
    Target("asteroid_d", "asteroid", (-0.3420, -0.9254, -0.1632), 1.0e-3, 0.6),
)


@dataclass(frozen=True, slots=True)
class SpacecraftConfig:
    """One spacecraft in one sky. Times in seconds, angles in radians, powers in watts, data in megabits."""

    # integration and control
    time_step_s: float = 0.5
    quiet_time_step_s: float = 1.0
    control_period_s: int = 1
    # surroundings: the Sun at time 0, from a circular orbit; or the spacecraft's own elements instead of the two
    targets: tuple[Target, ...] = DEFAULT_TARGETS
    sun_direction_I: Vector = (1.0, 0.0, 0.0)
    sun_distance_au: float = 1.01
    orbit: Elements | None = None
    sky_period_s: int = 60
    initial_target: str = "earth"
    initial_actuators: str = "wheels"  # or thrusters
    # attitude control (assumptions: slew rate, acceleration, settling)
    slew_rate_limit_rad_s: float = math.radians(0.15)
    slew_acceleration_limit_rad_s2: float = 1.0e-4
    control_bandwidth_rad_s: float = 0.1
    control_damping: float = 0.9
    settle_error_rad: float = 5.0e-4
    settle_rate_rad_s: float = 5.0e-5
    settle_hold_s: int = 60
    wing_rate_limit_rad_s: float = math.radians(0.25)
    # cones (assumptions): the Sun off the camera's boresight, the Sun within the field of the fine Sun sensor
    camera_sun_exclusion_rad: float = math.radians(40.0)
    sun_sensor_half_field_rad: float = math.radians(64.0)
    # Sun standby: +X to the Sun, and a turn about it in an hour; settled within these (coarse Sun sensors alone)
    sun_standby_spin_rad_s: float = 2.0 * math.pi / 3600.0
    sun_standby_error_rad: float = 0.02
    sun_standby_rate_rad_s: float = 2.0e-4
    # wheels (class of a 12 N m s, 0.2 N m wheel); each starts at a random speed within +-initial
    wheel_torque_limit_Nm: float = 0.2
    wheel_speed_limit_rad_s: float = 628.0
    wheel_initial_speed_rad_s: float = 100.0
    # bearings: viscous (N m s) and dry (N m) friction, and the share of it that the drives leave (assumptions)
    wheel_viscous_Nms: float = 4.0e-6
    wheel_dry_Nm: float = 5.0e-4
    wheel_friction_left: float = 0.1
    # hydrazine thrusters (assumptions: lever arm, minimum opening; force and mass of the flight's class)
    thruster_N: float = 0.9
    thruster_lever_m: float = 0.5
    thruster_minimum_s: float = 0.005
    thruster_specific_impulse_s: float = 220.0
    hydrazine_kg: float = 31.1
    unload_Nm: float = 0.05
    unloaded_Nms: float = 0.3
    # sunlight: pressure at 1 AU, area, and where it acts from the centre of mass (assumptions but the pressure)
    solar_pressure_1au_Pa: float = 4.56e-6
    sunlit_area_m2: float = 26.0
    pressure_centre_B_m: Vector = (0.0, 0.02, -0.05)
    # attitude sensors (assumptions of a class: gyro of 0.2 arcsec/s^1/2, tracker of 2 and 12 arcsec)
    attitude_source: str = "estimator"
    gyro_angle_walk_rad_rs: float = 1.0e-6
    gyro_rate_noise_rad_s: float = 2.0e-6
    gyro_bias_rad_s: float = 5.0e-6
    gyro_bias_walk_rad_s_rs: float = 1.0e-10
    tracker_noise_rad: tuple[float, float, float] = (6.0e-5, 1.0e-5, 1.0e-5)
    tracker_frames: bool = False  # measure with pictures of the sky, at a tenth of a second each, instead of the noise
    tracker_rate_limit_rad_s: float = math.radians(0.07)
    tracker_sun_exclusion_rad: float = math.radians(30.0)
    sun_sensor_noise_rad: float = math.radians(0.1)
    initial_attitude_error_rad: float = 1.0e-5
    initial_bias_error_rad_s: float = 1.0e-7
    # power: 2,500 W at 1 AU and normal incidence
    array_power_1au_W: float = 2500.0
    base_load_W: float = 350.0
    battery_capacity_Wh: float = 670.0
    battery_initial_soc: float = 0.95
    battery_charge_limit_W: float = 300.0
    battery_charge_efficiency: float = 0.9
    # ion engine (assumptions: gimbals, durations, power outside thrusting)
    xenon_kg: float = 81.5
    gimbal_limit_rad: float = math.radians(5.0)
    gimbal_rate_limit_rad_s: float = math.radians(0.5)
    gimbal_arm_m: float = 0.88
    engine_start_s: tuple[float, float] = (600.0, 1200.0)
    engine_stop_s: tuple[float, float] = (60.0, 240.0)
    engine_starting_W: float = 200.0
    engine_ready_W: float = 100.0
    engine_stopping_W: float = 100.0
    # camera (assumptions: warm-up, read-out; a 1024 x 1024 frame of 12 bits is 12.6 Mbit)
    camera_warmup_s: tuple[float, float] = (600.0, 900.0)
    camera_readout_s: tuple[float, float] = (20.0, 40.0)
    camera_warming_W: float = 150.0
    camera_on_W: float = 100.0
    camera_exposure_limit_s: float = 600.0
    camera_pointing_error_rad: float = 3.0e-3
    camera_smear_rate_rad_s: float = 1.0e-4
    camera_frames: bool = True  # make each frame and look for the target in it; else the limits above alone decide
    image_Mbit: float = 12.6
    # radio and recorder
    radio_on_W: float = 15.0
    radio_downlinking_W: float = 60.0
    downlink_Mbit_s: float = 0.02
    antenna_half_beam_rad: float = math.radians(0.5)
    recorder_capacity_Mbit: float = 2000.0
    # ground stations by name, least elevation, and the Greenwich meridian's angle from +X of the equator at time 0
    ground_stations: str = "goldstone madrid canberra"
    station_elevation_rad: float = math.radians(10.0)
    sidereal_angle_rad: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what cannot fly; every message names the field."""
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, float | int) and not (math.isfinite(value) and value >= 0):
                raise ConfigurationError(f"{field.name}: expected a finite number of at least 0, found {value}")
        self._check_spans()
        self._check_sensors()
        self._check_steps()
        self._check_targets()

    def _check_spans(self) -> None:
        for name in ("engine_start_s", "engine_stop_s", "camera_warmup_s", "camera_readout_s"):
            low, high = getattr(self, name)
            if not 0.0 < low <= high < math.inf:
                raise ConfigurationError(f"{name}: expected 0 < lower <= upper, found {low}, {high}")
        for name in ("battery_initial_soc", "battery_charge_efficiency"):
            if getattr(self, name) > 1.0:
                raise ConfigurationError(f"{name}: expected at most 1, found {getattr(self, name)}")
        for name in ("camera_sun_exclusion_rad", "sun_sensor_half_field_rad"):
            if getattr(self, name) > math.pi:
                raise ConfigurationError(f"{name}: expected at most half a turn, found {getattr(self, name)}")
        positive = (
            "slew_rate_limit_rad_s",
            "slew_acceleration_limit_rad_s2",
            "control_bandwidth_rad_s",
            "battery_capacity_Wh",
            "sun_distance_au",
        )
        for name in positive:
            if getattr(self, name) == 0.0:
                raise ConfigurationError(f"{name}: expected more than 0, found 0")

    def _check_sensors(self) -> None:
        if self.attitude_source not in ATTITUDE_SOURCES:
            expected = " or ".join(ATTITUDE_SOURCES)
            raise ConfigurationError(f"attitude_source: expected {expected}, found {self.attitude_source!r}")
        if len(self.tracker_noise_rad) != 3 or not all(0.0 < noise < 0.1 for noise in self.tracker_noise_rad):
            raise ConfigurationError(
                f"tracker_noise_rad: expected three numbers over 0 and under 0.1, found {self.tracker_noise_rad}"
            )
        for name in ("gyro_angle_walk_rad_rs", "sun_sensor_noise_rad"):
            if getattr(self, name) == 0.0:
                raise ConfigurationError(f"{name}: expected more than 0, found 0: the filter divides by it")

    def _check_steps(self) -> None:
        if self.control_period_s < 1:
            raise ConfigurationError(f"control_period_s: expected at least 1, found {self.control_period_s}")
        if self.sky_period_s < 1 or self.sky_period_s % self.control_period_s:
            raise ConfigurationError(
                f"sky_period_s: expected a multiple of control_period_s ({self.control_period_s} s), "
                f"found {self.sky_period_s}"
            )
        for name in ("time_step_s", "quiet_time_step_s"):
            step = getattr(self, name)
            if step == 0.0 or not (self.control_period_s / step).is_integer():
                raise ConfigurationError(
                    f"{name}: expected a whole fraction of control_period_s ({self.control_period_s} s), found {step}"
                )

    def _check_targets(self) -> None:
        names = [target.name for target in self.targets]
        for target in self.targets:
            where = f"targets, {target.name!r}"
            if names.count(target.name) > 1:
                raise ConfigurationError(
                    f"{where}: expected a name of its own, found it {names.count(target.name)} times"
                )
            if target.kind not in TARGET_KINDS:
                raise ConfigurationError(
                    f"{where}: expected a kind of {', '.join(TARGET_KINDS)}, found {target.kind!r}"
                )
            if not 0.0 < dot(target.direction_I, target.direction_I) < math.inf:
                raise ConfigurationError(f"{where}: expected a direction with a length, found {target.direction_I}")
            if not 0.0 <= target.distance_au < math.inf:
                raise ConfigurationError(f"{where}: expected a distance of at least 0, found {target.distance_au} AU")
        for name in self.ground_stations.split():
            if name not in STATIONS:
                raise ConfigurationError(f"ground_stations: expected of {', '.join(STATIONS)}, found {name!r}")
        if not 0.0 < dot(self.sun_direction_I, self.sun_direction_I) < math.inf:
            raise ConfigurationError(f"sun_direction_I: expected a direction, found {self.sun_direction_I}")
        if self.initial_target not in names:
            raise ConfigurationError(
                f"initial_target: expected one of {', '.join(names)}, found {self.initial_target!r}"
            )
        if self.initial_actuators not in ("wheels", "thrusters"):
            raise ConfigurationError(
                f"initial_actuators: expected wheels or thrusters, found {self.initial_actuators!r}"
            )
        if sum(target.kind == "earth" for target in self.targets) != 1:
            raise ConfigurationError(f"targets: expected exactly one of kind earth, found {', '.join(names)}")
