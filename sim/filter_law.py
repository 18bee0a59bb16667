"""The arithmetic of sensors and attitude filter, on memories of floats; `sim.estimator` says what it models.

The filter is the multiplicative extended Kalman filter: E. Lefferts, F. Markley, M. Shuster, "Kalman Filtering for
Spacecraft Attitude Estimation", J. Guidance, Control, and Dynamics 5(5), 1982, with body-fixed errors (their section
XI) and the measurements taken one component after the other. State: attitude error (3, rad, body axes) and error of the
gyro's bias (3, rad/s).
"""

from __future__ import annotations

import math

from sim.kernels import Memory, compiled

# Places in the sensors' memory: what they read, and what they are like.
GYRO_TURN, GYRO_RATE, GYRO_BIAS = 0, 3, 6
TRACKER, TRACKER_VALID = 9, 13
SUN_READING, SUN_SEEN = 14, 17
LAST_TRUTH = 18
ANGLE_NOISE, RATE_NOISE, BIAS_WALK, TRACKER_NOISE, SUN_NOISE = 22, 23, 24, 25, 28
TRACKER_RATE_LIMIT, TRACKER_AXIS, SUN_EXCLUSION_COS, TRACKER_POWERED = 29, 30, 33, 34
TRACKER_WORKS, SUN_WORKS = 35, 36
SENSORS_SIZE = 37
NOISE_COLUMNS = 15
TRACKER_COLUMNS = slice(9, 12)

# Places in the filter's memory.
ESTIMATE, BIAS, COVARIANCE = 0, 4, 7
SIGMA = COVARIANCE + 36
SCRATCH = SIGMA + 1
FILTER_SIZE = SCRATCH + 6


@compiled
def sense(s: Memory, attitude: Memory, rate: Memory, sun_I: Memory, noise: Memory, dt_s: float) -> None:
    """Read the sensors: truth (`attitude` w, x, y, z; `rate` in body axes) and a row of standard normal numbers."""
    w, x, y, z = attitude[0], attitude[1], attitude[2], attitude[3]
    lw, lx, ly, lz = s[LAST_TRUTH], s[LAST_TRUTH + 1], s[LAST_TRUTH + 2], s[LAST_TRUTH + 3]
    dw = lw * w + lx * x + ly * y + lz * z
    dx = lw * x - lx * w - ly * z + lz * y
    dy = lw * y + lx * z - ly * w - lz * x
    dz = lw * z - lx * y + ly * x - lz * w
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    scale = 2.0 if length < 1e-9 else 2.0 * math.atan2(length, abs(dw)) / length
    if dw < 0.0:
        scale = -scale
    s[LAST_TRUTH], s[LAST_TRUTH + 1], s[LAST_TRUTH + 2], s[LAST_TRUTH + 3] = w, x, y, z
    root = math.sqrt(dt_s)
    turn = (scale * dx, scale * dy, scale * dz)
    for k in range(3):
        s[GYRO_TURN + k] = turn[k] + s[GYRO_BIAS + k] * dt_s + s[ANGLE_NOISE] * root * noise[k]
        s[GYRO_RATE + k] = rate[k] + s[GYRO_BIAS + k] + s[RATE_NOISE] * noise[3 + k]
        s[GYRO_BIAS + k] += s[BIAS_WALK] * root * noise[6 + k]
    sx, sy, sz = sun_I[0], sun_I[1], sun_I[2]
    tx, ty, tz = 2.0 * (z * sy - y * sz), 2.0 * (x * sz - z * sx), 2.0 * (y * sx - x * sy)
    bx = sx + w * tx - (y * tz - z * ty)
    by = sy + w * ty - (z * tx - x * tz)
    bz = sz + w * tz - (x * ty - y * tx)
    s[SUN_SEEN] = s[SUN_WORKS]
    s[SUN_READING] = s[SUN_WORKS] * (bx + s[SUN_NOISE] * noise[12])
    s[SUN_READING + 1] = s[SUN_WORKS] * (by + s[SUN_NOISE] * noise[13])
    s[SUN_READING + 2] = s[SUN_WORKS] * (bz + s[SUN_NOISE] * noise[14])
    sun_cosine = bx * s[TRACKER_AXIS] + by * s[TRACKER_AXIS + 1] + bz * s[TRACKER_AXIS + 2]
    square = rate[0] * rate[0] + rate[1] * rate[1] + rate[2] * rate[2]
    blind = square > s[TRACKER_RATE_LIMIT] * s[TRACKER_RATE_LIMIT] or sun_cosine > s[SUN_EXCLUSION_COS]
    s[TRACKER_VALID] = 0.0 if blind else s[TRACKER_WORKS] * s[TRACKER_POWERED]
    hx = 0.5 * s[TRACKER_NOISE] * noise[9]
    hy = 0.5 * s[TRACKER_NOISE + 1] * noise[10]
    hz = 0.5 * s[TRACKER_NOISE + 2] * noise[11]
    hw = math.sqrt(max(0.0, 1.0 - hx * hx - hy * hy - hz * hz))
    s[TRACKER] = w * hw - x * hx - y * hy - z * hz
    s[TRACKER + 1] = w * hx + x * hw + y * hz - z * hy
    s[TRACKER + 2] = w * hy - x * hz + y * hw + z * hx
    s[TRACKER + 3] = w * hz + x * hy - y * hx + z * hw


