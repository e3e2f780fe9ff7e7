"""Compare drivable coordinates with the facets of the set of available torques."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from controllers.analysis.drivable import MARGIN, Terms, find_drivable, force_margin
from controllers.analysis.wrench_set import capacity_margin

NEGLIGIBLE = np.full(6, 1e-9)  # accelerations that any force reaches


def terms(L: object, torque: object, low: float = 0.0, high: float = 10.0) -> Terms:
    A = -np.asarray(L, dtype=float).T
    n, m = A.shape
    return Terms(
        np.eye(n), A, np.asarray(torque, float), np.full(m, low), np.full(m, high), NEGLIGIBLE[:n]
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(60))
def test_all_coordinates_are_drivable_if_and_only_if_the_torque_is_inside(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    m = n + int(rng.integers(0, 4))
    L, torque = rng.normal(size=(m, n)), 5.0 * rng.normal(size=n)
    inside = float(capacity_margin(L, torque, 1.0, 10.0))
    assert abs(inside) > 1e-3  # the torque is not on the boundary
    found = find_drivable(terms(L, torque, 1.0, 10.0), range(n))
    t, _, forces = force_margin(terms(L, torque, 1.0, 10.0), range(n))
    assert (t > 0.0) == (inside > 0.0)
    np.testing.assert_allclose(-L.T @ forces, torque, atol=1e-6)
    assert (len(found.coordinates) == n) == (t > MARGIN)
    if found.coordinates:
        rows = list(found.coordinates)
        assert float(capacity_margin(L[:, rows], torque[rows], 1.0, 10.0)) > 0.0
    for k in found.missing:  # no drivable coordinate is missing
        rows = sorted([*found.coordinates, k])
        assert not float(capacity_margin(L[:, rows], torque[rows], 1.0, 10.0)) > 0.05


@pytest.mark.parametrize(
    ("moment_arm", "torque", "missing"),
    [
        (-0.1, 0.5, None),  # the muscle pulls up, and the weight pulls down
        (0.1, 0.5, "up"),
        (-0.1, -0.5, "down"),
        (-0.1, 0.0, "down"),  # on the boundary: it cannot decelerate
        (0.0, 0.0, "any muscle"),
        (-0.1, 1.1, "up"),  # too weak
    ],
)
def test_one_joint_with_one_muscle(moment_arm: float, torque: float, missing: str | None) -> None:
    found = find_drivable(terms([[moment_arm]], [torque]), [0])
    assert found.coordinates == ((0,) if missing is None else ())
    assert found.missing == ({} if missing is None else {0: missing})


def test_two_joints_with_proportional_moment_arms_have_one_drivable_joint() -> None:
    found = find_drivable(terms([[0.1, 0.1], [-0.1, -0.1], [0.2, 0.2]], [0.0, 0.0]), [0, 1])
    assert len(found.coordinates) == 1
    assert list(found.missing.values()) == ["independent motion"]


def test_only_candidates_are_reported() -> None:
    found = find_drivable(terms([[0.1, 0.0], [-0.1, 0.0]], [0.0, 0.0]), [0])
    assert found.coordinates == (0,)
    assert found.missing == {}


def test_coordinate_below_the_required_acceleration_is_not_drivable() -> None:
    one = terms([[0.1], [-0.1]], [0.0])
    slow = Terms(one.M, one.A, one.torque, one.low, one.high, np.array([0.9]))
    fast = Terms(one.M, one.A, one.torque, one.low, one.high, np.array([1.1]))
    assert find_drivable(slow, [0]).coordinates == (0,)
    assert find_drivable(fast, [0]).missing == {0: "independent motion"}  # 10 N on 0.1 m make 1 N·m


def test_coordinate_without_mass_has_no_margin() -> None:
    """Very large lengths also cause a mass of zero by rounding."""
    one = terms(np.eye(2), np.zeros(2), 1.0, 10.0)
    t, _, forces = force_margin(replace(one, M=np.diag([1.0, 0.0])), range(2))
    assert t == -np.inf
    assert np.isnan(forces).all()


def test_huge_torques_of_a_muscle_are_accepted() -> None:
    found = find_drivable(terms([[1e300, 0.0], [-0.1, 0.1]], [0.5, 0.5], 0.0, 1e10), range(2))
    assert set(found.coordinates) | set(found.missing) == {0, 1}
