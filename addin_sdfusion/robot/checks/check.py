"""Check of a complete robot: all errors and warnings."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ..errors import RobotError
from ..finding import Finding, errors_first
from ..model.robot import Robot, cached_on_robot
from . import (
    driven,
    loops,
    masses,
    muscle_laws,
    muscle_paths,
    muscles,
    names,
    numbers,
    plausible,
    pulleys,
    tasks,
    tree,
    wraps,
)

Check = Callable[[Robot], Iterable[Finding]]

CHECKS: tuple[Check, ...] = (
    names.names,
    names.world_is_reserved,
    names.active_sets,
    numbers.numbers,
    tree.joint_ends,
    tree.one_parent_each,
    tree.parents_first,
    tree.no_loops,
    tree.axes,
    loops.loop_ends,
    loops.loop_axes,
    tree.coordinates,
    driven.functions,
    driven.couplings,
    driven.resisting,
    tree.limits,
    tree.motors,
    masses.inertias,
    masses.moving_bodies,
    masses.inertia_about_axis,
    muscles.has_muscles,
    muscles.via_points,
    muscle_paths.conditions,
    muscle_paths.moving_points,
    muscle_paths.branches,
    muscle_paths.terms,
    muscles.moment_arms,
    muscles.force_limits,
    muscles.cable_models,
    pulleys.pulleys,
    muscle_laws.muscle_laws,
    wraps.wrap_surfaces,
    wraps.wraps,
    muscle_paths.wrap_rules,
    tasks.task_frames,
)


def check(robot: Robot) -> list[Finding]:
    """Return all errors and warnings of a robot.

    Returns:
        Errors first, then warnings; empty for a valid robot without warnings.
    """
    return list(_cached_findings(robot))


@cached_on_robot
def _cached_findings(robot: Robot) -> tuple[Finding, ...]:
    findings = [finding for run_check in CHECKS for finding in run_check(robot)]
    if not any(finding.is_error for finding in findings):
        findings += [*pulleys.reached_points(robot), *plausible.plausible(robot)]
    return tuple(errors_first(findings))


def require_valid(robot: Robot) -> Robot:
    """Return the robot if it has no errors.

    Raises:
        RobotError: The robot has errors. The exception contains all findings.
    """
    findings = check(robot)
    if any(finding.is_error for finding in findings):
        raise RobotError(findings)
    return robot
