"""Masses of MJCF's bodies: as given, or of their geoms, then as the compiler's flags have them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from ...formats.reading.xml import ZERO, Node
from ...model.pose import Vector3
from ...model.robot import WORLD, Inertia
from ...model.rotations import (
    Matrix3,
    add,
    multiply,
    point_inertia,
    rotate_inertia,
    subtract,
    transpose,
)
from ...model.transform import IDENTITY, Transform
from .bodies import Body, Part
from .compiler import Compiler, numbers
from .meshes import MeshAssets
from .shapes import SIZES, WITHOUT_MASS, moments, place_of, shape_of, shell, sizes_of, volume

DENSITY = 1000.0
"""Of a geom that says neither its density nor its mass, in [kg/m³]."""
SWEEPS = 30
"""Of Jacobi's method: six are enough for digits of a double."""

Diagonal = tuple[float, float, float]


class _Lump(NamedTuple):
    """A rigid part of a body: mass, centre, inertia about the centre along the body's axes."""

    mass: float
    com: Vector3
    inertia: Matrix3


def read_inertias(
    bodies: Sequence[Body], compiler: Compiler, meshes: MeshAssets
) -> dict[str, Inertia]:
    """The inertia of every body but the world."""
    found = {
        body.name: _bounded(_own(body, compiler, meshes), compiler, body)
        for body in bodies
        if body.name != WORLD
    }
    total = sum(inertia.mass for inertia in found.values())
    if compiler.total_mass is None or not total > 0.0:
        return found
    factor = compiler.total_mass / total
    return {name: inertia.scaled(factor) for name, inertia in found.items()}


def _own(body: Body, compiler: Compiler, meshes: MeshAssets) -> Inertia:
    if compiler.from_geoms == "true" or (compiler.from_geoms == "auto" and body.inertial is None):
        return _of_geoms(body, compiler, meshes)
    return Inertia(0.0) if body.inertial is None else _given(body.inertial, compiler)


def _given(part: Part, compiler: Compiler) -> Inertia:
    node = part.node
    own = compiler.place(node)
    if not node.has("pos"):
        node.error("missing-attribute", "<inertial> has no 'pos'")
    T = own if part.T == IDENTITY else part.T.compose(own)
    mass = node.number_attribute("mass")
    if node.has("fullinertia"):
        xx, yy, zz, xy, xz, yz = node.numbers_attribute("fullinertia", 6)
        inertia = Inertia(mass, T.p, xx, yy, zz, xy, xz, yz)
    else:
        xx, yy, zz = node.vector_attribute("diaginertia") if node.has("diaginertia") else ZERO
        inertia = Inertia(mass, T.p, xx, yy, zz)
    if T.R == IDENTITY.R:
        return inertia
    return Inertia.of(mass, T.p, rotate_inertia(T.R, inertia.matrix))


def _of_geoms(body: Body, compiler: Compiler, meshes: MeshAssets) -> Inertia:
    lumps = [lump for part in body.geoms if (lump := _lump(part, compiler, meshes)) is not None]
    mass = sum(lump.mass for lump in lumps)
    if not mass > 0.0:
        return Inertia(0.0)
    com = ZERO
    for lump in lumps:
        x, y, z = lump.com
        share = lump.mass / mass
        com = add(com, (share * x, share * y, share * z))
    matrix = ((0.0, 0.0, 0.0),) * 3
    for lump in lumps:
        moved = point_inertia(lump.mass, subtract(lump.com, com))
        matrix = _sum(_sum(matrix, lump.inertia), moved)
    return Inertia.of(mass, com, matrix)


