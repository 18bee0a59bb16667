"""The arithmetic of `sim.control`, on a memory of floats; see there for the law and its source."""

from __future__ import annotations

import math

from sim.kernels import Memory, compiled

# Places in the memory. Quaternions are body to inertial (w, x, y, z), rates in body axes.
ATTITUDE, RATE = 0, 4
START, AXIS, WAY, DONE, WAY_RATE, BRAKING = 7, 11, 14, 15, 16, 17
REFERENCE, TARGET = 18, 22
QUIET_S, RATE_FACTOR, SETTLED, ERROR, RATE_SIZE = 26, 27, 28, 29, 30
STIFFNESS, DAMPING, RATE_LIMIT, ACCELERATION_LIMIT = 31, 32, 33, 34
SETTLE_ERROR, SETTLE_RATE, SETTLE_HOLD, INERTIA = 35, 36, 37, 38
VIA, HAS_VIA = 41, 45
SUN_MODE, SUN_B, SPIN, SUN_ERROR, SUN_RATE = 46, 47, 50, 51, 52
FROM_CAMERA, FROM_SENSOR = 53, 54
CAMERA_LEAST, SENSOR_MOST, CONES_KEPT = 55, 56, 57
SIZE = 58

BRAKED_RATE_RAD_S = 1.0e-4
# How far it turns while the rate, below the acceleration limit's share, fades.
BRAKE_TAIL_RAD = 2.0e-3
_BRAKE_GAIN_PER_S = 0.18
# Sun standby: rate wanted per angle off the Sun, and acceleration per rate off the wanted one.
_TURN_PER_S, _SUN_GAIN_PER_S = 0.02, 0.1
_HALF = math.sqrt(0.5)


@compiled
def small_angle(m: Memory, place: int) -> float:
    """Angle (rad) from the attitude to the quaternion at `place`; by the vector part, as the scalar has no digits."""
    tw, tx, ty, tz = m[place], m[place + 1], m[place + 2], m[place + 3]
    w, x, y, z = m[ATTITUDE], m[ATTITUDE + 1], m[ATTITUDE + 2], m[ATTITUDE + 3]
    ex = tw * x - tx * w - ty * z + tz * y
    ey = tw * y + tx * z - ty * w - tz * x
    ez = tw * z - tx * y + ty * x - tz * w
    return 2.0 * math.atan2(math.sqrt(ex * ex + ey * ey + ez * ez), abs(tw * w + tx * x + ty * y + tz * z))


@compiled
def observe(m: Memory, dt_s: float) -> None:
    """Judge the attitude, rate and Sun that lie in the memory after `dt_s` more."""
    wx, wy, wz = m[RATE], m[RATE + 1], m[RATE + 2]
    m[RATE_SIZE] = math.sqrt(wx * wx + wy * wy + wz * wz)
    sx, sy, sz = m[SUN_B], m[SUN_B + 1], m[SUN_B + 2]
    m[FROM_CAMERA] = math.atan2(math.sqrt(sx * sx + sy * sy), sz)
    along, across = _HALF * (sx - sz), _HALF * (sx + sz)
    m[FROM_SENSOR] = math.atan2(math.sqrt(across * across + sy * sy), along)
    m[CONES_KEPT] = 1.0 if m[FROM_CAMERA] >= m[CAMERA_LEAST] and m[FROM_SENSOR] <= m[SENSOR_MOST] else 0.0
    if m[SUN_MODE] != 0.0:
        m[ERROR] = math.atan2(math.sqrt(sy * sy + sz * sz), sx)
        off = wx - m[SPIN]
        judge(m, dt_s, m[SUN_ERROR], m[SUN_RATE], math.sqrt(off * off + wy * wy + wz * wz))
    else:
        m[ERROR] = small_angle(m, TARGET)
        judge(m, dt_s, m[SETTLE_ERROR], m[SETTLE_RATE], m[RATE_SIZE])


