"""Directional derivatives of native plants, compared with closed forms and finite differences."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
from support.cases import LONG
from support.fmu.fmu_host import opened, pack, require_error
from support.fmu.native_slopes import (
    PLAIN,
    STEP,
    Options,
    Slave,
    gamma_of,
    plant_file,
    slave_at,
    started,
    stretched,
)
from support.robots.driven import leg
from support.robots.every_joint import every_joint
from support.robots.loops import four_bar
from support.robots.random_robots import random_robot, random_tree
from support.robots.robots import EXAMPLES, stopped, with_coordinates
from support.robots.wrapped import over_ellipsoids

from addin_sdfusion.robot import CableModel, Robot
from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.signals.groups import all_ports
from cardsflow_fmu.cosim.signals.ports import Port, plant_groups
from cardsflow_fmu.models.native.fields import encode
from cardsflow_fmu.models.plant import PlantModel, plant_fields
from cardsflow_fmu.runtime.model_file import NativeModel
from cardsflow_fmu.simulation.build import build
from sim_dart import CoreDynamics, close_loops, compile_blob
from sim_dart.core.arrays import FloatArray


def check(
    robot: Robot, folder: Path, seed: int, options: Options = PLAIN, size: float = 2e-3
) -> None:
    """Compare all knowns at once, along random directions, to 1e-9 of the maximum."""
    rng = np.random.default_rng(seed)
    n, m = len(robot.coordinates), len(robot.muscles)
    q, qd = rng.uniform(-1, 1, n), rng.uniform(-2, 2, n)
    with started(robot, folder, q, qd, options) as slave:
        inputs = slave.of["input"]
        knowns = [*inputs, *slave.references("q"), *slave.references("qd")]
        forces = np.concatenate([rng.uniform(5, 50, m), rng.uniform(-9, 9, len(inputs) - m)])
        at = np.concatenate([forces, q, qd])
        gamma = gamma_of(slave, knowns)
        for _ in range(4):
            direction = rng.uniform(-1, 1, at.size)
            expected = stretched(gamma, at, direction, size)
            found = slave_at(slave, inputs, at).derivative(knowns, direction)
            scale = np.abs(expected).max()
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * scale)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_random_robots(seed: int, tmp_path: Path) -> None:
    """Branches, rotated frames, prismatic and fixed joints, muscles across all of them, tasks."""
    check(random_robot(seed), tmp_path, seed)


def test_motors(tmp_path: Path) -> None:
    """Also by torques: the largest entries are those of M^-1 h."""
    check(with_coordinates(random_robot(6), actuated=True), tmp_path, 6)


@pytest.mark.native
def test_every_joint(tmp_path: Path) -> None:
    check(every_joint(), tmp_path, 4)


@pytest.mark.slow
@pytest.mark.native
def test_wraps_over_ellipsoids(tmp_path: Path) -> None:
    check(over_ellipsoids(), tmp_path, 3)


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
def test_joints_driven_by_functions(integrator: str, tmp_path: Path) -> None:
    """With couplings, springs and damping of dependent joints, limit force, energies, wrench."""
    free = with_coordinates(leg(), lower=-math.inf, upper=math.inf)
    check(free, tmp_path, 1, Options(1, integrator, energy=True, wrenches=("kneecap", "foot")))


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
def test_closed_loops(integrator: str, tmp_path: Path) -> None:
    """Along directions in which the loop stays closed: an open loop is closed at the start."""
    robot, rng = four_bar(), np.random.default_rng(0)
    dynamics, q = CoreDynamics(robot), close_loops(robot, [-1.3, 0.5, -2.0])
    J = dynamics.loop_jacobian(q)
    (*_, tangent), back = np.linalg.svd(J)[2], np.linalg.pinv(J, rcond=1e-9)
    qd = 1.5 * tangent
    with started(robot, tmp_path, q, qd, Options(2, integrator, energy=True)) as slave:
        inputs = slave.of["input"]
        knowns = [*inputs, *slave.references("q"), *slave.references("qd")]
        at = np.concatenate([rng.uniform(5, 50, len(inputs)), q, qd])
        gamma = gamma_of(slave, knowns)
        for _ in range(4):
            dq, more = tangent * rng.normal(), tangent * rng.normal()
            bends = [dynamics.loop_bias(q, qd + side * dq) for side in (1, -1)]
            dqd = more - back @ (bends[0] - bends[1]) / 4.0  # d(J qd) = 0
            direction = np.concatenate([rng.uniform(-1, 1, len(inputs)), dq, dqd])
            expected = stretched(gamma, at, direction, 2e-3)
            found = slave_at(slave, inputs, at).derivative(knowns, direction)
            scale = np.abs(expected).max()
            np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8 * scale)


def test_substeps(tmp_path: Path) -> None:
    check(random_robot(5), tmp_path, 5, Options(substeps=3))


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
@pytest.mark.native
def test_integrators_wrenches_and_energies(integrator: str, tmp_path: Path) -> None:
    """Energies, work and momenta by forces, wrenches and the start state of a step."""
    robot = random_robot(5)
    pushed = robot.links[-1].name, robot.links[1].name
    check(robot, tmp_path, 5, Options(2, integrator, energy=True, wrenches=pushed))


def test_friction(tmp_path: Path) -> None:
    """Joints that slide, and one that friction holds."""
    robot = random_robot(5)
    grips = [1e6, *[0.5] * len(robot.coordinates)]
    joints = tuple(
        replace(
            joint, coordinates=tuple(replace(c, friction=grips.pop(0)) for c in joint.coordinates)
        )
        for joint in robot.joints
    )
    check(replace(robot, joints=joints), tmp_path, 5, size=2e-4)


@pytest.mark.parametrize("seed", [4, 5])
def test_friction_of_cables(seed: int, tmp_path: Path) -> None:
    """Iterated within the step, with the tension at the far end."""
    robot = random_robot(seed)
    rough = [replace(muscle, friction=0.2, presliding=0.01) for muscle in robot.muscles]
    check(robot.with_muscles(rough), tmp_path, seed, Options(2, energy=True), size=5e-4)


def test_friction_of_cables_that_stretch(tmp_path: Path) -> None:
    """By commands, from a fixed start whose stretch does not depend on them."""
    robot, rng = random_robot(4), np.random.default_rng(4)
    values = (("stiffness", 2e3), ("damping", 0.0), ("longest_rest_length", 5.0))
    rough = [
        replace(muscle, friction=0.2, presliding=0.01, model=CableModel("elastic_cable", values))
        for muscle in robot.muscles
    ]
    n, m = len(robot.coordinates), len(robot.muscles)
    q, qd = rng.uniform(-1, 1, n), rng.uniform(-2, 2, n)
    with started(robot.with_muscles(rough), tmp_path, q, qd, Options(2, energy=True)) as slave:
        inputs = slave.of["input"]
        start = np.concatenate([rng.uniform(0.1, 0.2, m), np.zeros(len(inputs) - m)])

        def gamma(values: FloatArray) -> FloatArray:
            slave.restart(inputs, start)
            slave.slave.setReal(inputs, list(values))
            return slave.step()

        for _ in range(4):
            at = start + rng.uniform(-0.02, 0.02, start.size)
            direction = rng.uniform(-1, 1, at.size)
            expected = stretched(gamma, at, direction, 1e-5)
            slave.restart(inputs, start)
            slave.slave.setReal(inputs, list(at))
            found, scale = slave.derivative(inputs, direction), np.abs(expected).max()
            np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-7 * scale)


def test_springs_and_damping(tmp_path: Path) -> None:
    robot = with_coordinates(random_robot(6), damping=0.3, stiffness=5.0, rest=0.1)
    check(robot, tmp_path, 6)


def test_joint_at_its_limit(tmp_path: Path) -> None:
    """A joint hits its stop within the step; by each known separately."""
    robot, seed = random_robot(7), 7
    rng = np.random.default_rng(seed)
    n, m = len(robot.coordinates), len(robot.muscles)
    q, qd = rng.uniform(-1, 1, n), rng.uniform(-2, 2, n)
    qd[0] = 3.0
    with started(stopped(robot, float(q[0]) + 1e-3), tmp_path, q, qd) as slave:
        inputs = slave.of["input"]
        knowns = [*inputs, *slave.references("q"), *slave.references("qd")]
        at = np.concatenate([np.linspace(5, 50, m), np.zeros(len(inputs) - m), q, qd])
        gamma = gamma_of(slave, knowns)
        assert gamma(at)[0] == pytest.approx(q[0] + 1e-3, abs=1e-15)
        directions = np.eye(at.size)[[0, 1, m, len(inputs), len(inputs) + 1, len(at) - n + 1]]
        for direction in directions:
            expected = stretched(gamma, at, direction, 1e-4)
            found = slave_at(slave, inputs, at).derivative(knowns, direction)
            scale = np.abs(expected).max()
            np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-9 * max(scale, 1))


@pytest.mark.parametrize("example", ["planar_2r", "roboy_left_arm"])
def test_closed_forms(example: str, tmp_path: Path) -> None:
    """dqd+ = -h (M + h D)^-1 L' df, dq+ = h dqd+, dl+ = L dq+, dy+ = J dq+: to 1e-12."""
    experiment = Experiment.load(EXAMPLES / example)
    slave = Slave(build(experiment, tmp_path, compute="c")["plant"], tmp_path / "unpacked")
    slave.restart()
    forces = slave.references("f")
    slave.slave.setReal(forces, [20.0] * len(forces))
    before = slave.step(5)
    d = CoreDynamics(experiment.robot)
    q, qd = before[: d.n], before[d.n : 2 * d.n]
    matrix = np.array([slave.derivative([f], np.ones(1)) for f in forces]).T
    after = slave.step()[: d.n]
    qd_f = -STEP * np.linalg.solve(
        d.mass_matrix(q) + STEP * np.diag(d.damping), d.muscle_jacobian(q).T
    )
    q_f = STEP * qd_f
    rows = [q_f, qd_f, d.muscle_jacobian(after) @ q_f, d.task_jacobian(after) @ q_f]
    expected = np.vstack(rows)
    np.testing.assert_allclose(matrix, expected, rtol=1e-9, atol=1e-12 * np.abs(expected).max())
    assert qd.any()


