"""The spacecraft: its components in one update order, commanded and observed as from the ground.

One seeded generator a component, spawned from the run's seed in a fixed order: the same configuration, seed, commands
and injections give the same telemetry to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from sim import flight_law as loop
from sim.assembly import load_assembly
from sim.attitude_modes import ACTUATORS, AttitudeModes
from sim.components import thrusters
from sim.components.camera import Camera
from sim.components.gimbals import Gimbals
from sim.components.ion_engine import IonEngine
from sim.components.power import SWITCHED_W, TOO_COLD, Power
from sim.components.radio import RATE_MBIT_S, Radio, Recorder
from sim.components.switchboard import Switchboard
from sim.components.terminal import Acknowledgement, BusTerminal
from sim.components.thermal import Thermal
from sim.components.thrusters import Thrusters
from sim.components.wheels import Wheels
from sim.components.wings import Wings
from sim.config import SpacecraftConfig
from sim.control import AttitudeControl
from sim.dictionary import TELECOMMANDS, TELEMETRY, TERMINALS, TelemetryValue, round_telemetry, why_wrong
from sim.environment import Environment
from sim.errors import ConfigurationError
from sim.estimator import Estimator, Sensors
from sim.faults import FaultHook, FaultSchedule
from sim.filter_law import GYRO_BIAS, TRACKER_POWERED
from sim.flight_loop import FlightLoop, Units
from sim.ground import GroundSegment
from sim.imager import Imager
from sim.kernels import Memory
from sim.navigation import Frame
from sim.physics import Physics
from sim.quaternion import Vector, rotate_inverse
from sim.recorded_state import RecordedState
from sim.star_tracker import StarTracker
from sim.views import Views

# Generators are spawned in this order; new ones go to the end, or old seeds would give new runs.
_GENERATORS = ("wheels", "ips", "micas", "sensors", "thermal", "optics", "tracker")
_SWITCH_ON = ("ips.start", "ips.thrust", "micas.power", "micas.expose", "radio.power", "radio.downlink")
_UNDERVOLTAGE = "bus undervoltage: only base loads until the battery recovers"


class Spacecraft:
    """A Deep-Space-One-like spacecraft. Starts settled on the configuration's initial target, in standby, at time 0."""

    def __init__(self, config: SpacecraftConfig, seed: int) -> None:
        streams = np.random.SeedSequence(seed).spawn(len(_GENERATORS))
        generators = {name: np.random.default_rng(stream) for name, stream in zip(_GENERATORS, streams, strict=True)}
        self._config = config
        self._ticks = 0
        self._values: dict[str, TelemetryValue] = dict.fromkeys(TELEMETRY, 0.0)
        self._assembly = load_assembly(config.time_step_s)
        self.environment = Environment(config)
        attitude_IB = self.environment.target_attitude_IB(config.initial_target, 0.0)
        spread = config.wheel_initial_speed_rad_s
        speeds = generators["wheels"].uniform(-spread, spread, 4).tolist()
        self._physics = Physics(self._assembly, attitude_IB, speeds)
        sun_B = rotate_inverse(attitude_IB, self.environment.sun_direction_I(0.0))
        self._wings = Wings(config.wing_rate_limit_rad_s, sun_B)
        self._physics.place_wings(self._wings.setpoint_rad)
        self._control = AttitudeControl(config, self._assembly.inertia_kg_m2, attitude_IB, config.initial_target)
        self._wheels = Wheels(
            self._assembly.wheel_axes_B,
            self._assembly.wheel_inertia_kg_m2,
            config.wheel_torque_limit_Nm,
            config.wheel_speed_limit_rad_s,
            speeds,
            (config.wheel_viscous_Nms, config.wheel_dry_Nm, config.wheel_friction_left),
        )
        self._thrusters = Thrusters(config)
        tracker = StarTracker(generators["tracker"]) if config.tracker_frames else None
        self._sensors = Sensors(config, generators["sensors"], attitude_IB, tracker)
        bias = self._sensors.memory[GYRO_BIAS : GYRO_BIAS + 3].copy()
        self._estimator = Estimator(config, generators["sensors"], attitude_IB, bias)
        self._thermal = Thermal(config, generators["thermal"])
        self._engine = IonEngine(config, generators["ips"], self._thermal.cathode)
        self._gimbals = Gimbals(config)
        self._camera = Camera(config, generators["micas"], self._thermal.camera)
        self._imager = Imager(self.environment, generators["optics"])
        self._power = Power(config)
        self._radio = Radio(config)
        self._recorder = Recorder(config.recorder_capacity_Mbit)
        self._terminals = {name: BusTerminal(name) for name in TERMINALS}
        self._switchboard = Switchboard()
        self._ground = GroundSegment()
        self._faults = FaultSchedule(self._fault_hooks())
        units = Units(
            self._control,
            self._wheels,
            self._thrusters,
            self._wings,
            self._power,
            self._sensors,
            self._estimator,
            self._engine,
            self._recorder,
            self._gimbals,
            self._thermal,
        )
        self._loop = FlightLoop(config, self._physics, units, self._new_surroundings())
        self._surroundings = self._loop.surroundings
        steered = (self._thrusters, self._engine)
        self._modes = AttitudeModes(config, self.environment, self._control, steered, self._surroundings)
        self._follow_sky()
        self._modes.actuators(config.initial_actuators)
        # Units whose telemetry changes only when something is switched, and whether it has been since the last look.
        self._switched_units = (
            self._control,
            self._power,
            self._radio,
            self._switchboard,
            self._thrusters,
            self._engine,
            self._camera,
            self._imager,
        )
        self._switched = True
        self._was_undervoltage = False
        self._views = Views(self._assembly.model, self.environment, self._physics)
        self._balance()

    def __repr__(self) -> str:
        return f"Spacecraft(time={self.time}, {self._control!r}, {self._engine!r}, {self._camera!r})"

    @property
    def time(self) -> int:
        """Seconds of simulation clock."""
        return self._ticks * self._config.control_period_s

    @property
    def physics_steps(self) -> int:
        """Integration steps so far."""
        return self._physics.steps

    @property
    def config(self) -> SpacecraftConfig:
        """What it was made from."""
        return self._config

    def send(self, name: str, arguments: Mapping[str, TelemetryValue]) -> Acknowledgement | None:
        """Put a telecommand of `sim.dictionary` on the bus; it takes effect at once.

        A wrong or untimely one is refused with the reason. None when the terminal does not answer.
        """
        command = TELECOMMANDS.get(name)
        if command is None:
            return Acknowledgement(False, f"command: expected one of {', '.join(TELECOMMANDS)}, found {name!r}")
        reason = why_wrong(command, arguments)
        target = arguments.get("target")
        if reason is None and target is not None and target not in self.environment.targets:
            known = ", ".join(self.environment.targets)
            reason = f"{name}.target: expected one of {known}, found {target!r}"
        if reason is not None:
            return Acknowledgement(False, reason)
        acknowledgement = self._terminals[command.terminal].deliver(lambda: self._execute(name, arguments))
        self._balance()
        return acknowledgement

    def advance(self, until_s: float) -> None:
        """Let time pass up to `until_s`, a multiple of the control period not before now.

        Raises `ConfigurationError` for another time, `SimulationError` when the physics break down.
        """
        period = self._config.control_period_s
        if not (math.isfinite(until_s) and until_s >= self.time and until_s % period == 0):
            raise ConfigurationError(
                f"advance: expected a multiple of {period} s that is at least {self.time} s, found {until_s}"
            )
        last = round(until_s / period)
        while self._ticks < last:
            self._tick(float(period))

    def telemetry(self) -> dict[str, TelemetryValue]:
        """Every channel of `sim.dictionary` now, rounded to its resolution, in the table's order."""
        values = self._values
        if self._switched:
            self._switched = False
            for unit in self._switched_units:
                values.update(round_telemetry({**unit.telemetry()}))
        *readings, settled, tracker_valid, cones_kept, actuators = self._loop.readings()
        values.update(zip(self._loop.channels, readings, strict=True))
        values["acs.state"] = "settled" if settled else "slewing"
        values["tracker.state"] = "tracking" if tracker_valid else self._sensors.tracker_state
        values["acs.actuators"] = ACTUATORS[int(actuators)]
        values["acs.mode"] = self._modes.mode(int(actuators))
        values["acs.cones"] = "kept" if cones_kept else "broken"
        return values.copy()

    def inject(
        self,
        fault_name: str,
        at_s: float,
        end_s: float | None = None,
        parameters: Mapping[str, float] | None = None,
    ) -> None:
        """Let a fault of `sim.faults` begin at `at_s` (at once if that is past) and end at `end_s` (None: never)."""
        self._faults.add(fault_name, at_s, end_s, parameters or {})
        if self._faults.update(self.time):
            self._balance()

    def state_for_recording(self) -> RecordedState:
        """The raw state now."""
        physics = self._physics
        return RecordedState(
            time_s=float(self.time),
            position_I_m=physics.position_I,
            velocity_I_m_s=physics.velocity_I,
            attitude_IB=physics.attitude_IB,
            rate_B_rad_s=physics.rate_B,
            wheel_speeds_rad_s=tuple(physics.wheel_speeds_rad_s),
            wing_angles_rad=tuple(physics.wing_angles_rad),
            mass_kg=self._assembly.total_mass_kg - self._propellant_used_kg,
            thrust_I_N=self._thrust_I_N,
            sun_direction_I=self.environment.sun_direction_I(self.time),
            sun_distance_au=self.environment.sun_distance_au(self.time),
            heliocentric_position_I_m=self.environment.position_I_m(self.time),
            active_faults=self._faults.active,
        )

    @property
    def received_Mbit(self) -> float:
        """What has arrived on the ground, a light time after it was sent."""
        return self._ground.received_Mbit(float(self.time))

    @property
    def last_frame(self) -> Frame | None:
        """The science camera's last frame with what was found in it; None before the first."""
        return self._imager.frame

    def angular_momentum_I(self) -> Vector:
        """Of spacecraft and wheels about the centre of mass, N m s: constant without sunlight and thrusters."""
        return self._physics.angular_momentum_I()

    def render(self, camera: str, width: int, height: int) -> NDArray[np.uint8]:
        """What a camera sees now, as rows, columns and RGB of 0 to 255: `micas`, or `chase` from outside.

        Raises `ConfigurationError` for another camera or size; `chase` without offscreen OpenGL `RenderingUnavailable`.
        """
        thrusting = self._engine.state == "thrusting"
        return self._views.render(camera, width, height, time_s=float(self.time), thrusting=thrusting)

    def close(self) -> None:
        """Give back what drawing views holds; the spacecraft flies on."""
        self._views.close()

    @property
    def _propellant_used_kg(self) -> float:
        return self._engine.xenon_used_kg + self._thrusters.used_kg

    @property
    def _thrust_I_N(self) -> Vector:
        x, y, z = self._surroundings[loop.THRUST_I : loop.THRUST_I + 3].tolist()
        return (x, y, z)

    def _take_out_propellant(self) -> None:
        used_kg = self._propellant_used_kg
        if used_kg - self._surroundings[loop.PROPELLANT_TAKEN_KG] >= loop.PROPELLANT_GRAIN_KG:
            self._surroundings[loop.PROPELLANT_TAKEN_KG] = used_kg
            self._physics.set_xenon_used(used_kg)

    def _new_surroundings(self) -> Memory:
        config = self._config
        e = loop.surroundings()
        e[loop.PRESSURE_CENTRE : loop.PRESSURE_CENTRE + 3] = config.pressure_centre_B_m
        e[loop.BEAM_COS] = math.cos(config.antenna_half_beam_rad)
        e[loop.USE_TRUTH] = config.attitude_source == "truth"
        e[loop.UNLOAD_NM], e[loop.UNLOADED_NMS] = config.unload_Nm, config.unloaded_Nms
        return e

    def _tick(self, dt_s: float) -> None:
        self._loop.before(dt_s)
        changed = False
        if self._engine.busy:
            state = self._engine.state
            self._engine.step(dt_s)
            changed = state != self._engine.state
        if self._camera.busy:
            changed = self._operate_camera(dt_s) or changed
        changed = self._loop.after(dt_s) or changed
        self._ticks += 1
        if self.time % self._config.sky_period_s == 0:
            self._follow_sky()
        if changed or self._was_undervoltage:
            self._balance()
        if self._faults.update(self.time):
            self._balance()

    def _operate_camera(self, dt_s: float) -> bool:
        camera, state = self._camera, self._camera.state
        if camera.shutter_open:
            error = self.environment.pointing_error_rad(self._physics.attitude_IB, camera.target, float(self.time))
            camera.watch(error, math.hypot(*self._physics.rate_B))
            if self._config.camera_frames:
                self._imager.look(self._physics.attitude_IB, self._estimator.attitude_IB)
        good = camera.step(dt_s)
        if good is not None:
            if self._config.camera_frames:
                good = self._imager.develop(camera.target, camera.exposed_s, float(self.time)) and good
            if self._recorder.store(self._config.image_Mbit) and good:
                camera.images += 1
        return state != camera.state

    def _balance(self) -> None:
        """Who has power, and what all draw: whenever something was switched, not every second."""
        board, undervoltage = self._switchboard, self._power.undervoltage
        self._switched = True
        self._was_undervoltage = undervoltage
        self._camera.supply(board.fed("neb2") and not undervoltage)
        if undervoltage or not board.fed("neb2"):
            self._engine.trip()
        if undervoltage:
            self._radio.trip()
        self._sensors.memory[TRACKER_POWERED] = board.fed("neb1")
        self._thrusters.memory[thrusters.POWERED] = board.fed("neb1s")
        self._terminals["lpe"].powered = board.lpe_fed
        board.carry(self._camera.power_W)
        self._engine.notice()
        self._modes.notice()
        self._recorder.memory[RATE_MBIT_S] = self._radio.rate_Mbit_s
        self._take_out_propellant()
        self._surroundings[loop.THRUST_N] = self._engine.thrust_N
        load_W = self._engine.power_W + self._camera.power_W + self._radio.power_W + board.power_W
        self._power.memory[SWITCHED_W] = load_W
        self._loop.feel_light()

    def _follow_sky(self) -> None:
        """Sun, Earth and targets move on: look again, and go on pointing at what is pointed at."""
        now_s = float(self.time)
        self.environment.gain(now_s, self._physics.velocity_I)
        self._loop.look_around(self.environment, now_s)
        self._modes.follow(now_s)
        self._thrusters.memory[thrusters.FROZEN] = self._thermal.tank_frozen
        self._power.memory[TOO_COLD] = self._thermal.battery_cold
        self._ground.sent(now_s, self.environment.light_time_s(now_s), self._recorder.downlinked_Mbit)
        self._values.update(round_telemetry({**self.environment.telemetry(now_s)}))

    def _execute(self, name: str, arguments: Mapping[str, TelemetryValue]) -> str | None:
        if name.startswith("ips.") and not self._switchboard.fed("neb2"):
            return f"{name} needs power from NEB2, found none"
        if self._power.undervoltage and name in _SWITCH_ON and arguments.get("on") is not False:
            return _UNDERVOLTAGE
        modes = self._modes
        actions: dict[str, Callable[[], str | None]] = {
            "acs.point": lambda: modes.point(str(arguments["target"]), float(self.time)),
            "acs.standby": lambda: modes.standby(float(self.time)),
            "acs.sun_standby": modes.sun_standby,
            "acs.actuators": lambda: modes.actuators(str(arguments["name"])),
            "acs.unload": modes.unload,
            "rcs.mode": lambda: self._thrusters.select(str(arguments["mode"])),
            "pasm.power": lambda: self._switchboard.power(bool(arguments["on"])),
            "lpe.status": lambda: None,
            "terminal.reset": lambda: self._terminals[str(arguments["name"])].reset(),  # noqa: PLW0108
            "ips.start": self._engine.start,
            "ips.thrust": lambda: self._engine.thrust(int(arguments["level"])),
            "ips.idle": self._engine.idle,
            "ips.stop": self._engine.stop,
            "micas.power": lambda: self._camera.power(bool(arguments["on"])),
            "micas.expose": lambda: self._camera.expose(str(arguments["target"]), float(arguments["seconds"])),
            "radio.power": lambda: self._radio.power(bool(arguments["on"])),
            "radio.downlink": lambda: self._radio.downlink(bool(arguments["on"])),
        }
        return actions[name]()

    def _fault_hooks(self) -> dict[str, FaultHook]:
        hooks: dict[str, FaultHook] = {
            "acs": self._control,
            "wheels": self._wheels,
            "ips": self._engine,
            "gimbals": self._gimbals,
            "wings": self._wings,
            "thermal": self._thermal,
            "micas": self._camera,
            "power": self._power,
            "radio": self._radio,
            "recorder": self._recorder,
            "rcs": self._thrusters,
            "sensors": self._sensors,
            "switchboard": self._switchboard,
        }
        hooks.update({f"terminal.{name}": terminal for name, terminal in self._terminals.items()})
        return hooks
