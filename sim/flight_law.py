"""What acts on the spacecraft and who answers for it: forces, torques, light; arithmetic on the units' memories.

The surroundings' memory holds what belongs to no unit: directions, light, thrust, who is in charge of the attitude.
"""

from __future__ import annotations

import math

import numpy as np

from sim import control_law, filter_law
from sim.components import gimbals, ion_engine, power, thrusters, wheels
from sim.kernels import Memory, compiled

# Places in the surroundings' memory: what acts on the spacecraft and what it sees.
SUN_I, SUN_B, THRUST_N, SUNLIGHT_N, PRESSURE_CENTRE = 0, 3, 6, 7, 8
ACTUATORS, USE_TRUTH, UNLOAD_NM, UNLOADED_NMS, THRUST_I = 11, 12, 13, 14, 15
EARTH_I, EARTH_COS, BEAM_COS, QUIET, PROPELLANT_TAKEN_KG = 18, 21, 22, 23, 24
BESIDE_GIMBALS, STATION_HEARS = 25, 26
SIZE = 27
_WINGS_REST_RAD_S = 1.0e-4
# The mass in the physics follows the propellant in grains of this size, half a minute of thrust: 2e-7 of the mass.
PROPELLANT_GRAIN_KG = 1.0e-4
WITH_WHEELS, UNLOADING, WITH_THRUSTERS, WITH_GIMBALS = 0.0, 1.0, 2.0, 3.0


@compiled
def sun_in_body(e: Memory, qpos: Memory) -> None:
    """Turn the Sun's direction into body axes."""
    w, x, y, z = qpos[3], -qpos[4], -qpos[5], -qpos[6]
    sx, sy, sz = e[SUN_I], e[SUN_I + 1], e[SUN_I + 2]
    tx, ty, tz = 2.0 * (y * sz - z * sy), 2.0 * (z * sx - x * sz), 2.0 * (x * sy - y * sx)
    e[SUN_B] = sx + w * tx + y * tz - z * ty
    e[SUN_B + 1] = sy + w * ty + z * tx - x * tz
    e[SUN_B + 2] = sz + w * tz + x * ty - y * tx


@compiled
def see_sun(c: Memory, s: Memory, sun_I: Memory) -> None:
    """The Sun for the control: in Sun standby as the sensors see it, else, or if they are blind, as it should be."""
    if c[control_law.SUN_MODE] != 0.0 and s[filter_law.SUN_SEEN] != 0.0:
        x, y, z = s[filter_law.SUN_READING], s[filter_law.SUN_READING + 1], s[filter_law.SUN_READING + 2]
    else:
        a = control_law.ATTITUDE
        qw, qx, qy, qz = c[a], -c[a + 1], -c[a + 2], -c[a + 3]
        tx = 2.0 * (qy * sun_I[2] - qz * sun_I[1])
        ty = 2.0 * (qz * sun_I[0] - qx * sun_I[2])
        tz = 2.0 * (qx * sun_I[1] - qy * sun_I[0])
        x = sun_I[0] + qw * tx + qy * tz - qz * ty
        y = sun_I[1] + qw * ty + qz * tx - qx * tz
        z = sun_I[2] + qw * tz + qx * ty - qy * tx
    k = control_law.SUN_B
    c[k], c[k + 1], c[k + 2] = x, y, z


@compiled
def unload(e: Memory, r: Memory, w: Memory, dt_s: float) -> None:
    """Thruster torque against the wheels' momentum; ends with little left."""
    hx, hy, hz = w[wheels.MOMENTUM], w[wheels.MOMENTUM + 1], w[wheels.MOMENTUM + 2]
    size = math.sqrt(hx * hx + hy * hy + hz * hz)
    if size <= e[UNLOADED_NMS]:
        e[ACTUATORS] = WITH_WHEELS
        thrusters.close(r)
        return
    gain = -min(e[UNLOAD_NM], 0.05 * size) / size
    thrusters.fire(r, dt_s, gain * hx, gain * hy, gain * hz)


@compiled
def look_to_earth(e: Memory, qpos: Memory) -> None:
    """Cosine between the antenna, +X of the body, and the direction to the Earth."""
    w, x, y, z = qpos[3], qpos[4], qpos[5], qpos[6]
    ex, ey, ez = e[EARTH_I], e[EARTH_I + 1], e[EARTH_I + 2]
    e[EARTH_COS] = (1.0 - 2.0 * (y * y + z * z)) * ex + 2.0 * (x * y + w * z) * ey + 2.0 * (x * z - w * y) * ez


@compiled
def is_quiet(c: Memory, e: Memory, qvel: Memory) -> float:
    """1.0 when nothing turns: settled, wheels in charge, wings at rest."""
    turning = abs(qvel[10]) + abs(qvel[11]) > _WINGS_REST_RAD_S
    return 0.0 if turning or c[control_law.SETTLED] == 0.0 or e[ACTUATORS] != WITH_WHEELS else 1.0


