"""Robot -> dartpy Skeleton, built from the description; fixes the order of coordinates."""

from __future__ import annotations

import math
from typing import Any

import dartpy
import numpy as np

from addin_sdfusion.robot import WORLD, Joint, Link, Robot

from .frames import transform

_CREATE = {
    "revolute": "createRevoluteJointAndBodyNodePair",
    "prismatic": "createPrismaticJointAndBodyNodePair",
    "fixed": "createWeldJointAndBodyNodePair",
}


def _set_geometry(dart_joint: Any, joint: Joint) -> None:
    dart_joint.setName(joint.name)
    dart_joint.setTransformFromParentBodyNode(
        dartpy.math.Isometry3(transform(joint.T_parent_joint))
    )
    dart_joint.setTransformFromChildBodyNode(dartpy.math.Isometry3(transform(joint.T_child_joint)))
    if joint.type != "fixed":
        dart_joint.setAxis(np.array(joint.axis) / np.linalg.norm(joint.axis))


def _set_coordinates(dart_joint: Any, joint: Joint) -> None:
    """Names; viscous damping; limits where there are any, as inelastic stops."""
    for k, coordinate in enumerate(joint.coordinates):
        dart_joint.setDofName(k, coordinate.name, True)
        dart_joint.setDampingCoefficient(k, coordinate.damping)
        if math.isfinite(coordinate.lower) or math.isfinite(coordinate.upper):
            dart_joint.setPositionLowerLimit(k, coordinate.lower)
            dart_joint.setPositionUpperLimit(k, coordinate.upper)
            dart_joint.setLimitEnforcement(True)


def _set_inertia(body: Any, link: Link) -> None:
    """Set through the body: an Inertia object complains of zero moments on the console."""
    inertia = link.inertia
    body.setName(link.name)
    body.setMass(inertia.mass)
    body.setLocalCOM(np.array(inertia.com))
    body.setMomentOfInertia(
        inertia.ixx, inertia.iyy, inertia.izz, inertia.ixy, inertia.ixz, inertia.iyz
    )


def build_skeleton(robot: Robot) -> Any:
    """The robot as a dartpy Skeleton; its degrees of freedom are robot.coordinates, in order.

    Args:
        robot: A valid robot.
    """
    skeleton = dartpy.dynamics.Skeleton(robot.name)
    bodies: dict[str, Any] = {WORLD: None}
    for joint in robot.joints:
        dart_joint, body = getattr(skeleton, _CREATE[joint.type])(bodies[joint.parent])
        _set_geometry(dart_joint, joint)
        _set_inertia(body, robot.link(joint.child))
        _set_coordinates(dart_joint, joint)
        bodies[joint.child] = body
    skeleton.setGravity(np.array(robot.gravity))
    names = [skeleton.getDof(k).getName() for k in range(skeleton.getNumDofs())]
    assert names == [c.name for c in robot.coordinates], names
    return skeleton
