import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.quaternion import (
    about,
    angle_between,
    axis_angle,
    conjugate,
    cross,
    dot,
    from_axes,
    multiply,
    rotate,
    rotate_inverse,
    unit,
)

numbers = st.floats(-1.0, 1.0)
vectors = st.tuples(numbers, numbers, numbers).filter(lambda v: dot(v, v) > 1e-4)
axes = vectors.map(unit)
angles = st.floats(-math.pi, math.pi)
rotations = st.builds(about, axes, angles)
bounded = settings(max_examples=60, derandomize=True, deadline=None)


def matrix(q):
    """Textbook direction cosine matrix, body to inertial: the oracle."""
    w, x, y, z = q
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


@bounded
@given(rotations, rotations, vectors)
def test_rotation_is_the_textbook_matrix(p, q, v):
    assert rotate(q, v) == pytest.approx(matrix(q) @ v, abs=1e-12)
    assert rotate_inverse(q, v) == pytest.approx(matrix(q).T @ v, abs=1e-12)
    assert rotate(multiply(p, q), v) == pytest.approx(matrix(p) @ matrix(q) @ v, abs=1e-12)


@bounded
@given(rotations)
def test_axes_give_their_attitude_back(q):
    columns = matrix(q).T
    back = from_axes(tuple(columns[0]), tuple(columns[1]), tuple(columns[2]))
    assert matrix(back) == pytest.approx(matrix(q), abs=1e-9)
    assert dot(cross(tuple(columns[0]), tuple(columns[1])), tuple(columns[2])) == pytest.approx(1.0)


@bounded
@given(rotations, axes, st.floats(1e-6, math.pi - 1e-6))
def test_angle_between_is_the_angle_turned(q, axis, angle):
    turned = multiply(q, about(axis, angle))
    assert angle_between(q, turned) == pytest.approx(angle, abs=1e-9)
    other_sign = (-turned[0], -turned[1], -turned[2], -turned[3])
    assert angle_between(q, other_sign) == pytest.approx(angle, abs=1e-9)
    found_axis, found = axis_angle(multiply(conjugate(q), turned))
    assert found == pytest.approx(angle, abs=1e-9)
    assert dot(found_axis, axis) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), unit((1.0, -2.0, 3.0))])
def test_half_turns_come_back_from_their_axes(axis):
    q = about(axis, math.pi)
    columns = matrix(q).T
    back = from_axes(tuple(columns[0]), tuple(columns[1]), tuple(columns[2]))
    assert matrix(back) == pytest.approx(matrix(q), abs=1e-12)


def test_no_rotation_has_an_axis_all_the_same():
    assert axis_angle((1.0, 0.0, 0.0, 0.0)) == ((1.0, 0.0, 0.0), 0.0)


def test_nothing_has_no_direction():
    with pytest.raises(ValueError, match="needs a length"):
        unit((0.0, 0.0, 0.0))
