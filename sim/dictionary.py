"""The spacecraft's telecommands and telemetry: one table each, the contract with whoever flies it.

A telemetry value is rounded to its channel's resolution before anybody outside sees it. A telecommand's arguments are
checked against its row before its terminal sees them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from sim.components.ion_engine import LEVELS
from sim.components.thrusters import MODES

TelemetryValue = float | int | str | bool


@dataclass(frozen=True, slots=True)
class Argument:
    """An argument: its type by name (str, bool, int, float), unit, what it may be (empty: anything of the type)."""

    name: str
    type: str
    unit: str = ""
    choices: tuple[int | str, ...] = ()


@dataclass(frozen=True, slots=True)
class Telecommand:
    """A row of the telecommand table; `terminal` is the bus terminal that takes it."""

    name: str
    terminal: str
    arguments: tuple[Argument, ...]
    meaning: str


@dataclass(frozen=True, slots=True)
class Channel:
    """A row of the telemetry table. `resolution`: what one count is worth, a power of ten; 0: nothing to round."""

    name: str
    unit: str
    type: str
    resolution: float
    meaning: str


RESETTABLE = ("acs", "ips", "lpe", "micas", "pdu", "radio")

_TELECOMMANDS = (
    Telecommand("acs.point", "acs", (Argument("target", "str"),), "slew to a target and hold it with the wheels"),
    Telecommand("acs.standby", "acs", (), "slew to the Earth and stay there, safe"),
    Telecommand("acs.sun_standby", "acs", (), "turn +X to the Sun without star tracker, spin slowly, safe"),
    Telecommand(
        "acs.actuators",
        "acs",
        (Argument("name", "str", "", ("wheels", "thrusters", "gimbals")),),
        "hold and turn with wheels or thrusters, or hold with the thrusting engine's gimbals",
    ),
    Telecommand("acs.unload", "acs", (), "let the thrusters take the momentum out of the wheels"),
    Telecommand(
        "rcs.mode",
        "acs",
        (Argument("mode", "str", "", MODES),),
        "which four thrusters turn about Y: the x-thrusters or the z-thrusters",
    ),
    Telecommand("pasm.power", "pdu", (Argument("on", "bool"),), "throw the power switch PASM, which feeds the LPE"),
    Telecommand("lpe.status", "lpe", (), "ask the LPE's terminal for a sign of life"),
    Telecommand(
        "terminal.reset", "bus", (Argument("name", "str", "", RESETTABLE),), "start a bus terminal's electronics anew"
    ),
    Telecommand("ips.start", "ips", (), "start the ion engine: standby to ready"),
    Telecommand(
        "ips.thrust", "ips", (Argument("level", "int", "", LEVELS),), "thrust at a level, from ready or thrusting"
    ),
    Telecommand("ips.idle", "ips", (), "stop thrusting, stay ready"),
    Telecommand("ips.stop", "ips", (), "shut the ion engine down: to standby"),
    Telecommand("micas.power", "micas", (Argument("on", "bool"),), "throw the camera's power switch"),
    Telecommand(
        "micas.expose",
        "micas",
        (Argument("target", "str"), Argument("seconds", "float", "s")),
        "take one image of what should be the target",
    ),
    Telecommand("radio.power", "radio", (Argument("on", "bool"),), "transmitter on or off"),
    Telecommand("radio.downlink", "radio", (Argument("on", "bool"),), "play the recorder to the ground, or stop"),
)
TELECOMMANDS: Mapping[str, Telecommand] = MappingProxyType({row.name: row for row in _TELECOMMANDS})
TERMINALS = tuple(sorted({row.terminal for row in _TELECOMMANDS}))

_TELEMETRY = (
    Channel("acs.mode", "", "str", 0, "wheels | rcs | tvc | earth_standby | sun_standby"),
    Channel("acs.target", "", "str", 0, "target held or on the way to; sun in Sun standby"),
    Channel("acs.state", "", "str", 0, "slewing | settled"),
    Channel("acs.error_rad", "rad", "float", 1e-6, "angle to the attitude that the target asks for"),
    Channel("acs.rate_rad_s", "rad/s", "float", 1e-7, "size of the angular rate"),
    Channel("wheels.speed_1_rad_s", "rad/s", "float", 0.01, "speed of wheel 1 against the bus"),
    Channel("wheels.speed_2_rad_s", "rad/s", "float", 0.01, "speed of wheel 2 against the bus"),
    Channel("wheels.speed_3_rad_s", "rad/s", "float", 0.01, "speed of wheel 3 against the bus"),
    Channel("wheels.speed_4_rad_s", "rad/s", "float", 0.01, "speed of wheel 4 against the bus"),
    Channel("wheels.momentum_Nms", "N m s", "float", 0.001, "size of the momentum in the wheels"),
    Channel("ips.state", "", "str", 0, "standby | starting | ready | thrusting | stopping"),
    Channel("ips.level", "", "int", 0, "throttle level, 0 when not thrusting"),
    Channel("ips.thrust_N", "N", "float", 1e-5, "thrust"),
    Channel("ips.power_W", "W", "float", 0.1, "power of the ion engine"),
    Channel("ips.xenon_kg", "kg", "float", 1e-5, "xenon left"),
    Channel("ips.thrust_seconds", "s", "float", 1.0, "time thrusting since the start"),
    Channel("micas.switch", "", "str", 0, "on | off: status of the power switch"),
    Channel("micas.state", "", "str", 0, "off | warming | ready | exposing"),
    Channel("micas.images", "", "int", 0, "good images since the start"),
    Channel("optnav.status", "", "str", 0, "none | stars | attitude (what the target was measured against) | why not"),
    Channel("optnav.longitude_rad", "rad", "float", 1e-7, "the target of the last frame, in the inertial frame"),
    Channel("optnav.latitude_rad", "rad", "float", 1e-7, "the same, latitude over the ecliptic"),
    Channel("micas.power_W", "W", "float", 0.1, "power of the camera"),
    Channel("power.array_W", "W", "float", 0.1, "what the solar array can give now"),
    Channel("power.load_W", "W", "float", 0.1, "what all loads draw"),
    Channel("power.margin_W", "W", "float", 0.1, "array less load; negative: from the battery"),
    Channel("power.bus", "", "str", 0, "nominal | undervoltage"),
    Channel("battery.soc", "", "float", 1e-4, "charge of the battery, 0 to 1"),
    Channel("radio.state", "", "str", 0, "off | on | downlinking"),
    Channel("recorder.stored_Mbit", "Mbit", "float", 0.01, "data waiting for a downlink"),
    Channel("recorder.downlinked_Mbit", "Mbit", "float", 0.01, "data sent to the ground"),
    Channel("neb1.status", "", "str", 0, "on | off: what the status sensor of power bus NEB1 says"),
    Channel("neb1.current_A", "A", "float", 0.01, "current of power bus NEB1"),
    Channel("neb1s.status", "", "str", 0, "on | off: what the status sensor of power bus NEB1-S says"),
    Channel("neb1s.current_A", "A", "float", 0.01, "current of power bus NEB1-S"),
    Channel("neb2.status", "", "str", 0, "on | off: what the status sensor of power bus NEB2 says"),
    Channel("neb2.current_A", "A", "float", 0.01, "current of power bus NEB2"),
    Channel("pasm.switch", "", "str", 0, "on | off: status of the power switch PASM"),
    Channel("rcs.mode", "", "str", 0, "x_for_y | z_for_y: which thrusters turn about Y"),
    Channel("rcs.latch", "", "str", 0, "open | closed: the tank's latch valve; closed, no thruster fires"),
    Channel("rcs.hydrazine_kg", "kg", "float", 1e-4, "hydrazine left"),
    Channel("tracker.state", "", "str", 0, "tracking | blind | failed | off: star tracker"),
    Channel("acs.estimate_sigma_rad", "rad", "float", 1e-7, "standard deviation that the filter gives its attitude"),
    Channel("acs.actuators", "", "str", 0, "wheels | unloading | thrusters | gimbals"),
    Channel("acs.cones", "", "str", 0, "kept | broken: the Sun off the camera, the Sun on the fine Sun sensor"),
    Channel("acs.sun_from_camera_rad", "rad", "float", 1e-4, "angle from the camera's boresight to the Sun"),
    Channel("acs.sun_from_sensor_rad", "rad", "float", 1e-4, "angle from the fine Sun sensor's axis to the Sun"),
    Channel("ips.gimbal_x_rad", "rad", "float", 1e-5, "angle of the ion engine's gimbal about X"),
    Channel("ips.gimbal_y_rad", "rad", "float", 1e-5, "angle of the ion engine's gimbal about Y"),
    Channel("sun_sensor.x", "", "float", 1e-4, "the Sun's direction as its sensors see it, body +X; 0: none"),
    Channel("sun_sensor.y", "", "float", 1e-4, "the same along +Y"),
    Channel("sun_sensor.z", "", "float", 1e-4, "the same along +Z"),
    Channel("sun.distance_au", "AU", "float", 1e-5, "distance of the Sun, from the ephemeris on board"),
    Channel("earth.station", "", "str", 0, "ground station that will hear what is sent now, or none"),
    Channel("thermal.camera_C", "deg C", "float", 0.1, "temperature of the camera"),
    Channel("thermal.cathode_C", "deg C", "float", 0.1, "temperature of the ion engine's cathodes"),
    Channel("thermal.battery_C", "deg C", "float", 0.1, "temperature of the battery"),
    Channel("thermal.tank_C", "deg C", "float", 0.1, "temperature of the hydrazine tank"),
    Channel("earth.light_time_s", "s", "float", 0.1, "what a signal takes to the Earth"),
)
TELEMETRY: Mapping[str, Channel] = MappingProxyType({row.name: row for row in _TELEMETRY})

# Resolutions are powers of ten: a count divided by counts per unit is then the nearest float to its decimal.
_COUNTS_PER_UNIT: Mapping[str, float] = MappingProxyType(
    {row.name: 10.0 ** -round(math.log10(row.resolution)) for row in _TELEMETRY if row.resolution}
)


def counts_per_unit(channel: str) -> float:
    """Counts of an analogue channel's resolution in one of its units."""
    return _COUNTS_PER_UNIT[channel]


