"""Paths with conditions, branches, terms and wraps of other programs: our format, and losses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.robots.one_link import one_link
from support.robots.wrapped import FAR, carriage

from addin_sdfusion.robot import (
    WORLD,
    Branch,
    CoordinateTerm,
    Muscle,
    PointCondition,
    Pose,
    Robot,
    RobotError,
    Vector3,
    ViaPoint,
    Wrap,
    WrapSurface,
    check,
    merge_fixed_joints,
    read_robot,
    write_sdf,
)
from addin_sdfusion.robot.formats.convert import convert

SURFACES = [
    WrapSurface("barrel", "link_0", "cylinder", 0.1, Pose((0.1, 0.0, 0.0), (0.1, 0.2, 0.3)), 0.5),
    WrapSurface("egg", "link_1", "ellipsoid", 0.1, Pose((0.0, 0.3, 0.0)), half_axes=(0.2, 0.3)),
]
POINTS = (
    ViaPoint(WORLD, (0.0, 0.0, -1.0)),
    ViaPoint("link_0", (0.2, 0.0, 0.0), PointCondition("joint_1", -0.5, 0.25, 0.125)),
    ViaPoint(FAR, (0.0, 1.0, 0.0)),
    ViaPoint(FAR, (0.0, 1.5, 0.0)),
    ViaPoint(WORLD, (0.0, 0.5, 1.0)),
)
SITE = ViaPoint("link_0", (0.3, 0.0, 0.1))
MUSCLES = [
    Muscle("branched", POINTS, f_max=1.0, branches=(Branch(0, 1.0), Branch(3, 2.0))),
    Muscle("fixed", (), f_max=1.0, terms=(CoordinateTerm("joint_0", 0.5),)),
    Muscle("opensim", POINTS, f_max=1.0, wraps=(
        Wrap("barrel", 0, rule="opensim", quadrant="-y", last_segment=3),
        Wrap("egg", 2, rule="opensim"),
    )),
    Muscle("mujoco", POINTS, f_max=1.0, wraps=(
        Wrap("barrel", 0, rule="mujoco", side_point=SITE), Wrap("barrel", 1, rule="mujoco"),
    )),
]  # fmt: skip


A, B = (0.3, 0.4, 0.0), (0.1, 0.5, 0.0)
TWICE = Muscle(
    "m",
    (
        ViaPoint(WORLD, (1.0, 0.0, 0.0)),
        ViaPoint("a", A, PointCondition("q", -1.0, 0.1)),
        ViaPoint("a", A, PointCondition("q", -0.2, 1.0)),
        ViaPoint("a", B),
        ViaPoint("a", B),
        ViaPoint(WORLD, (0.0, 1.0, 0.0)),
    ),
    f_max=1.0,
    wraps=(Wrap("ball", 4, rule="opensim"),),
    branches=(Branch(4, 1.0),),
)
BALL = WrapSurface("ball", WORLD, "sphere", 0.01, Pose((0.2, 0.9, 0.0)))


@pytest.mark.parametrize(
    ("format_", "kept", "wrapped"),
    [("osim", [A, A, B], 3), ("mjcf", [A, B, B], 3), ("caspr", [A, B], None)],
)
def test_points_that_differ_only_by_condition_or_branch_are_written_once(
    format_: str, kept: list[Vector3], wrapped: int | None, tmp_path: Path
) -> None:
    """If a format does not support these, the second point would create a segment of length 0."""
    robot = one_link(muscles=[TWICE], surfaces=[BALL])
    (muscle,) = read_robot(convert(robot, format_, tmp_path).files[0]).muscles
    inner = [point.position for point in muscle.via_points[1:-1]]
    assert inner == [pytest.approx(position) for position in kept]
    assert [wrap.segment for wrap in muscle.wraps] == ([] if wrapped is None else [wrapped])


def everything() -> Robot:
    return carriage(MUSCLES, SURFACES)


def test_cardsflow_xml_keeps_all_path_features(tmp_path: Path) -> None:
    robot = everything()
    assert check(robot) == []
    write_sdf(robot, tmp_path)
    assert read_robot(tmp_path) == robot
    assert merge_fixed_joints(robot) == robot


@pytest.mark.parametrize("name", ["caspr", "mjcf", "osim"])
def test_unsupported_path_features_of_other_formats_are_reported(tmp_path: Path, name: str) -> None:
    robot = everything()
    if name != "mjcf":
        with pytest.raises(
            RobotError, match=r"'fixed': .* lengths proportional to coordinates; add"
        ):
            convert(robot, name, tmp_path)
    kept = tuple(m for m in robot.muscles if m.name != "fixed")
    findings = convert(robot.with_muscles(kept), name, tmp_path).findings
    reported = {(f.subject.name, f.code) for f in findings}
    assert (("branched", "point-condition-left-out") in reported) == (name != "osim")
    assert (("branched", "branches-left-out") in reported) == (name != "mjcf")
    rules = {"osim": ["mujoco"], "mjcf": ["opensim"]}.get(name, ["opensim", "mujoco"])
    assert {m for m, code in reported if code == "wrap-rule-left-out"} == set(rules)


@pytest.mark.parametrize(
    ("muscle", "problem"),
    [
        (replace(MUSCLES[0], branches=(Branch(4),)), "at least two via points"),
        (replace(MUSCLES[0], branches=(Branch(9),)), r"branches start at via points \[9\]"),
        (replace(MUSCLES[0], branches=(Branch(2, 0.0),)), "divisor is 0"),
        (replace(MUSCLES[1], terms=()), "needs at least two via points"),
        (replace(MUSCLES[1], terms=(CoordinateTerm("elbow", 1.0),)), "no coordinate 'elbow'"),
        (replace(MUSCLES[2], wraps=(Wrap("barrel", 3, rule="opensim", last_segment=4),)), "up to"),
        (
            replace(MUSCLES[2], wraps=(Wrap("barrel", 0, 1, rule="opensim"),)),
            "does not support side",
        ),
        (replace(MUSCLES[2], wraps=(Wrap("barrel", 0, quadrant="+x"),)), "only rule"),
        (
            replace(MUSCLES[3], wraps=(Wrap("egg", 0, rule="mujoco"),)),
            "does not support ellipsoids",
        ),
        (replace(MUSCLES[3], wraps=(Wrap("barrel", 0, rule="mujoco"),) * 2), "use at most one"),
    ],
)
def test_invalid_paths_are_reported(muscle: Muscle, problem: str) -> None:
    with pytest.raises(RobotError, match=problem):
        write_sdf(carriage([muscle], SURFACES), Path())
