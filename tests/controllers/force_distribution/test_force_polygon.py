"""Compare the feasible polygon with corners and optima from brute force."""

from __future__ import annotations

import numpy as np
import pytest
from support.controllers.distribution_problems import HIGH, LOW, least_norm, stacked, vertices

from addin_sdfusion.robot import InputError
from controllers.force_distribution.methods import distribute
from controllers.force_distribution.polygon import (
    feasible_polygon,
    polygon_1_norm,
    polygon_2_norm,
    polygon_centroid,
)
from controllers.force_distribution.quadratic import least_squares


def _in_order(corners: np.ndarray) -> np.ndarray:
    return corners[np.lexsort(corners.round(6).T)]


@pytest.mark.parametrize("n", [1, 2, 4])
def test_corners_equal_brute_force(n: int) -> None:
    L, tau = stacked(20 + n, 15, n, n + 2, 8.0)
    polygon = feasible_polygon(L, tau, LOW, HIGH)
    counts = []
    for k, pose in enumerate(zip(L, tau, strict=True)):
        corners, expected = polygon.vertices(k), vertices(*pose)
        assert corners.shape == expected.shape
        np.testing.assert_allclose(_in_order(corners), _in_order(expected), atol=1e-8)
        counts.append(len(corners))
    assert 0 in counts
    assert max(counts) >= 4


def test_area_and_centroid_match_sums_over_triangles() -> None:
    L, tau = stacked(31, 20, 2, 4, 2.0)
    polygon, centroid = feasible_polygon(L, tau, LOW, HIGH), polygon_centroid(L, tau, LOW, HIGH)
    for k in range(20):
        corners = polygon.vertices(k)
        if not len(corners):
            assert polygon.area[k] == 0.0
            continue
        fan = np.stack(
            [np.broadcast_to(corners[0], corners[1:-1].shape), corners[1:-1], corners[2:]]
        )
        a, b = fan[1] - fan[0], fan[2] - fan[0]
        gram = np.sum(a * a, axis=1) * np.sum(b * b, axis=1) - np.sum(a * b, axis=1) ** 2
        areas = 0.5 * np.sqrt(gram)
        assert polygon.area[k] == pytest.approx(areas.sum(), rel=1e-9)
        middle = (areas[:, None] * fan.mean(axis=0)).sum(axis=0) / areas.sum()
        np.testing.assert_allclose(centroid.forces[k], middle, atol=1e-7)


@pytest.mark.parametrize("n", [1, 2, 4])
def test_norms_equal_brute_force(n: int) -> None:
    L, tau = stacked(40 + n, 12, n, n + 2, 4.0)
    one, two = polygon_1_norm(L, tau, LOW, HIGH), polygon_2_norm(L, tau, LOW, HIGH)
    quadratic = least_squares(L, tau, LOW, HIGH)
    assert one.solved.any()
    assert (one.status == quadratic.status).all()
    np.testing.assert_allclose(two.forces, quadratic.forces, atol=1e-8)
    for k, pose in enumerate(zip(L, tau, strict=True)):
        corners = vertices(*pose)
        if len(corners):
            assert one.forces[k].sum() == pytest.approx(corners.sum(axis=1).min(), abs=1e-8)
            best = least_norm(*pose, np.zeros(n + 2))
            np.testing.assert_allclose(two.forces[k], best, atol=1e-8)


def test_minimum_norm_may_be_inside_the_polygon() -> None:
    L = np.array([[-0.1], [-0.1], [-0.1]])
    answer = polygon_2_norm(L, [9.0], LOW, HIGH)
    np.testing.assert_allclose(answer.forces, [30.0, 30.0, 30.0], atol=1e-12)


def test_parallel_muscles_with_coinciding_lines_are_supported() -> None:
    """Two equal muscles oppose two other equal muscles, so that lines of limits coincide."""
    L = np.array([[-0.1, 0.0], [-0.1, 0.0], [0.1, 0.0], [0.0, 0.1]])
    tau = np.array([1.0, -5.0])
    polygon = feasible_polygon(L, tau, LOW, HIGH)
    corners = polygon.vertices()
    for f in corners:
        np.testing.assert_allclose(-L.T @ f, tau, atol=1e-9)
    np.testing.assert_allclose(_in_order(corners), _in_order(vertices_of_three(tau)), atol=1e-8)
    for method in ("polygon_1_norm", "polygon_2_norm", "polygon_centroid"):
        answer = distribute(L, tau, LOW, HIGH, method)
        assert answer.solved
        assert answer.forces[3] == pytest.approx(50.0)


def vertices_of_three(tau: np.ndarray) -> np.ndarray:
    """Return the corners for f_1 + f_2 - f_3 = 10 and f_4 = 50 within the limits."""
    c = tau[0] / 0.1
    corners = [
        (LOW, LOW, 2 * LOW - c),
        (HIGH, LOW, HIGH + LOW - c),
        (LOW, HIGH, HIGH + LOW - c),
        (HIGH, c + HIGH - HIGH, HIGH),
        (c + HIGH - HIGH, HIGH, HIGH),
    ]
    return np.unique([(*f, 50.0) for f in corners], axis=0)


def test_polygon_may_be_a_line_or_a_point() -> None:
    """Equal limits of one force leave a line; equal limits of all forces leave a point."""
    L, tau = np.array([[-0.1], [-0.1], [0.1]]), np.array([2.0])
    low, high = np.array([10.0, 20.0, 10.0]), np.array([100.0, 20.0, 100.0])
    line = [distribute(L, tau, low, high, f"polygon_{kind}") for kind in ("1_norm", "centroid")]
    np.testing.assert_allclose(line[0].forces, [10.0, 20.0, 10.0], atol=1e-6)
    np.testing.assert_allclose(line[1].forces, [55.0, 20.0, 55.0], atol=1e-6)
    for kind in ("1_norm", "2_norm", "centroid"):
        point = distribute(L, [1.0], [10.0] * 3, [10.0, 100.0, 10.0], f"polygon_{kind}")
        np.testing.assert_allclose(point.forces, [10.0, 10.0, 10.0], atol=1e-6)


def test_centroid_is_continuous_along_a_motion() -> None:
    """The minimum sum jumps between corners, but the centroid moves continuously."""
    L = np.tile(stacked(50, 1, 2, 4)[0], (400, 1, 1))
    turn = np.linspace(0.0, 2 * np.pi, 400)
    tau = -L[0].T @ np.full(4, 55.0) + 2.0 * np.column_stack([np.cos(turn), np.sin(turn)])
    answer = polygon_centroid(L, tau, LOW, HIGH)
    assert answer.solved.all()
    assert np.abs(np.diff(answer.forces, axis=0)).max() < 1.5


@pytest.mark.parametrize("m", [3, 5])
def test_other_numbers_of_muscles_raise_an_error(m: int) -> None:
    L, tau = stacked(51, 1, 2, m)
    with pytest.raises(InputError, match=rf"two more muscles than coordinates, not {m} muscles"):
        polygon_centroid(L, tau, LOW, HIGH)
