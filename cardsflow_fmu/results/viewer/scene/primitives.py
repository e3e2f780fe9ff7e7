"""Shapes as balls, rods and cones, which viewers draw in batches."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray

from .shapes import (
    Arrow,
    Capsule,
    Colour,
    Cylinder,
    Frame,
    Line,
    Shape,
    Sphere,
    Trail,
    Triangles,
)

Kind = Literal["ball", "rod", "cone"]

AXES: tuple[Colour, ...] = ((214, 58, 58), (52, 160, 76), (52, 104, 220))
_HEAD_LENGTH, _HEAD_RADIUS = 13.0, 4.5  # size of an arrow head, as multiple of the shaft radius


class Body(NamedTuple):
    """Ball at a, or rod or cone from a to b.

    Attributes:
        kind: `ball`, `rod`, or `cone` with its tip at b.
        a, b: Points, shape (3,), in [m].
        radius: Radius, in [m].
        colour: Red, green and blue.
    """

    kind: Kind
    a: FloatArray
    b: FloatArray
    radius: float
    colour: Colour


def bodies(shapes: Iterable[Shape]) -> Iterator[Body]:
    """Yield the bodies of shapes; labels and meshes have no bodies."""
    for shape in shapes:
        match shape:
            case Line(colour=colour, path=path, radius=radius):
                yield from (Body("rod", a, b, radius, colour) for a, b in pairwise(path))
                yield from (Body("ball", p, p, radius, colour) for p in path[1:-1])
            case Trail(colour=colour, path=path, radius=radius):
                yield from (Body("ball", p, p, radius, colour) for p in path)
            case Sphere(colour=colour, centre=p, radius=radius):
                yield Body("ball", p, p, radius, colour)
            case Capsule(colour=colour, start=a, end=b, radius=radius):
                yield Body("rod", a, b, radius, colour)
                yield from (Body("ball", p, p, radius, colour) for p in (a, b))
            case Cylinder(colour=colour, start=a, end=b, radius=radius):
                yield Body("rod", a, b, radius, colour)
            case Arrow():
                yield from _arrow(shape)
            case Frame(points=points, radius=radius):
                for tip, colour in zip(points[1:], AXES, strict=True):
                    yield Body("rod", points[0], tip, radius, colour)


def _arrow(arrow: Arrow) -> Iterator[Body]:
    length = float(np.linalg.norm(arrow.end - arrow.start))
    if length < 0.5 * arrow.radius:
        return
    head = min(_HEAD_LENGTH * arrow.radius, 0.6 * length)
    neck = arrow.end + (arrow.start - arrow.end) * (head / length)
    yield Body("rod", arrow.start, neck, arrow.radius, arrow.colour)
    radius = min(_HEAD_RADIUS * arrow.radius, 0.6 * head)
    yield Body("cone", neck, arrow.end, radius, arrow.colour)


def unit_body(kind: Kind) -> Triangles:
    """Return a ball of radius 1 at the origin, or a rod or cone of radius 1 up to z = 1."""
    rings = np.linspace(0.0, np.pi, 9)
    profiles = {
        "ball": np.column_stack([np.sin(rings), -np.cos(rings)]),
        "rod": np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 1.0], [0.0, 1.0]]),
        "cone": np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
    }
    return _revolve(profiles[kind], around=16)


def _revolve(profile: FloatArray, around: int) -> Triangles:
    """Return the surface of revolution of a profile (radius, z) about the z axis."""
    angles = 2.0 * np.pi * np.arange(around) / around
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    vertices = np.concatenate([np.column_stack([r * ring, np.full(around, z)]) for r, z in profile])
    first = np.arange(around)
    second = (first + 1) % around
    faces = []
    for level in range(len(profile) - 1):
        low, high = level * around, (level + 1) * around
        faces.append(np.column_stack([low + first, low + second, high + second]))
        faces.append(np.column_stack([low + first, high + second, high + first]))
    return Triangles(vertices, np.concatenate(faces))


def rotations_from_z(vectors: FloatArray) -> FloatArray:
    """Return quaternions (w, x, y, z) that rotate the z axis to vectors of shape (N, 3)."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    z = np.divide(
        vectors, lengths, out=np.tile([0.0, 0.0, 1.0], (len(vectors), 1)), where=lengths > 0
    )
    w = 1.0 + z[:, 2:]  # (1 + cos, axis sin): twice the half-angle quaternion, before normalisation
    halves = np.hstack([w, -z[:, 1:2], z[:, 0:1], np.zeros_like(w)])
    halves[w[:, 0] < 1e-9] = (0.0, 1.0, 0.0, 0.0)
    unit: FloatArray = halves / np.linalg.norm(halves, axis=1, keepdims=True)
    return unit
