from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.robots.random_robots import angles, poses, vectors

from addin_sdfusion.robot import IDENTITY, Pose
from addin_sdfusion.robot.model.rotations import (
    apply,
    compose,
    dot,
    inverse,
    multiply,
    normalized,
    point_inertia,
    rotate,
    rotate_inertia,
    rotation,
    rpy,
    transpose,
)

UNIT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def flat(A):
    return [entry for row in A for entry in row]


def test_rotation_is_right_handed_in_the_order_roll_pitch_yaw():
    quarter = math.pi / 2
    assert rotate(rotation((quarter, 0, 0)), (0, 1, 0)) == pytest.approx((0, 0, 1))
    assert rotate(rotation((0, quarter, 0)), (0, 0, 1)) == pytest.approx((1, 0, 0))
    assert rotate(rotation((0, 0, quarter)), (1, 0, 0)) == pytest.approx((0, 1, 0))
    assert rotate(rotation((quarter, 0, quarter)), (0, 1, 0)) == pytest.approx((0, 0, 1))


@given(angles)
def test_rotation_matrix_is_orthogonal(rpy_):
    R = rotation(rpy_)
    assert flat(multiply(R, transpose(R))) == pytest.approx(flat(UNIT), abs=1e-14)


@given(angles, st.sampled_from([None, math.pi / 2, -math.pi / 2]))
def test_rpy_restores_angles_also_in_gimbal_lock(rpy_, pitch):
    R = rotation((rpy_[0], rpy_[1] if pitch is None else pitch, rpy_[2]))
    assert flat(rotation(rpy(R))) == pytest.approx(flat(R), abs=1e-14)


@given(poses, poses, vectors)
def test_composed_poses_equal_successive_application(a, b, p):
    assert apply(compose(a, b), p) == pytest.approx(apply(a, apply(b, p)), abs=1e-12)


@given(poses, vectors)
def test_inverse_reverts_pose(pose, p):
    assert apply(inverse(pose), apply(pose, p)) == pytest.approx(p, abs=1e-12)


@given(poses)
def test_composing_with_identity_is_exact(pose):
    assert compose(IDENTITY, pose) == pose
    assert compose(pose, IDENTITY) == pose


@given(vectors)
def test_inverting_translation_twice_is_exact(v):
    assert inverse(inverse(Pose(v))) == Pose(v)


@given(vectors)
def test_normalizing_twice_equals_normalizing_once(v):
    once = normalized(v)
    assert normalized(once) == once


@given(angles, vectors, vectors)
def test_rotated_inertia_keeps_kinetic_energy(rpy_, omega, r):
    R, inertia = rotation(rpy_), point_inertia(2.0, r)
    energy = dot(omega, rotate(inertia, omega))
    turned = rotate(R, omega)
    assert dot(turned, rotate(rotate_inertia(R, inertia), turned)) == pytest.approx(
        energy, abs=1e-9
    )


@given(vectors, vectors)
def test_point_inertia_is_mass_times_squared_distance(r, axis):
    lever = [axis[i - 2] * r[i - 1] - axis[i - 1] * r[i - 2] for i in range(3)]
    expected = 3.0 * sum(x * x for x in lever)
    assert dot(axis, rotate(point_inertia(3.0, r), axis)) == pytest.approx(expected, abs=1e-9)
