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
SIZE = 41

BRAKED_RATE_RAD_S = 1.0e-4
_BRAKE_GAIN_PER_S = 0.18


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
    """Judge the attitude and rate that lie in the memory after `dt_s` more."""
    wx, wy, wz = m[RATE], m[RATE + 1], m[RATE + 2]
    m[RATE_SIZE] = math.sqrt(wx * wx + wy * wy + wz * wz)
    m[ERROR] = small_angle(m, TARGET)
    slack = 2.0 if m[SETTLED] != 0.0 else 1.0
    if m[ERROR] > slack * m[SETTLE_ERROR] or m[RATE_SIZE] > slack * m[SETTLE_RATE]:
        m[QUIET_S] = 0.0
        m[SETTLED] = 0.0
    elif m[SETTLED] == 0.0:
        m[QUIET_S] += dt_s
        if m[QUIET_S] >= m[SETTLE_HOLD]:
            m[SETTLED] = 1.0


@compiled
def plan(m: Memory) -> None:
    """Lay the way: one rotation from the present attitude to the target's, the shorter one."""
    w, x, y, z = m[ATTITUDE], -m[ATTITUDE + 1], -m[ATTITUDE + 2], -m[ATTITUDE + 3]
    tw, tx, ty, tz = m[TARGET], m[TARGET + 1], m[TARGET + 2], m[TARGET + 3]
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
    if m[BRAKING] != 0.0 and m[RATE_SIZE] <= BRAKED_RATE_RAD_S:
        plan(m)
    ax, ay, az = brake(m) if m[BRAKING] != 0.0 else follow(m, dt_s)
    wx, wy, wz = m[RATE], m[RATE + 1], m[RATE + 2]
    jx, jy, jz = m[INERTIA], m[INERTIA + 1], m[INERTIA + 2]
    hx, hy, hz = jx * wx + wheel_x, jy * wy + wheel_y, jz * wz + wheel_z
    return jx * ax + wy * hz - wz * hy, jy * ay + wz * hx - wx * hz, jz * az + wx * hy - wy * hx
