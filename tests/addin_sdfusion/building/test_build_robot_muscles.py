"""Tests of muscles in link frames, of meshes, and of damaged snapshots."""

from __future__ import annotations

from array import array
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.designs.design_strategies import Draughtsman, forward, initial, matrix
from support.designs.small_designs import arm, via

from addin_sdfusion.building.build_robot import build_robot, link_of
from addin_sdfusion.robot import CableModel, Robot, Wrap
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import (
    DesignSnapshot,
    MeshSnapshot,
    MuscleSnapshot,
    PointSnapshot,
    PointUse,
    SurfaceSnapshot,
    SurfaceUse,
    WrapUse,
)
from addin_sdfusion.snapshot_file import read_snapshot, write_snapshot


def robot_of(snapshot: DesignSnapshot) -> Robot:
    made = build_robot(snapshot)
    assert made.robot is not None, made.findings
    return made.robot


def face(name: str, after: int, shape: Any = "cylinder", **more: Any) -> SurfaceSnapshot:
    use = SurfaceUse(name, "upper", (WrapUse("flexor", after, -1, 1),))
    axis = more.pop("axis", (0.6, 0.0, 0.8))
    length = 0.3 if shape == "cylinder" else 0.0
    return SurfaceSnapshot("upper:1", shape, 0.02, (0.4, 0.1, 0.2), axis, length, name, use)


def displaced() -> DesignSnapshot:
    """Return the arm with its shoulder at 0.7 rad."""
    snapshot = arm()
    shoulder = snapshot.joints[0]
    moved = replace(shoulder, motions=(replace(shoulder.motions[0], value=0.7),))
    return replace(snapshot, joints=(moved, snapshot.joints[1]))


def test_a_muscle_has_the_properties_of_the_table() -> None:
    rows = (
        MuscleSnapshot("b", f_min=2.0, f_max=30.0, model="linear_spring", parameters={"k": 5.0}),
        MuscleSnapshot("a", f_min=0.0, f_max=float("inf")),
    )
    points = [
        via(name, number, link, (0.1 * number, 0.2, 0.0))
        for name in "ab"
        for number, link in ((10, "lower"), (2, "upper"), (0, "world"))
    ]
    robot = robot_of(arm(points=tuple(points), muscles=rows))
    b, a = robot.muscles
    assert (b.name, b.f_min, b.f_max) == ("b", 2.0, 30.0)
    assert b.model == CableModel("linear_spring", (("k", 5.0),))
    assert (a.name, a.f_max) == ("a", float("inf"))
    assert [v.link for v in a.via_points] == ["world", "upper", "lower"]
    assert a.via_points[0].position == (0.0, 0.2, 0.0)


def test_wrap_surfaces_are_on_their_link_with_z_along_the_axis() -> None:
    snapshot = replace(displaced(), surfaces=(face("ball", 2, "sphere"), face("shaft", 1)))
    robot = robot_of(snapshot)
    ball, shaft = robot.wrap_surfaces
    T_world_upper = forward(robot, initial(robot))["upper"]
    for surface in (ball, shaft):
        T = T_world_upper @ matrix(surface.pose)
        np.testing.assert_allclose(T[:3, 3], (0.4, 0.1, 0.2), atol=1e-12)
    np.testing.assert_allclose(T[:3, 2], (0.6, 0.0, 0.8), atol=1e-12)
    assert (shaft.shape, shaft.radius, shaft.length) == ("cylinder", 0.02, 0.3)
    assert (ball.shape, ball.radius, ball.length) == ("sphere", 0.02, float("inf"))
    assert robot.muscle("flexor").wraps == (Wrap("shaft", 0, -1, 1), Wrap("ball", 1, -1, 1))


@pytest.mark.parametrize("axis", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, -1, 0)])
def test_a_wrap_surface_may_have_any_axis(axis: Any) -> None:
    snapshot = replace(arm(), surfaces=(face("shaft", 1, axis=tuple(map(float, axis))),))
    (shaft,) = robot_of(snapshot).wrap_surfaces
    np.testing.assert_allclose(matrix(shaft.pose)[:3, 2], axis, atol=1e-15)


def test_task_points_and_markers_are_operational_spaces() -> None:
    snapshot = displaced()
    marked = [
        PointSnapshot("EE_upper", "upper:1", (0.3, 0.2, 0.1), "1"),
        PointSnapshot("EE_lower", "lower:1", (0.6, 0.2, 0.1), "2"),
        PointSnapshot("VM_lower", "lower:1", (0.7, 0.2, 0.1), "3"),
    ]
    turned = PointUse("task", "lower", name="palm", axes=("alpha", "gamma"))
    palm = PointSnapshot("p", "lower:1", (0.6, 0.0, 0.0), "4", turned)
    robot = robot_of(replace(snapshot, points=(*snapshot.points, *marked, palm)))
    assert robot.task_set == "task"
    assert [f.name for f in robot.task_frames] == ["lower", "palm", "upper"]
    markers = robot.task_sets[1]
    assert (markers.name, markers.frames[0].link) == ("markers", "lower")
    poses = forward(robot, initial(robot))
    for frame, at in (
        (robot.task_frames[2], (0.3, 0.2, 0.1)),
        (markers.frames[0], (0.7, 0.2, 0.1)),
    ):
        there = poses[frame.link] @ [*frame.position, 1.0]
        np.testing.assert_allclose(there[:3], at, atol=1e-12)
    assert robot.task_frames[1].position == (0.0, 0.0, 0.0)


