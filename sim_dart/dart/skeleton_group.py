"""Group of DART skeletons, one for every kinematic tree.

Contacts couple all joints of a skeleton, and their cost grows with the square of the number of
joints. Twenty robots in contact are about 100 times as slow as one robot if they are one skeleton,
and about 15 times as slow if they are twenty skeletons.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from addin_sdfusion.robot import WORLD, Robot
from sim_dart.core.arrays import FloatArray

from .skeleton import Skeleton, build_skeleton


def trees(robot: Robot) -> list[Robot]:
    """Return each kinematic tree as a robot without muscles, in the order of their first joints."""
    root = {WORLD: ""}
    for joint in robot.joints:
        root[joint.child] = joint.child if joint.parent == WORLD else root[joint.parent]
    bare = replace(robot, cable_sets=(), cable_set="", task_sets=(), task_set="")
    return [
        replace(
            bare,
            links=tuple(link for link in robot.links if root[link.name] == first),
            joints=tuple(joint for joint in robot.joints if root[joint.child] == first),
        )
        for first in (joint.child for joint in robot.joints if joint.parent == WORLD)
    ]


def build_skeletons(robot: Robot) -> Skeleton:
    """Create the skeletons of a robot, one for every kinematic tree.

    Args:
        robot: A valid robot.

    Raises:
        InputError: The mass matrix of a tree is singular.
    """
    robots = trees(robot)
    if len(robots) == 1:
        return build_skeleton(robot)
    names = [c.name for each in robots for c in each.coordinates]
    order = [names.index(c.name) for c in robot.coordinates]
    return SkeletonGroup([build_skeleton(each) for each in robots], order)


class SkeletonGroup(Skeleton):
    """Several skeletons with the interface of one.

    Args:
        order: Index of every coordinate of the robot in the concatenated coordinates of the parts.
    """

    def __init__(self, skeletons: Sequence[Skeleton], order: list[int]) -> None:
        bodies = {name: body for skeleton in skeletons for name, body in skeleton.bodies.items()}
        self._skeletons = list(skeletons)
        super().__init__(_ConcatenatedSkeletons(skeletons), bodies, order)

    @property
    def darts(self) -> list[Any]:
        """The skeletons of DART."""
        return [dart for skeleton in self._skeletons for dart in skeleton.darts]


class _ConcatenatedSkeletons:
    """Interface of a dartpy Skeleton for several concatenated skeletons."""

    def __init__(self, skeletons: Sequence[Skeleton]) -> None:
        self._skeletons = list(skeletons)
        counts = [skeleton.dart.getNumDofs() for skeleton in skeletons]
        ends = np.cumsum(counts).tolist()
        self._slices = [slice(end - n, end) for end, n in zip(ends, counts, strict=True)]

    def getPositions(self) -> FloatArray:
        return np.concatenate([skeleton.get_positions() for skeleton in self._skeletons])

    def getVelocities(self) -> FloatArray:
        return np.concatenate([skeleton.get_velocities() for skeleton in self._skeletons])

    def getExternalForces(self) -> FloatArray:
        return np.concatenate([each.get_external_forces() for each in self._skeletons])

    def setPositions(self, values: FloatArray) -> None:
        for skeleton, rows in zip(self._skeletons, self._slices, strict=True):
            skeleton.set_positions(values[rows])

    def setVelocities(self, values: FloatArray) -> None:
        for skeleton, rows in zip(self._skeletons, self._slices, strict=True):
            skeleton.set_velocities(values[rows])

    def setForces(self, values: FloatArray) -> None:
        for skeleton, rows in zip(self._skeletons, self._slices, strict=True):
            skeleton.set_forces(values[rows])

    def resetAccelerations(self) -> None:
        for skeleton in self._skeletons:
            skeleton.dart.resetAccelerations()
