from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.oracles.mujoco_model import MujocoRobot
from support.robots.random_robots import random_robot
from support.robots.robots import planar_2r

from addin_sdfusion.robot import IDENTITY, Inertia, InputError, read_robot
from sim_dart import CoreDynamics, DartDynamics, Plant

pytestmark = pytest.mark.native

Engine = type[CoreDynamics] | type[DartDynamics]
every_engine = pytest.mark.parametrize("engine", [CoreDynamics, DartDynamics])
"""Dynamics of DART and the C core: both must compute the same terms."""

CASPR_2R = {
    "Example_2R_planar_XZ__basic": "basic",
    "Example_2R_planar_XZ__basic_multi_segment": "basic_multi_segment",
    "Example_2R_planar_XZ__commit_03330b5f_2018_10_25": "basic_4_cables_2018_10",
    "Example_2R_planar_XZ__commit_b8314f6f_2018_07_03": "basic_2018_07",
}
CASPR_OTHERS = {
    "RoboyLeftArm__DEFAULT": "RoboyLeftArm",
    "RoboyUpperBody__DEFAULT": "RoboyUpperBody",
    "BMArm__WORKING": "BMArm",
    "Example_spherical__basic_4_cables": "Example_spherical",
    "Example_spatial__basic_7_cables": "Example_spatial",
}


@every_engine
@pytest.mark.parametrize("file", [*CASPR_2R, *CASPR_OTHERS])
def test_terms_equal_caspr(engine: Engine, shared: Path, file: str) -> None:
    """M, G, L, l, J, y equal CASPR's values to 1e-10, and C, J' to 1e-8.

    The 2R models are from the example. The other models are read from CASPR files, with ball and
    free joints, branches, and cables over several links.
    """
    if file in CASPR_2R:
        robot = planar_2r(CASPR_2R[file])
    else:
        robot = read_robot(shared / "robots/caspr" / CASPR_OTHERS[file], file.split("__")[1])
    dynamics = engine(robot)
    reference = json.loads((shared / "reference/caspr" / f"{file}.json").read_text())
    names = [muscle.name.replace("_", " ") for muscle in robot.muscles]
    assert names == [name.replace("_", " ") for name in reference["cable_names"]]
    assert reference["poses"]
    for pose in reference["poses"]:
        q, qd = np.array(pose["q"], float), np.array(pose["qd"], float)
        equal = {"rtol": 0, "atol": 1e-10}
        np.testing.assert_allclose(dynamics.mass_matrix(q), pose["M"], **equal)
        np.testing.assert_allclose(dynamics.gravity(q), pose["G"], **equal)
        np.testing.assert_allclose(dynamics.muscle_jacobian(q), pose["L"], **equal)
        np.testing.assert_allclose(dynamics.muscle_lengths(q), pose["l"], **equal)
        np.testing.assert_allclose(dynamics.coriolis(q, qd), pose["C"], rtol=0, atol=1e-8)
        if "y" in pose:
            bias = np.array(pose["Jdot"]) @ qd
            np.testing.assert_allclose(dynamics.task_position(q), pose["y"], **equal)
            np.testing.assert_allclose(dynamics.task_jacobian(q), pose["J"], **equal)
            np.testing.assert_allclose(dynamics.task_bias(q, qd), bias, rtol=0, atol=1e-8)


@every_engine
def test_published_caspr_terms_are_reproduced(engine: Engine) -> None:
    """Compare published values of one pose to the published digits."""
    dynamics = engine(planar_2r("basic_4_cables_2018_10"))
    q, qd = np.array([-0.4448, -0.3029]), np.array([-0.2181, 0.7428])
    L = [[-0.33126, 0], [-0.78211, -0.23618], [0.49093, 0], [1.41739, 0.71539]]
    lengths = [1.102993, 2.882402, 0.726739, 1.561710]
    np.testing.assert_allclose(
        dynamics.mass_matrix(q), [[0.24545, 0.07272], [0.07272, 0.025]], atol=5e-5
    )
    np.testing.assert_allclose(dynamics.coriolis(q, qd), [0.0033967, -0.0007094], atol=1e-6)
    np.testing.assert_allclose(dynamics.gravity(q), [0.966671, 0.333517], atol=5e-5)
    np.testing.assert_allclose(dynamics.muscle_jacobian(q), L, atol=5e-5)
    np.testing.assert_allclose(dynamics.muscle_lengths(q), lengths, atol=5e-5)


