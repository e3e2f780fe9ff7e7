"""Loop joints in MJCF and OpenSim constrain the same motions as the original ones."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.oracles.loop_model import pose_matrix, residuals
from support.robots.loops import four_bar, with_loop

from addin_sdfusion.robot import LoopJoint, Pose, Robot, read_robot
from addin_sdfusion.robot.formats.mjcf.write import write_mjcf
from addin_sdfusion.robot.formats.opensim.write import write_osim
from addin_sdfusion.robot.model.loop import AXES, LoopType
from addin_sdfusion.robot.transforms.hinge_loops import (
    merge_points_to_hinges,
    with_hinges_as_points,
)

AXIS = (0.0, 0.6, 0.8)
PARENT, CHILD = Pose((0.5, 0.1, -0.2), (0.3, 0.2, -0.4)), Pose((0.1, 0.2, 0.3), (0.4, -0.5, 0.6))


def of_type(kind: LoopType) -> Robot:
    axes = (AXIS,) if AXES[kind] else ()
    return with_loop(four_bar(), type=kind, axes=axes, T_parent_joint=PARENT, T_child_joint=CHILD)


def gaps(robot: Robot, q: Any) -> Any:
    """Return the distance of the points and the remaining residuals' norm."""
    found = residuals(robot, q.astype(complex)).real
    return np.linalg.norm(found[:3]), np.linalg.norm(found[3:])


@pytest.mark.parametrize("write", [write_mjcf, write_osim])
@pytest.mark.parametrize("kind", ["ball", "fixed", "revolute"])
def test_loop_joint_is_restored(
    kind: LoopType, write: Callable[..., list[Path]], tmp_path: Path
) -> None:
    robot = of_type(kind)
    (file,) = write(robot, tmp_path)
    other = read_robot(file)
    (loop,) = other.loops
    assert (loop.name, loop.type) == ("closing", kind)
    names = [c.name for c in other.coordinates]
    order = [names.index(c.name) for c in robot.coordinates]
    for q in np.random.default_rng(3).uniform(-1.0, 1.0, (5, 3)):
        theirs = np.empty(3)
        theirs[order] = q
        assert gaps(other, theirs) == pytest.approx(gaps(robot, q), abs=1e-12)


def test_points_at_other_distances_are_not_a_hinge() -> None:
    robot = with_hinges_as_points(of_type("revolute"))
    first, second = robot.loops
    (hinge,) = merge_points_to_hinges(robot.loops)
    assert hinge.type == "revolute"
    x, y, z = second.T_child_joint.position
    for changed in (
        LoopJoint("b", second.parent, second.child, "ball", (), PARENT, Pose((x, y, z + 1e-6))),
        LoopJoint("b", second.child, second.parent, "ball"),
        LoopJoint("b", second.parent, second.child, "fixed"),
    ):
        assert merge_points_to_hinges((first, changed)) == (first, changed)


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0)])
def test_hinges_with_opposite_axes_in_their_links_are_merged(axis: Any) -> None:
    """The frame on the child is rotated by up to half a turn."""
    a, b, c = axis
    ends = Pose((0.0, 0.0, 0.0)), Pose((0.1, 0.0, 0.0))
    first = LoopJoint("a", "p", "c", "ball", (), *ends)
    moved = Pose((0.2, 0.0, 0.0)), Pose((0.1 + 0.2 * a, 0.2 * b, 0.2 * c))
    (hinge,) = merge_points_to_hinges((first, LoopJoint("b", "p", "c", "ball", (), *moved)))
    R = pose_matrix(hinge.T_child_joint)[:3, :3]
    assert R @ hinge.axes[0] == pytest.approx(axis, abs=1e-15)
