"""Time of a controller tick (kinematics, dynamics and QP), relative to its limit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import qpsolvers
from support.interleaved import interleaved, record
from support.robots.robots import EXAMPLES, planar_2r

from addin_sdfusion.robot import Robot, read_robot
from controllers import ControlLoop, JointSpaceController, OperationalSpaceController, Posture
from controllers.qp.solver import DUAL_NEWTON
from sim_dart import DartDynamics

RIVALS = [name for name in ("daqp", "quadprog", "proxqp") if name in qpsolvers.available_solvers]
OPERATIONAL_LIMIT, JOINT_LIMIT = 150e-6, 100e-6
POSE = np.array([1.45, 0.0, 0.0, -1.3])


def operational(solver: str) -> Callable[[], object]:
    """Return ticks of the arm near a pose, with all features of the loop."""
    dynamics = DartDynamics(read_robot(EXAMPLES / "roboy_left_arm/robot"))
    law = OperationalSpaceController(
        dynamics, 400.0, 40.0, posture=Posture(10.0, 25.0, POSE), solver=solver
    )
    loop = ControlLoop(law, dynamics.task_names, 0.005)
    return ticking(loop, POSE, dynamics.task_position(POSE))


def joint(solver: str, robot: Robot) -> Callable[[], object]:
    """Return ticks in joint space near a pose of the robot."""
    dynamics = DartDynamics(robot)
    loop = ControlLoop(
        JointSpaceController(dynamics, 400.0, 40.0, solver=solver),
        dynamics.coordinate_names,
        0.005,
    )
    pose = POSE if len(robot.coordinates) == 4 else np.zeros(len(robot.coordinates))
    return ticking(loop, pose, pose)


def ticking(loop: ControlLoop, pose: Any, goal: Any) -> Callable[[], object]:
    rng = np.random.default_rng(0)
    states = iter(1e-4 * rng.standard_normal((1_000_000, 2, len(pose))))
    reference = np.zeros((3, len(goal)))
    reference[0] = goal

    def tick() -> object:
        dq, qd = next(states)
        return loop.tick(pose + dq, qd, reference)

    return tick


def measure(name: str, make: Callable[[str], Callable[[], object]], benchmark: Any) -> float:
    solvers = [DUAL_NEWTON, *RIVALS]
    ticks = {solver: make(solver) for solver in solvers}
    benchmark(ticks[DUAL_NEWTON])
    times = interleaved(ticks, calls=100)
    ratios = {f"{solver}_ratio": times[solver] / times[DUAL_NEWTON] for solver in RIVALS}
    record(f"tick, {name}", us=times[DUAL_NEWTON] * 1e6, **ratios)
    return times[DUAL_NEWTON]


def test_operational_space(benchmark: Any) -> None:
    """Measure eq. (4) for 11 muscles, 4 joints and 3 tasks of the arm."""
    assert measure("operational space, arm", operational, benchmark) <= OPERATIONAL_LIMIT


@pytest.mark.parametrize("name", ["two-link arm", "arm"])
def test_joint_space(name: str, benchmark: Any) -> None:
    """Measure eq. (3) for the two-link arm, and for 11 muscles and 4 joints of the left arm."""
    robot = read_robot(EXAMPLES / "roboy_left_arm/robot") if name == "arm" else planar_2r()
    assert measure(f"joint space, {name}", lambda s: joint(s, robot), benchmark) <= JOINT_LIMIT