@every_engine
def test_terms_equal_the_closed_form_of_a_two_link_arm(engine: Engine) -> None:
    """Links have length 1, their mass in the middle, and no moment of inertia."""
    dynamics, m, g = engine(planar_2r()), 0.1, 9.81
    for q1, q2, u1, u2 in np.random.default_rng(0).uniform(-2, 2, (20, 4)):
        c2, s2 = np.cos(q2), np.sin(q2)
        M = m * np.array([[0.25 + 1.25 + c2, 0.25 + 0.5 * c2], [0.25 + 0.5 * c2, 0.25]])
        C = m * 0.5 * s2 * np.array([-(2 * u1 * u2 + u2**2), u1**2])
        G = -m * g * np.array([1.5 * np.sin(q1) + 0.5 * np.sin(q1 + q2), 0.5 * np.sin(q1 + q2)])
        q, qd = np.array([q1, q2]), np.array([u1, u2])
        np.testing.assert_allclose(dynamics.mass_matrix(q), M, rtol=0, atol=1e-14)
        np.testing.assert_allclose(dynamics.coriolis(q, qd), C, rtol=0, atol=1e-14)
        np.testing.assert_allclose(dynamics.gravity(q), G, rtol=0, atol=1e-14)


@every_engine
@pytest.mark.parametrize("seed", range(10))
def test_terms_equal_mujoco_on_random_trees(engine: Engine, seed: int) -> None:
    robot = random_robot(seed)
    dynamics, mujoco = engine(robot), MujocoRobot(robot)
    rng = np.random.default_rng(seed)
    for _ in range(5):
        q, qd = rng.uniform(-1.5, 1.5, (2, len(robot.coordinates)))
        mujoco.move(q, qd)
        bias = dynamics.coriolis(q, qd) + dynamics.gravity(q)
        np.testing.assert_allclose(
            dynamics.mass_matrix(q), mujoco.mass_matrix, rtol=1e-11, atol=1e-12
        )
        np.testing.assert_allclose(bias, mujoco.bias, rtol=1e-11, atol=1e-11)


@every_engine
@pytest.mark.parametrize("seed", range(5))
def test_task_bias_equals_finite_differences(engine: Engine, seed: int) -> None:
    """J' qd = d(J qd)/dt at constant qd, by central differences."""
    robot = random_robot(seed)
    dynamics, h = engine(robot), 1e-6
    q, qd = np.random.default_rng(seed).uniform(-1, 1, (2, len(robot.coordinates)))
    ahead, behind = (dynamics.task_jacobian(q + s * h * qd) @ qd for s in (1, -1))
    np.testing.assert_allclose(dynamics.task_bias(q, qd), (ahead - behind) / (2 * h), atol=1e-7)


@every_engine
def test_dynamics_do_not_change_the_state_of_a_plant(engine: Engine) -> None:
    robot = planar_2r()
    plant, alone, dynamics = Plant(robot), Plant(robot), engine(robot)
    for _ in range(50):
        dynamics.mass_matrix([1.0, 2.0])
        dynamics.coriolis([1.0, 2.0], [3.0, 4.0])
        plant.step([20.0, 10.0, 30.0, 10.0])
        alone.step([20.0, 10.0, 30.0, 10.0])
    assert np.array_equal(plant.get_state(), alone.get_state())


@every_engine
def test_zero_moment_of_inertia_prints_no_warning(
    engine: Engine, capfd: pytest.CaptureFixture[str]
) -> None:
    """DART accepts such inertias with a warning, which must not be printed."""
    Plant(planar_2r()).step([10.0] * 4)
    engine(planar_2r()).mass_matrix([0.0, 0.0])
    assert capfd.readouterr() == ("", "")


@every_engine
def test_robot_with_massless_motion_is_rejected(engine: Engine) -> None:
    """Only a massless link is between two coincident axes."""
    first, second = planar_2r().joints
    turned = replace(second, T_parent_joint=IDENTITY)
    massless = replace(planar_2r().links[0], inertia=Inertia(0.0))
    robot = replace(planar_2r(), joints=(first, turned), links=(massless, planar_2r().links[1]))
    for make in (Plant, engine):
        with pytest.raises(InputError, match="mass matrix is singular"):
            make(robot)


@pytest.mark.parametrize("seed", range(10))
def test_articulated_bodies_solve_the_equation_of_motion(seed: int) -> None:
    """Check M qdd + C + G = tau with the terms of DART."""
    robot = random_robot(seed, joints=12)
    core, dart = CoreDynamics(robot), DartDynamics(robot)
    rng = np.random.default_rng(seed)
    for _ in range(5):
        q, qd, tau = rng.uniform(-2, 2, (3, core.n))
        qdd = core.acceleration(q, qd, tau)
        M, h = dart.mass_matrix(q), dart.coriolis(q, qd) + dart.gravity(q)
        scale = np.abs(M) @ np.abs(qdd) + np.abs(h) + np.abs(tau)
        assert (np.abs(M @ qdd + h - tau) <= 1e-13 * scale.max()).all()
