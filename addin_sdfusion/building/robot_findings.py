"""Findings of `check` and the SDF writer, merged with the findings of the design."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from ..robot.checks.check import check
from ..robot.finding import Finding, Subject
from ..robot.formats.sdf.capabilities import sdf_losses
from ..robot.model.robot import Robot
from ..snapshot import bare_name

_CONSEQUENCES = {
    "unknown-link": ("too-few-via-points", "no-moment-arm"),
    "duplicate-wrap": ("duplicate-wrap-surface",),
    "missing-name": ("bad-name",),
    "joint-apart": ("joint-sides-apart",),
    "ball-axes-uncertain": ("ball-joint-turned",),
    "link-without-mass": ("no-mass-along-axis", "no-inertia-about-axis"),
}
"""Findings that are not reported because another finding of the same defect exists."""
_MEASURED = ("zero-inertia-about-axis",)
"""Warnings about masses that are often forgotten in files; those of a design are measured."""
_OF_JOINTS = ("duplicate-joint", "bad-name")
_OF_COORDINATES = ("duplicate-coordinate", "bad-name")
_CANNOT_MOVE = ("no-mass-along-axis", "no-inertia-about-axis")


def check_measured(robot: Robot) -> list[Finding]:
    """Return the findings on a robot whose masses are measured."""
    return [finding for finding in check(robot) if finding.code not in _MEASURED]


def add_robot_findings(
    findings: Sequence[Finding], massless: Iterable[Finding], robot: Robot
) -> list[Finding]:
    """Return all findings on a design and its robot.

    Args:
        massless: Warnings on links without mass. They become errors if the robot cannot move
            because of the missing mass.
        robot: The robot, as far as it could be built.
    """
    if not robot.links:
        return list(findings)
    checked = check_measured(robot)
    stuck = {finding.subject for finding in checked if finding.code in _CANNOT_MOVE}
    reported = list(findings)
    for finding in massless:
        reported.append(replace(finding, severity="error") if finding.subject in stuck else finding)
    if not any(finding.is_error for finding in (*reported, *checked)):
        # The check for file formats requires a robot without errors.
        checked += [finding for finding in sdf_losses(robot) if finding.is_error]
    follows = {
        (code, Subject(f.subject.kind, bare_name(f.subject.name)))
        for f in reported
        for code in _CONSEQUENCES.get(f.code, ())
    }
    reported = [finding for finding in reported if (finding.code, finding.subject) not in follows]
    covered = {(finding.code, finding.subject) for finding in reported} | follows
    misnamed = [
        f.subject.name for f in checked if f.code in _OF_JOINTS and f.subject.kind == "joint"
    ]
    return reported + [
        finding
        for finding in checked
        if (finding.code, finding.subject) not in covered
        and not _is_caused_by_joint(finding, misnamed)
    ]


def _is_caused_by_joint(finding: Finding, misnamed: Sequence[str]) -> bool:
    """Return whether a coordinate has an invalid name because its joint has one."""
    kind, name = finding.subject
    if kind != "coordinate" or finding.code not in _OF_COORDINATES:
        return False
    return any(name == joint or name.startswith(f"{joint}_") for joint in misnamed)
