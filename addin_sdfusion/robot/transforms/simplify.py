"""Simplified robots: without fixed joints, or with link frames as CASPR has them.

Neither changes how the robot moves: M, C, G, l, L, y and J are the same at any q. What is on a link
moves with it: inertias, meshes, via points, task frames, wrap surfaces, ends of loop joints.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ..model.joint import Joint, Motion
from ..model.loop import LoopJoint
from ..model.muscle import CableSet, Muscle, ViaPoint, WrapSurface
from ..model.pose import IDENTITY, Pose
from ..model.robot import WORLD, Inertia, Link, Robot, TaskFrame, TaskSet
from ..model.rotations import (
    Matrix3,
    add,
    apply,
    compose,
    inverse,
    normalized,
    point_inertia,
    rotate,
    rotate_inertia,
    rotation,
    subtract,
)

Homes = Mapping[str, tuple[str, Pose]]
"""For each link, the link that takes over what is on it, and its pose there."""


def merge_fixed_joints(robot: Robot) -> Robot:
    """Return the robot with links that are fixed to one another made one.

    The link nearest to the world keeps its name, frame and far end. Links fixed to the world
    disappear, mass and meshes included: their via points and wrap surfaces are fixed in the world.
    A link stays, with its fixed joint, where a task frame on it could not be kept: on a link fixed
    to the world, and an orientation on a link that is turned against the one it would be merged
    into.
    """
    homes: dict[str, tuple[str, Pose]] = {WORLD: (WORLD, IDENTITY)}
    for joint in robot.joints:
        home, T_home_parent = homes[joint.parent]
        T_home_joint = compose(T_home_parent, joint.T_parent_joint)
        T_home_child = compose(T_home_joint, inverse(joint.T_child_joint))
        merged = not joint.motions and _may_merge(robot, joint.child, home, T_home_child)
        homes[joint.child] = (home, T_home_child) if merged else (joint.child, IDENTITY)
    parts: dict[str, list[Link]] = {link.name: [] for link in robot.links}
    for link in robot.links:
        home, T_home_link = homes[link.name]
        if home != WORLD:
            parts[home].append(_in_frame(link, T_home_link))
    links = tuple(_union(link, parts[link.name]) for link in robot.links if parts[link.name])
    joints = tuple(_rehung(j, homes) for j in robot.joints if homes[j.child][0] == j.child)
    return _rehomed(replace(robot, links=links, joints=joints), homes)


def joint_frames(robot: Robot) -> Robot:
    """The robot with the frame of each link at the joint that carries it: T_child_joint is none.

    An orientation that is controlled is then that of the joint's frame.
    """
    homes: dict[str, tuple[str, Pose]] = {WORLD: (WORLD, IDENTITY)}
    for joint in robot.joints:
        homes[joint.child] = (joint.child, inverse(joint.T_child_joint))
    return _reframed(robot, homes)


def align_frames(robot: Robot) -> Robot:
    """Return the robot with link frames at their joints and parallel to the world at q = 0.

    T_child_joint becomes the identity and T_parent_joint a translation; axes that were along a
    frame's axes may become tilted. An orientation that is controlled is then that of the turned
    frame: its angles count from the pose at q = 0.
    """
    homes: dict[str, tuple[str, Pose]] = {WORLD: (WORLD, IDENTITY)}
    joints = []
    for joint in robot.joints:
        T_parent_joint = compose(homes[joint.parent][1], joint.T_parent_joint)
        turned = Pose(rpy=T_parent_joint.rpy)
        homes[joint.child] = (joint.child, compose(turned, inverse(joint.T_child_joint)))
        joints.append(
            replace(
                joint,
                motions=tuple(_turned(motion, turned) for motion in joint.motions),
                T_parent_joint=Pose(T_parent_joint.position),
                T_child_joint=IDENTITY,
            )
        )
    return _with_frames(replace(robot, joints=tuple(joints)), homes)


def _reframed(robot: Robot, homes: Homes) -> Robot:
    """Return the robot with other link frames, which are those of their joints."""
    joints = tuple(replace(_rehung(j, homes), T_child_joint=IDENTITY) for j in robot.joints)
    return _with_frames(replace(robot, joints=joints), homes)


def _with_frames(robot: Robot, homes: Homes) -> Robot:
    """What is on the links, seen from their new frames."""
    links = []
    for link in robot.links:
        T_new_link = homes[link.name][1]
        end = None if link.end is None else apply(T_new_link, link.end)
        links.append(replace(_in_frame(link, T_new_link), end=end))
    return _rehomed(replace(robot, links=tuple(links)), homes)


def _may_merge(robot: Robot, link: str, home: str, T_home_link: Pose) -> bool:
    """Return whether every task frame on a link can be one on its new home."""
    frames = [f for group in robot.task_sets for f in group.frames if f.link == link]
    turned = any(T_home_link.rpy) and any(frame.is_orientation for frame in frames)
    return not turned and (home != WORLD or not frames)


def _turned(motion: Motion, by: Pose) -> Motion:
    if not any(by.rpy):
        return motion
    return replace(motion, axis=normalized(rotate(rotation(by.rpy), motion.axis)))


def _rehung(joint: Joint, homes: Homes) -> Joint:
    home, T_home_parent = homes[joint.parent]
    return replace(joint, parent=home, T_parent_joint=compose(T_home_parent, joint.T_parent_joint))


def _in_frame(link: Link, T_home_link: Pose) -> Link:
    """Return a link as seen from another frame, but for its far end."""
    own = link.inertia
    matrix = own.matrix
    if any(T_home_link.rpy):
        matrix = rotate_inertia(rotation(T_home_link.rpy), matrix)
    inertia = Inertia.of(own.mass, apply(T_home_link, own.com), matrix)
    meshes = tuple(replace(m, pose=compose(T_home_link, m.pose)) for m in link.meshes)
    shapes = tuple(replace(s, pose=compose(T_home_link, s.pose)) for s in link.shapes)
    return replace(link, inertia=inertia, meshes=meshes, shapes=shapes)


def _union(link: Link, parts: list[Link]) -> Link:
    """Return a link and all that is fixed to it, as one; every part in the link's frame."""
    meshes = tuple(mesh for part in parts for mesh in part.meshes)
    shapes = tuple(shape for part in parts for shape in part.shapes)
    own = [part.inertia for part in parts]
    inertia = own[0] if len(parts) == 1 else _sum(own)
    return replace(link, inertia=inertia, meshes=meshes, shapes=shapes)