@compiled
def judge(m: Memory, dt_s: float, error_limit: float, rate_limit: float, rate: float) -> None:
    """Settled: under both limits for the hold time, then until twice one of them."""
    slack = 2.0 if m[SETTLED] != 0.0 else 1.0
    if m[ERROR] > slack * error_limit or rate > slack * rate_limit:
        m[QUIET_S] = 0.0
        m[SETTLED] = 0.0
    elif m[SETTLED] == 0.0:
        m[QUIET_S] += dt_s
        if m[QUIET_S] >= m[SETTLE_HOLD]:
            m[SETTLED] = 1.0


@compiled
def plan(m: Memory) -> None:
    """Lay the way: one rotation from the present attitude to the next stop or the target, the shorter one."""
    w, x, y, z = m[ATTITUDE], -m[ATTITUDE + 1], -m[ATTITUDE + 2], -m[ATTITUDE + 3]
    goal = VIA if m[HAS_VIA] != 0.0 else TARGET
    tw, tx, ty, tz = m[goal], m[goal + 1], m[goal + 2], m[goal + 3]
    rw = w * tw - x * tx - y * ty - z * tz
    rx = w * tx + x * tw + y * tz - z * ty
    ry = w * ty - x * tz + y * tw + z * tx
    rz = w * tz + x * ty - y * tx + z * tw
    if rw < 0.0:
        rw, rx, ry, rz = -rw, -rx, -ry, -rz
    s = math.sqrt(rx * rx + ry * ry + rz * rz)
    if s < 1e-15:
        m[AXIS], m[AXIS + 1], m[AXIS + 2], m[WAY] = 1.0, 0.0, 0.0, 0.0
    else:
        m[AXIS], m[AXIS + 1], m[AXIS + 2] = rx / s, ry / s, rz / s
        m[WAY] = 2.0 * math.atan2(s, rw)
    m[BRAKING] = m[DONE] = m[WAY_RATE] = 0.0
    for k in range(4):
        m[START + k] = m[ATTITUDE + k]
        m[REFERENCE + k] = m[ATTITUDE + k]


@compiled
def advance_reference(m: Memory, dt_s: float) -> float:
    """Move the reference on by `dt_s`; the acceleration it takes (rad/s2), constant over the step."""
    limit = m[ACCELERATION_LIMIT]
    left = m[WAY] - m[DONE]
    rate = m[WAY_RATE]
    # The fastest new rate v that can still be braked in whole steps: v^2/2a of ideal braking, and v dt for this
    # step's own share and for the last step that is not a whole one, have to fit into what is left.
    room = left - 0.5 * rate * dt_s
    stoppable = limit * (math.sqrt(dt_s * dt_s + 2.0 * max(room, 0.0) / limit) - dt_s)
    wanted = min(m[RATE_LIMIT] * m[RATE_FACTOR], rate + limit * dt_s, stoppable)
    new = max(wanted, rate - limit * dt_s, 0.0)
    done = m[DONE] + 0.5 * (rate + new) * dt_s
    if m[WAY] - done < 1e-9 or (new < 1e-9 and rate < 1e-9):
        done, new = m[WAY], 0.0
    m[DONE] = done
    m[WAY_RATE] = new
    c, s = math.cos(0.5 * done), math.sin(0.5 * done)
    x, y, z = s * m[AXIS], s * m[AXIS + 1], s * m[AXIS + 2]
    pw, px, py, pz = m[START], m[START + 1], m[START + 2], m[START + 3]
    m[REFERENCE] = pw * c - px * x - py * y - pz * z
    m[REFERENCE + 1] = pw * x + px * c + py * z - pz * y
    m[REFERENCE + 2] = pw * y - px * z + py * c + pz * x
    m[REFERENCE + 3] = pw * z + px * y - py * x + pz * c
    return float((new - rate) / dt_s)


