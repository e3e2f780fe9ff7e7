"""Writer for test vectors: robots, states, QPs and closed loops, with results of DART and others.

A record is a name of 48 bytes, an allowed deviation (relative to the largest number), the number of
doubles, and the doubles, all little-endian. A file of single precision contains floats instead,
and each record is padded to 8 bytes:

    robot               a blob
    state               q, qd, f
    program             variables, rows
    solve               nothing
    loop                rows of the tracked task coordinates; empty in joint space
    run                 period, step of the plant, steps per period, q, qd, reference of each tick
    set <array>         numbers for an array of `program`, `loop` or `law`
    expect <array>      expected values of an array of `core`, `program` or `run`
"""

from __future__ import annotations

import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import qpsolvers
from numpy.typing import ArrayLike
from support.oracles.dart_tasks import task_bias
from support.oracles.mujoco_model import MujocoRobot
from support.robots.random_robots import random_robot
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import Robot, TaskFrame, TaskSet
from cardsflow_fmu import Experiment
from cardsflow_fmu.models.python_law import control_law
from cardsflow_fmu.models.reference import make_reference
from controllers import ControlLoop
from sim_dart import DartDynamics, Plant, compile_blob
from sim_dart.core.tasks import task_rows
from sim_dart.dart.skeleton import build_skeleton

REPLAY = ("replay_hosted.c", "replay_vectors.c")
"""Program that replays a file; it fails if a value deviates by more than allowed."""
TICKS = 50
AROUND = {"controller.ki": 500.0, "controller.observer": 20.0, "controller.delay": 1}
HEAD = struct.Struct("<48sdQ")
SINGLE_HEAD = struct.Struct("<48sfI")
SINGLE_TOLERANCES = {
    "core.lengths": 1e-6,
    "core.jacobian": 5e-6,
    "core.mass_matrix": 5e-6,
    "core.gravity": 5e-6,
    "core.coriolis": 5e-6,
    "core.torques": 1e-5,
    "core.task_bias": 1e-4,
    "core.qdd": 1e-4,
    "program.x": 1e-4,
    "run.q": 1e-4,
    "run.forces": 1e-2,
}
"""Tolerances relative to the largest number; angles near a singularity are the least exact."""