@pytest.mark.slow
def test_at_the_start(tmp_path: Path) -> None:
    """dl/dq_start = L, dy/dq_start = J."""
    experiment = Experiment.load(EXAMPLES / "roboy_left_arm")
    slave = Slave(build(experiment, tmp_path, compute="c")["plant"], tmp_path / "unpacked")
    q = np.array(experiment.start.q)
    found = np.array([slave.derivative([k], np.ones(1)) for k in slave.references("q_start")]).T
    d = CoreDynamics(experiment.robot)
    expected = np.vstack(
        [np.eye(d.n), np.zeros((d.n, d.n)), d.muscle_jacobian(q), d.task_jacobian(q)]
    )
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)
    assert not slave.derivative(slave.references("f")[:1], np.ones(1)).any()


@pytest.mark.slow
def test_derivatives_do_not_change_the_instance(tmp_path: Path) -> None:
    """A run with requests in between is bit-identical; other variables are rejected."""
    experiment = Experiment.load(EXAMPLES / "roboy_left_arm")
    file = build(experiment, tmp_path, compute="c")["plant"]
    rows = []
    for has_requests in (False, True):
        slave = Slave(file, tmp_path / str(has_requests))
        slave.restart()
        slave.slave.setReal(slave.references("f"), [30.0] * len(slave.references("f")))
        for _ in range(5):
            slave.step()
            if has_requests:
                slave.derivative(slave.references("q"), np.ones(4))
                for what in ("l", "q_start"):
                    require_error(lambda: slave.derivative(slave.references(what)[:1], np.ones(1)))  # noqa: B023
        rows.append(slave.step())
    assert (rows[0] == rows[1]).all()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_random_trees(seed: int, tmp_path: Path) -> None:
    """Joints with several degrees of freedom, and free bases."""
    check(random_tree(seed, damping=0.1), tmp_path, seed)


