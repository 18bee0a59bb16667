"""What the attitude control is told to do: targets, standbys, actuators; and what it refuses.

Modes, as `acs.mode` names them: `wheels` and `rcs` point and turn with the wheels or the thrusters; `tvc` holds with
the gimbals of the thrusting ion engine about X and Y and leaves the turn about Z to the wheels or thrusters that were
in charge before, and gives the attitude back to them when the thrust ends; `earth_standby` points the antenna at the
Earth; `sun_standby` points +X at the Sun by Sun sensors and gyro alone, star tracker or not, and spins slowly about it.
The two standbys use the actuators in charge, and are never refused.
"""

from __future__ import annotations

from sim import flight_law as loop
from sim.components import thrusters
from sim.components.ion_engine import IonEngine
from sim.components.thrusters import Thrusters
from sim.cones import Cones
from sim.config import SpacecraftConfig
from sim.control import SUN, AttitudeControl, profile_duration_s
from sim.environment import Environment
from sim.kernels import Memory
from sim.quaternion import Quaternion, angle_between, rotate_inverse

ACTUATORS = ("wheels", "unloading", "thrusters", "gimbals")
_MODES = ("wheels", "wheels", "rcs", "tvc")


class AttitudeModes:
    """Commands of the attitude control; `None` from one of them means taken, text is the reason of a refusal."""

    def __init__(
        self,
        config: SpacecraftConfig,
        environment: Environment,
        control: AttitudeControl,
        units: tuple[Thrusters, IonEngine],
        surroundings: Memory,
    ) -> None:
        self._config = config
        self._environment = environment
        self._control = control
        self._thrusters, self._engine = units
        self._surroundings = surroundings
        self._cones = Cones.of(config)
        self._standby = "earth_standby"

    def __repr__(self) -> str:
        return f"AttitudeModes({self.mode(int(self._surroundings[loop.ACTUATORS]))}, {self._control!r})"

    def mode(self, actuators: int) -> str:
        """The mode with these actuators (number in `ACTUATORS`) in charge."""
        return self._standby or _MODES[actuators]

    def point(self, target: str, now_s: float) -> str | None:
        """Turn to a target and hold it."""
        if target != self._control.target:
            if self._surroundings[loop.ACTUATORS] == loop.WITH_GIMBALS:
                return "acs.point: gimbals hold and do not turn; expected actuators wheels or thrusters"
            way = self._way(target, now_s)
            if isinstance(way, str):
                return f"acs.point: {way}"
            self._control.point(target, way)
        self._standby = ""
        return None

    def standby(self, now_s: float) -> str | None:
        """Turn to the Earth, keeping the Sun where it belongs if that can be."""
        self._release_gimbals()
        earth = self._environment.earth
        way = self._way(earth, now_s)
        self._control.point(earth, (self._goal(earth, now_s),) if isinstance(way, str) else way)
        self._standby = "earth_standby"
        return None

    def sun_standby(self) -> str | None:
        """Turn +X to the Sun and spin about it."""
        self._release_gimbals()
        self._control.seek_sun()
        self._standby = "sun_standby"
        return None

    def actuators(self, name: str) -> str | None:
        """Who turns the spacecraft."""
        e = self._surroundings
        if name == "gimbals":
            if self._engine.state != "thrusting":
                return f"acs.actuators: gimbals need the ion engine thrusting, found {self._engine.state}"
            if not self._control.settled or self._control.target == SUN:
                return f"acs.actuators: gimbals need a settled target to hold, found {self._control!r}"
            if e[loop.ACTUATORS] != loop.WITH_GIMBALS:
                with_thrusters = e[loop.ACTUATORS] == loop.WITH_THRUSTERS
                e[loop.BESIDE_GIMBALS] = loop.WITH_THRUSTERS if with_thrusters else loop.WITH_WHEELS
                e[loop.ACTUATORS] = loop.WITH_GIMBALS
            return None
        thrusters.close(self._thrusters.memory)
        e[loop.ACTUATORS] = loop.WITH_THRUSTERS if name == "thrusters" else loop.WITH_WHEELS
        return None

    def unload(self) -> str | None:
        """Let the thrusters take the momentum out of the wheels."""
        actuators = int(self._surroundings[loop.ACTUATORS])
        if actuators not in (loop.WITH_WHEELS, loop.UNLOADING):
            return f"acs.unload needs actuators wheels, found {ACTUATORS[actuators]}"
        self._surroundings[loop.ACTUATORS] = loop.UNLOADING
        return None

    def follow(self, now_s: float) -> None:
        """The sky has moved on: go on pointing at what is pointed at."""
        if self._control.target != SUN:
            self._control.track(self._environment.target_attitude_IB(self._control.target, now_s))

    def notice(self) -> None:
        """Without thrust the gimbals have nothing to steer."""
        if self._engine.state != "thrusting":
            self._release_gimbals()

    def _release_gimbals(self) -> None:
        e = self._surroundings
        if e[loop.ACTUATORS] == loop.WITH_GIMBALS:
            thrusters.close(self._thrusters.memory)
            e[loop.ACTUATORS] = e[loop.BESIDE_GIMBALS]

    def _way(self, target: str, now_s: float) -> tuple[Quaternion, ...] | str:
        """The turns to a target, or why there are none."""
        goal_IB, sun_I = self._goal(target, now_s), self._environment.sun_direction_I(now_s)
        complaint = self._cones.complaint(rotate_inverse(goal_IB, sun_I))
        if complaint is not None:
            return f"{target} would put {complaint}"
        way = self._cones.way(self._control.rest_IB, goal_IB, sun_I)
        return way or f"every turn to {target} leads the Sun through a cone, expected a way round"

    def _goal(self, target: str, now_s: float) -> Quaternion:
        """The attitude for where the target will be when a straight turn arrives."""
        sky = self._environment
        angle_rad = angle_between(self._control.attitude_IB, sky.target_attitude_IB(target, now_s))
        return sky.target_attitude_IB(target, now_s + profile_duration_s(angle_rad, self._config))
