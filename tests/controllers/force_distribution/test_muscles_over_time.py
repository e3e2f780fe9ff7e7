"""Activations over a whole motion: linear equations, closed forms, and simulation of the result."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.robots import EXAMPLES
from support.third_party_models import without_ellipsoids

from addin_sdfusion.robot import Robot, read_robot
from cardsflow_fmu.results.analysis.redundancy.over_time import optimise_activations
from cardsflow_fmu.results.analysis.redundancy.static import static_optimisation
from controllers.analysis.inverse_dynamics import Motion, motion_terms
from controllers.arrays import FloatArray
from controllers.force_distribution.over_time.chains import ChainEquations, MuscleChains
from controllers.force_distribution.over_time.problem import MuscleProblem
from controllers.force_distribution.over_time.solver import MuscleTrajectorySolver
from controllers.force_distribution.over_time.terms import convex
from sim_dart import CoreDynamics
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core
from sim_dart.muscles.fibres import FIBRE_LAWS, HillMuscles

ARM = read_robot(EXAMPLES / "hill_arm/robot")


def with_parameters(robot: Robot, kind: str | None = None, **changes: float) -> Robot:
    """Return a robot with other muscle laws and parameters; common parameters are kept."""
    muscles = []
    common = ("max_isometric_force", "optimal_fibre_length", "tendon_slack_length")
    for muscle in robot.muscles:
        own = dict(muscle.model.parameters)
        if kind is not None:
            own = {name: own[name] for name in common}
        model = replace(
            muscle.model,
            kind=kind or muscle.model.kind,
            parameters=tuple((own | changes).items()),
        )
        muscles.append(replace(muscle, model=model))
    return robot.with_muscles(muscles)


def waving(frames: int, duration: float = 0.6) -> Motion:
    t = (np.arange(frames)[:, None] + 0.5) * duration / frames
    w = 2 * np.pi / duration
    size = np.array([0.3, 0.4])
    q = np.array([0.4, 1.0]) + size * np.sin(w * t)
    return Motion(t[:, 0], q, size * w * np.cos(w * t), -size * w * w * np.sin(w * t))


def test_chain_equations_match_dense_equations() -> None:
    rng = np.random.default_rng(0)
    N, m, n = 40, 3, 2  # more equations than a block of the factorisation
    L = rng.normal(size=(N, m, n))
    L[:, 0, 1] = 0.0

    def symmetric(*shape: int) -> FloatArray:
        A = rng.normal(size=shape)
        return A @ A.mT + np.eye(shape[-1])

    own = ChainEquations(
        symmetric(m, N, 3, 3),
        symmetric(m, N - 1, 2, 2),
        rng.normal(size=(m, N, 2)),
        rng.normal(size=(m, N)),
        rng.normal(size=(m, N, 3)),
        rng.uniform(0.1, 1.0, (N, n)),
        rng.normal(size=(m, N + 1)),
        rng.normal(size=(m, N)),
        rng.normal(size=(N, n)),
    )
    size = m * (2 * N + 1) + m * N + N * n  # x, a, multipliers of a, y
    K, right = np.zeros((size, size)), np.zeros(size)
    x = np.arange(m * (N + 1)).reshape(m, N + 1)
    a = x.size + np.arange(m * N).reshape(m, N)
    mu, y = a + m * N, x.size + 2 * m * N + np.arange(N * n).reshape(N, n)
    right[x], right[a] = -own.g_x, -own.g_a
    for i in range(m):
        for k in range(N):
            local = [x[i, k], a[i, k], x[i, k + 1]]
            K[np.ix_(local, local)] += own.frames[i, k]
            row = np.array([-own.T[i, k, 0], 1.0, -own.T[i, k, 1]])
            K[mu[i, k], local] = K[local, mu[i, k]] = row
            right[mu[i, k]] = own.t[i, k]
            rates = np.outer(own.B[i, k], L[k, i])
            K[np.ix_(local, y[k])] += rates
            K[np.ix_(y[k], local)] += rates.T
            if k < N - 1:
                pair = [a[i, k], a[i, k + 1]]
                K[np.ix_(pair, pair)] += own.edges[i, k]
    K[y, y] -= own.D
    right[y] = -own.c
    expected = np.linalg.solve(K, right)
    found = MuscleChains(L).solve(own)
    assert found is not None
    for part, index in ((found.x, x), (found.a, a), (found.y, y)):
        np.testing.assert_allclose(part, expected[index], atol=1e-9)


def test_convex_only_changes_negative_curvature_along_the_constraint() -> None:
    rng = np.random.default_rng(1)
    H, A, added = rng.normal(size=(50, 3, 3)), rng.normal(size=(50, 3)), rng.uniform(0, 1, (50, 3))
    H = H + H.mT
    changed = convex(H, added, A)
    for before, after, row, more in zip(H, changed, A, added, strict=True):
        basis = np.linalg.svd(row[None])[2][1:].T
        values = np.linalg.eigvalsh(basis.T @ (before + np.diag(more)) @ basis)
        curvature = np.linalg.eigvalsh(basis.T @ (after + np.diag(more)) @ basis)
        np.testing.assert_allclose(curvature, np.maximum(values, 0.0), atol=1e-9)
        np.testing.assert_allclose((after - before) @ row, 0.0, atol=1e-9)


@pytest.mark.parametrize("kind", FIBRE_LAWS)
def test_fibres_have_exact_derivatives(kind: str) -> None:
    own = HillMuscles(with_parameters(ARM, kind, elastic_tendon=1.0))
    rng, shape = np.random.default_rng(2), (20, len(own.force))
    points = np.stack(
        [
            rng.uniform(0.1, 0.9, shape),
            own.optimal * rng.uniform(0.7, 1.3, shape),
            own.speed * rng.uniform(-0.4, 0.4, shape),
            own.slack * 1.02 + own.optimal * rng.uniform(0.7, 1.3, shape),
            rng.uniform(-5.0, 5.0, shape),
        ],
        axis=2,
    )
    values, h = own.fibres(points), 1e-7
    for number, row, column in (
        (0, 0, 1),
        (1, 0, 2),
        (2, 0, 3),
        (1, 4, 5),
        (0, 10, 11),
        (4, 10, 12),
    ):
        step = h * np.eye(5)[number]
        slope = (own.fibres(points + step) - own.fibres(points - step))[..., row] / (2 * h)
        scale = abs(slope).max()
        np.testing.assert_allclose(values[..., column], slope, atol=1e-5 * scale)
    tension = np.stack([rng.uniform(0.05, 1.0, shape), points[:, :, 3]], axis=2)
    fibre, slope = np.moveaxis(own.tendons(tension), 2, 0)
    points[:, :, 1] = fibre
    np.testing.assert_allclose(own.fibres(points)[..., 4] / own.force, tension[..., 0], atol=1e-9)
    np.testing.assert_allclose(own.fibres(points)[..., 5] / own.force * slope, 1.0, atol=1e-7)


def test_elastic_arm_needs_the_excitations_of_moco_inverse(shared: Path) -> None:
    """OpenSim Moco 4.6, 25 intervals, tolerance 1e-5; its goal of auxiliary derivatives apart."""
    arm = without_ellipsoids(read_robot(shared / "reference/moco/P3.osim"))
    t = (np.arange(101)[:, None] + 0.5) / 101
    q = [0.05, 0.6] + t**3 * (10.0 - 15.0 * t + 6.0 * t**2) * [0.1, 0.8]
    qd = 30.0 * (t * (1.0 - t)) ** 2 * [0.1, 0.8]
    qdd = 60.0 * t * (1.0 - t) * (1.0 - 2.0 * t) * [0.1, 0.8]
    motion = Motion(t[:, 0], q, qd, qdd)
    found = optimise_activations(with_parameters(arm, elastic_tendon=1.0), motion).trajectory
    assert found is not None
    assert found.cost == pytest.approx(0.8024681, rel=0.01)
    middle = dict(zip((m.name for m in arm.muscles), found.excitations[50], strict=True))
    for name, excitation in (("TRIlat", 0.40040), ("TRImed", 0.37446), ("BIClong", 0.56466)):
        assert middle[name] == pytest.approx(excitation, rel=0.01)


def test_two_synergists_share_a_constant_torque_in_closed_form() -> None:
    """With min sum of a^p, a_i^(p-1) is proportional to r_i F_i, except near the ends."""
    robot = with_parameters(ARM, elastic_tendon=0.0)
    own = HillMuscles(robot.with_muscles(robot.muscles[:2]))
    N = 61
    lengths = np.tile(own.slack + own.optimal, (N, 1))
    arms, still = np.array([0.03, 0.05]), np.zeros_like(lengths)
    fibres = own.fibres(np.stack([still + 1, lengths - own.slack, still, lengths, still], axis=2))
    idle = own.fibres(np.stack([still, lengths - own.slack, still, lengths, still], axis=2))
    gain, tau = arms * (fibres - idle)[0, :, 0], 20.0
    L = -np.tile(arms[:, None], (N, 1, 1))
    torque = np.full((N, 1), tau + float(arms @ idle[0, :, 0]))
    for power in (2.0, 3.0):
        problem = MuscleProblem(
            *(0.02, L, torque, lengths, own, own.elastic, *own.rigid(lengths, still)),
            *(own.force, own.optimal, own.shortest, np.zeros(2), np.array([1e-4]), power),
        )
        found = MuscleTrajectorySolver(problem, np.full((N, 2), 0.1)).solve()
        share = gain ** (1.0 / (power - 1.0))
        assert found.is_solved
        np.testing.assert_allclose(
            found.activations[N // 2], tau * share / (gain @ share), rtol=2e-3
        )


def test_slow_motion_has_the_cost_of_static_optimisation() -> None:
    """With rigid tendons, and activations that change slowly."""
    robot, motion = with_parameters(ARM, elastic_tendon=0.0, fibre_damping=0.0), waving(30, 20.0)
    static = static_optimisation(robot, motion, passive=True)
    found = optimise_activations(robot, motion)
    costs = [np.square(own.activations).sum() for own in (static, found)]
    assert costs[1] == pytest.approx(costs[0], rel=0.01)
    assert costs[0] > 0.1


@pytest.mark.parametrize("elastic", [0.0, 1.0])
def test_simulated_muscles_reproduce_the_tensions(elastic: float) -> None:
    """The laws of the plant, driven by the excitations along the motion, to the time step."""
    robot = with_parameters(ARM, elastic_tendon=elastic, activation_smoothing=0.1)
    motion = waving(60)
    found = optimise_activations(robot, motion)
    own, h = found.trajectory, motion.times[1] - motion.times[0]
    assert own is not None
    terms = motion_terms(CoreDynamics(robot), motion)
    made = -np.einsum("tmn,tm->tn", terms.L, found.forces) + found.reserves
    np.testing.assert_allclose(made, terms.tau, atol=1e-6)
    assert abs(found.reserves).max() < 0.05
    core, m = Core(compile_blob(robot)), len(robot.muscles)
    states = core.array("law_states", (1 + int(elastic)) * m)
    states.reshape(m, -1)[:, 0] = own.activations[0]
    if elastic:
        states.reshape(m, -1)[:, 1] = own.fibre_lengths[0]
    tensions, scale = core.array("tensions", m), found.forces.max()
    for k in range(len(motion.times) - 1):
        u = (own.excitations[k] + own.excitations[k + 1]) / 2
        core.move(core.handle, motion.q[k].tobytes())
        core.update_rates(core.handle, ((motion.qd[k] + motion.qd[k + 1]) / 2).tobytes())
        core.advance(core.handle, u.tobytes(), h)
        core.move(core.handle, motion.q[k + 1].tobytes())
        core.drive(core.handle, motion.qd[k + 1].tobytes(), u.tobytes())
        assert abs(tensions - found.forces[k + 1]).max() < 0.03 * scale


def test_cost_converges_with_the_square_of_the_time_step() -> None:
    costs = []
    for frames in (16, 32, 64):
        own = optimise_activations(with_parameters(ARM, elastic_tendon=1.0), waving(frames))
        assert own.trajectory is not None
        costs.append(own.trajectory.cost)
    first, second = abs(np.diff(costs))
    assert second < 0.4 * first
    assert second < 0.01 * costs[-1]


def test_kinks_of_a_curve_do_not_prevent_convergence() -> None:
    """At rest, Thelen's force-velocity curve has a kink, so that gradients do not vanish."""
    robot, motion = with_parameters(ARM, "hill_thelen2003", elastic_tendon=1.0), waving(40, 3.0)
    found = optimise_activations(robot, motion)
    terms = motion_terms(CoreDynamics(robot), motion)
    made = -np.einsum("tmn,tm->tn", terms.L, found.forces) + found.reserves
    np.testing.assert_allclose(made, terms.tau, atol=1e-6)
    assert not found.rigid_names


def test_tendons_of_slack_muscles_become_rigid() -> None:
    muscle = ARM.muscles[0]
    longer = dict(muscle.model.parameters)
    longer["tendon_slack_length"] += 0.3
    model = replace(muscle.model, parameters=tuple(longer.items()))
    robot = ARM.with_muscles([replace(muscle, model=model), *ARM.muscles[1:]])
    found = optimise_activations(with_parameters(robot, elastic_tendon=1.0), waving(20))
    assert found.rigid_names == (muscle.name,)
    assert not found.forces[:, 0].any()
