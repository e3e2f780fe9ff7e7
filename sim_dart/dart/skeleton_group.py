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
    parts = trees(robot)
    if len(parts) == 1:
        return build_skeleton(robot)
    names = [c.name for part in parts for c in part.coordinates]
    order = [names.index(c.name) for c in robot.coordinates]
    return SkeletonGroup([build_skeleton(part) for part in parts], order)


class SkeletonGroup(Skeleton):
    """Several skeletons with the interface of one.

    Args:
        order: Index of every coordinate of the robot in the concatenated coordinates of the parts.
    """

    def __init__(self, parts: Sequence[Skeleton], order: list[int]) -> None:
        bodies = {name: body for part in parts for name, body in part.bodies.items()}
        self._parts = list(parts)
        super().__init__(_ConcatenatedSkeletons(parts), bodies, order)

    @property
    def darts(self) -> list[Any]:
        """The skeletons of DART."""
        return [dart for part in self._parts for dart in part.darts]


class _ConcatenatedSkeletons:
    """Interface of a dartpy Skeleton for several concatenated skeletons."""

    def __init__(self, parts: Sequence[Skeleton]) -> None:
        self._parts = list(parts)
        counts = [part.dart.getNumDofs() for part in parts]
        ends = np.cumsum(counts).tolist()
        self._slices = [slice(end - n, end) for end, n in zip(ends, counts, strict=True)]

    def getPositions(self) -> FloatArray:
        return np.concatenate([part.get_positions() for part in self._parts])

    def getVelocities(self) -> FloatArray:
        return np.concatenate([part.get_velocities() for part in self._parts])

    def setPositions(self, values: FloatArray) -> None:
        for part, rows in zip(self._parts, self._slices, strict=True):
            part.set_positions(values[rows])

    def setVelocities(self, values: FloatArray) -> None:
        for part, rows in zip(self._parts, self._slices, strict=True):
            part.set_velocities(values[rows])

    def setForces(self, values: FloatArray) -> None:
        for part, rows in zip(self._parts, self._slices, strict=True):
            part.set_forces(values[rows])

    def resetAccelerations(self) -> None:
        for part in self._parts:
            part.dart.resetAccelerations()

    def getMass(self) -> float:
        return float(sum(part.dart.getMass() for part in self._parts))

    def getCOM(self) -> FloatArray:
        moments: FloatArray = sum(
            (part.dart.getMass() * part.dart.getCOM() for part in self._parts), np.zeros(3)
        )
        return moments / self.getMass()

    def computeKineticEnergy(self) -> float:
        return float(sum(part.dart.computeKineticEnergy() for part in self._parts))

    def getNumDofs(self) -> int:
        return self._slices[-1].stop if self._slices else 0

    def getNumBodyNodes(self) -> int:
        return len(self._bodies())

    def getBodyNode(self, index: int) -> Any:
        return self._bodies()[index]

    def _bodies(self) -> list[Any]:
        darts = [part.dart for part in self._parts]
        return [dart.getBodyNode(k) for dart in darts for k in range(dart.getNumBodyNodes())]