@pytest.mark.slow
def test_joint_that_has_left_its_limit(tmp_path: Path) -> None:
    """A step does not depend on earlier stops: it equals a step of a new instance."""
    robot = random_robot(7)
    n, m = len(robot.coordinates), len(robot.muscles)
    q, qd = np.full(n, 0.2), np.zeros(n)
    qd[0] = 3.0
    with started(stopped(robot, 0.201), tmp_path, q, qd) as slave:
        inputs = slave.of["input"]
        assert slave.step()[0] == pytest.approx(0.201, abs=1e-15)
        back = np.zeros(m)
        back[np.argmax(CoreDynamics(robot).muscle_jacobian(q)[:, 0])] = 2000.0
        slave.slave.setReal(inputs[:m], list(back))
        state = slave.step()[: 2 * n]
        assert state[n] < 0.0
        knowns = [*inputs, *slave.references("q"), *slave.references("qd")]
        found = slave.derivative(knowns, np.ones(len(knowns)))
    again = tmp_path / "again"
    again.mkdir()
    with started(robot, again, state[:n], state[n:]) as slave:
        at = np.concatenate([back, np.zeros(len(inputs) - m)])
        expected = slave_at(slave, inputs, at).derivative(knowns, np.ones(len(knowns)))
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())


def test_tension_of_an_ideal_cable(tmp_path: Path) -> None:
    """As an output, the tension equals the force if the force is not negative."""
    robot = random_robot(1)
    n = len(robot.coordinates)
    groups = dict(plant_groups(robot, [0.0] * n, [0.0] * n, STEP))
    groups["tensions"] = [Port("t.cable", "N", "output", "continuous", "Tension")]
    counts, fields = plant_fields(robot, 1)
    contents = encode("plant", compile_blob(robot), groups, counts, fields | {"modelled": [0]})
    native = NativeModel(contents, True)
    file = pack(tmp_path / "plant.fmu", PlantModel, all_ports(groups), native=native)
    slave = Slave(file, tmp_path / "unpacked")
    slave.restart()
    (tension,) = slave.references("t")
    slave.slave.setReal([0, 1], [5.0, -5.0])
    assert slave.slave.getDirectionalDerivative([tension], [0, 1], [3.0, 1.0]) == [3.0]
    slave.slave.setReal([0], [-5.0])
    assert slave.slave.getDirectionalDerivative([tension], [0], [1.0]) == [0.0]
    slave.slave.terminate()
    slave.slave.freeInstance()


@pytest.mark.slow
@pytest.mark.skipif(
    shutil.which("gcc") is None or "CARDSFLOW_LIBRARY_DIR" in os.environ,
    reason="no gcc, or a different library is tested",
)
@LONG
def test_compiler_without_complex_numbers(tmp_path: Path) -> None:
    """As with Microsoft's compiler: derivatives are rejected with a message, the rest works."""
    robot = random_robot(1)
    n, folder = len(robot.coordinates), tmp_path / "unpacked"
    fmpy.extract(str(plant_file(robot, tmp_path, np.zeros(n), np.zeros(n))), str(folder))
    (library,) = folder.glob("binaries/*/*.so")
    files = [str(path) for path in (folder / "sources").rglob("*.c")]
    flags = ["-std=c99", "-DHAS_CORE_TANGENT=0", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared"]
    subprocess.run(["gcc", *flags, *files, "-o", str(library), "-lm"], check=True)
    with opened(folder) as (host,):
        host.start()
        host.slave.doStep(0.0, STEP)
        require_error(
            lambda: host.slave.getDirectionalDerivative(host.of("output")[:1], [0], [1.0])
        )
        assert "no complex numbers" in host.last
        host.slave.terminate()
