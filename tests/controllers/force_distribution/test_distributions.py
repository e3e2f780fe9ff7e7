"""Compare force distributions with brute force, linear programs and results of CASPR."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linprog, minimize
from support.cases import sample_cases
from support.controllers.distribution_problems import (
    HIGH,
    LOW,
    feasible,
    least_norm,
    stacked,
    vertices,
)

from addin_sdfusion.robot import InputError
from controllers.force_distribution.closed_form import (
    closed_form,
    improved_closed_form,
    improved_puncture,
    puncture,
)
from controllers.force_distribution.linear import (
    linear_programme,
    minimum_infinity_norm,
    optimally_safe,
)
from controllers.force_distribution.methods import METHODS, distribute
from controllers.force_distribution.quadratic import least_squares

CASPR = {
    "Example_2R_planar_XZ__basic": 2e-3,
    "Example_2R_planar_XZ__basic_multi_segment": 2e-3,
    "Example_2R_planar_XZ__commit_03330b5f_2018_10_25": 2e-3,
    "Example_2R_planar_XZ__commit_b8314f6f_2018_07_03": 2e-3,
    "Example_spatial__basic_7_cables": 2e-3,
    "Example_spherical__basic_4_cables": 8e-2,  # m = n + 1 muscles amplify the rounding error
    "BMArm__WORKING": 2e-3,
    "RoboyLeftArm__DEFAULT": 1e-2,
}
"""Tolerances for minimum-norm forces of CASPR, in [N]. CASPR rounds the coefficients of the
equation of motion to 6 decimals."""

COMPLETE = (
    *("least_squares", "p_norm", "linear_programme", "minimum_infinity_norm"),
    "optimally_safe",
)
"""Methods that find a solution for every feasible torque."""


@pytest.mark.parametrize("file", CASPR)
def test_least_squares_match_minimum_norm_forces_of_caspr(shared: Path, file: str) -> None:
    reference = json.loads((shared / "reference/caspr" / f"{file}.json").read_text())
    poses = reference["poses"]
    n = reference["numDofs"]
    terms = (np.reshape(p["M"], (n, n)) @ np.ravel(p["qdd"]) for p in poses)
    tau = [t + np.ravel(p["C"]) + np.ravel(p["G"]) for t, p in zip(terms, poses, strict=True)]
    L = np.array([np.reshape(p["L"], (-1, n)) for p in poses])
    answer = least_squares(L, tau, reference["force_min"], reference["force_max"])
    rounded = least_squares(
        np.round(L, 6), np.round(tau, 6), reference["force_min"], reference["force_max"]
    )
    statuses = [p["caspr_id_minquad"]["status"] for p in poses]
    assert answer.status.tolist() == ["solved" if s == "ok" else s for s in statuses]
    for pose, forces, as_caspr in zip(poses, answer.forces, rounded.forces, strict=True):
        caspr = pose["caspr_id_minquad"]
        if caspr["status"] == "ok":
            np.testing.assert_allclose(forces, caspr["f"], rtol=0, atol=CASPR[file])
            np.testing.assert_allclose(as_caspr, caspr["f"], rtol=0, atol=1e-10)
            assert forces @ forces == pytest.approx(caspr["objective_sum_f2"], rel=1e-3)


@pytest.mark.cases(6)
@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("size", [1.0, 8.0])
def test_statuses_match_the_feasibility_of_poses(method: str, size: float) -> None:
    L, tau = stacked(3, 60, 3, 5, size)
    answer = distribute(L, tau, LOW, HIGH, method)
    assert answer.forces.shape == (60, 5)
    possible = np.array([feasible(*pose) for pose in zip(L, tau, strict=True)])
    assert np.array_equal(answer.status == "infeasible", ~possible)
    good = answer.solved
    assert good.any()
    if method in COMPLETE or method.startswith("polygon"):
        assert np.array_equal(good, possible)
    f = answer.forces[good]
    assert (f >= LOW).all()
    assert (f <= HIGH).all()
    error = np.abs(tau[good] + np.einsum("pmn,pm->pn", L[good], f)).max(axis=1)
    np.testing.assert_allclose(answer.torque_error[good], error, atol=1e-12)
    assert error.max() < 1e-6
    assert np.isnan(answer.forces[~good]).all()


@pytest.mark.parametrize("n", [1, 2, 3])
def test_least_squares_equal_brute_force(n: int) -> None:
    L, tau = stacked(n, 12, n, n + 2, 4.0)
    middle = np.full(n + 2, 0.5 * (LOW + HIGH))
    for target in (0.0 * middle, middle):
        answer = least_squares(L, tau, LOW, HIGH, target=target)
        best = [least_norm(*pose, target) for pose in zip(L, tau, strict=True)]
        np.testing.assert_allclose(answer.forces, best, atol=1e-8)


@pytest.mark.slow
def test_linear_programs_match_scipy() -> None:
    L, tau = stacked(5, 25, 3, 6, 4.0)
    for one, desired in zip(L, tau, strict=True):
        A, box = -one.T, [(LOW, HIGH)] * 6
        least = linprog(np.ones(6), A_eq=A, b_eq=desired, bounds=box)
        f = linear_programme(one, desired, LOW, HIGH).forces
        weighted = linear_programme(one, desired, LOW, HIGH, costs=[1, 2, 1, 3, 1, 1]).forces
        peak = minimum_infinity_norm(one, desired, LOW, HIGH).forces.max()
        if least.status != 0:
            assert np.isnan(f).all()
            continue
        assert f.sum() == pytest.approx(least.fun, abs=1e-8)
        costly = linprog([1, 2, 1, 3, 1, 1], A_eq=A, b_eq=desired, bounds=box).fun
        assert weighted @ [1, 2, 1, 3, 1, 1] == pytest.approx(costly, abs=1e-8)
        for factor, possible in ((1 + 1e-7, True), (1 - 1e-6, False)):
            assert (
                peak <= LOW * (1 + 1e-8) or feasible(one, desired, LOW, factor * peak) == possible
            )


@pytest.mark.parametrize("p", [3, 4, 8])
@pytest.mark.parametrize("target", [0.0, 20.0])
def test_p_norms_match_scipy(p: int, target: float) -> None:
    """SciPy does not find a smaller norm, up to its tolerance."""
    L, tau = stacked(5, 3, 3, 6)
    weights = np.array([1.0, 2.0, 1.0, 3.0, 1.0, 1.0])
    forces = distribute(L, tau, LOW, HIGH, "p_norm", p=p, weights=weights, target=target).forces

    def power(f: np.ndarray) -> float:
        return float(np.sum(np.abs(np.sqrt(weights) * (f - target) / HIGH) ** p))

    for one, desired, f in zip(L, tau, forces, strict=True):
        rows = {"type": "eq", "fun": lambda f, L=one, t=desired: -L.T @ f - t}
        start, box = np.full(6, 0.5 * (LOW + HIGH)), [(LOW, HIGH)] * 6
        options = {"ftol": 1e-14, "maxiter": 300}
        best = minimize(power, start, bounds=box, constraints=[rows], options=options).fun
        assert power(f) <= best * (1 + 1e-9)
        assert power(f) == pytest.approx(best, rel=1e-4)


@pytest.mark.parametrize("p", [1, np.inf])
def test_norms_with_a_target_match_linear_programs_of_scipy(p: float) -> None:
    L, tau = stacked(6, 6, 3, 6)
    target, eye = 45.0, np.eye(6)
    forces = distribute(L, tau, LOW, HIGH, "p_norm", p=p, target=target).forces
    shares = eye if p == 1 else np.ones((6, 1))
    rows = np.block([[eye, -shares], [-eye, -shares]])
    cost = np.append(np.zeros(6), np.ones(shares.shape[1]))
    for one, desired, f in zip(L, tau, forces, strict=True):
        A = np.c_[-one.T, np.zeros((3, shares.shape[1]))]
        ends = np.repeat([target, -target], 6)
        box = [(LOW, HIGH)] * 6 + [(0.0, None)] * shares.shape[1]
        best = linprog(cost, A_ub=rows, b_ub=ends, A_eq=A, b_eq=desired, bounds=box).fun
        assert np.linalg.norm(f - target, p) == pytest.approx(best, rel=1e-7)


def test_p_norms_converge_to_the_minimum_largest_force() -> None:
    L, tau = stacked(7, 20, 3, 6)
    norms = [distribute(L, tau, LOW, HIGH, "p_norm", p=p).forces for p in (2, 4, 8, np.inf)]
    np.testing.assert_array_equal(norms[0], least_squares(L, tau, LOW, HIGH).forces)
    np.testing.assert_array_equal(norms[3], minimum_infinity_norm(L, tau, LOW, HIGH).forces)
    largest = [np.abs(f).max(axis=1) for f in norms]
    for p, peak in zip((2, 4, 8), largest[:3], strict=True):
        assert (peak >= largest[3] * (1 - 1e-9)).all()
        assert (peak <= largest[3] * 6 ** (1 / p)).all()
    assert (largest[0] > largest[3] + 1.0).any()


@pytest.mark.parametrize("alpha", [0.0, 1.0, 0.3])
def test_optimally_safe_forces_have_the_largest_distance(alpha: float) -> None:
    L, tau = stacked(6, 25, 3, 6, 3.0)
    answer = optimally_safe(L, tau, LOW, HIGH, alpha=alpha)
    for one, desired, f in zip(L, tau, answer.forces, strict=True):
        rows = np.vstack([np.c_[-np.eye(6), np.ones(6)], np.c_[np.eye(6), np.full(6, alpha)]])
        best = linprog(
            [0] * 6 + [-1],
            A_ub=rows,
            b_ub=[-LOW] * 6 + [HIGH] * 6,
            A_eq=np.c_[-one.T, np.zeros(3)],
            b_eq=desired,
            bounds=[(None, None)] * 6 + [(0, None)],
        )
        if best.status != 0:
            assert np.isnan(f).all()
            continue
        above = (HIGH - f).min() / alpha if alpha else np.inf
        assert min((f - LOW).min(), above) == pytest.approx(-best.fun, abs=1e-6)


def test_smallest_of_several_optima_is_returned() -> None:
    """Each of two joints has two muscles. The muscles that are not at the peak are at f_min."""
    L = np.array([[-0.1, 0.0], [0.1, 0.0], [0.0, -0.1], [0.0, 0.1]])
    answer = minimum_infinity_norm(L, [5.0, 0.0], 10.0, 100.0)
    np.testing.assert_allclose(answer.forces, [60.0, 10.0, 10.0, 10.0], atol=1e-6)


def test_closed_form_is_nearest_to_the_mean_of_the_limits() -> None:
    L, tau = stacked(7, 40, 3, 6, 1.0)
    answer, best = closed_form(L, tau, LOW, HIGH), least_squares(L, tau, LOW, HIGH, target=55.0)
    good = answer.solved
    assert good.sum() > 20
    np.testing.assert_allclose(answer.forces[good], best.forces[good], atol=1e-8)


def test_improved_closed_form_matches_a_loop_over_poses() -> None:
    L, tau = stacked(8, 80, 2, 5, 4.0)
    answer, plain = improved_closed_form(L, tau, LOW, HIGH), closed_form(L, tau, LOW, HIGH)
    assert answer.solved.sum() > plain.solved.sum()
    assert not (plain.solved & ~answer.solved).any()
    for one, desired, f, solved in zip(L, tau, answer.forces, answer.solved, strict=True):
        expected = _improved_closed_form(one, desired)
        assert solved == (expected is not None)
        if expected is not None:
            np.testing.assert_allclose(f, expected, atol=1e-8)


def _improved_closed_form(L: np.ndarray, tau: np.ndarray) -> np.ndarray | None:
    """Compute Pott's improved closed form of one pose by least squares for the free forces."""
    m, n = L.shape
    f, free = np.full(m, 0.5 * (LOW + HIGH)), list(range(m))
    while True:
        rest = tau + L.T @ f
        f[free] += np.linalg.lstsq(-L[free].T, rest, rcond=None)[0]
        beyond = np.maximum(LOW - f, f - HIGH)
        if beyond.max() < 1e-7:
            return f
        if len(free) == n:
            return None
        worst = int(beyond.argmax())
        free.remove(worst)
        f[worst] = np.clip(f[worst], LOW, HIGH)
        f[free] = 0.5 * (LOW + HIGH)


