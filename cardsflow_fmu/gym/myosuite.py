"""Environments with the tasks of MyoSuite, for the user's own copy of its models."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError, Robot, read_robot
from addin_sdfusion.robot.model.joint import Coordinate, LimitForce
from sim_dart import Batch

from .episodes import Setup
from .tasks.pose import PoseTask
from .tasks.reach import ReachTask
from .tasks.task import Task

STEP, SUBSTEPS = 0.02, 10
"""Length of an action, and steps of 2 ms in it."""

EPISODE = 100
"""Actions of an episode."""

_TIME_CONSTANT, _IMPEDANCE = 0.02, 0.95
"""Softness of the joint limits, MuJoCo's defaults, which MyoSuite's models keep."""

_BEYOND = 1.0
"""Distance of the hard stops from the limits, in [rad] or [m]."""

_FINGER = {"IFadb": (-0.2, 0.2), "IFmcp": (-0.4, 1.0), "IFpip": (0.1, 1.0), "IFdip": (0.1, 1.0)}
_BENT_FINGER = {"IFadb": (0, 0), "IFmcp": (0, 0), "IFpip": (0.75, 0.75), "IFdip": (0.75, 0.75)}
_BOX = {"IFtip": ((0.1, -0.1, 0.1), (0.27, 0.1, 0.3))}
_TIPS = {
    "THtip": (-0.165, -0.537, 1.495),
    "IFtip": (-0.151, -0.547, 1.455),
    "MFtip": (-0.146, -0.547, 1.447),
    "RFtip": (-0.148, -0.543, 1.445),
    "LFtip": (-0.148, -0.528, 1.434),
}


def _pose(**options: Any) -> Callable[[Robot], Task]:
    return lambda robot: PoseTask(robot, **options)


def _reach(targets: Mapping[str, Any], **options: Any) -> Callable[[Robot], Task]:
    return lambda robot: ReachTask(robot, _own_names(robot, targets), **options)


def _own_names(robot: Robot, targets: Mapping[str, Any]) -> dict[str, Any]:
    """Return targets with the names of the model, which can end with `_r`."""
    frames = {frame.name for frame in robot.task_frames}
    return {f"{k}_r" if f"{k}_r" in frames else k: box for k, box in targets.items()}


TASKS: dict[str, Callable[[Robot], Task]] = {
    "myoElbowPose1D6MFixed-v0": _pose(
        targets={"r_elbow_flex": (2.0, 2.0)}, threshold=0.175, start="random"
    ),
    "myoElbowPose1D6MRandom-v0": _pose(
        targets={"r_elbow_flex": (0.0, 2.27)}, threshold=0.175, start="random"
    ),
    "myoFingerPoseFixed-v0": _pose(targets=_BENT_FINGER),
    "myoFingerPoseRandom-v0": _pose(targets=_FINGER),
    "myoFingerReachFixed-v0": _reach({"IFtip": ((0.2, 0.05, 0.2), (0.2, 0.05, 0.2))}),
    "myoFingerReachRandom-v0": _reach(_BOX, sampling="workspace"),
    "myoHandPoseRandom-v0": _pose(threshold=0.7, start="random"),
    "myoHandReachFixed-v0": _reach({k: (at, at) for k, at in _TIPS.items()}, far=0.044),
}
"""Tasks by the ids of MyoSuite. The targets of `myoHandPoseRandom` are poses within the limits."""


def myosuite_setup(name: str, model: str | Path | None) -> Setup:
    """Return the setup of an environment with a task of MyoSuite.

    Args:
        name: Id of MyoSuite, a key of `TASKS`.
        model: The model's MJCF file.

    Raises:
        InputError: The model is missing or lacks a joint or site of the task.
    """
    if not isinstance(model, str | Path):
        needed = 'needs a model of yours: make(id, model="path/to/model.xml")'
        raise InputError(f"cardsflow/{name} {needed}, not {model!r}")
    robot = _robot(Path(model))
    options: dict[str, Any] = {"rest": 0.0, "folder": Path(model).parent}
    return Setup(soft_limits(robot), TASKS[name](robot), STEP, SUBSTEPS, **options)


def soft_limits(robot: Robot) -> Robot:
    """Return the robot with the soft limits of MuJoCo (Computation, Constraint model).

    With the regularisation R = (1 - d) / d w, impedance d, time constant T, and the diagonal w of
    M^-1 in the initial pose, the inertia of a limit is 1 / R, its stiffness 1 / (d T^2 R) and its
    damping 2 / (d T R).
    """
    weights = np.diag(np.linalg.inv(Batch(robot, 1, STEP).mass_matrix()[0]))
    regularisation = (1.0 - _IMPEDANCE) / _IMPEDANCE * weights
    inertias = dict(zip((c.name for c in robot.coordinates), 1.0 / regularisation, strict=True))

    def soften(c: Coordinate) -> Coordinate:
        if not (c.is_free and c.is_limited):
            return c
        inertia = float(inertias[c.name])
        k = inertia / (_IMPEDANCE * _TIME_CONSTANT**2)
        force = LimitForce(c.lower, c.upper, k, k, 2.0 * _TIME_CONSTANT * k, 1e-4, inertia)
        return replace(c, lower=c.lower - _BEYOND, upper=c.upper + _BEYOND, limit_force=force)

    return replace(robot, joints=tuple(joint.map_coordinates(soften) for joint in robot.joints))


@cache
def _robot(path: Path) -> Robot:
    robot = read_robot(path)
    sites = robot.task_sets[0].name if robot.task_sets else robot.task_set
    return replace(robot, task_set=robot.task_set or sites)