def round_telemetry(values: dict[str, TelemetryValue]) -> dict[str, TelemetryValue]:
    """Round every analogue channel of `values`, in place, to its resolution; there is no negative zero."""
    for name, value in values.items():
        counts = _COUNTS_PER_UNIT.get(name)
        if counts is not None and value.__class__ is float:
            values[name] = math.floor(float(value) * counts + 0.5) / counts
    return values


def why_wrong(command: Telecommand, arguments: Mapping[str, TelemetryValue]) -> str | None:
    """The reason to refuse `arguments` for `command`: names, types, choices; None when they are right."""
    expected = [argument.name for argument in command.arguments]
    if sorted(arguments) != sorted(expected):
        return f"{command.name}: expected arguments {expected or 'none'}, found {sorted(arguments) or 'none'}"
    for argument in command.arguments:
        value = arguments[argument.name]
        where = f"{command.name}.{argument.name}"
        if not _has_type(value, argument.type):
            return f"{where}: expected {argument.type}, found {value!r}"
        if argument.choices and value not in argument.choices:
            return f"{where}: expected one of {', '.join(map(str, argument.choices))}, found {value!r}"
    return None


def _has_type(value: TelemetryValue, name: str) -> bool:
    if name == "str":
        return isinstance(value, str)
    if name == "bool":
        return isinstance(value, bool)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return isinstance(value, int) if name == "int" else math.isfinite(value)
