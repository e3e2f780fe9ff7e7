"""Each field of a robot is either written by a format or reported as lost."""

from __future__ import annotations

import tempfile
from collections import Counter
from dataclasses import fields, is_dataclass
from typing import Any, NamedTuple

import numpy as np
import pytest
from support.cases import LONG, sample_cases
from support.robots.every_field import Variant, robot_of_every_field, variants

from addin_sdfusion.robot import CableSet, Finding, Robot, RobotError, TaskSet, check
from addin_sdfusion.robot.formats.convert import FORMATS, convert
from addin_sdfusion.robot.formats.writing import wrap_ends

WITHOUT_MEANING = {"Robot.links order", "Robot.wrap_surfaces order", "Robot.cable_sets order",
                   "Robot.task_sets order", "Coordinate.unit"}  # fmt: skip
"""Orders without effect, and a unit that follows from the motion."""

COVERED = {
    "Link": {"links-left-out", "links-merged"},
    "Joint": {"links-left-out"},
    "Robot.name": {"links-left-out"},
    "Robot.links": {"links-left-out"},
    "Robot.joints": {"links-left-out"},
    "Link.end": {"link-ends-left-out", "caspr-link-ends"},
    "Mesh": {"mesh-left-out", "caspr-meshes", "collisions-left-out"},
    "Link.meshes": {"mesh-left-out", "caspr-meshes", "collisions-left-out"},
    "Shape": {"caspr-meshes", "collisions-left-out"},
    "Link.shapes": {"caspr-meshes", "collisions-left-out"},
    "Mesh.name": {"mesh-names-left-out"},
    "Joint.name": {"names-left-out", "caspr-joint-names"},
    "Coordinate.name": {"caspr-joint-names"},
    "CableSet.name": {"names-left-out"},
    "TaskSet.name": {"names-left-out"},
    "Coordinate.initial": {"initial-left-out"},
    "Coordinate.damping": {"caspr-damping"},
    "Coordinate.stiffness": {"spring-left-out", "caspr-spring"},
    "Coordinate.rest": {"spring-left-out", "caspr-spring"},
    "Coordinate.friction": {"friction-left-out", "caspr-spring"},
    "Coordinate.armature": {"armature-left-out", "caspr-spring", "held-beside-urdf"},
    "Coordinate.limit_force": {"limit-force-left-out", "caspr-spring", "held-beside-urdf"},
    "Coordinate.max_velocity": {"velocity-limit-left-out"},
    "Coordinate.actuated": {"motor-left-out"},
    "Coordinate.tau_min": {"motor-bounds-left-out", "caspr-motor-bounds", "one-sided-effort"},
    "Coordinate.tau_max": {"motor-bounds-left-out", "caspr-motor-bounds", "one-sided-effort"},
    "TaskFrame.axes": {"task-axes-left-out"},
    "TaskFrame": {"task-frames-left-out"},
    "TaskSet": {"task-frames-left-out"},
    "TaskSet.frames": {"task-axes-left-out"},
    "Robot.task_set": {"task-frames-left-out"},
    "Muscle": {"muscles-left-out"},
    "CableSet": {"muscles-left-out"},
    "Muscle.model": {"cable-model-left-out", "caspr-tension-law"},
    "Muscle.f_min": {"force-limits-left-out"},
    "Muscle.f_max": {"force-limits-left-out"},
    "Muscle.pulley": {"pulley-left-out"},
    "Muscle.friction": {"cable-friction-left-out"},
    "Muscle.presliding": {"cable-friction-left-out"},
    "ViaPoint.friction": {"cable-friction-left-out"},
    "Wrap.friction": {"cable-friction-left-out"},
    "CableModel": {"cable-model-left-out", "tension-law-changed", "caspr-tension-law",
                   "cable-parameters-left-out"},
    "BasePulley": {"pulley-left-out"},
    "ViaPoint.moves": {"point-motion-left-out"},
    "PointMotion": {"point-motion-left-out", "point-range-changed"},
    "ViaPoint.when": {"point-condition-left-out"},
    "PointCondition": {"point-condition-left-out", "point-smoothing-left-out"},
    "Branch": {"branches-left-out"},
    "Muscle.branches": {"branches-left-out"},
    "CoordinateTerm": {"terms-left-out"},
    "Muscle.terms": {"terms-left-out"},
    "Wrap": {"wrap-left-out", "caspr-wrap", "wraps-left-out", "turns-left-out",
             "wrap-rule-left-out", "ellipsoid-left-out"},
    "Muscle.wraps": {"wrap-left-out", "caspr-wrap", "wraps-left-out"},
    "WrapSurface": {"wrap-surfaces-left-out", "caspr-wrap", "sphere-turned-back",
                    "ellipsoid-left-out"},
    "Robot.wrap_surfaces": {"wrap-surfaces-left-out", "caspr-wrap"},
    "Robot.loops": {"loop-left-out", "loop-type", "links-left-out"},
    "Robot.gravity": {"gravity-left-out", "links-left-out"},
}  # fmt: skip
"""Findings that report the loss of a field, or of all fields of a type."""


