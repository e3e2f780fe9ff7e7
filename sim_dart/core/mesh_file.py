"""Reader for the triangles of mesh files, based on trimesh."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.mesh_files import mesh_bytes


def read_mesh(file: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the triangles of a mesh file, in the units of the file.

    Args:
        file: Mesh of a type that `mesh_problem` accepts. It must not refer to other files.

    Returns:
        The corners, shape (n, 3), and the indices of the corners of each triangle, shape (m, 3).

    Raises:
        InputError: The file cannot be read, contains no triangles, or contains a corner that is
            not finite or too far from the origin.
    """
    import trimesh  # imported late, since the import takes a second

    data = mesh_bytes(file, None)
    logging.getLogger("trimesh").setLevel(logging.CRITICAL)
    try:
        stream, kind = trimesh.util.wrap_as_stream(data), file.suffix.lstrip(".").lower()
        with np.errstate(all="ignore"):  # invalid numbers are rejected below
            mesh = trimesh.load_mesh(stream, file_type=kind, skip_materials=True)
            if isinstance(mesh, trimesh.Scene):
                mesh = mesh.to_mesh()
        vertices = np.array(mesh.vertices, np.float64).reshape(-1, 3)
        faces = np.array(mesh.faces, np.int64).reshape(-1, 3)
    except Exception as error:  # readers raise errors of any type for damaged files
        reason = next(iter(str(error).splitlines()), "") or type(error).__name__
        raise InputError(f"cannot be read as a mesh: {reason}", file=file) from error
    if not len(faces):
        raise InputError("contains no triangles", file=file)
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError("contains a triangle whose corners do not exist", file=file)
    if not (np.abs(vertices) < limits.MESH_REACH).all():
        problem = f"contains a corner that is not finite or is {limits.MESH_REACH:g} or more from 0"
        raise InputError(problem, file=file)
    return vertices, faces