@compiled
def is_usual(p: Memory, n: Memory, r: Memory, e: Memory) -> bool:
    """False when somebody should look: bus in undervoltage, engine out of xenon, a grain of propellant gone."""
    gone_kg = n[ion_engine.USED_KG] + r[thrusters.USED_KG] - e[PROPELLANT_TAKEN_KG]
    dry = n[ion_engine.BURNING] != 0.0 and n[ion_engine.LEFT_KG] <= 0.0
    return bool(p[power.UNDERVOLTAGE] == 0.0 and gone_kg < PROPELLANT_GRAIN_KG and not dry)


@compiled
def actuate(e: Memory, r: Memory, w: Memory, h: Memory, dt_s: float, tx: float, ty: float, tz: float) -> None:
    """Give the wanted torque to wheels, thrusters, both while unloading, or to the gimbals and one of the two."""
    charge = e[ACTUATORS]
    if charge == WITH_GIMBALS:
        gimbals.steer(h, dt_s, e[THRUST_N], tx, ty)
        charge, tx, ty = e[BESIDE_GIMBALS], 0.0, 0.0
    else:
        gimbals.steer(h, dt_s, e[THRUST_N], 0.0, 0.0)
    if charge == WITH_THRUSTERS:
        # The drives still compensate their bearings' friction, so that the wheels keep their speed.
        thrusters.fire(r, dt_s, tx, ty, tz)
        wheels.allocate(w, dt_s, 0.0, 0.0, 0.0)
        return
    if r[thrusters.LEAKS] != 0.0 and charge == WITH_WHEELS:
        thrusters.push(r, dt_s)
    if charge == UNLOADING:
        unload(e, r, w, dt_s)
        t = thrusters.TORQUE
        tx, ty, tz = tx - r[t], ty - r[t + 1], tz - r[t + 2]
    wheels.allocate(w, dt_s, tx, ty, tz)


@compiled
def apply_forces(e: Memory, r: Memory, h: Memory, qpos: Memory, applied: Memory) -> None:
    """Engine, thrusters and sunlight as force (inertial axes) and torque (body axes) on the bus."""
    light = -e[SUNLIGHT_N]
    lx, ly, lz = light * e[SUN_B], light * e[SUN_B + 1], light * e[SUN_B + 2]
    cx, cy, cz = e[PRESSURE_CENTRE], e[PRESSURE_CENTRE + 1], e[PRESSURE_CENTRE + 2]
    applied[3] = r[thrusters.TORQUE] + h[gimbals.TORQUE] + cy * lz - cz * ly
    applied[4] = r[thrusters.TORQUE + 1] + h[gimbals.TORQUE + 1] + cz * lx - cx * lz
    applied[5] = r[thrusters.TORQUE + 2] + cx * ly - cy * lx
    fx, fz = r[thrusters.FORCE], r[thrusters.FORCE + 2]
    w, x, y, z = qpos[3], qpos[4], qpos[5], qpos[6]
    # The axes +X and +Z of the body are the first and the third column of its rotation matrix.
    xx, xy, xz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
    zx, zy, zz = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
    yx, yy, yz = zy * xz - zz * xy, zz * xx - zx * xz, zx * xy - zy * xx
    d, thrust = gimbals.DIRECTION, e[THRUST_N]
    px, py, pz = thrust * h[d], thrust * h[d + 1], thrust * h[d + 2]
    e[THRUST_I] = px * xx + py * yx + pz * zx
    e[THRUST_I + 1] = px * xy + py * yy + pz * zy
    e[THRUST_I + 2] = px * xz + py * yz + pz * zz
    applied[0] = e[THRUST_I] + fx * xx + fz * zx + light * e[SUN_I]
    applied[1] = e[THRUST_I + 1] + fx * xy + fz * zy + light * e[SUN_I + 1]
    applied[2] = e[THRUST_I + 2] + fx * xz + fz * zz + light * e[SUN_I + 2]


@compiled
def know(c: Memory, s: Memory, f: Memory, e: Memory, qpos: Memory, qvel: Memory) -> None:
    """Attitude, rate and Sun for the control: the filter's, or the truth if the configuration says so."""
    truth = e[USE_TRUTH] != 0.0
    for k in range(4):
        c[control_law.ATTITUDE + k] = qpos[3 + k] if truth else f[filter_law.ESTIMATE + k]
    for k in range(3):
        # Sun standby trusts nothing of the filter, which may have lost itself: the gyro's own bias is small.
        bias = f[filter_law.BIAS + k] if c[control_law.SUN_MODE] == 0.0 else 0.0
        c[control_law.RATE + k] = qvel[3 + k] if truth else s[filter_law.GYRO_RATE + k] - bias
    see_sun(c, s, e[SUN_I : SUN_I + 3])


def surroundings() -> Memory:
    """A memory for what acts on the spacecraft, all zero: wheels in charge, the filter believed."""
    return np.zeros(SIZE)