def _lump(part: Part, compiler: Compiler, meshes: MeshAssets) -> _Lump | None:
    """A geom's part of its body; None for one that has no mass."""
    node = part.node
    group = node.number_attribute("group", 0.0)
    kind = shape_of(node)
    first, last = compiler.groups
    if not first <= group <= last or kind in WITHOUT_MASS:
        return None
    given = node.number_attribute("mass", math.nan) if node.has("mass") else None
    density = node.number_attribute("density", DENSITY)
    if given == 0.0 or (given is None and density == 0.0):
        return None
    if kind == "mesh" or node.has("mesh") or kind not in SIZES:
        return _of_mesh(part, compiler, meshes, given, density)
    size = sizes_of(node)
    T = place_of(part, compiler)
    hollow = shell(kind, size) if node.attribute("shellinertia", "false") == "true" else None
    if hollow is not None and hollow[0] > 0.0:
        area, own = hollow
        mass = density * area if given is None else given
        a, b, c = (mass / area * moment for moment in own)
    else:
        if node.attribute("shellinertia", "false") == "true":
            node.error("unsupported-shell", f"the mass of a {kind} in its surface is not supported")
        mass = density * volume(kind, size) if given is None else given
        a, b, c = moments(kind, size, mass)
    return _Lump(mass, T.p, rotate_inertia(T.R, ((a, 0.0, 0.0), (0.0, b, 0.0), (0.0, 0.0, c))))


def _of_mesh(
    part: Part, compiler: Compiler, meshes: MeshAssets, given: float | None, density: float
) -> _Lump | None:
    solid = meshes.solid(part)
    if solid is None:
        return None
    if shape_of(part.node) != "mesh":
        problem = "a shape fitted to a mesh has the inertia of the mesh here, not that of the shape"
        part.node.warning("fitted-shape", problem)
    T: Transform = place_of(part, compiler)
    mass = density * solid.volume if given is None else given
    factor = mass / solid.volume
    rows = [tuple(factor * x for x in row) for row in solid.inertia]
    inertia: Matrix3 = (rows[0], rows[1], rows[2])  # type: ignore[assignment]
    return _Lump(mass, T.apply(solid.centre), rotate_inertia(T.R, inertia))


def _bounded(inertia: Inertia, compiler: Compiler, body: Body) -> Inertia:
    """With the least mass and moments, and moments that a body can have, as the flags say."""
    bounded = replace(inertia, mass=max(inertia.mass, compiler.least_mass))
    if not compiler.least_inertia and not compiler.balance:
        return bounded
    values, axes = principal(inertia.matrix)
    least = [max(value, compiler.least_inertia) for value in values]
    a, b, c = sorted(least)
    if compiler.balance and a + b < c:
        least = [(a + b + c) / 3.0] * 3
    if least == list(values):
        return bounded
    diagonal = ((least[0], 0.0, 0.0), (0.0, least[1], 0.0), (0.0, 0.0, least[2]))
    return Inertia.of(bounded.mass, inertia.com, rotate_inertia(axes, diagonal))


def principal(A: Matrix3) -> tuple[Diagonal, Matrix3]:
    """Moments and axes, column by column, of a symmetric matrix, by Jacobi's rotations."""
    V = IDENTITY.R
    if not all(math.isfinite(x) for row in A for x in row):
        return (A[0][0], A[1][1], A[2][2]), V
    for sweep in range(SWEEPS):
        i, j = ((0, 1), (0, 2), (1, 2))[sweep % 3]
        if A[i][j] == 0.0:
            continue
        angle = 0.5 * math.atan2(2.0 * A[i][j], A[j][j] - A[i][i])
        c, s = math.cos(angle), math.sin(angle)
        rows = [[float(k == m) for m in range(3)] for k in range(3)]
        rows[i][i] = rows[j][j] = c
        rows[i][j], rows[j][i] = s, -s
        G: Matrix3 = tuple(tuple(row) for row in rows)  # type: ignore[assignment]
        A = multiply(transpose(G), multiply(A, G))
        V = multiply(V, G)
    return (A[0][0], A[1][1], A[2][2]), V


def _sum(A: Matrix3, B: Matrix3) -> Matrix3:
    return add(A[0], B[0]), add(A[1], B[1]), add(A[2], B[2])


def masses_from_meshes(body: Body, compiler: Compiler) -> list[Node]:
    """The geoms of a body that have mass by a mesh."""
    if compiler.from_geoms == "false" or (compiler.from_geoms == "auto" and body.inertial):
        return []
    return [part.node for part in body.geoms if shape_of(part.node) == "mesh" and not _empty(part)]


def _empty(part: Part) -> bool:
    return numbers(part.node, "mass")[:1] == (0.0,) or numbers(part.node, "density")[:1] == (0.0,)
