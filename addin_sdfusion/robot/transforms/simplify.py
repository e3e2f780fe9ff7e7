"""Simplification of robots: merging of fixed joints, and alignment of link frames as in CASPR.

The dynamics do not change: M, C, G, l, L, y and J are the same at any q. All parts of a link are
transformed with it: inertias, meshes, via points, task frames, wrap surfaces, loop joints.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ..model.joint import Joint, Motion
from ..model.pose import IDENTITY, Pose
from ..model.robot import WORLD, Inertia, Link, Robot
from ..model.rotations import (
    apply,
    compose,
    inverse,
    normalized,
    rotate,
    rotation,
)
from .part_map import PartMap

Targets = Mapping[str, tuple[str, Pose]]
"""For each link, the target link that receives its parts, and its pose in the target's frame."""


def merge_fixed_joints(robot: Robot) -> Robot:
    """Merge links that are fixed to each other.

    The link nearest to the world keeps its name, frame and distal end. Links fixed to the world are
    removed, including mass and meshes; their via points and wrap surfaces become fixed in the
    world. A link and its fixed joint are kept if the merged robot could not represent a task frame:
    any task frame on a link fixed to the world, and an orientation on a link that is rotated
    relative to its target link.
    """
    targets: dict[str, tuple[str, Pose]] = {WORLD: (WORLD, IDENTITY)}
    for joint in robot.joints:
        target, T_target_parent = targets[joint.parent]
        T_target_joint = compose(T_target_parent, joint.T_parent_joint)
        T_target_child = compose(T_target_joint, inverse(joint.T_child_joint))
        merged = not joint.motions and _may_merge(robot, joint.child, target, T_target_child)
        targets[joint.child] = (target, T_target_child) if merged else (joint.child, IDENTITY)
    parts: dict[str, list[Link]] = {link.name: [] for link in robot.links}
    for link in robot.links:
        target, T_target_link = targets[link.name]
        if target != WORLD:
            parts[target].append(_in_frame(link, T_target_link))
    links = tuple(_union(link, parts[link.name]) for link in robot.links if parts[link.name])
    joints = tuple(
        _with_target_parent(j, targets) for j in robot.joints if targets[j.child][0] == j.child
    )
    return _with_targets(replace(robot, links=links, joints=joints), targets)


def joint_frames(robot: Robot) -> Robot:
    """Return the robot with each link frame at its joint, so that T_child_joint is the identity.

    Orientation task frames then refer to the joint frames.
    """
    targets: dict[str, tuple[str, Pose]] = {WORLD: (WORLD, IDENTITY)}
    for joint in robot.joints:
        targets[joint.child] = (joint.child, inverse(joint.T_child_joint))
    joints = tuple(
        replace(_with_target_parent(j, targets), T_child_joint=IDENTITY) for j in robot.joints
    )
    return _with_frames(replace(robot, joints=joints), targets)


def align_frames(robot: Robot) -> Robot:
    """Return the robot with link frames at their joints and parallel to the world at q = 0.

    T_child_joint becomes the identity and T_parent_joint a translation. Joint axes along a frame
    axis may become oblique. Orientation task frames refer to the new frames, so that their angles
    are relative to the pose at q = 0.
    """
    targets: dict[str, tuple[str, Pose]] = {WORLD: (WORLD, IDENTITY)}
    joints = []
    for joint in robot.joints:
        T_parent_joint = compose(targets[joint.parent][1], joint.T_parent_joint)
        turned = Pose(rpy=T_parent_joint.rpy)
        targets[joint.child] = (joint.child, compose(turned, inverse(joint.T_child_joint)))
        joints.append(
            replace(
                joint,
                motions=tuple(_turned(motion, turned) for motion in joint.motions),
                T_parent_joint=Pose(T_parent_joint.position),
                T_child_joint=IDENTITY,
            )
        )
    return _with_frames(replace(robot, joints=tuple(joints)), targets)


def _with_frames(robot: Robot, targets: Targets) -> Robot:
    """Return the robot with all parts of links expressed in the new link frames."""
    links = []
    for link in robot.links:
        T_new_link = targets[link.name][1]
        end = None if link.end is None else apply(T_new_link, link.end)
        links.append(replace(_in_frame(link, T_new_link), end=end))
    return _with_targets(replace(robot, links=tuple(links)), targets)


def _may_merge(robot: Robot, link: str, target: str, T_target_link: Pose) -> bool:
    """Return whether the target link can have every task frame of a link."""
    frames = [f for group in robot.task_sets for f in group.frames if f.link == link]
    turned = any(T_target_link.rpy) and any(frame.is_orientation for frame in frames)
    return not turned and (target != WORLD or not frames)


def _turned(motion: Motion, by: Pose) -> Motion:
    if not any(by.rpy):
        return motion
    return replace(motion, axis=normalized(rotate(rotation(by.rpy), motion.axis)))


def _with_target_parent(joint: Joint, targets: Targets) -> Joint:
    target, T_target_parent = targets[joint.parent]
    return replace(
        joint, parent=target, T_parent_joint=compose(T_target_parent, joint.T_parent_joint)
    )


def _in_frame(link: Link, T_target_link: Pose) -> Link:
    """Return a link with its parts expressed in another frame, except its distal end."""
    inertia = link.inertia.in_frame(T_target_link)
    meshes = tuple(replace(m, pose=compose(T_target_link, m.pose)) for m in link.meshes)
    shapes = tuple(replace(s, pose=compose(T_target_link, s.pose)) for s in link.shapes)
    return replace(link, inertia=inertia, meshes=meshes, shapes=shapes)


def _union(link: Link, parts: list[Link]) -> Link:
    """Merge a link and the parts fixed to it; all parts are in the link's frame."""
    meshes = tuple(mesh for part in parts for mesh in part.meshes)
    shapes = tuple(shape for part in parts for shape in part.shapes)
    inertia = Inertia.of_bodies([part.inertia for part in parts])
    return replace(link, inertia=inertia, meshes=meshes, shapes=shapes)


def _with_targets(robot: Robot, targets: Targets) -> Robot:
    """Return the robot with all parts of each link moved to its target link."""
    to_targets = PartMap(link=lambda link: targets[link][0], frame=lambda link: targets[link][1])
    return to_targets.apply_to_attached(robot)
