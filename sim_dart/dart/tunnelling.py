"""Bound on the speeds of bodies, above which one could pass through another between two steps.

DART searches for contacts at the steps alone. Two bodies that approach at the speed v overlap by up
to v h when DART finds their contact, and separate again to the same side as long as that is less
than a part of their thickness: 0.6 of the sum of both half thicknesses; for a cylinder, which ODE
keeps apart less well, half of the smaller half thickness. Below that nothing passes; above it, and
near enough to meet within the step, the run ends here, not with a body on the wrong side.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from addin_sdfusion.robot import Pose
from sim_dart.core.arrays import FloatArray
from sim_dart.core.frames import transform

from .shapes import SolidShape

_OF_BOTH = 0.6
_OF_A_CYLINDER = 0.5


@dataclass(frozen=True)
class WatchedBody:
    """A body that collides.

    Attributes:
        name: Its name.
        body: The body of DART.
        shapes: Its shapes with their poses in the body's frame.
        moves: Whether it can move at all.
    """

    name: str
    body: Any
    shapes: tuple[tuple[SolidShape, Pose], ...]
    moves: bool

    @property
    def thinnest(self) -> float:
        """Half of the smallest thickness of its shapes, in [m]."""
        return min(solid.thinnest for solid, _ in self.shapes)

    @property
    def radius(self) -> float:
        """Of a sphere about its frame's origin that holds it all, in [m]."""
        return max(
            float(np.linalg.norm(_middle(solid, pose)) + np.linalg.norm(solid.half))
            for solid, pose in self.shapes
        )

    @property
    def has_cylinder(self) -> bool:
        """Whether one of its shapes is a cylinder."""
        return any(solid.is_cylinder for solid, _ in self.shapes)


@dataclass(frozen=True)
class TooFast:
    """Two bodies that could pass through one another.

    Attributes:
        first, second: Their names; the first is the faster one.
        speed: Bound on the approach of their points, in [m/s].
        step: A step that is short enough, in [s].
    """

    first: str
    second: str
    speed: float
    step: float


class SpeedWatch:
    """Check of all pairs of bodies that collide.

    Args:
        bodies: The bodies.
        ignored: Pairs of names that pass through one another anyway.
        step: In [s].
    """

    def __init__(
        self, bodies: Sequence[WatchedBody], ignored: Collection[frozenset[str]], step: float
    ) -> None:
        self._bodies = sorted(bodies, key=lambda body: not body.moves)
        self._step = step
        self._movers = [body.body for body in self._bodies if body.moves]
        self._radii = np.array([body.radius for body in self._bodies])
        self._bounds = self._pair_bounds(ignored)
        smallest = self._bounds.min(initial=np.inf)
        self._harmless = 0.5 * smallest / step
        """Speed of points below which no two bodies approach too fast, in [m/s]."""

    def too_fast(self) -> TooFast | None:
        """The first two bodies that could pass through one another in a step; None if none can."""
        twists = np.array([body.getSpatialVelocity() for body in self._movers]).reshape(-1, 6)
        turning = np.sqrt(np.einsum("ij,ij->i", twists[:, :3], twists[:, :3]))
        moving = np.sqrt(np.einsum("ij,ij->i", twists[:, 3:], twists[:, 3:]))
        speeds = moving + turning * self._radii[: len(self._movers)]
        if not len(speeds) or speeds.max() <= self._harmless:
            return None
        return self._worst_pair(speeds)

    def _pair_bounds(self, ignored: Collection[frozenset[str]]) -> FloatArray:
        """Largest approach of two bodies in a step, shape (movers, bodies), in [m]."""
        bounds = np.full((len(self._movers), len(self._bodies)), np.inf)
        for i in range(len(self._movers)):
            for j in range(i + 1, len(self._bodies)):
                one, other = self._bodies[i], self._bodies[j]
                if frozenset((one.name, other.name)) not in ignored:
                    bounds[i, j] = _bound(one, other)
        return bounds

    def _worst_pair(self, speeds: FloatArray) -> TooFast | None:
        every = np.concatenate([speeds, np.zeros(len(self._bodies) - len(speeds))])
        approach = speeds[:, None] + every[None, :]
        for i, j in np.argwhere(approach * self._step > self._bounds):
            speed = float(approach[i, j])
            if _gap(self._bodies[i], self._bodies[j]) <= speed * self._step:
                fast, slow = (i, j) if every[i] >= every[j] else (j, i)
                step = float(self._bounds[i, j]) / speed
                return TooFast(self._bodies[fast].name, self._bodies[slow].name, speed, step)
        return None


def _middle(solid: SolidShape, pose: Pose) -> FloatArray:
    """Return the middle of a shape in its body's frame, shape (3,), in [m]."""
    T = transform(pose)
    middle: FloatArray = T[:3, :3] @ solid.centre + T[:3, 3]
    return middle


def _bound(one: WatchedBody, other: WatchedBody) -> float:
    if one.has_cylinder or other.has_cylinder:
        return _OF_A_CYLINDER * min(one.thinnest, other.thinnest)
    return _OF_BOTH * (one.thinnest + other.thinnest)


def _gap(one: WatchedBody, other: WatchedBody) -> float:
    """Return a lower bound on the distance of two bodies, in [m]; may be negative."""
    return max(_clearance(one, other), _clearance(other, one))


def _clearance(ball: WatchedBody, boxes: WatchedBody) -> float:
    """From the sphere that holds one body to the boxes that hold the other's shapes, in [m]."""
    centre = np.append(ball.body.getWorldTransform().translation(), 1.0)
    T_world_body = boxes.body.getWorldTransform().matrix()
    nearest = np.inf
    for solid, pose in boxes.shapes:
        point = np.linalg.solve(T_world_body @ transform(pose), centre)[:3] - solid.centre
        outside = np.maximum(np.abs(point) - solid.half, 0.0)
        nearest = min(nearest, float(np.linalg.norm(outside)))
    return nearest - ball.radius