def _sum(parts: list[Inertia]) -> Inertia:
    """The inertia of several bodies that move as one; a massless one is at the first's place."""
    mass = sum(part.mass for part in parts)
    com = parts[0].com
    if mass > 0.0:
        x, y, z = (sum(part.mass * part.com[i] for part in parts) / mass for i in range(3))
        com = (x, y, z)
    matrix: Matrix3 = ((0.0, 0.0, 0.0),) * 3
    for part in parts:
        away = point_inertia(part.mass, subtract(part.com, com))
        own = part.matrix
        matrix = (
            add(matrix[0], add(own[0], away[0])),
            add(matrix[1], add(own[1], away[1])),
            add(matrix[2], add(own[2], away[2])),
        )
    return Inertia.of(mass, com, matrix)


def _rehomed(robot: Robot, homes: Homes) -> Robot:
    """Return the robot with everything that is fixed to a link fixed to that link's home."""
    return replace(
        robot,
        cable_sets=tuple(
            CableSet(group.name, tuple(_muscle(muscle, homes) for muscle in group.muscles))
            for group in robot.cable_sets
        ),
        task_sets=tuple(
            TaskSet(group.name, tuple(_task_frame(frame, homes) for frame in group.frames))
            for group in robot.task_sets
        ),
        wrap_surfaces=tuple(_surface(surface, homes) for surface in robot.wrap_surfaces),
        loops=tuple(_loop(loop, homes) for loop in robot.loops),
    )


def _muscle(muscle: Muscle, homes: Homes) -> Muscle:
    points = tuple(_via_point(point, homes) for point in muscle.via_points)
    wraps = tuple(
        wrap
        if wrap.side_point is None
        else replace(wrap, side_point=_via_point(wrap.side_point, homes))
        for wrap in muscle.wraps
    )
    return replace(muscle, via_points=points, wraps=wraps)


def _via_point(point: ViaPoint, homes: Homes) -> ViaPoint:
    home, T_home_link = homes[point.link]
    R = rotation(T_home_link.rpy)
    moves = tuple(replace(move, axis=rotate(R, move.axis)) for move in point.moves)
    return replace(point, link=home, position=apply(T_home_link, point.position), moves=moves)


def _task_frame(frame: TaskFrame, homes: Homes) -> TaskFrame:
    home, T_home_link = homes[frame.link]
    if frame.is_orientation:
        return replace(frame, link=home)
    return replace(frame, link=home, position=apply(T_home_link, frame.position))


def _loop(loop: LoopJoint, homes: Homes) -> LoopJoint:
    (parent, T_home_parent), (child, T_home_child) = homes[loop.parent], homes[loop.child]
    return replace(
        loop,
        parent=parent,
        child=child,
        T_parent_joint=compose(T_home_parent, loop.T_parent_joint),
        T_child_joint=compose(T_home_child, loop.T_child_joint),
    )


def _surface(surface: WrapSurface, homes: Homes) -> WrapSurface:
    home, T_home_link = homes[surface.link]
    return replace(surface, link=home, pose=compose(T_home_link, surface.pose))