@compiled
def turn_estimate(f: Memory, tx: float, ty: float, tz: float) -> None:
    """Turn the estimated attitude by a small rotation vector in body axes."""
    angle = math.sqrt(tx * tx + ty * ty + tz * tz)
    half = 0.5 if angle < 1e-9 else math.sin(0.5 * angle) / angle
    c, x, y, z = math.cos(0.5 * angle), half * tx, half * ty, half * tz
    w0, x0, y0, z0 = f[ESTIMATE], f[ESTIMATE + 1], f[ESTIMATE + 2], f[ESTIMATE + 3]
    w = w0 * c - x0 * x - y0 * y - z0 * z
    a = w0 * x + x0 * c + y0 * z - z0 * y
    b = w0 * y - x0 * z + y0 * c + z0 * x
    d = w0 * z + x0 * y - y0 * x + z0 * c
    n = 1.0 / math.sqrt(w * w + a * a + b * b + d * d)
    f[ESTIMATE], f[ESTIMATE + 1], f[ESTIMATE + 2], f[ESTIMATE + 3] = n * w, n * a, n * b, n * d


@compiled
def propagate(f: Memory, s: Memory, dt_s: float) -> None:
    """Carry attitude and covariance on by the gyro's reading of the last `dt_s`."""
    tx = s[GYRO_TURN] - f[BIAS] * dt_s
    ty = s[GYRO_TURN + 1] - f[BIAS + 1] * dt_s
    tz = s[GYRO_TURN + 2] - f[BIAS + 2] * dt_s
    turn_estimate(f, tx, ty, tz)
    # P <- F P F' + Q with F = [[1 - [t x], -dt 1], [0, 1]]: rows first, then columns.
    p = COVARIANCE
    for k in range(6):
        a, b, c = f[p + k], f[p + 6 + k], f[p + 12 + k]
        f[p + k] = a + tz * b - ty * c - dt_s * f[p + 18 + k]
        f[p + 6 + k] = b - tz * a + tx * c - dt_s * f[p + 24 + k]
        f[p + 12 + k] = c + ty * a - tx * b - dt_s * f[p + 30 + k]
    for k in range(6):
        row = p + 6 * k
        a, b, c = f[row], f[row + 1], f[row + 2]
        f[row] = a + tz * b - ty * c - dt_s * f[row + 3]
        f[row + 1] = b - tz * a + tx * c - dt_s * f[row + 4]
        f[row + 2] = c + ty * a - tx * b - dt_s * f[row + 5]
    angle, walk = s[ANGLE_NOISE] * s[ANGLE_NOISE] * dt_s, s[BIAS_WALK] * s[BIAS_WALK] * dt_s
    for k in range(3):
        f[p + 7 * k] += angle
        f[p + 7 * (k + 3)] += walk