@pytest.mark.parametrize("punctured", [puncture, improved_puncture])
def test_puncture_is_smaller_than_the_closed_form(punctured: object) -> None:
    L, tau = stacked(9, 60, 3, 6, 3.0)
    safe = (closed_form if punctured is puncture else improved_closed_form)(L, tau, LOW, HIGH)
    answer, best = punctured(L, tau, LOW, HIGH), least_squares(L, tau, LOW, HIGH)  # type: ignore[operator]
    assert not (safe.solved & ~answer.solved).any()
    both = safe.solved
    norms = [np.linalg.norm(x.forces[both], axis=1) for x in (best, answer, safe)]
    assert (norms[0] <= norms[1] + 1e-9).all()
    assert (norms[1] <= norms[2] + 1e-9).all()
    assert (norms[1] < norms[2] - 1.0).any()


def test_puncture_equals_a_feasible_minimum_norm() -> None:
    L, tau = stacked(10, 30, 3, 6, 1.0)
    best = least_squares(L, tau, 0.0, 1e4)
    inside = ((best.forces > 1e-6) & (best.forces < 1e4)).all(axis=1)
    assert inside.any()
    for method in (puncture, improved_puncture):
        answer = method(L, tau, 0.0, 1e4)
        np.testing.assert_allclose(answer.forces[inside], best.forces[inside], atol=1e-7)


