"""Evaluation of muscles while they are edited: paths, moment arms, torque ranges, findings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from addin_sdfusion.robot import Finding, Robot, check
from cardsflow_fmu.results.analysis.drive_check import drive_findings
from cardsflow_fmu.results.viewer.scene.link_poses import link_poses
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import MusclePaths

_SAMPLES = 25  # positions of a joint on a curve of moment arms
_MIN_ARM = 1e-9  # in [m], or without unit
_HALF_TURN = np.pi  # range to each side of a coordinate without limits, in [rad] or [m]
_LOOPS = "note: poses here do not close the loops; moment arms are about each coordinate alone"


def evaluate_muscles(robot: Robot, pose: FloatArray) -> dict[str, Any]:
    """Return lengths, paths, moment arms, torque ranges and findings as plain data.

    Args:
        robot: A robot whose muscles and wrap surfaces may have errors; these are omitted.
        pose: Joint positions, shape (n,), in [rad] or [m].

    Returns:
        `poses`: 12 numbers of T_world_link by link, rows of the rotation and then the position;
        `muscles`: name, length in [m] and points of the path in the world frame;
        `moment_arms`: by muscle and coordinate, `values` [positions, moment arms] and
        `sign_change`;
        `torque_ranges`: by coordinate, minimum and maximum at the pose, in [N·m] or [N];
        `findings`: lines of `cardsflow check` about the robot.
    """
    findings = check(robot)
    poses = link_poses(replace(robot, cable_sets=(), cable_set=""), pose[np.newaxis])
    valid = _without_errors(robot, findings)
    result: dict[str, Any] = {
        "poses": {name: [*T[0, :3, :3].flat, *T[0, :3, 3]] for name, T in poses.items()},
        "muscles": [],
        "moment_arms": {},
        "torque_ranges": {},
    }
    if valid is not None:
        result |= _evaluate_valid(valid, pose)
        findings += drive_findings(valid)
    lines = [str(replace(finding, file=None, line=None)) for finding in findings]
    return result | {"findings": [_LOOPS, *lines] if robot.loops else lines}


def _without_errors(robot: Robot, findings: Sequence[Finding]) -> Robot | None:
    """Return the robot without muscles that have errors; None if other errors remain."""
    wrong = {f.subject for f in findings if f.is_error}
    if not wrong:
        return robot
    muscles = {subject.name for subject in wrong if subject.kind == "muscle"}
    surfaces = {subject.name for subject in wrong if subject.kind == "wrap_surface"}
    valid = replace(
        robot.with_muscles(
            muscle
            for muscle in robot.muscles
            if muscle.name not in muscles
            and not any(wrap.surface in surfaces for wrap in muscle.wraps)
        ),
        wrap_surfaces=tuple(s for s in robot.wrap_surfaces if s.name not in surfaces),
    )
    return None if any(finding.is_error for finding in check(valid)) else valid


def _evaluate_valid(robot: Robot, pose: FloatArray) -> dict[str, Any]:
    core = MusclePaths(robot)
    paths = [path.tolist() for path in core.path_points(pose)]
    lengths, L = (values.copy() for values in core.evaluate(pose))
    rows = zip(robot.muscles, lengths.tolist(), paths, strict=True)
    return {
        "muscles": [{"name": m.name, "length": length, "path": path} for m, length, path in rows],
        "moment_arms": _curves(robot, core, pose),
        "torque_ranges": dict(_torque_ranges(robot, -L)),
    }


def _curves(robot: Robot, core: MusclePaths, pose: FloatArray) -> dict[str, dict[str, Any]]:
    """Return moment arms over the range of each joint that it crosses, by muscle and joint."""
    curves: dict[str, dict[str, Any]] = {muscle.name: {} for muscle in robot.muscles}
    for k, c in enumerate(robot.coordinates):
        low = c.lower if np.isfinite(c.lower) else pose[k] - _HALF_TURN
        high = c.upper if np.isfinite(c.upper) else pose[k] + _HALF_TURN
        positions, moved = np.linspace(low, high, _SAMPLES), pose.copy()
        arms = np.empty((_SAMPLES, len(robot.muscles)))
        for i, moved[k] in enumerate(positions):
            arms[i] = -core.evaluate(moved).jacobian[:, k]
        for muscle, values in zip(robot.muscles, arms.T, strict=True):
            if np.abs(values).max() > _MIN_ARM:
                changes = bool(values.min() < -_MIN_ARM and values.max() > _MIN_ARM)
                curve = [positions.tolist(), values.tolist()]
                curves[muscle.name][c.name] = {"values": curve, "sign_change": changes}
    return curves


def _torque_ranges(robot: Robot, arms: FloatArray) -> Iterator[tuple[str, list[float]]]:
    """Yield the torques that the force limits of all muscles allow at a pose, by coordinate."""
    low = np.array([muscle.f_min for muscle in robot.muscles])
    high = np.array([muscle.f_max for muscle in robot.muscles])
    for k, c in enumerate(robot.coordinates):
        acting = np.abs(arms[:, k]) > _MIN_ARM
        ends = arms[acting, k] * np.array([low, high])[:, acting]
        yield c.name, [float(ends.min(axis=0).sum()), float(ends.max(axis=0).sum())]