@compiled
def take(f: Memory, x: Memory, hx: float, hy: float, hz: float, residual: float, variance: float) -> None:
    """One scalar measurement: `residual` = h . attitude error + noise, into the correction `x` (6) and covariance."""
    p = COVARIANCE
    g0 = hx * f[p] + hy * f[p + 1] + hz * f[p + 2]
    g1 = hx * f[p + 6] + hy * f[p + 7] + hz * f[p + 8]
    g2 = hx * f[p + 12] + hy * f[p + 13] + hz * f[p + 14]
    g3 = hx * f[p + 18] + hy * f[p + 19] + hz * f[p + 20]
    g4 = hx * f[p + 24] + hy * f[p + 25] + hz * f[p + 26]
    g5 = hx * f[p + 30] + hy * f[p + 31] + hz * f[p + 32]
    g = (g0, g1, g2, g3, g4, g5)
    gain = 1.0 / (hx * g0 + hy * g1 + hz * g2 + variance)
    innovation = residual - (hx * x[0] + hy * x[1] + hz * x[2])
    for i in range(6):
        share = gain * g[i]
        x[i] += share * innovation
        for k in range(6):
            f[p + 6 * i + k] -= share * g[k]


@compiled
def correct(f: Memory, s: Memory, sun_I: Memory) -> None:
    """Take the star tracker's reading, or the Sun sensors' while it is blind: beside it they tell nothing."""
    x = f[SCRATCH : SCRATCH + 6]
    for k in range(6):
        x[k] = 0.0
    w, a, b, c = f[ESTIMATE], f[ESTIMATE + 1], f[ESTIMATE + 2], f[ESTIMATE + 3]
    if s[TRACKER_VALID] != 0.0:
        tw, tx, ty, tz = s[TRACKER], s[TRACKER + 1], s[TRACKER + 2], s[TRACKER + 3]
        sign = 2.0 if w * tw + a * tx + b * ty + c * tz >= 0.0 else -2.0
        take(f, x, 1.0, 0.0, 0.0, sign * (w * tx - a * tw - b * tz + c * ty), s[TRACKER_NOISE] ** 2)
        take(f, x, 0.0, 1.0, 0.0, sign * (w * ty + a * tz - b * tw - c * tx), s[TRACKER_NOISE + 1] ** 2)
        take(f, x, 0.0, 0.0, 1.0, sign * (w * tz - a * ty + b * tx - c * tw), s[TRACKER_NOISE + 2] ** 2)
    elif s[SUN_SEEN] != 0.0:
        sx, sy, sz = sun_I[0], sun_I[1], sun_I[2]
        tx, ty, tz = 2.0 * (c * sy - b * sz), 2.0 * (a * sz - c * sx), 2.0 * (b * sx - a * sy)
        px = sx + w * tx - (b * tz - c * ty)
        py = sy + w * ty - (c * tx - a * tz)
        pz = sz + w * tz - (a * ty - b * tx)
        # The Sun moves in the body against the attitude's error: s = (1 - [error x]) p = p + [p x] error.
        variance = s[SUN_NOISE] ** 2
        take(f, x, 0.0, -pz, py, s[SUN_READING] - px, variance)
        take(f, x, pz, 0.0, -px, s[SUN_READING + 1] - py, variance)
        take(f, x, -py, px, 0.0, s[SUN_READING + 2] - pz, variance)
    turn_estimate(f, x[0], x[1], x[2])
    for k in range(3):
        f[BIAS + k] += x[3 + k]
    # Rounding makes the two triangles drift apart over days; their mean does not.
    p = COVARIANCE
    for i in range(6):
        for k in range(i):
            mean = 0.5 * (f[p + 6 * i + k] + f[p + 6 * k + i])
            f[p + 6 * i + k] = mean
            f[p + 6 * k + i] = mean
    f[SIGMA] = math.sqrt(max(0.0, f[p] + f[p + 7] + f[p + 14]))
