"""Forces and moments that joints transmit along a motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import WORLD, Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.core.frames import transform
from sim_dart.muscles.paths import MusclePaths

from .link_motion import link_motion


class JointReactions(NamedTuple):
    """Wrenches of joints on their child links, world axes, about the joint frames of the children.

    A wrench contains everything that the joint transmits: constraint forces, and the torques of
    motors, reserves, springs, damping and friction along its axes. Muscles act on the links.

    Attributes:
        joints: j names.
        forces: Shape (T, j, 3), in [N].
        moments: Shape (T, j, 3), in [N·m].
    """

    joints: tuple[str, ...]
    forces: FloatArray
    moments: FloatArray


def joint_reactions(
    robot: Robot,
    motion: tuple[FloatArray, FloatArray, FloatArray],
    tensions: FloatArray,
    loads: tuple[Sequence[str], FloatArray, FloatArray] | None = None,
) -> JointReactions:
    """Return the wrenches that the joints of a robot without loops transmit.

    Args:
        robot: The robot, without closed loops.
        motion: q, qd and qdd, shape (T, n) each.
        tensions: Tensions of the muscles, shape (T, m), in [N].
        loads: Links, forces and moments of external wrenches about the origins of the links, world
            axes, shape (T, k, 3) each.
    """
    names = [link.name for link in robot.links]
    index, links = {name: k for k, name in enumerate(names)}, link_motion(robot, names, *motion)
    R, o = links.rotations, links.origins
    bend = np.moveaxis(links.accelerations[:, :, 1:] - links.accelerations[:, :, :1], -2, -1)
    forces, moments = np.zeros_like(o), np.zeros_like(o)  # needed, moments about the world's origin
    for k, link in enumerate(robot.links):
        inertia = link.inertia
        c, m = np.array(inertia.com), inertia.mass
        I = np.array(inertia.matrix)  # noqa: E741
        second = 0.5 * np.trace(I) * np.eye(3) - I + m * np.outer(c, c)  # integral of x x' dm
        pull = links.accelerations[:, k, 0] - np.array(robot.gravity)
        arm = np.einsum("tij,j->ti", R[:, k], c)
        forces[:, k] = m * (pull + np.einsum("tij,j->ti", bend[:, k], c))
        moments[:, k] = m * np.cross(arm, pull) + np.cross(o[:, k], forces[:, k])
        moments[:, k] += _axial(bend[:, k] @ second @ np.swapaxes(R[:, k], 1, 2))
    paths = MusclePaths(robot)
    for t in range(len(o)):
        pulls = paths.point_forces(motion[0][t], tensions[t])
        moved = np.array([index.get(name, len(names)) for name in pulls.links], dtype=int)
        on = moved < len(names)  # not on the world
        np.subtract.at(forces[t], moved[on], pulls.forces[on])
        np.subtract.at(moments[t], moved[on], np.cross(pulls.points[on], pulls.forces[on]))
    for k, name in enumerate(loads[0] if loads is not None else ()):
        assert loads is not None
        force, at = loads[1][:, k], index[name]
        forces[:, at] -= force
        moments[:, at] -= loads[2][:, k] + np.cross(o[:, at], force)
    for joint in reversed(robot.joints):
        if joint.parent != WORLD:
            forces[:, index[joint.parent]] += forces[:, index[joint.child]]
            moments[:, index[joint.parent]] += moments[:, index[joint.child]]
    children = [index[joint.child] for joint in robot.joints]
    centres = np.array([transform(joint.T_child_joint)[:3, 3] for joint in robot.joints])
    at = o[:, children] + np.einsum("tkij,kj->tki", R[:, children], centres.reshape(-1, 3))
    forces, moments = forces[:, children], moments[:, children]
    moments = moments - np.cross(at, forces)
    return JointReactions(tuple(joint.name for joint in robot.joints), forces, moments)


def _axial(A: FloatArray) -> FloatArray:
    """Return the moments of r x a for matrices of the sums of a r', shape (T, 3, 3)."""
    rows = A[:, 2, 1] - A[:, 1, 2], A[:, 0, 2] - A[:, 2, 0], A[:, 1, 0] - A[:, 0, 1]
    return np.stack(rows, axis=1)
