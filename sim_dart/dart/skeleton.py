"""Skeleton of DART for a robot, with values in the order of the robot's coordinates."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from addin_sdfusion.robot import WORLD, Coordinate, InputError, Joint, Link, Pose, Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.core.frames import transform
from sim_dart.core.mass_check import require_inertia

_CREATE = {
    "rotation": "createRevoluteJointAndBodyNodePair",
    "translation": "createPrismaticJointAndBodyNodePair",
}
_NEGLIGIBLE_MASS = 1e-300  # in [kg]; negligible in all sums, since DART prints a warning for zero


class Skeleton:
    """Robot in DART. All values are in the order of the robot's coordinates.

    Args:
        dart: The dartpy Skeleton. Every joint is a chain of one-dimensional joints.
        bodies: Body of each link, by name.
        order: Index of the degree of freedom of DART for every coordinate.

    Attributes:
        get_positions, get_velocities: Return q and qd, shape (n,), as new arrays.
        get_external_forces: Return the generalised forces of external forces on bodies, shape (n,).
        set_positions, set_velocities, set_forces: Set values from an array of shape (n,).
    """

    def __init__(self, dart: Any, bodies: dict[str, Any], order: list[int]) -> None:
        self.dart = dart
        self.bodies = bodies
        self._order = None if order == list(range(len(order))) else np.array(order)
        self.get_positions = self._getter(dart.getPositions)
        self.get_velocities = self._getter(dart.getVelocities)
        self.get_external_forces = self._getter(dart.getExternalForces)
        self.set_positions = self._setter(dart.setPositions)
        self.set_velocities = self._setter(dart.setVelocities)
        self.set_forces = self._setter(dart.setForces)

    @property
    def darts(self) -> list[Any]:
        """The skeletons of DART."""
        return [self.dart]

    def vector(self, values: FloatArray) -> FloatArray:
        """Reorder values of DART's degrees of freedom to the coordinates, shape (n,)."""
        return values if self._order is None else values[self._order]

    def matrix(self, values: FloatArray) -> FloatArray:
        """Reorder a matrix of DART's degrees of freedom to the coordinates, shape (n, n)."""
        return values if self._order is None else values[np.ix_(self._order, self._order)]

    def _getter(self, get: Callable[[], FloatArray]) -> Callable[[], FloatArray]:
        """Return a getter in the order of the coordinates, which is DART's if both are equal."""
        order = self._order
        return get if order is None else lambda: get()[order]

    def _setter(self, put: Callable[[FloatArray], None]) -> Callable[[FloatArray], None]:
        if self._order is None:
            return put
        inverse = np.argsort(self._order)
        return lambda values: put(values[inverse])


def build_skeleton(robot: Robot) -> Skeleton:
    """Create the skeleton of a robot.

    Args:
        robot: A valid robot.

    Raises:
        InputError: The mass matrix is singular.
    """
    import dartpy

    _reject_driven(robot)
    skeleton = dartpy.dynamics.Skeleton(robot.name)
    skeleton.setGravity(np.array(robot.gravity))
    bodies: dict[str, Any] = {WORLD: None}
    for joint in robot.joints:
        body = _add_joint(skeleton, bodies[joint.parent], joint)
        _set_inertia(body, robot.link(joint.child))
        bodies[joint.child] = body
    require_inertia(robot, skeleton.getMassMatrix())
    dofs = [skeleton.getDof(k).getName() for k in range(skeleton.getNumDofs())]
    return Skeleton(skeleton, bodies, [dofs.index(c.name) for c in robot.coordinates])


def _reject_driven(robot: Robot) -> None:
    """Reject features of joints that DART does not support."""
    problem = "are only supported by the engine 'core', not by DART"
    for joint in robot.driven_joints:
        raise InputError(f"joint {joint.name!r}: functions, couplings and locks {problem}")
    for c in robot.coordinates:
        if c.armature or c.limit_force:
            raise InputError(f"coordinate {c.name!r}: armatures and limit forces {problem}")


def _add_joint(skeleton: Any, parent: Any, joint: Joint) -> Any:
    """Add a joint as a chain of one-dimensional joints, and return the body at its end."""
    if not joint.motions:
        dart_joint, body = skeleton.createWeldJointAndBodyNodePair(parent)
        dart_joint.setName(joint.name)
        _set_ends(dart_joint, joint, first=True, last=True)
        return body
    body, last = parent, len(joint.motions) - 1
    for k, motion in enumerate(joint.motions):
        dart_joint, body = getattr(skeleton, _CREATE[motion.kind])(body)
        dart_joint.setName(joint.name if k == last else f"{joint.name}/{k}")
        dart_joint.setAxis(np.array(motion.axis) / np.linalg.norm(motion.axis))
        _set_ends(dart_joint, joint, first=k == 0, last=k == last)
        _set_coordinate(dart_joint, joint.coordinates[motion.coordinate])
        if k != last:
            _make_massless(body, f"{joint.name}/{k}")
    return body


def _set_ends(dart_joint: Any, joint: Joint, *, first: bool, last: bool) -> None:
    if first:
        dart_joint.setTransformFromParentBodyNode(_isometry(joint.T_parent_joint))
    if last:
        dart_joint.setTransformFromChildBodyNode(_isometry(joint.T_child_joint))


def _isometry(pose: Pose) -> Any:
    import dartpy

    return dartpy.math.Isometry3(transform(pose))


def _set_coordinate(dart_joint: Any, coordinate: Coordinate) -> None:
    """Set name, damping, spring, friction, and limits as inelastic stops."""
    dart_joint.setDofName(0, coordinate.name, True)
    dart_joint.setDampingCoefficient(0, coordinate.damping)
    if coordinate.stiffness:
        dart_joint.setSpringStiffness(0, coordinate.stiffness)
        dart_joint.setRestPosition(0, coordinate.rest)
    if coordinate.friction:
        dart_joint.setCoulombFriction(0, coordinate.friction)
    if math.isfinite(coordinate.lower) or math.isfinite(coordinate.upper):
        dart_joint.setPositionLowerLimit(0, coordinate.lower)
        dart_joint.setPositionUpperLimit(0, coordinate.upper)
        dart_joint.setLimitEnforcement(True)


def _set_inertia(body: Any, link: Link) -> None:
    """Set the inertia through the body, since an Inertia object warns about zero moments."""
    inertia = link.inertia
    body.setName(link.name)
    body.setMass(inertia.mass or _NEGLIGIBLE_MASS)
    body.setLocalCOM(np.array(inertia.com))
    body.setMomentOfInertia(*inertia.entries)


def _make_massless(body: Any, name: str) -> None:
    body.setName(name)
    body.setMass(_NEGLIGIBLE_MASS)
    body.setMomentOfInertia(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
