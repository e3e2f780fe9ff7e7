"""A batch equals single plants bit by bit, and its derivatives equal differences."""

from __future__ import annotations

import pickle
import tracemalloc
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import (
    Coordinate,
    InputError,
    LimitForce,
    Robot,
    SimulationError,
    read_robot,
)
from sim_dart import Batch, Plant
from sim_dart.estimation.estimated_robot import without_limits

STEP, SUBSTEPS = 3e-3, 3


def _robot(name: str) -> Robot:
    return read_robot(EXAMPLES / name / "robot")


def _commands(batch: Batch, count: int) -> list[np.ndarray]:
    rng = np.random.default_rng(0)
    high = np.where(np.isfinite(batch.command_high), batch.command_high, 100.0)
    return [rng.uniform(batch.command_low, high, batch.commands.shape) for _ in range(count)]


def _heavier(robot: Robot) -> Robot:
    links = [replace(k, inertia=replace(k.inertia, mass=1.5 * k.inertia.mass)) for k in robot.links]
    return replace(robot, links=tuple(links))


@pytest.mark.native
@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("name", ["hill_arm", "roboy_left_arm", "bicycle"])
def test_batches_equal_plants_bit_by_bit(name: str, threads: int) -> None:
    robot = _robot(name)
    variants = (robot, _heavier(robot))
    batch = Batch(robot, 90, STEP, substeps=SUBSTEPS, variants=variants, threads=threads)
    plants = [Plant(variants[i % 2], STEP, substeps=SUBSTEPS, engine="core") for i in (0, 41, 89)]
    steps = _commands(batch, 20)
    for u in steps:
        batch.step(u)
    for i, plant in zip((0, 41, 89), plants, strict=True):
        for u in steps:
            plant.step(u[i])
        single = plant.q, plant.qd, plant.muscle_states, plant.muscle_lengths, plant.muscle_jacobian
        several = batch.q, batch.qd, batch.states, batch.lengths, batch.jacobian
        for one, all_ in zip(single, several, strict=True):
            np.testing.assert_array_equal(one, all_[i])
        np.testing.assert_array_equal(plant.tensions, batch.tensions()[i])
        np.testing.assert_array_equal(plant.task_position, batch.task_position[i])


@pytest.mark.parametrize("name", ["planar_2r", "roboy_left_arm"])
def test_instances_in_lanes_equal_instances_alone_bit_by_bit(name: str) -> None:
    """Also slack cables, limits that some instances meet, torques, and one that diverges."""
    robot = _robot(name) if name == "roboy_left_arm" else without_limits(_robot(name))
    variants = (robot, _heavier(robot), robot)
    lanes, alone = (
        Batch(robot, 14, 0.02, substeps=20, variants=variants, threads=1) for _ in range(2)
    )
    assert lanes._groups
    alone._groups = []
    rng = np.random.default_rng(1)
    start = alone.get_state()
    start[:, alone.q.shape[1] : 2 * alone.q.shape[1]] = rng.normal(0.0, 3.0, alone.q.shape)
    for batch in (lanes, alone):
        batch.set_state(start)
    for u in _commands(alone, 4):
        u = np.maximum(u - 30.0, 0.0)
        u[5] = 1e308
        torques = rng.normal(0.0, 0.1, (14, len(alone._actuated)))
        for batch in (lanes, alone):
            with suppress(SimulationError):
                batch.step(u, torques)
    assert alone.diverged.any()
    for array in ("work", "qdd", "torques", "points", "task_values", "frame_rotation"):
        views = (batch._instances.view(array, -1) for batch in (lanes, alone))
        np.testing.assert_array_equal(*views)
    for array in ("q", "qd", "lengths", "jacobian", "diverged"):
        np.testing.assert_array_equal(getattr(lanes, array), getattr(alone, array))


