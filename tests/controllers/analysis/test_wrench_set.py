"""Compare facets of the available torques with convex hulls and linear programs."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull
from support.controllers.distribution_problems import HIGH, LOW, feasible, stacked

from addin_sdfusion.robot import InputError
from controllers.analysis.wrench_set import capacity_margin, has_wrench_closure, torque_margins


@pytest.mark.parametrize("n", [2, 3])
def test_capacity_margins_are_distances_from_the_convex_hull(n: int) -> None:
    """CASPR uses the convex hull of the torques of all forces at their limits."""
    L, tau = stacked(60 + n, 10, n, n + 3, 12.0)
    margins = capacity_margin(L, tau, LOW, HIGH)
    assert (margins < 0).any()
    assert (margins > 0).any()
    corners = np.array(list(product((LOW, HIGH), repeat=n + 3)))
    for jacobian, desired, margin in zip(L, tau, margins, strict=True):
        hull = ConvexHull(-corners @ jacobian)
        distance = -(hull.equations[:, :-1] @ desired + hull.equations[:, -1]).max()
        assert margin == pytest.approx(distance, abs=1e-9)


def test_one_coordinate_has_two_facets() -> None:
    L = np.array([[-0.1], [0.2]])
    assert capacity_margin(L, [0.0], 10.0, 100.0) == pytest.approx(8.0)  # from -19 to 8
    down, up = torque_margins(L, [0.0], 10.0, 100.0)
    assert (down[0], up[0]) == (pytest.approx(19.0), pytest.approx(8.0))
    down, up = torque_margins(L, [0.0], 10.0, [np.inf, 100.0])
    assert (down[0], up[0]) == (pytest.approx(19.0), np.inf)


@pytest.mark.slow
def test_set_of_torques_is_available_if_all_corners_are() -> None:
    L, tau = stacked(62, 40, 2, 5, 8.0)
    W = np.array([[2.0, 0.0, 0.7], [0.0, 1.0, -0.5]])
    margins = capacity_margin(L, tau, LOW, HIGH, half_widths=W)
    inside = []
    for jacobian, desired in zip(L, tau, strict=True):
        corners = (desired + W @ np.array(s) for s in product((-1.0, 1.0), repeat=3))
        inside.append(all(feasible(jacobian, corner) for corner in corners))
    assert np.array_equal(margins >= 0, inside)
    assert 5 < sum(inside) < 35


@pytest.mark.slow
def test_torque_margins_match_linear_programs() -> None:
    L, tau = stacked(63, 15, 3, 5, 2.0)
    down, up = torque_margins(L, tau, LOW, HIGH)
    for k, (jacobian, desired) in enumerate(zip(L, tau, strict=True)):
        if not feasible(jacobian, desired):
            assert np.isnan(up[k]).all()
            continue
        for j, (margins, sign) in product(range(3), ((down, -1.0), (up, 1.0))):
            more = np.zeros((3, 1))
            more[j] = -sign
            best = linprog(
                [0] * 5 + [-1],
                A_eq=np.c_[-jacobian.T, more],
                b_eq=desired,
                bounds=[(LOW, HIGH)] * 5 + [(0, None)],
            )
            assert margins[k, j] == pytest.approx(-best.fun, abs=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize(("n", "m"), [(1, 2), (2, 3), (2, 5), (3, 4), (4, 7)])
def test_wrench_closure_requires_a_positive_null_vector_and_full_rank(n: int, m: int) -> None:
    L = stacked(70 + m, 80, n, m)[0]
    closed = has_wrench_closure(L)
    for jacobian, found in zip(L, closed, strict=True):
        null = (
            linprog(np.ones(m), A_eq=jacobian.T, b_eq=np.zeros(n), bounds=(1.0, None)).status == 0
        )
        assert found == (null and np.linalg.matrix_rank(jacobian) == n)
    assert 0 < closed.sum() < 80


def test_flat_sets_have_no_margin_and_no_wrench_closure() -> None:
    """No muscle acts on the second coordinate, or there are too few muscles."""
    L = np.array([[-0.1, 0.0], [0.1, 0.0], [0.2, 0.0]])
    assert np.isnan(capacity_margin(L, [0.0, 0.0], LOW, HIGH))
    assert not has_wrench_closure(L)
    assert not has_wrench_closure(L[:1])


def test_too_many_facets_and_wrong_sets_raise_an_error() -> None:
    with pytest.raises(InputError, match="38 muscles for 26 coordinates"):
        capacity_margin(np.ones((38, 26)), np.zeros(26), LOW, HIGH)
    L, tau = stacked(64, 2, 2, 4)
    for wrong in (np.ones(2), np.ones((3, 1)), np.full((2, 2), np.nan), np.ones((7, 2, 2))):
        with pytest.raises(InputError, match="half_widths"):
            capacity_margin(L, tau, LOW, HIGH, half_widths=wrong)
