"""Comparison of the engines of the plant, the C core and DART."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.robots.plants import check_repeats, steps
from support.robots.random_robots import random_robot, random_state, random_tree
from support.robots.robots import planar_2r, with_coordinates

from addin_sdfusion.robot import InputError, Robot, SimulationError, UnknownNameError
from addin_sdfusion.robot.model.muscle import CableModel
from sim_dart import Plant, Scene
from sim_dart.dart.skeleton import build_skeleton

ENGINES_AND_RULES: Any = pytest.mark.parametrize(
    ("engine", "rule"), [("core", "euler"), ("core", "rk4"), ("dart", "euler")]
)
CLOSE = 1e-9  # in [rad] and [m]


def both_plants(robot: Robot, **settings: Any) -> tuple[Plant, Plant]:
    return Plant(robot, engine="core", **settings), Plant(robot, engine="dart", **settings)


def step_together(plants: tuple[Plant, Plant], steps: int, *inputs: Any, **more: Any) -> float:
    """Step both plants, compare their states, and return the displacement."""
    core, dart = plants
    begin = core.q
    for k in range(steps):
        for plant in plants:
            plant.step(*inputs, **more)
        if k % 50 == 49:
            np.testing.assert_allclose(core.q, dart.q, rtol=0, atol=CLOSE)
    return float(np.abs(core.q - begin).max())


@pytest.mark.cases(10)
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_damped_tree_moves_like_in_dart(seed: int) -> None:
    """Include springs, loads on a point, wrenches on two links, and motors."""
    robot = with_coordinates(random_tree(seed, damping=2.0), actuated=True)
    robot = with_coordinates(robot, stiffness=0.5, rest=0.1)
    rng = np.random.default_rng(seed)
    plants = both_plants(robot, step=1e-3, wrenched=("link_0", "link_1"))
    q, _, f = random_state(robot, rng)
    for plant in plants:
        plant.reset(q)
    torques = 0.2 * rng.uniform(-1, 1, q.size)
    loads, wrenches = 0.3 * rng.uniform(-1, 1, 3), 0.3 * rng.uniform(-1, 1, 12)
    assert step_together(plants, 1000, 0.3 * f, torques, loads=loads, wrenches=wrenches) > 0.01
    for plant in plants:
        plant.reset(q)
    assert step_together(plants, 1000, 0.3 * f) > 0.01  # only by muscles and springs


@pytest.mark.slow
@pytest.mark.parametrize("robot", [planar_2r(), random_robot(2, joints=4)])
def test_joint_limits_in_core_and_dart_are_equal(robot: Robot) -> None:
    """An arm falls to its limits and rests there."""
    limited = with_coordinates(robot, lower=-0.4, upper=0.4, damping=0.05)
    plants = both_plants(limited)
    start = np.full(len(robot.coordinates), 0.1)
    for plant in plants:
        plant.reset(start)
    step_together(plants, 1000, np.zeros(len(robot.muscles)))
    assert np.abs(plants[0].q).max() > 0.4 - 1e-9
    assert np.abs(plants[0].q).max() <= 0.4 + 1e-9


@pytest.mark.slow
def test_substeps_laws_and_energies_equal_dart() -> None:
    """Compare energies, momenta, tensions and states of elastic muscles under a load."""
    model = CableModel("elastic_cable", (("stiffness", 1e3), ("damping", 5.0)))
    robot = with_coordinates(planar_2r(), damping=0.1, stiffness=0.3, rest=0.2)
    robot = robot.with_muscles([replace(muscle, model=model) for muscle in robot.muscles])
    core, dart = both_plants(robot, substeps=3, energy=True)
    commands = core.commands
    for _ in range(300):
        for plant in (core, dart):
            plant.step(commands, loads=[0.4, 0.0, -0.3])
    np.testing.assert_allclose(core.q, dart.q, rtol=0, atol=CLOSE)
    np.testing.assert_allclose(core.energy, dart.energy, rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(core.tensions, dart.tensions, rtol=1e-8)
    np.testing.assert_allclose(core.muscle_states, dart.muscle_states, rtol=1e-8)
    np.testing.assert_allclose(core.task_position, dart.task_position, rtol=0, atol=CLOSE)


@pytest.mark.parametrize("seed", range(9))
def test_energies_and_momenta_equal_dart(seed: int) -> None:
    robot = random_tree(seed)
    q, qd, _ = random_state(robot, np.random.default_rng(seed))
    skeleton = build_skeleton(robot)
    skeleton.set_positions(q)
    skeleton.set_velocities(qd)
    dart, linear, angular = skeleton.dart, np.zeros(3), np.zeros(3)
    for body in (dart.getBodyNode(k) for k in range(dart.getNumBodyNodes())):
        R, momentum = (
            body.getWorldTransform().rotation(),
            body.getMass() * body.getCOMLinearVelocity(),
        )
        linear += momentum
        spin = R @ body.getInertia().getMoment() @ R.T @ body.getAngularVelocity()
        angular += np.cross(body.getCOM(), momentum) + spin
    weight = -dart.getMass() * np.array(robot.gravity) @ dart.getCOM()
    for plant in both_plants(robot, energy=True):
        plant.reset(q, qd)
        expected = dart.computeKineticEnergy(), weight
        np.testing.assert_allclose(plant.energy[:2], expected, rtol=1e-11, atol=1e-11)
        np.testing.assert_allclose(plant.momentum, (linear, angular), rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("rule", ["euler", "rk4"])
def test_core_state_is_restored_bit_identically(rule: Any) -> None:
    plant = Plant(planar_2r(), integrator=rule, engine="core", energy=True)
    f = np.array([30.0, 10.0, 20.0, 10.0])
    steps(plant, 30, f, loads=[1.0, 0.0, 2.0])
    saved = plant.get_state()
    check_repeats(plant, 30, f)
    other = Plant(planar_2r(), engine="dart", energy=True)
    other.set_state(saved)  # the same numbers in the same order
    assert np.array_equal(other.get_state(), saved)


def test_load_is_removed_after_its_end() -> None:
    pushed, free = (Plant(planar_2r(), engine="core") for _ in range(2))
    pushed.step(np.zeros(4), loads=[5.0, 0.0, 0.0])
    pushed.reset()
    for plant in (pushed, free):
        plant.step(np.zeros(4))
    assert np.array_equal(pushed.get_state(), free.get_state())


@ENGINES_AND_RULES
@pytest.mark.parametrize("force", [1e250, 1e300])
def test_diverging_plant_reports_time_and_coordinate(engine: Any, force: float, rule: Any) -> None:
    endless = with_coordinates(planar_2r(), lower=-np.inf, upper=np.inf)
    plant = Plant(endless, integrator=rule, engine=engine)
    with pytest.raises(SimulationError, match=r"diverged at t = .* s: joint_\d is .*velocity"):
        steps(plant, 100, [force, 0.0, 0.0, 0.0])
    plant.reset()
    plant.step(np.zeros(4))
    assert np.isfinite(plant.q).all()


@ENGINES_AND_RULES
@pytest.mark.parametrize("push", ["loads", "wrenches"])
def test_force_that_is_not_finite_raises(engine: Any, push: str, rule: Any) -> None:
    """DART ignores accelerations that are not numbers."""
    plant = Plant(planar_2r(), integrator=rule, engine=engine, wrenched=["link_2"])
    size = 3 if push == "loads" else 6
    with pytest.raises(SimulationError, match=r"diverged at t = 0.001 s: .*joint_1"):
        plant.step(np.zeros(4), **{push: np.full(size, 1.5e308)})  # type: ignore[arg-type]


@pytest.mark.parametrize("value", ["a", None, [1, 2], 1j, 10**400, np.nan, np.inf, 0.0, -1.0])
def test_invalid_steps_and_substeps_are_rejected(value: Any) -> None:
    with pytest.raises(InputError, match="step of the plant must be a positive time in s, not"):
        Plant(planar_2r(), value)
    for substeps in (value, 1.5, 2**32):
        with pytest.raises(InputError, match="substeps must be a whole number from 1"):
            Plant(planar_2r(), substeps=substeps)


def test_auto_uses_the_core_if_possible() -> None:
    robot = planar_2r()
    assert Plant(robot).engine == "core"
    assert Plant(robot, scene=Scene()).engine == "dart"
    assert Plant(with_coordinates(robot, friction=0.1)).engine == "core"
    with pytest.raises(
        InputError, match=r'"core" does not support worlds with contacts.*engine = "dart"'
    ):
        Plant(robot, engine="core", scene=Scene())
    with pytest.raises(UnknownNameError, match="did you mean 'core'"):
        Plant(robot, engine="corre")  # type: ignore[arg-type]
    with pytest.raises(UnknownNameError, match="link"):
        Plant(robot, engine="core", wrenched=("nothing",))
