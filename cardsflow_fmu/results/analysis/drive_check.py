"""Findings on what cannot run, or muscles cannot drive: of a robot, and of an experiment."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from addin_sdfusion.robot import CardsflowError, Finding, InputError, Robot, Subject
from addin_sdfusion.robot import check as description_check
from addin_sdfusion.robot.finding import errors_first
from addin_sdfusion.robot.finding_builders import error, warning
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.analysis.drivable import drivable
from controllers.analysis.inverse_dynamics import motion_terms
from controllers.force_distribution.poses import INFEASIBLE
from sim_dart import CoreDynamics, control_dynamics
from sim_dart.core.mass_check import massless_coordinates

from .first_motion import closed_or, initial_pose, lacks, pose_terms, very_large
from .sizing import driven_part, reference_motion

_POSES = 5
_NO_ARM = 1e-9  # beside the largest of the robot's
_POINTS = 100


def check(robot: Robot) -> list[Finding]:
    """Everything that `cardsflow check` says of a robot, which may be built in Python.

    That is `addin_sdfusion.robot.check`, which knows no dynamics; and where that finds no errors,
    what cannot be simulated, such as loops that cannot be closed, or driven.

    Returns:
        Errors first, then warnings; empty for a sound robot.
    """
    findings = description_check(robot)
    if any(finding.is_error for finding in findings):
        return findings
    return errors_first([*findings, *drive_findings(robot)])


def drive_findings(robot: Robot) -> list[Finding]:
    """What cannot be simulated, and what muscles cannot do, wherever an experiment puts the robot.

    Args:
        robot: A robot without errors.
    """
    if not robot.coordinates or not (robot.muscles or robot.motors or robot.loops):
        return []
    if (large := very_large(robot)) is not None:
        problem = f"whether it can be simulated and driven is not looked at: {large}"
        return [warning(Subject("robot", robot.name), "not-looked-at", problem)]
    try:
        dynamics = control_dynamics(robot, may_be_singular=True)
        if not (robot.muscles or robot.motors):
            return []
        return [*_massless(robot, dynamics), *_held(robot, dynamics, None)]
    except CardsflowError as refused:
        problem = f"{refused}: it is described, converted and drawn, not run"
        return [warning(Subject("robot", robot.name), "not-simulated", problem)]


def experiment_findings(experiment: Experiment) -> list[Finding]:
    """What goes wrong in a run that can begin, as far as that is known without one."""
    robot = experiment.robot
    dynamics = control_dynamics(robot, may_be_singular=True)
    subject = Subject("experiment", experiment.name)
    found = [warning(subject, "experiment", line) for line in experiment.warnings()]
    passive = experiment.controller.uncontrolled
    found += _held(robot, dynamics, np.array(experiment.start.q), passive)
    return found + list(_motion(experiment, subject))


def _massless(robot: Robot, dynamics: CoreDynamics) -> Iterator[Finding]:
    M = dynamics.mass_matrix([c.initial for c in robot.coordinates])
    if not np.isfinite(M).all():
        return
    for name in massless_coordinates(robot, M):
        problem = (
            "its motion moves no mass, and no engine simulates that; give the links there masses "
            f"and inertias, or lock it: [robot.coordinates.{name}] locked = true"
        )
        yield error(Subject("coordinate", name), "massless-motion", problem)


def _held(
    robot: Robot,
    dynamics: CoreDynamics,
    start: FloatArray | None,
    passive: Sequence[bool] = (),
) -> Iterator[Finding]:
    """Coordinates that no muscle moves, and those that muscles cannot hold at the start."""
    q = closed_or(dynamics, initial_pose(robot) if start is None else start)
    poses = [closed_or(dynamics, pose, q) for pose in _poses(robot)]
    arms = [np.abs(dynamics.actuator_jacobian(pose)).max(axis=0) for pose in poses]
    still = np.max(arms, axis=0) <= _NO_ARM * max(float(np.max(arms)), 1e-300)
    free = []
    for k, c in enumerate(robot.coordinates):
        if not c.lower < c.upper or (passive and passive[k]) or dynamics.dependent[k]:
            continue
        if still[k]:
            problem = (
                "no muscle moves it; lock it, [robot.coordinates."
                f"{c.name}] locked = true, as `cardsflow init` does, give it a motor, or leave it "
                f"to a spring and a damper: controller.passive.{c.name} = true"
            )
            yield warning(Subject("coordinate", c.name), "coordinate-without-muscle", problem)
        else:
            free.append(k)
    terms = pose_terms(robot, dynamics, q, np.zeros(len(q)))
    massless = massless_coordinates(robot, terms.M)
    free = [k for k in free if robot.coordinates[k].name not in massless]
    where = "in its initial pose" if start is None else "where the experiment starts"
    found = drivable(terms, free)
    for k, why in lacks(robot, dynamics, q, found).items():
        subject = Subject("coordinate", robot.coordinates[k].name)
        yield warning(subject, "pose-not-held", f"muscles cannot drive it {where}: {why}")


def _poses(robot: Robot) -> FloatArray:
    """The initial pose, and others within the limits."""
    pose = initial_pose(robot)
    rng = np.random.default_rng(0)
    reach = [min(1.0, 0.5 * (c.upper - c.lower)) for c in robot.coordinates]
    away = rng.uniform(-1.0, 1.0, (_POSES, len(pose))) * reach
    lower = np.array([c.lower for c in robot.coordinates])
    upper = np.array([c.upper for c in robot.coordinates])
    return np.vstack([pose, np.clip(pose + away, lower, upper)])


def _motion(experiment: Experiment, subject: Subject) -> Iterator[Finding]:
    """Points of the reference at which no forces fit."""
    try:
        motion = reference_motion(experiment, _POINTS)
        robot, motion = driven_part(experiment, experiment.robot, motion)
        terms = motion_terms(control_dynamics(robot), motion)
    except InputError as problem:
        yield warning(subject, "motion-not-reached", str(problem))
        return
    status = terms.distribute().distribution.status
    wrong = status == INFEASIBLE
    if wrong.any():
        problem_ = (
            f"no forces within their bounds fit at {int(wrong.sum())} of {len(wrong)} points of "
            f"the reference, from t = {motion.times[int(np.argmax(wrong))]:.3g} s; "
            "`cardsflow size` says what is missing"
        )
        yield warning(subject, "motion-not-held", problem_)