class VectorFile:
    """Sequence of records."""

    def __init__(self, *, single: bool = False) -> None:
        self.contents = b""
        self.single = single

    def add(self, name: str, values: ArrayLike | bytes = (), tolerance: float = 0.0) -> None:
        """Add a record; numbers may have any shape."""
        head, size = (SINGLE_HEAD, 4) if self.single else (HEAD, 8)
        if not isinstance(values, bytes):
            values = np.asarray(values, dtype=f"<f{size}").tobytes()
        if self.single and tolerance:
            tolerance = SINGLE_TOLERANCES[name.removeprefix("expect ")]
        self.contents += head.pack(name.encode(), tolerance, len(values) // size)
        self.contents += values + bytes(-len(values) % 8)


def write_vectors(path: Path, *, single: bool = False) -> Path:
    """Write the file in double or single precision; return its path."""
    file = VectorFile(single=single)
    for seed in range(3):
        _add_robot(file, random_robot(seed), np.random.default_rng(seed))
    for seed in range(10):
        _add_program(file, np.random.default_rng(seed))
    for example in ("planar_2r", "roboy_left_arm"):
        for settings in ({}, AROUND):
            _add_loop(file, Experiment.load(EXAMPLES / example, settings))
    path.write_bytes(file.contents)
    return path


def _add_robot(file: VectorFile, robot: Robot, rng: np.random.Generator) -> None:
    """Add a robot and its terms at some states: dynamics by DART, muscle paths by MuJoCo."""
    points = TaskFrame("hand", robot.links[5].name, (0.1, -0.2, 0.3))
    turned = TaskFrame("palm", robot.links[4].name, axes=("alpha", "beta", "gamma"))
    robot = replace(robot, task_sets=(TaskSet("whole", (points, turned)),), task_set="whole")
    file.add("robot", compile_blob(robot, single=file.single))
    dart, skeleton, mujoco = DartDynamics(robot), build_skeleton(robot), MujocoRobot(robot)
    for _ in range(5):
        q, qd = rng.uniform(-1.5, 1.5, (2, dart.n))
        f = rng.uniform(0.0, 100.0, dart.m)
        mujoco.move(q)
        L = mujoco.jacobian
        skeleton.set_positions(q)
        skeleton.set_velocities(qd)
        skeleton.set_forces(-L.T @ f)
        skeleton.dart.computeForwardDynamics()
        file.add("state", [*q, *qd, *f])
        file.add("expect core.lengths", mujoco.lengths, 1e-14)
        file.add("expect core.jacobian", L, 1e-14)
        file.add("expect core.mass_matrix", dart.mass_matrix(q), 1e-12)
        file.add("expect core.gravity", dart.gravity(q), 1e-12)
        file.add("expect core.coriolis", dart.coriolis(q, qd) + dart.gravity(q), 1e-12)
        file.add("expect core.torques", -L.T @ f, 1e-13)
        qdd = skeleton.vector(skeleton.dart.getAccelerations())
        file.add("expect core.qdd", qdd, 1e-12)
        file.add("expect core.task_bias", task_bias(robot, skeleton, q, qd), 1e-12)


def _add_program(file: VectorFile, rng: np.random.Generator) -> None:
    """Add a QP of a controller with some forces at their bounds, and the solution of quadprog."""
    n, rows = int(rng.integers(6, 20)), int(rng.integers(2, 5))
    H, g, A = rng.uniform(0.5, 2.0, n), rng.normal(size=n), rng.normal(size=(rows, n))
    lb = rng.uniform(-1.0, 0.0, n)
    ub = lb + rng.uniform(0.5, 2.0, n)
    b = A @ rng.uniform(lb, ub)
    x = qpsolvers.solve_qp(np.diag(H), g, A=A, b=b, lb=lb, ub=ub, solver="quadprog")
    file.add("program", [n, rows])
    problem = {"H_diagonal": H, "g": g, "lb": lb, "ub": ub, "A": A.T, "b": b}
    for name, values in problem.items():
        file.add(f"set program.{name}", values)
    file.add("solve")
    file.add("expect program.x", x, 1e-9)


def law_arrays(experiment: Experiment) -> dict[str, ArrayLike]:
    """Return the arrays of the control law and the loop in C, by name."""
    robot, settings = experiment.robot, experiment.controller
    return settings.law_arrays() | {
        "f_min": [muscle.f_min for muscle in robot.muscles],
        "f_max": [muscle.f_max for muscle in robot.muscles],
        "q_min": [c.lower for c in robot.coordinates],
        "q_max": [c.upper for c in robot.coordinates],
        "gain": 1.0 - np.exp(-settings.observer * settings.period),
    }


def _add_loop(file: VectorFile, experiment: Experiment) -> None:
    """Add a closed loop over some ticks, with results of the Python law and the DART plant."""
    robot, settings = experiment.robot, experiment.controller
    dynamics, reference = DartDynamics(robot), make_reference(experiment)
    names = dynamics.coordinate_names if settings.space == "joint" else dynamics.task_names
    loop = ControlLoop(
        control_law(experiment, dynamics),
        names,
        settings.period,
        ki=settings.ki,
        observer=settings.observer,
        delay=settings.delay,
        predict=settings.predict,
    )
    plant = Plant(robot, experiment.plant.step, engine="dart")  # differs from the replaying program
    plant.reset(experiment.start.q, experiment.start.qd)
    steps = round(settings.period / experiment.plant.step)
    rows = [np.array(reference.evaluate(0.5 + settings.period * t)[:3]) for t in range(TICKS)]
    start = [*plant.q, *plant.qd]
    positions, forces = [], []
    for row in rows:
        loop.tick(plant.q, plant.qd, row)
        for _ in range(steps):
            plant.step(loop.acting)
        positions.append(plant.q)
        forces.append(loop.acting)
    file.add("robot", compile_blob(robot, single=file.single))
    file.add("loop", [] if settings.space == "joint" else task_rows(robot))
    for name, values in law_arrays(experiment).items():
        file.add(f"set loop.{name}", values)
    file.add("run", [settings.period, experiment.plant.step, steps, *start, *np.ravel(rows)])
    file.add("expect run.q", positions, 1e-11)
    file.add("expect run.forces", forces, 1e-8)