def test_chosen_instances_are_reset_with_their_variant() -> None:
    robot = _robot("planar_2r")
    heavy = _heavier(robot)
    batch = Batch(robot, 3, variants=(robot, heavy))
    before = pickle.loads(pickle.dumps(batch))
    batch.step(30.0 * np.ones(4))
    batch.reset([False, True, True], q=[0.1, 0.2], qd=[0.3, -0.1], variant=[1, 0, 1])
    assert batch.ticks.tolist() == [1, 0, 0]
    assert batch.variant.tolist() == [0, 0, 1]
    batch.step(20.0 * np.ones(4), chosen=[False, True, True])
    assert batch.ticks.tolist() == [1, 1, 1]
    for i, variant in ((1, robot), (2, heavy)):
        plant = Plant(variant)
        plant.reset([0.1, 0.2], [0.3, -0.1])
        plant.step(20.0 * np.ones(4))
        np.testing.assert_array_equal(batch.q[i], plant.q)
    assert not np.array_equal(batch.q[1], batch.q[2])
    again = pickle.loads(pickle.dumps(batch))
    for one in (batch, again):
        one.step(np.full(4, 10.0))
    np.testing.assert_array_equal(batch.get_state(), again.get_state())
    assert before.ticks.tolist() == [0, 0, 0]


def test_terms_equal_those_of_the_motion_equation() -> None:
    robot = _robot("planar_2r")
    batch = Batch(robot, 4)
    batch.reset(q=np.random.default_rng(1).uniform(-0.3, 0.3, (4, 2)), qd=[0.5, -0.4])
    q, qd, y = batch.q.copy(), batch.qd.copy(), batch.task_position
    M, h, J = batch.mass_matrix().copy(), batch.bias().copy(), batch.task_jacobian()
    lengths, L = batch.lengths.copy(), batch.jacobian.copy()
    damping = np.array([c.damping for c in robot.coordinates])
    u, step = np.full(4, 15.0), batch.step_size
    batch.step(u)
    acceleration = (batch.qd - qd) / step
    M_damped = M + step * np.diag(damping)
    expected = np.linalg.solve(M_damped, (-np.swapaxes(L, 1, 2) @ u - h - damping * qd)[..., None])
    np.testing.assert_allclose(acceleration, expected[..., 0], rtol=1e-9)
    moved = ((batch.q - q)[:, None, :] @ np.swapaxes(J, 1, 2))[:, 0]
    np.testing.assert_allclose(batch.task_position - y, moved, atol=1e-6)
    pulled = ((batch.q - q)[:, None, :] @ np.swapaxes(L, 1, 2))[:, 0]
    np.testing.assert_allclose(batch.lengths - lengths, pulled, atol=1e-6)


def _beyond_soft_limits(robot: Robot) -> Robot:
    """Return the robot with limits that its initial pose exceeds by 0.2 rad."""

    def limited(c: Coordinate) -> Coordinate:
        return replace(c, limit_force=LimitForce(-9.0, c.initial - 0.2, 9.0, 9.0, 0.5, 0.01, 0.1))

    return replace(robot, joints=tuple(joint.map_coordinates(limited) for joint in robot.joints))


@pytest.mark.native
@pytest.mark.parametrize("integrator", ["euler", "rk4", "beyond soft limits"])
def test_derivatives_equal_differences(integrator: Any) -> None:
    robot, e = _robot("hill_arm"), 1e-6
    if integrator == "beyond soft limits":
        integrator, robot = "euler", _beyond_soft_limits(robot)
    batch = Batch(robot, 6, 4e-3, integrator=integrator, substeps=2, threads=2)
    rng = np.random.default_rng(2)
    u = rng.uniform(0.2, 0.8, batch.commands.shape)
    for _ in range(10):
        batch.step(u)
    x = batch.get_state()
    found = batch.derivatives(u)
    np.testing.assert_array_equal(batch.get_state(), x)  # no step
    dx, du = 0.1 * rng.normal(size=x.shape), 0.1 * rng.normal(size=u.shape)
    ends = []
    for sign in (e, -e):
        batch.set_state(x + sign * dx)
        batch.step(u + sign * du)
        ends.append(batch.get_state())
    along = np.einsum("kij,kj->ki", found.A, dx) + np.einsum("kij,kj->ki", found.B, du)
    np.testing.assert_allclose(along, (ends[0] - ends[1]) / (2 * e), rtol=1e-6, atol=1e-8)


