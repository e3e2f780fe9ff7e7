"""Meshes, bodies and built robots for tests of the export."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import trimesh
from support.robots.robots import planar_2r

from addin_sdfusion.robot import Finding, Pose, Robot
from addin_sdfusion.robot.model.robot import WORLD
from addin_sdfusion.robot.model.rotations import compose, inverse
from addin_sdfusion.snapshot import BodySnapshot, MeshSnapshot


@dataclass(frozen=True)
class Built:
    """Substitute for a robot built from a design."""

    robot: Robot | None
    findings: tuple[Finding, ...] = ()
    T_world_link: Mapping[str, Pose] = field(default_factory=dict)
    bodies_of_link: Mapping[str, Sequence[BodySnapshot]] = field(default_factory=dict)


def snapshot_of(mesh: Any) -> MeshSnapshot:
    """Return a trimesh as MeshSnapshot."""
    nodes = array("d", np.asarray(mesh.vertices, dtype=float).ravel())
    return MeshSnapshot(nodes, array("i", np.asarray(mesh.faces).ravel().tolist()))


def body(mesh: Any, name: str = "Body1", **more: Any) -> BodySnapshot:
    return BodySnapshot(name, "part:1", mesh=snapshot_of(mesh), **more)


def box(*size: float, at: Sequence[float] = (0.0, 0.0, 0.0)) -> Any:
    mesh = trimesh.creation.box(extents=size)
    mesh.apply_translation(at)
    return mesh


def matrix(pose: Pose) -> Any:
    T = np.eye(4)
    T[:3, :3] = trimesh.transformations.euler_matrix(*pose.rpy, "sxyz")[:3, :3]
    T[:3, 3] = pose.position
    return T


def zero_poses(robot: Robot) -> dict[str, Pose]:
    """Return the poses of the links in the world frame at q = 0."""
    poses = {WORLD: Pose()}
    for joint in robot.joints:
        T_world_joint = compose(poses[joint.parent], joint.T_parent_joint)
        poses[joint.child] = compose(T_world_joint, inverse(joint.T_child_joint))
    return poses


def built(robot: Robot | None = None, bodies: int = 1) -> Built:
    """Return a built robot (default: the arm of the paper) with boxes as links."""
    robot = planar_2r() if robot is None else robot
    robot = replace(robot, links=tuple(replace(link, end=None) for link in robot.links))
    poses = zero_poses(robot)
    of_link = {}
    for link in robot.links:
        boxes = [box(0.1, 0.1, 0.3, at=(0.2 * k, 0.0, 0.0)) for k in range(bodies)]
        for mesh in boxes:
            mesh.apply_transform(matrix(poses[link.name]))
        of_link[link.name] = tuple(body(m, f"Body{k}") for k, m in enumerate(boxes, start=1))
    return Built(robot, (), poses, of_link)