def test_the_axis_of_a_joint_is_moved_back_to_the_zero_pose() -> None:
    """Manual calculation: upper is rotated by 90° about z, so y of the elbow was x."""
    snapshot = arm()
    shoulder, elbow = snapshot.joints
    quarter = replace(shoulder.motions[0], value=float(np.pi / 2))
    sideways = replace(elbow.motions[0], axis=(0.0, 1.0, 0.0), value=0.3)
    joints = (
        replace(shoulder, motions=(quarter,), origin_one=(0.0, 0.0, 0.0), origin_two=None),
        replace(elbow, motions=(sideways,), origin_one=(0.0, 0.4, 0.0), origin_two=None),
    )
    robot = robot_of(replace(snapshot, joints=joints))
    elbow_joint = robot.joint("elbow")
    np.testing.assert_allclose(elbow_joint.motions[0].axis, (1.0, 0.0, 0.0), atol=1e-15)
    np.testing.assert_allclose(elbow_joint.T_parent_joint.position, (0.4, 0.0, 0.0), atol=1e-15)
    assert robot.coordinates[1].initial == 0.3


def test_meshes_of_a_design_with_y_up_are_in_the_world_frame() -> None:
    mesh = MeshSnapshot(array("d", [1, 2, 3, 4, 5, 6, 7, 8, 9]), array("i", [0, 1, 2]))
    snapshot = arm()
    bodies = tuple(replace(body, mesh=mesh) for body in snapshot.bodies)
    lying = replace(snapshot, bodies=bodies, settings=ExportSettings(up_axis="y"))
    made = build_robot(lying)
    turned = made.bodies_of_link["upper"][0].mesh
    assert turned is not None
    assert list(turned.nodes) == [1, -3, 2, 4, -6, 5, 7, -9, 8]
    assert list(mesh.nodes) == [1, 2, 3, 4, 5, 6, 7, 8, 9]
    assert build_robot(replace(lying, settings=ExportSettings())).bodies_of_link["upper"] == (
        bodies[1],
    )


def test_a_snapshot_read_from_a_file_results_in_the_same_robot(tmp_path: Path) -> None:
    snapshot = Draughtsman(7, 4).draw().snapshot
    again = read_snapshot(write_snapshot(snapshot, tmp_path / "design.json"))
    assert build_robot(again) == build_robot(snapshot)


STRANGE = st.sampled_from(
    [None, "", "a:1", "link_1:1", "no such", float("nan"), float("inf"), 0.0, -1.0, "\n", "world"]
)
PLACES = st.sampled_from(
    [
        ("occurrences", "path"),
        ("occurrences", "parent"),
        ("occurrences", "component"),
        ("occurrences", "grounded"),
        ("bodies", "occurrence"),
        ("bodies", "name"),
        ("bodies", "mass"),
        ("groups", "name"),
        ("groups", "occurrences"),
        ("joints", "name"),
        ("joints", "kind"),
        ("joints", "one"),
        ("joints", "two"),
        ("joints", "origin_one"),
        ("joints", "origin_two"),
        ("joints", "motions"),
        ("points", "occurrence"),
        ("points", "position"),
        ("points", "use"),
    ]
)


def _strange(old: Any, value: Any) -> Any:
    """Return a value of the same type that a damaged snapshot file may contain."""
    if isinstance(old, str):
        return value if isinstance(value, str) else "strange"
    if isinstance(old, bool):
        return not old
    if isinstance(old, tuple) and old and isinstance(old[0], float):
        return (value if isinstance(value, float) else 0.0, *old[1:])
    if isinstance(old, tuple) and old and isinstance(old[0], str):
        return (value,) if isinstance(value, str) else ()
    if isinstance(old, tuple) and old and isinstance(value, float):
        return (replace(old[0], value=value, lower=value, axis=(value, 0.0, 0.0)), *old[1:])
    if isinstance(old, tuple):
        return ()
    if isinstance(old, PointUse):
        return replace(old, link=value) if isinstance(value, str) else None
    if old is not None and isinstance(value, float):
        return replace(old, mass=value, com=(value, 0.0, 0.0))
    return None


@pytest.mark.slow
@given(
    st.integers(0, 50),
    st.booleans(),
    st.lists(st.tuples(PLACES, st.integers(0, 30), STRANGE), min_size=1, max_size=4),
    st.builds(
        ExportSettings,
        base=st.sampled_from(["", "link_1", "x"]),
        fixed_base=st.booleans(),
        links=st.sampled_from(["auto", "rigid_groups", "components"]),
        up_axis=st.sampled_from(["y", "z"]),
    ),
)
def test_a_damaged_snapshot_results_in_findings_without_exception(
    seed: int, groups: bool, damages: Any, chosen: ExportSettings
) -> None:
    snapshot = Draughtsman(seed, 3, groups=groups, muscles=1).draw().snapshot
    snapshot = replace(snapshot, settings=chosen)
    for (collection, name), k, value in damages:
        items = list(getattr(snapshot, collection))
        if not items:
            continue
        k %= len(items)
        items[k] = replace(items[k], **{name: _strange(getattr(items[k], name), value)})
        snapshot = replace(snapshot, **{collection: tuple(items)})
    link_of(snapshot)
    made = build_robot(snapshot)
    assert (made.robot is None) == any(finding.is_error for finding in made.findings)