def test_diverged_instances_stop_until_they_are_reset() -> None:
    batch = Batch(without_limits(_robot("planar_2r")), 3)
    u = np.full((3, 4), 20.0)
    u[1] = [1e15, 0.0, 0.0, 0.0]
    with pytest.raises(SimulationError, match=r"1 of 3 instances .* instance 1 in 'joint_1'"):
        for _ in range(9):
            batch.step(u)
    assert batch.diverged.tolist() == [False, True, False]
    ticks = batch.ticks.copy()
    batch.step(np.full((3, 4), 20.0))
    assert (batch.ticks - ticks).tolist() == [1, 0, 1]
    batch.reset(batch.diverged)
    batch.step(np.full((3, 4), 20.0))
    assert not batch.diverged.any()


def test_a_step_allocates_no_arrays() -> None:
    batch = Batch(_robot("planar_2r"), 5000, threads=1)
    u = np.full((5000, 4), 20.0)
    batch.step(u)
    tracemalloc.start()
    batch.step(u)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < u.nbytes / 2


WRONG: dict[str, tuple[Callable[[Batch], object], str]] = {
    "few": (lambda b: Batch(b.robot, 0), "n must be a whole number from 1, not 0"),
    "half": (lambda b: Batch(b.robot, 2.5), "n must be a whole number"),  # type: ignore[arg-type]
    "threads": (lambda b: Batch(b.robot, 1, threads=-1), "threads must be a whole number from 0"),
    "step": (lambda b: Batch(b.robot, 1, 0.0), "must be a positive time"),
    "rule": (lambda b: Batch(b.robot, 1, integrator="rk5"), "unknown integrator 'rk5'"),  # type: ignore[arg-type]
    "substeps": (lambda b: Batch(b.robot, 1, substeps=0), "substeps must be a whole number"),
    "variant robot": (
        lambda b: Batch(b.robot, 1, variants=(b.robot, _robot("hill_arm"))),
        "variant 'hill_arm': coordinates, muscles and muscle laws must be the same",
    ),
    "shape": (lambda b: b.step(np.ones(5)), r"commands must have shape \(2, 4\) or \(4,\)"),
    "text": (lambda b: b.step("high"), "commands must be numbers"),
    "nan": (lambda b: b.step([1, 2, np.nan, 4]), r"finite, not nan \(instance 0, column 2\)"),
    "torques": (lambda b: b.step(np.ones(4), np.ones(1)), r"torques must have shape \(2, 0\)"),
    "q": (lambda b: b.reset(q=np.ones(3)), r"q must have shape \(2, 2\)"),
    "large q": (lambda b: b.reset(q=[1e10, 0.0]), "instance 0: coordinate .* beyond 1e9"),
    "qd": (lambda b: b.reset(qd=[np.inf, 0.0]), "qd must be finite"),
    "chosen": (lambda b: b.reset([1, 0]), "chosen must be 2 flags, not an array of int64"),
    "variant": (lambda b: b.reset(variant=[0, 1]), "variant must be from 0 to 0, not 0 to 1"),
    "variants": (lambda b: b.reset(variant=[0.0, 1.0]), "variant must be 2 whole numbers"),
    "state": (lambda b: b.set_state(np.ones(5)), r"x must have shape \(2, 4\)"),
}


@pytest.mark.parametrize(("call", "message"), WRONG.values(), ids=WRONG)
def test_wrong_arguments_are_rejected(call: Callable[[Batch], object], message: str) -> None:
    batch = Batch(_robot("planar_2r"), 2)
    x = batch.get_state()
    with pytest.raises(InputError, match=message):
        call(batch)
    if "beyond" not in message:
        np.testing.assert_array_equal(batch.get_state(), x)