NAMED = {"links-merged", "names-left-out", "cable-sets-left-out", "task-sets-left-out"}
"""Findings about the robot, which must name the affected parts."""


class Written(NamedTuple):
    """Result of writing a robot; without files if the format rejects it."""

    files: dict[str, bytes]
    findings: list[Finding]


def _written(robot: Robot, format_: str) -> Written:
    with tempfile.TemporaryDirectory() as folder:
        try:
            conversion = convert(robot, format_, folder)
        except RobotError as error:
            return Written({}, list(error.findings))
        files = {file.name: file.read_bytes() for file in conversion.files}
        return Written(files, conversion.findings)


def _means_something(variant: Variant) -> bool:
    part = variant.within[-1]
    return variant.field not in WITHOUT_MEANING and not (
        (variant.field == "Coordinate.rest" and part.stiffness == 0.0)
        or (variant.field == "Muscle.presliding" and not part.bend_friction)
        or (variant.field == "TaskFrame.position" and part.is_orientation)
        or (variant.field == "WrapSurface.length" and part.shape != "cylinder")
    )


def _said(variant: Variant, findings: list[Finding]) -> bool:
    """Return whether a finding reports that a changed field is lost."""
    robot, *parts = variant.within
    field = variant.field.split()[0]
    codes: set[str] = set()
    for key in (field, *(type(part).__name__ for part in parts)):
        codes |= COVERED.get(key, set())
    if field == "Robot.cable_sets" or _is_other(parts, CableSet, robot.cable_set):
        codes |= {"cable-sets-left-out", "muscles-left-out"}
    if field == "Robot.task_sets" or _is_other(parts, TaskSet, robot.task_set):
        codes |= {"task-sets-left-out", "task-frames-left-out"}
    names = {getattr(part, "name", "") for part in parts}
    names |= {
        f"{part.name}/{name}" for part in parts[:1] for name in names if hasattr(part, "name")
    }
    return any(
        finding.code in codes
        and (finding.subject.name in names or finding.subject.kind == "robot")
        and (finding.code not in NAMED or any(name in finding.message for name in names))
        for finding in findings
    )


def _is_other(parts: list[Any], kind: type, active: str) -> bool:
    """Return whether the part is in a set that is not active."""
    return any(isinstance(part, kind) and part.name != active for part in parts)


OF_THE_TREE = {"Joint.child", "Robot.joints", "Coordinate.unit"}
"""Fields that cannot be changed separately; link names and parents can."""
OF_EXPERIMENTS = {"CableModel.custom"}
"""Fields that no file contains and no reader returns."""
WITHIN = {"CableModel.kind": "Muscle.model", "BasePulley.kind": "Muscle.pulley",
          "Shape.kind": "Link.shapes"}  # fmt: skip
"""Fields that are changed together with their references."""


@pytest.mark.slow
def test_variants_change_all_fields() -> None:
    """A new field of the robot description must be changed by a variant."""
    robot = robot_of_every_field(1)
    changed: set[str] = set()
    every: set[str] = set()
    for variant in variants(robot):
        field = variant.field.split()[0]
        if field not in changed and not any(f.is_error for f in check(variant.robot)):
            changed.add(field)
        part = variant.within[-1]
        plain = [f.name for f in fields(part) if not is_dataclass(getattr(part, f.name))]
        every |= {f"{type(part).__name__}.{name}" for name in plain}
    assert {WITHIN.get(field, field) for field in every} - changed == OF_THE_TREE | OF_EXPERIMENTS


CASES = [
    *sample_cases(((1, 1, format_) for format_ in FORMATS), 3),
    *(
        pytest.param(
            seed, 1 + 2 * (seed == 5), format_, marks=[pytest.mark.slow, *[LONG] * (seed == 5)]
        )
        for seed in (4, 5)
        for format_ in FORMATS
        if seed % 2 or format_ != "caspr"  # which rejects joints in rotated frames
    ),
]


@pytest.mark.cases(5)
@pytest.mark.slow
@pytest.mark.parametrize(("seed", "each", "format_"), CASES)
def test_no_field_is_lost_without_a_finding(
    seed: int, each: int, format_: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each field is changed several times, at random parts of the robot."""
    monkeypatch.setattr(wrap_ends, "POSES", 2)  # test_wrap_ends tests their content
    robot = robot_of_every_field(seed)
    before, rng = _written(robot, format_), np.random.default_rng(seed)
    assert before.files
    every = [v for v in variants(robot) if _means_something(v)]
    counts: Counter[str] = Counter()
    silent = []
    for k in rng.permutation(len(every)):
        variant = every[k]
        if counts[variant.field] == each or any(f.is_error for f in check(variant.robot)):
            continue
        counts[variant.field] += 1
        after = _written(variant.robot, format_)
        if after == before and not _said(variant, after.findings):
            where = "/".join(getattr(part, "name", "") for part in variant.within[1:])
            silent.append(f"{variant.field} of {where}")
    assert silent == []
    assert len(counts) > 70
