"""Rotations in plain floats: at a few numbers an operation numpy costs ten times the arithmetic.

Unit quaternions are `(w, x, y, z)`. An attitude `q_IB` turns body coordinates into inertial ones: `v_I = q v_B q*`.
Algebra after J. Diebel, "Representing Attitude: Euler Angles, Unit Quaternions, and Rotation Vectors" (2006), sect. 6.
"""

from __future__ import annotations

import math

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product, right-handed."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a: Vector) -> Vector:
    """`a` at length one; `ValueError` for the null vector, which has no direction."""
    length = math.sqrt(dot(a, a))
    if not length > 0.0:
        raise ValueError(f"a direction needs a length, found {a}")
    return (a[0] / length, a[1] / length, a[2] / length)


def multiply(p: Quaternion, q: Quaternion) -> Quaternion:
    """Hamilton product: the rotation `q` first, then `p`."""
    pw, px, py, pz = p
    qw, qx, qy, qz = q
    return (
        pw * qw - px * qx - py * qy - pz * qz,
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
    )


def conjugate(q: Quaternion) -> Quaternion:
    """The inverse rotation of a unit quaternion."""
    return (q[0], -q[1], -q[2], -q[3])


def rotate(q: Quaternion, v: Vector) -> Vector:
    """`q v q*`: body to inertial for an attitude `q_IB`."""
    w, x, y, z = q
    tx = 2.0 * (y * v[2] - z * v[1])
    ty = 2.0 * (z * v[0] - x * v[2])
    tz = 2.0 * (x * v[1] - y * v[0])
    return (v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx)


def rotate_inverse(q: Quaternion, v: Vector) -> Vector:
    """`q* v q`: inertial to body for an attitude `q_IB`."""
    return rotate((q[0], -q[1], -q[2], -q[3]), v)


def about(axis: Vector, angle_rad: float) -> Quaternion:
    """The rotation by `angle_rad` about the unit vector `axis`."""
    half = 0.5 * angle_rad
    s = math.sin(half)
    return (math.cos(half), s * axis[0], s * axis[1], s * axis[2])


def axis_angle(q: Quaternion) -> tuple[Vector, float]:
    """Unit axis and angle in `[0, pi]` of a rotation; the identity gives +X and 0."""
    w, x, y, z = q if q[0] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])
    s = math.sqrt(x * x + y * y + z * z)
    if s < 1e-15:
        return (1.0, 0.0, 0.0), 0.0
    return (x / s, y / s, z / s), 2.0 * math.atan2(s, w)


def angle_between(p: Quaternion, q: Quaternion) -> float:
    """Angle of the one rotation (about the eigenaxis) that takes `p` to `q`, radians in `[0, pi]`."""
    w, x, y, z = multiply(conjugate(p), q)
    return 2.0 * math.atan2(math.sqrt(x * x + y * y + z * z), abs(w))


def from_axes(x: Vector, y: Vector, z: Vector) -> Quaternion:
    """The attitude whose body axes lie along the right-handed unit vectors `x`, `y`, `z` of the inertial frame.

    The largest component is taken from the trace and the others from it, which stays exact near every half turn
    (J. Guidance and Control 1(3), 1978, pp. 223-224).
    """
    trace = x[0] + y[1] + z[2]
    squares = (trace, 2.0 * x[0] - trace, 2.0 * y[1] - trace, 2.0 * z[2] - trace)
    largest = squares.index(max(squares))
    r = 2.0 * math.sqrt(1.0 + squares[largest])
    if largest == 0:
        q = (0.25 * r, (y[2] - z[1]) / r, (z[0] - x[2]) / r, (x[1] - y[0]) / r)
    elif largest == 1:
        q = ((y[2] - z[1]) / r, 0.25 * r, (x[1] + y[0]) / r, (z[0] + x[2]) / r)
    elif largest == 2:
        q = ((z[0] - x[2]) / r, (x[1] + y[0]) / r, 0.25 * r, (y[2] + z[1]) / r)
    else:
        q = ((x[1] - y[0]) / r, (z[0] + x[2]) / r, (y[2] + z[1]) / r, 0.25 * r)
    n = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return (q[0] / n, q[1] / n, q[2] / n, q[3] / n)
