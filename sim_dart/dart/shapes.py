"""Conversion of shapes of a scene to shapes of DART, with size and mass properties."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from addin_sdfusion.robot import Pose
from sim_dart.core.arrays import FloatArray
from sim_dart.core.frames import transform
from sim_dart.scene import Box, Capsule, Cylinder, Scene, Shape, Sphere

from .meshes import convex_hull, dart_mesh


@dataclass(frozen=True)
class SolidShape:
    """Solid shape of DART with its properties.

    Attributes:
        dart: The shape of DART.
        centre: Centre of the bounding box in the shape frame, shape (3,), in [m].
        half: Half edge lengths of the bounding box, shape (3,), in [m].
        thinnest: Half of the smallest thickness, in [m].
        com: Centre of mass in the shape frame, shape (3,), in [m].
        gyration: Inertia matrix about the centre of mass for a mass of 1, shape (3, 3), in [m²].
        is_cylinder: Whether the shape is a cylinder, which ODE separates less reliably.
    """

    dart: Any
    centre: FloatArray
    half: FloatArray
    thinnest: float
    com: FloatArray
    gyration: FloatArray
    is_cylinder: bool = False


def solid_shape(shape: Shape) -> SolidShape:
    """Create the solid shape of DART for a shape of a scene."""
    import dartpy

    shapes = dartpy.dynamics
    zero = np.zeros(3)
    if isinstance(shape, Sphere):
        r = shape.radius
        return _primitive(shapes.SphereShape(r), np.full(3, r), r)
    if isinstance(shape, Box):
        half = 0.5 * np.array(shape.size)
        return _primitive(shapes.BoxShape(2.0 * half), half, float(half.min()))
    if isinstance(shape, Capsule):
        r, length = shape.radius, shape.length
        half = np.array([r, r, 0.5 * length + r])
        return _primitive(shapes.CapsuleShape(r, length), half, r)
    if isinstance(shape, Cylinder):
        r, half_length = shape.radius, 0.5 * shape.length
        dart = shapes.CylinderShape(r, shape.length)
        half = np.array([r, r, half_length])
        gyration = dart.computeInertia(1.0)
        return SolidShape(dart, zero, half, min(r, half_length), zero, gyration, True)
    hull = convex_hull(shape.file, shape.scale)
    low, high = np.asarray(hull.bounds, float)
    return SolidShape(
        dart_mesh(hull),
        0.5 * (low + high),
        0.5 * (high - low),
        0.5 * float(np.min(hull.bounding_box_oriented.primitive.extents)),
        np.asarray(hull.center_mass, float),
        np.asarray(hull.moment_inertia, float) / float(hull.mass),
    )


def _primitive(dart: Any, half: FloatArray, thinnest: float) -> SolidShape:
    zero = np.zeros(3)
    return SolidShape(dart, zero, half, thinnest, zero, dart.computeInertia(1.0))


@dataclass(frozen=True)
class Surface:
    """Friction and restitution of a body.

    Attributes:
        friction: Coefficient of Coulomb friction.
        restitution: Coefficient of restitution between two bodies with this value.
    """

    friction: float
    restitution: float


def surface(scene: Scene, friction: float | None, restitution: float | None) -> Surface:
    """Return friction and restitution of a body, with the values of the scene as default."""
    return Surface(
        scene.friction if friction is None else friction,
        scene.restitution if restitution is None else restitution,
    )


def attach(body: Any, solid: SolidShape, pose: Pose, rough: Surface) -> Any:
    """Attach a collision shape to a body.

    DART multiplies the restitutions of both bodies, so each body has the square root of its value.

    Args:
        pose: Pose of the shape in the body frame.
        rough: Friction and restitution.

    Returns:
        The shape node of DART, to which contacts refer.
    """
    import dartpy

    node = body.createShapeNode(solid.dart)
    node.setRelativeTransform(dartpy.math.Isometry3(transform(pose)))
    node.createCollisionAspect()
    node.createDynamicsAspect()
    aspect = node.getDynamicsAspect()
    aspect.setFrictionCoeff(rough.friction)
    aspect.setRestitutionCoeff(float(np.sqrt(rough.restitution)))
    return node
