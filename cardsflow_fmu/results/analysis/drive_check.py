"""Findings on robots that cannot be simulated, and on coordinates that muscles cannot drive."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from addin_sdfusion.robot import CardsflowError, Finding, InputError, Robot, Subject
from addin_sdfusion.robot import check as description_check
from addin_sdfusion.robot.finding import errors_first
from addin_sdfusion.robot.finding_builders import error, warning
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.analysis.drivable import find_drivable
from controllers.analysis.inverse_dynamics import motion_terms
from controllers.force_distribution.poses import INFEASIBLE
from sim_dart import CoreDynamics, control_dynamics
from sim_dart.core.mass_check import massless_coordinates

from .first_motion import initial_pose, missing_drives, pose_terms, size_problem, try_close_loops
from .moment_arms import sign_changes
from .plausibility import reference_findings
from .sizing import lock_passive_coordinates, reference_motion

_CLOSED = 1e-9
"""Gap of a closed loop, in [m] or [rad]."""
_POSES = 5
_MIN_ARM = 1e-9  # moment arm, as fraction of the largest moment arm of the robot
_POINTS = 100


def check(robot: Robot) -> list[Finding]:
    """Return all findings of `cardsflow check` on a robot, for example one built in Python.

    These are the findings of `addin_sdfusion.robot.check`. If there are no errors, findings of the
    simulation follow, such as loops that cannot be closed, or coordinates without drives.
    """
    findings = description_check(robot)
    if any(finding.is_error for finding in findings):
        return findings
    return errors_first([*findings, *drive_findings(robot)])


def drive_findings(robot: Robot) -> list[Finding]:
    """Return findings on simulation and drives that do not depend on an experiment.

    Args:
        robot: A robot without errors.
    """
    if not robot.coordinates or not (robot.muscles or robot.motors or robot.loops):
        return []
    if (large := size_problem(robot)) is not None:
        problem = f"simulation and drives are not checked: {large}"
        return [warning(Subject("robot", robot.name), "not-looked-at", problem)]
    try:
        dynamics = control_dynamics(robot, may_be_singular=True)
        findings = list(_loop_findings(robot, dynamics))
        if robot.muscles or robot.motors:
            findings += _massless_findings(robot, dynamics)
            findings += _drive_warnings(robot, dynamics, None)
            findings += sign_changes(robot, dynamics, initial_pose(robot))
        return findings
    except CardsflowError as failure:
        problem = f"{failure}; the robot can be converted and displayed, but not simulated"
        return [warning(Subject("robot", robot.name), "not-simulated", problem)]


def experiment_findings(experiment: Experiment) -> list[Finding]:
    """Return findings on an experiment that do not require a run."""
    robot = experiment.robot
    dynamics = control_dynamics(robot, may_be_singular=True)
    subject = Subject("experiment", experiment.name)
    findings = list(experiment.world_findings)
    located = {finding.located for finding in findings}
    others = [line for line in experiment.warnings() if line not in located]
    findings += [warning(subject, "experiment", line) for line in others]
    passive = experiment.controller.uncontrolled
    start = np.array(experiment.start.q)
    findings += _drive_warnings(robot, dynamics, start, passive)
    findings += [*sign_changes(robot, dynamics, start), *reference_findings(experiment)]
    return findings + list(_motion_findings(experiment, subject))


def _loop_findings(robot: Robot, dynamics: CoreDynamics) -> Iterator[Finding]:
    """Report loops that close only up to the rounding of the positions in the files."""
    if not robot.loops or not dynamics.dependent.any():
        return
    gap = dynamics.remaining_gap(initial_pose(robot))
    if gap > _CLOSED:
        problem = (
            f"its loops stay open by {gap:.2g} m or rad, since positions in the file contradict "
            "each other; this gap stays constant during a run"
        )
        yield warning(Subject("robot", robot.name), "loops-not-exact", problem)


def _massless_findings(robot: Robot, dynamics: CoreDynamics) -> Iterator[Finding]:
    M = dynamics.mass_matrix([c.initial for c in robot.coordinates])
    if not np.isfinite(M).all():
        return
    for name in massless_coordinates(robot, M):
        problem = (
            "its motion moves no mass, which no engine can simulate; set masses and "
            f"inertias of its links, or lock it: [robot.coordinates.{name}] locked = true"
        )
        yield error(Subject("coordinate", name), "massless-motion", problem)


def _drive_warnings(
    robot: Robot,
    dynamics: CoreDynamics,
    start: FloatArray | None,
    passive: Sequence[bool] = (),
) -> Iterator[Finding]:
    """Report coordinates without muscles, and coordinates that muscles cannot hold at the start."""
    q = try_close_loops(dynamics, initial_pose(robot) if start is None else start)
    poses = [try_close_loops(dynamics, pose, q) for pose in _poses(robot)]
    arms = [np.abs(dynamics.actuator_jacobian(pose)).max(axis=0) for pose in poses]
    still = np.max(arms, axis=0) <= _MIN_ARM * max(float(np.max(arms)), 1e-300)
    free = []
    for k, c in enumerate(robot.coordinates):
        if not c.lower < c.upper or (passive and passive[k]) or dynamics.dependent[k]:
            continue
        if still[k]:
            problem = (
                "no muscle drives it; lock it ([robot.coordinates."
                f"{c.name}] locked = true, as `cardsflow init` does), add a motor, or use a spring "
                f"and a damper with controller.passive.{c.name} = true"
            )
            yield warning(Subject("coordinate", c.name), "coordinate-without-muscle", problem)
        else:
            free.append(k)
    terms = pose_terms(robot, dynamics, q, np.zeros(len(q)))
    massless = massless_coordinates(robot, terms.M)
    free = [k for k in free if robot.coordinates[k].name not in massless]
    where = "in the initial pose" if start is None else "in the start pose"
    drivable = find_drivable(terms, free)
    for k, why in missing_drives(robot, dynamics, q, drivable).items():
        subject = Subject("coordinate", robot.coordinates[k].name)
        yield warning(subject, "pose-not-held", f"muscles cannot drive it {where}: {why}")


def _poses(robot: Robot) -> FloatArray:
    """Return the initial pose and random poses within the joint limits."""
    pose = initial_pose(robot)
    rng = np.random.default_rng(0)
    reach = [min(1.0, 0.5 * (c.upper - c.lower)) for c in robot.coordinates]
    away = rng.uniform(-1.0, 1.0, (_POSES, len(pose))) * reach
    lower = np.array([c.lower for c in robot.coordinates])
    upper = np.array([c.upper for c in robot.coordinates])
    return np.vstack([pose, np.clip(pose + away, lower, upper)])


def _motion_findings(experiment: Experiment, subject: Subject) -> Iterator[Finding]:
    """Report points of the reference that are infeasible within the force limits."""
    try:
        motion = reference_motion(experiment, _POINTS)
        robot, motion = lock_passive_coordinates(experiment, experiment.robot, motion)
        terms = motion_terms(control_dynamics(robot), motion)
    except InputError as error_:
        yield warning(subject, "motion-not-reached", str(error_))
        return
    status = terms.distribute().distribution.status
    infeasible = status == INFEASIBLE
    if infeasible.any():
        message = (
            f"{int(infeasible.sum())} of {len(infeasible)} points of the reference are infeasible "
            f"within the force limits, from t = {motion.times[int(np.argmax(infeasible))]:.3g} s; "
            "`cardsflow size` computes the required forces"
        )
        yield warning(subject, "motion-not-held", message)
