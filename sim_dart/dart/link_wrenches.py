"""Generalised forces of external wrenches on links."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from addin_sdfusion.robot import UnknownNameError
from sim_dart.core.arrays import FloatArray

from .skeleton import Skeleton


class LinkWrenches:
    """Sum of J_b(q)'w over several links.

    Args:
        skeleton: The robot in DART.

    Raises:
        UnknownNameError: A link does not exist.
    """

    def __init__(self, skeleton: Skeleton, links: Sequence[str]) -> None:
        for link in links:
            if skeleton.bodies.get(link) is None:
                names = [name for name, body in skeleton.bodies.items() if body is not None]
                raise UnknownNameError("link", link, names)
        self._skeleton = skeleton
        self._bodies = [skeleton.bodies[link] for link in links]
        first = 0
        columns: dict[str, int] = {}
        for dart in skeleton.darts:
            for k in range(dart.getNumBodyNodes()):
                columns[dart.getBodyNode(k).getName()] = first
            first += dart.getNumDofs()
        self._n = first
        self._columns = [
            columns[link] + np.array(_moving(body), dtype=int)
            for link, body in zip(links, self._bodies, strict=True)
        ]

    @property
    def size(self) -> int:
        """Number of values, six per link."""
        return 6 * len(self._bodies)

    def torques(self, wrenches: FloatArray) -> FloatArray:
        """Return the generalised forces at the current positions of the skeleton, shape (n,).

        Args:
            wrenches: Force and torque at the frame origin of each link, world axes, shape (6 k,),
                in [N] and [N·m].
        """
        total = np.zeros(self._n)
        rows = wrenches.reshape(-1, 6)
        for body, columns, wrench in zip(self._bodies, self._columns, rows, strict=True):
            if columns.size:
                J = body.getWorldJacobian(np.zeros(3))  # rows: angular, then linear
                total[columns] += J[:3].T @ wrench[3:] + J[3:].T @ wrench[:3]
        return self._skeleton.vector(total)


def _moving(body: Any) -> list[int]:
    """Return the indices of the degrees of freedom that move a body."""
    count = body.getNumDependentGenCoords()
    return [body.getDependentGenCoordIndex(k) for k in range(count)]