@pytest.mark.parametrize("method", METHODS)
def test_any_stack_of_poses_is_supported(method: str) -> None:
    L, tau = stacked(11, 6, 2, 4)
    one = distribute(L[4], tau[4], LOW, HIGH, method)
    stack = distribute(L.reshape(3, 2, 4, 2), tau.reshape(3, 2, 2), [LOW] * 4, [HIGH] * 4, method)
    assert one.status.shape == ()
    assert str(one.status) == "solved"
    assert stack.forces.shape == (3, 2, 4)
    np.testing.assert_allclose(stack.forces[2, 0], one.forces, atol=1e-7)
    shared_tau = distribute(L, tau[4], LOW, HIGH, method)
    np.testing.assert_allclose(shared_tau.forces[4], one.forces, atol=1e-7)
    assert distribute(L[:0], tau[:0], LOW, HIGH, method).forces.shape == (0, 4)


@pytest.mark.parametrize("method", METHODS)
def test_statuses_of_rank_deficient_poses(method: str) -> None:
    """If no muscle acts on a coordinate, only zero torque is feasible there."""
    L, tau = stacked(12, 3, 2, 4)
    L[1:, :, 1] = 0.0
    tau[1, 1], tau[2, 1] = 0.0, 1.0
    status = distribute(L, tau, LOW, HIGH, method).status
    assert status[0] == "solved"
    assert status[1] in (("solved",) if not method.startswith("polygon") else ("no answer",))
    assert status[2] == "infeasible"


