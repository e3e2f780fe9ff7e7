"""A robot, or several, as one DART skeleton for every tree of joints.

Contacts couple all of a skeleton's joints, and their cost grows with the square of their number:
twenty robots in contact as one skeleton cost some hundred times one, as twenty some fifteen times.
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
    """The robot's trees, each as a robot without muscles, in the order of their first joints."""
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
    """Return the robot in DART, a skeleton a tree.

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
    """Several skeletons, read and written as one.

    Args:
        parts: The skeletons.
        order: For every coordinate of the whole, its index among those of the parts in a row.
    """

    def __init__(self, parts: Sequence[Skeleton], order: list[int]) -> None:
        bodies = {name: body for part in parts for name, body in part.bodies.items()}
        self._parts = list(parts)
        super().__init__(_Row(parts), bodies, order)

    @property
    def darts(self) -> list[Any]:
        """The skeletons of DART."""
        return [dart for part in self._parts for dart in part.darts]


class _Row:
    """The functions of a dartpy Skeleton that are used of several in a row."""

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