@compiled
def brake(m: Memory) -> tuple[float, float, float]:
    """Angular acceleration against what rate there is."""
    wanted = _BRAKE_GAIN_PER_S * m[RATE_SIZE]
    gain = _BRAKE_GAIN_PER_S * min(1.0, m[ACCELERATION_LIMIT] / max(wanted, 1e-12))
    return -gain * m[RATE], -gain * m[RATE + 1], -gain * m[RATE + 2]


@compiled
def seek_sun(m: Memory) -> tuple[float, float, float]:
    """Angular acceleration that turns +X to the Sun and spins about it: from its direction and rates alone."""
    sx, sy, sz = m[SUN_B], m[SUN_B + 1], m[SUN_B + 2]
    across = math.sqrt(sy * sy + sz * sz)
    angle = math.atan2(across, sx)
    wanted = min(m[RATE_LIMIT] * m[RATE_FACTOR], _TURN_PER_S * angle)
    # The shorter way is about X x Sun; with the Sun behind every way is as short.
    ny, nz = (-sz / across, sy / across) if across > 1e-6 else (1.0, 0.0)
    ax = _SUN_GAIN_PER_S * (m[SPIN] - m[RATE])
    ay = _SUN_GAIN_PER_S * (wanted * ny - m[RATE + 1])
    az = _SUN_GAIN_PER_S * (wanted * nz - m[RATE + 2])
    scale = min(1.0, m[ACCELERATION_LIMIT] / max(math.sqrt(ax * ax + ay * ay + az * az), 1e-12))
    return scale * ax, scale * ay, scale * az


@compiled
def follow(m: Memory, dt_s: float) -> tuple[float, float, float]:
    """Angular acceleration that keeps to the reference, which moves on."""
    rate, acceleration = m[WAY_RATE], 0.0
    rw, rx, ry, rz = m[REFERENCE], m[REFERENCE + 1], m[REFERENCE + 2], m[REFERENCE + 3]
    w, x, y, z = m[ATTITUDE], m[ATTITUDE + 1], m[ATTITUDE + 2], m[ATTITUDE + 3]
    sign = 2.0 if rw * w + rx * x + ry * y + rz * z >= 0.0 else -2.0
    ex = sign * (rw * x - rx * w - ry * z + rz * y)
    ey = sign * (rw * y + rx * z - ry * w - rz * x)
    ez = sign * (rw * z - rx * y + ry * x - rz * w)
    if m[DONE] < m[WAY]:
        acceleration = advance_reference(m, dt_s)
    nx, ny, nz = m[AXIS], m[AXIS + 1], m[AXIS + 2]
    k, d = m[STIFFNESS], m[DAMPING]
    return (
        acceleration * nx - k * ex - d * (m[RATE] - rate * nx),
        acceleration * ny - k * ey - d * (m[RATE + 1] - rate * ny),
        acceleration * nz - k * ez - d * (m[RATE + 2] - rate * nz),
    )


@compiled
def step(m: Memory, dt_s: float, wheel_x: float, wheel_y: float, wheel_z: float) -> tuple[float, float, float]:
    """Torque (N m, body axes) wanted on the bus for the next `dt_s`, given the wheels' momentum (N m s)."""
    if m[BRAKING] != 0.0:
        if m[RATE_SIZE] <= BRAKED_RATE_RAD_S:
            plan(m)
    elif m[HAS_VIA] != 0.0 and m[DONE] >= m[WAY]:
        m[HAS_VIA] = 0.0
        plan(m)
    if m[SUN_MODE] != 0.0:
        ax, ay, az = seek_sun(m)
    elif m[BRAKING] != 0.0:
        ax, ay, az = brake(m)
    else:
        ax, ay, az = follow(m, dt_s)
    wx, wy, wz = m[RATE], m[RATE + 1], m[RATE + 2]
    jx, jy, jz = m[INERTIA], m[INERTIA + 1], m[INERTIA + 2]
    hx, hy, hz = jx * wx + wheel_x, jy * wy + wheel_y, jz * wz + wheel_z
    return jx * ax + wy * hz - wz * hy, jy * ay + wz * hx - wx * hz, jz * az + wx * hy - wy * hx
