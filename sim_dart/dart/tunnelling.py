"""Check for tunnelling: fast bodies that could pass through each other between two steps.

DART detects contacts only at steps. Two bodies with approach speed v overlap by up to v h when DART
detects their contact. They separate to the correct side if this overlap is less than 0.6 of the sum
of both half thicknesses. ODE separates cylinders less reliably. For these the bound is half of the
smaller half thickness. If two bodies exceed this bound and are near enough to collide within the
step, the simulation stops with an error.
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
    """Body that is checked for tunnelling."""

    name: str
    body: Any
    shapes: tuple[tuple[SolidShape, Pose], ...]
    moves: bool

    @property
    def thinnest(self) -> float:
        """Half of the smallest thickness of all shapes, in [m]."""
        return min(solid.thinnest for solid, _ in self.shapes)

    @property
    def radius(self) -> float:
        """Radius of the bounding sphere about the frame origin, in [m]."""
        return max(
            float(np.linalg.norm(_middle(solid, pose)) + np.linalg.norm(solid.half))
            for solid, pose in self.shapes
        )

    @property
    def has_cylinder(self) -> bool:
        """Whether any shape is a cylinder."""
        return any(solid.is_cylinder for solid, _ in self.shapes)


@dataclass(frozen=True)
class TooFast:
    """Pair of bodies that could pass through each other.

    Attributes:
        first, second: Names of the bodies; the first is the faster one.
        speed: Bound on the approach speed of their points, in [m/s].
        step: A sufficiently small step, in [s].
    """

    first: str
    second: str
    speed: float
    step: float


class SpeedWatch:
    """Tunnelling check for all pairs of bodies that can collide."""

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
        """Speed of points below which no pair of bodies is too fast, in [m/s]."""

    def too_fast(self) -> TooFast | None:
        """Return the first pair that could pass through each other in a step, or None."""
        twists = np.array([body.getSpatialVelocity() for body in self._movers]).reshape(-1, 6)
        turning = np.sqrt(np.einsum("ij,ij->i", twists[:, :3], twists[:, :3]))
        moving = np.sqrt(np.einsum("ij,ij->i", twists[:, 3:], twists[:, 3:]))
        speeds = moving + turning * self._radii[: len(self._movers)]
        if not len(speeds) or speeds.max() <= self._harmless:
            return None
        return self._worst_pair(speeds)

    def _pair_bounds(self, ignored: Collection[frozenset[str]]) -> FloatArray:
        """Return the allowed approach of pairs in a step, shape (movers, bodies), in [m]."""
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
    """Return the centre of a shape in the body frame, shape (3,), in [m]."""
    T = transform(pose)
    middle: FloatArray = T[:3, :3] @ solid.centre + T[:3, 3]
    return middle


def _bound(one: WatchedBody, other: WatchedBody) -> float:
    if one.has_cylinder or other.has_cylinder:
        return _OF_A_CYLINDER * min(one.thinnest, other.thinnest)
    return _OF_BOTH * (one.thinnest + other.thinnest)


def _gap(one: WatchedBody, other: WatchedBody) -> float:
    """Return a lower bound on the distance of two bodies, in [m]; can be negative."""
    return max(_clearance(one, other), _clearance(other, one))


def _clearance(ball: WatchedBody, boxes: WatchedBody) -> float:
    """Return the distance of the bounding sphere of a body from the bounding boxes of another."""
    centre = np.append(ball.body.getWorldTransform().translation(), 1.0)
    T_world_body = boxes.body.getWorldTransform().matrix()
    nearest = np.inf
    for solid, pose in boxes.shapes:
        point = np.linalg.solve(T_world_body @ transform(pose), centre)[:3] - solid.centre
        outside = np.maximum(np.abs(point) - solid.half, 0.0)
        nearest = min(nearest, float(np.linalg.norm(outside)))
    return nearest - ball.radius
