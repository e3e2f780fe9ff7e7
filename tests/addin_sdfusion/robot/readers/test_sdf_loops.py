"""Loop joints in SDF: joints whose child already has a parent joint."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.robots.loops import four_bar, with_loop

from addin_sdfusion.robot import (
    WORLD,
    LoopJoint,
    Pose,
    Robot,
    check,
    merge_fixed_joints,
    read_robot,
    sdf_losses,
    write_sdf,
)
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.formats.sdf.write_joints import KINDS
from addin_sdfusion.robot.formats.urdf.write import write_urdf
from addin_sdfusion.robot.model.loop import AXES, LoopType
from addin_sdfusion.robot.transforms.combine import Member, combine

AXIS = ((0.0, 0.6, 0.8), (1.0, 0.0, 0.0))
TURNED = Pose((0.1, 0.2, 0.3), (0.4, -0.5, 0.6))


def of_type(kind: LoopType) -> Robot:
    return with_loop(four_bar(), type=kind, axes=AXIS[: AXES[kind]], T_child_joint=TURNED)


@pytest.mark.parametrize("kind", AXES)
def test_loop_joint_is_restored(kind: LoopType, tmp_path: Path) -> None:
    robot = of_type(kind)
    write_sdf(robot, tmp_path)
    reading = read(tmp_path)
    assert reading.require() == robot
    assert not {f.code for f in reading.findings} & {"loop-joint-held", "loop-joint-forces"}


@pytest.mark.parametrize("kind", AXES)
def test_loop_joint_is_restored_from_cardsflow_xml(kind: LoopType, tmp_path: Path) -> None:
    """A URDF cannot hold it; without plugin, an SDF cannot hold every type."""
    robot = of_type(kind)
    write_urdf(robot, tmp_path / "urdf")
    assert read_robot(tmp_path / "urdf/four_bar.urdf").loops == robot.loops
    write_sdf(robot, tmp_path, plugin=False)
    assert read_robot(tmp_path / "model.sdf") == robot


@pytest.mark.parametrize("kind", sorted(set(AXES) - set(KINDS)))
def test_loop_types_that_are_open_in_other_programs_are_reported(kind: LoopType) -> None:
    (finding,) = [f for f in sdf_losses(of_type(kind)) if f.code == "loop-in-the-plugin"]
    assert f"SDF has no {kind} joint as loop joint" in finding.message


def test_prismatic_loop_joints_with_range_zero_are_fixed(shared: Path) -> None:
    """The published biking_legs: a tree of 12 coordinates, with each foot fixed to its pedal."""
    reading = read(shared / "robots/cardsflow/biking_legs")
    robot = reading.require()
    assert len(robot.coordinates) == 12
    assert [(loop.type, loop.parent, loop.child) for loop in robot.loops] == [
        ("fixed", f"pedal_{side}", f"foot_{side}_tip") for side in ("left", "right")
    ]
    held = [f.line for f in reading.findings if f.code == "loop-joint-held"]
    assert held == [1414, 1447]


def test_omitted_limits_of_a_loop_joint_are_reported(tmp_path: Path) -> None:
    write_sdf(four_bar(), tmp_path)
    file = tmp_path / "model.sdf"
    before, _, after = file.read_text().partition('<joint name="closing"')
    limits = "</xyz><limit><lower>-1</lower><upper>1</upper></limit>"
    file.write_text(before + '<joint name="closing"' + after.replace("</xyz>", limits, 1))
    (finding,) = [f for f in read(tmp_path).findings if f.code == "loop-joint-forces"]
    assert "limits" in finding.message
    assert finding.line == 1 + before.count("\n")


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"parent": "nobody"}, "unknown-parent"),
        ({"child": WORLD}, "unknown-child"),
        ({"parent": "rocker_bar"}, "loop-of-no-length"),
        ({"type": "screw"}, "unsupported-loop"),
        ({"axes": ()}, "wrong-axes"),
        ({"axes": ((0.0, 0.0, 0.0),)}, "zero-axis"),
        ({"axes": ((0.0, 2.0, 0.0),)}, "axis-not-unit"),
        ({"type": "universal", "axes": (AXIS[0], AXIS[0])}, "axes-not-orthogonal"),
        ({"T_child_joint": Pose((float("nan"), 0.0, 0.0))}, "not-finite"),
        ({"name": "crank"}, "duplicate-joint"),
    ],
)
def test_invalid_loops_are_reported(changes: dict[str, object], code: str) -> None:
    assert [f.code for f in check(with_loop(four_bar(), **changes)) if f.is_error] == [code]


def test_loops_move_with_their_robot() -> None:
    robot = four_bar()
    placed = Pose((1.0, 2.0, 3.0), (0.0, 0.0, 0.5))
    both = combine("both", [Member("a", robot), Member("b", robot, placed)])
    assert [(loop.name, loop.parent, loop.child) for loop in both.loops] == [
        (f"{name}_closing", f"{name}_coupler_bar", f"{name}_rocker_bar") for name in "ab"
    ]
    grounded = replace(robot, loops=(LoopJoint("pin", WORLD, "rocker_bar", "ball"),))
    (_, loop) = combine("both", [Member("a", grounded), Member("b", grounded, placed)]).loops
    assert (loop.parent, loop.T_parent_joint) == (WORLD, placed)


def test_loops_are_kept_when_links_are_merged(shared: Path) -> None:
    robot = merge_fixed_joints(read_robot(shared / "robots/cardsflow/biking_legs"))
    assert [loop.child for loop in robot.loops] == ["foot_left", "foot_right"]
    assert not [f for f in check(robot) if f.is_error]