@pytest.mark.parametrize("method", COMPLETE[:4])
def test_infinite_upper_limits_are_supported(method: str) -> None:
    L, tau = stacked(13, 20, 2, 5, 30.0)
    answer = distribute(L, tau, LOW, np.inf, method)
    possible = np.array([feasible(*pose, LOW, np.inf) for pose in zip(L, tau, strict=True)])
    assert np.array_equal(answer.solved, possible)
    assert np.nanmax(answer.forces) > HIGH


@pytest.mark.parametrize("method", sorted({*METHODS} - {*COMPLETE[:4]}))
def test_methods_with_finite_limits_reject_infinite_limits(method: str) -> None:
    L, tau = stacked(14, 1, 2, 4)
    with pytest.raises(InputError, match="muscle 2: f_max must be finite"):
        distribute(L, tau, LOW, [HIGH, np.inf, HIGH, HIGH], method)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"L": np.ones(4)}, r"L must have shape \(..., m, n\)"),
        ({"tau": np.ones(3)}, r"tau \(..., n\)"),
        ({"tau": np.ones((3, 2))}, "inconsistent shapes"),
        ({"f_min": [1.0, 2.0]}, "a number or 4 numbers"),
        ({"f_min": 200.0}, "muscle 1: f_min 200 must be"),
        ({"f_min": [10.0, 10.0, -1.0, 10.0]}, "muscle 3: f_min -1"),
        ({"f_max": np.nan}, "f_max must be a number, not nan"),
        ({"tau": [np.nan, 0.0]}, r"tau\[0\] must be finite, not nan"),
        ({"L": np.full((2, 4, 2), np.inf)}, r"L\[0, 0, 0\] must be finite, not inf"),
        ({"L": "no"}, "L must be numbers"),
        ({"method": "least_square"}, "did you mean 'least_squares'"),
        ({"weights": [1.0, 1.0, 0.0, 1.0]}, "weights of 'muscle 3'"),
        ({"target": np.nan}, "target must be finite"),
        ({"alpha": 1.0}, "no option of 'least_squares' 'alpha'"),
        ({"method": "optimally_safe", "alpha": -1.0}, "alpha must be"),
        ({"method": "p_norm", "p": 2.5}, "norm must be an integer from 1 to 8, .*: 2.5"),
        ({"method": "p_norm", "p": 9}, "norm must be .*, or infinity: 9"),
        ({"method": "linear_programme", "costs": [1.0]}, None),
    ],
)
def test_wrong_input_raises_an_error(change: dict[str, object], message: str | None) -> None:
    L, tau = stacked(15, 2, 2, 4)
    arguments: dict[str, object] = {"L": L, "tau": tau, "f_min": LOW, "f_max": HIGH} | change
    if message is None:
        assert distribute(**arguments).solved.all()  # type: ignore[arg-type]
        return
    with pytest.raises(InputError, match=message):
        distribute(**arguments)  # type: ignore[arg-type]


def test_brute_force_finds_corners() -> None:
    """Check the oracle: every corner produces the torque, and one has the minimum sum."""
    L, tau = stacked(16, 1, 2, 4)
    corners = vertices(L[0], tau[0])
    assert len(corners) >= 3
    sums = corners.sum(axis=1)
    assert sums.min() == pytest.approx(linear_programme(L[0], tau[0], LOW, HIGH).forces.sum())


@pytest.mark.cases(12)
@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("lever", "force"), sample_cases([(1e-5, 1.0), (1e4, 1.0), (1.0, 1e3), (1.0, 1e-3)])
)
def test_units_do_not_matter(method: str, lever: float, force: float) -> None:
    L, tau = stacked(17, 40, 3, 5, 6.0)
    plain = distribute(L, tau, LOW, HIGH, method)
    scaled = distribute(lever * L, lever * force * tau, force * LOW, force * HIGH, method)
    assert (scaled.status == plain.status).all()
    np.testing.assert_allclose(scaled.forces / force, plain.forces, atol=1e-5)
