"""Surfaces of links, read with trimesh and simplified."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import InputError, Mesh, Robot
from cardsflow_fmu.utils.visual_meshes import visual_files, visuals
from sim_dart.core.frames import transform
from sim_dart.core.mesh_file import read_mesh

from .shapes import Colour, Triangles

MAX_FACES = 6000
"""Maximum number of faces of a link mesh; CAD meshes have about 100 times more."""

_MAX_CELLS = 256
"""Initial number of grid cells along the longest edge of a mesh that is simplified."""

LinkMeshes = Mapping[str, tuple[Triangles, ...]]
"""Surfaces of the links in their link frames; links without a mesh have no entry."""


def link_meshes(robot: Robot, folder: Path, roots: Sequence[Path] | None = None) -> LinkMeshes:
    """Read the visual meshes; links with missing or unreadable meshes are omitted."""
    read = {uri: read_triangles(file) for uri, file in visual_files(robot, folder, roots).items()}
    meshes = {}
    for link in robot.links:
        placed = [_in_link_frame(mesh, read.get(mesh.uri)) for mesh in visuals(link)]
        readable = tuple(triangles for triangles in placed if triangles is not None)
        if readable and len(readable) == len(placed):
            meshes[link.name] = readable
    return meshes


def read_triangles(file: Path) -> Triangles | None:
    """Read the surface in a single file; None if trimesh cannot read it."""
    try:
        return simplify(Triangles(*read_mesh(file)))
    except InputError:
        return None


def _in_link_frame(mesh: Mesh, triangles: Triangles | None) -> Triangles | None:
    """Transform a mesh to its link frame, in [m]."""
    if triangles is None:
        return None
    T = transform(mesh.pose)
    vertices = triangles.vertices * np.array(mesh.scale) @ T[:3, :3].T + T[:3, 3]
    turned = np.prod(mesh.scale) < 0.0
    faces = triangles.faces[:, ::-1] if turned else triangles.faces
    return Triangles(vertices, faces, _colour(mesh))


def _colour(mesh: Mesh) -> Colour | None:
    if mesh.color is None:
        return None
    red, green, blue = (round(255 * min(max(channel, 0.0), 1.0)) for channel in mesh.color[:3])
    return red, green, blue


def simplify(triangles: Triangles, most: int = MAX_FACES) -> Triangles:
    """Simplify a surface to a maximum number of faces by merging vertices in grid cells."""
    cells = _MAX_CELLS
    while len(triangles.faces) > most and cells >= 2:
        candidate = _merge_vertices(triangles, cells)
        count = len(candidate.faces)
        if count <= most or cells == 2:
            return candidate
        # the number of faces of a surface grows with the square of the number of cells
        cells = min(cells * 4 // 5, math.ceil(1.2 * cells * math.sqrt(most / count)))
    return triangles


def _merge_vertices(triangles: Triangles, cells: int) -> Triangles:
    """Merge vertices in a grid of cubes; remove degenerate faces."""
    vertices = triangles.vertices
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    size = float((high - low).max()) / cells or 1.0
    cube = np.floor((vertices - low) / size).astype(np.int64)
    # one integer per cube: integers are sorted much faster than rows
    number = np.ravel_multi_index(tuple(cube.T), (_MAX_CELLS + 1,) * 3)
    _, cell, count = np.unique(number, return_inverse=True, return_counts=True)
    sums = [np.bincount(cell, axis, len(count)) for axis in vertices.T]
    faces = cell[triangles.faces]
    is_valid = _has_distinct_corners(faces)
    return Triangles(np.stack(sums, axis=1) / count[:, np.newaxis], faces[is_valid])


def _has_distinct_corners(faces: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return whether each face has three different corners, shape (faces,)."""
    a, b, c = faces.T
    is_distinct: NDArray[np.bool_] = (a != b) & (b != c) & (c != a)
    return is_distinct
