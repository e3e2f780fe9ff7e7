"""Tests of closed loops of designs: where they are cut, and the loop joints that close them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.designs.small_designs import DesignSnapshot, body, box, part
from support.oracles.closed_loops import closed_poses, initial
from support.oracles.loop_model import loop_jacobian, residuals

from addin_sdfusion.building.build_robot import build_robot
from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.rotations import normalized
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import JointSnapshot, MotionSnapshot

TILTED = normalized((0.2, 1.0, -0.3))
"""Axis of the hinges of the linkage."""
AXES = np.linalg.svd(np.array([TILTED]))[2][1:]
"""Two directions in the plane of the linkage."""
CORNERS = ((0.0, 0.0), (0.5, 0.0), (0.45, 0.4), (0.1, 0.25))


def corner(k: int) -> tuple[float, float, float]:
    x, y, z = np.array(CORNERS[k]) @ AXES + (0.3, -0.1, 0.2)
    return float(x), float(y), float(z)


def linkage(values: Any = (0.0, 0.0, 0.0, 0.0), **settings: Any) -> DesignSnapshot:
    """Return a planar four-bar linkage in a tilted plane, with hinges j0 to j3 at its corners.

    Link k connects hinges k and k + 1; link 3 is grounded.
    """
    joints = []
    for k, value in enumerate(values):
        one, two = f"l{k}:1", f"l{(k - 1) % 4}:1"
        motion = MotionSnapshot("rotation", TILTED, value)
        joints.append(JointSnapshot(f"j{k}", "revolute", one, two, corner(k), corner(k), (motion,)))
    return DesignSnapshot(
        "linkage",
        ExportSettings(**settings),
        tuple(part(f"l{k}:1", grounded=k == 3) for k in range(4)),
        tuple(body(f"l{k}:1", box((0.1, 0.2, 0.3), corner(k))) for k in range(4)),
        joints=tuple(joints),
    )


def robot_of(snapshot: DesignSnapshot) -> Robot:
    made = build_robot(snapshot)
    assert made.robot is not None, made.findings
    return made.robot


@pytest.mark.parametrize("values", [(0.0, 0.0, 0.0, 0.0), (0.4, -0.3, 1.0, 0.2)])
def test_a_loop_moves_the_same_wherever_it_is_cut(values: Any) -> None:
    """The pose of the design closes the loop, and the crank moves all links alike."""
    at_start, moved = [], []
    for k in (1, 2, 3):
        robot = robot_of(linkage(values, cut_joints=(f"j{k}",)))
        assert [loop.name for loop in robot.loops] == [f"j{k}"]
        assert np.abs(residuals(robot, initial(robot))).max() < 1e-15
        at_start.append(closed_poses(robot, "j0", 1e-9))
        moved.append(closed_poses(robot, "j0", 0.3))
    for link in at_start[0]:
        turns = [
            new[link] @ np.linalg.inv(old[link]) for new, old in zip(moved, at_start, strict=True)
        ]
        for turn in turns[1:]:
            assert turn == pytest.approx(turns[0], abs=1e-8)


SPACE = {
    "revolute": (("rotation", 2),),
    "prismatic": (("translation", 2),),
    "cylindrical": (("rotation", 2), ("translation", 2)),
    "universal": (("rotation", 2), ("rotation", 0)),
    "ball": (("rotation", 2), ("rotation", 0), ("rotation", 1)),
    "planar": (("translation", 0), ("translation", 1), ("rotation", 2)),
    "fixed": (),
}


FREE = tuple(
    MotionSnapshot(kind, axis, 0.1 * k, role=f"{kind[0]}{k}")  # type: ignore[arg-type]
    for kind in ("translation", "rotation")
    for k, axis in enumerate([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)], 1)
)
"""All six motions at non-zero values."""


@pytest.mark.parametrize("kind", SPACE)
@pytest.mark.parametrize("to_world", ["", "one", "two"])
def test_every_motion_closes_a_loop_at_the_pose_of_the_design(kind: str, to_world: str) -> None:
    """The loop joint has the freedom of the joint, also at non-zero values and tilted axes."""
    axes = [TILTED, *map(tuple, AXES)]
    frame = (axes[1], axes[2], axes[0])
    motions = tuple(
        MotionSnapshot(k, frame[axis], 0.1 * (n + 1)) for n, (k, axis) in enumerate(SPACE[kind])
    )
    slide = sum(np.array(m.axis) * m.value for m in motions if m.kind == "translation")
    one = tuple(map(float, np.array(corner(2)) + slide))
    ends = {"": ("l2:1", "l0:1"), "one": ("", "l0:1"), "two": ("l2:1", "")}[to_world]
    words = {"revolute": "revolute", "fixed": "rigid", "prismatic": "slider"}
    extra = JointSnapshot("x", words.get(kind, kind), *ends, one, corner(2), motions)  # type: ignore[arg-type]
    chain = linkage((0.3, 0.2, 0.1, 0.0))
    joints = tuple(replace(j, motions=FREE, origin_two=None) for j in chain.joints[:3])
    settings = ExportSettings(cut_joints=("x",))
    robot = robot_of(replace(chain, joints=(*joints, extra), settings=settings))
    (loop,) = robot.loops
    assert loop.type == kind
    q = initial(robot)
    assert np.abs(residuals(robot, q)).max() < 1e-15
    rank = np.linalg.matrix_rank(loop_jacobian(robot, q), 1e-9)
    assert rank == 6 - len(SPACE[kind])


def test_joints_without_lost_properties_are_cut() -> None:
    """The joint farthest from the base has limits, so another one is cut."""
    snapshot = linkage()
    plain = robot_of(snapshot)
    (first,) = plain.loops
    limited = tuple(
        replace(j, motions=(replace(j.motions[0], lower=-math.pi),)) if j.name == first.name else j
        for j in snapshot.joints
    )
    made = build_robot(replace(snapshot, joints=limited))
    assert made.robot is not None
    (second,) = made.robot.loops
    assert second.name != first.name
    assert "loop-joint-forces" not in [f.code for f in made.findings]
    forced = replace(snapshot, joints=limited, settings=ExportSettings(cut_joints=(first.name,)))
    (lost,) = [f for f in build_robot(forced).findings if f.code == "loop-joint-forces"]
    assert "its limits are omitted" in lost.message


def test_a_pin_in_a_slot_is_in_the_tree() -> None:
    """No loop joint has its motions; if it is cut, its loop is open, and this is reported."""
    snapshot = linkage()
    slot = (MotionSnapshot("translation", tuple(AXES[0])), MotionSnapshot("rotation", TILTED))
    name = robot_of(snapshot).loops[0].name
    joints = tuple(
        replace(j, kind="pin_slot", motions=slot) if j.name == name else j for j in snapshot.joints
    )
    robot = robot_of(replace(snapshot, joints=joints))
    assert name in [joint.name for joint in robot.joints]
    assert len(robot.loops) == 1
    cut = build_robot(replace(snapshot, joints=joints, settings=ExportSettings(cut_joints=(name,))))
    assert cut.robot is not None
    assert cut.robot.loops == ()
    assert "cut-joint" in [f.code for f in cut.findings]
