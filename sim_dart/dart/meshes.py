"""Convex hulls of triangle meshes for collisions."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from sim_dart.core.arrays import FloatArray
from sim_dart.core.mesh_file import read_mesh
from sim_dart.scene import MAX_DISTANCE

if TYPE_CHECKING:
    import trimesh  # imported late, since the import takes a second

_MAX_FACES = 2000  # of a hull; finer hulls make contacts slow
_FLAT = 1e-9
_MAX_CORNERS = _MAX_FACES // 2 + 2
_MANY_POINTS = 20_000
"""For more points, too fine hulls are rejected early, since computing them takes gigabytes."""

_BODY = """<robot name="hull"><link name="hull">
<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<collision><geometry><mesh filename="{file}"/></geometry></collision></link></robot>
"""


def load_mesh(file: Path, scale: ArrayLike = (1.0, 1.0, 1.0)) -> trimesh.Trimesh:
    """Return a triangle mesh, in metres.

    Args:
        file: Mesh file; see `read_mesh`.
        scale: Factors along x, y, z that convert the units of the file to metres.
    """
    import trimesh

    vertices, faces = read_mesh(file)
    return trimesh.Trimesh(vertices * np.asarray(scale, float), faces, process=True)


def convex_hull(file: Path, scale: ArrayLike = (1.0, 1.0, 1.0)) -> trimesh.Trimesh:
    """Return the convex hull of a mesh.

    Args:
        file: Mesh file; see `read_mesh`.
        scale: Factors along x, y, z that convert the units of the file to metres.

    Raises:
        InputError: The mesh cannot be read, is flat or too large, or its hull is too fine.
    """
    mesh = load_mesh(file, scale)
    if _has_fine_hull(np.asarray(mesh.vertices)):
        problem = f"its convex hull has more than {_MAX_FACES} triangles"
        raise InputError(f"{problem}; simplify the mesh", file=file)
    with _naming(file, "its convex hull cannot be computed"):
        hull: trimesh.Trimesh = mesh.convex_hull
        flat = not hull.volume > _FLAT * float(np.max(hull.extents)) ** 3
    if flat:
        raise InputError("is flat; its convex hull has no volume", file=file)
    if not np.abs(hull.bounds).max() <= MAX_DISTANCE:
        raise InputError(f"reaches farther than {MAX_DISTANCE:g} m; check its scale", file=file)
    if len(hull.faces) > _MAX_FACES:
        problem = f"its convex hull has {len(hull.faces)} triangles, more than {_MAX_FACES}"
        raise InputError(f"{problem}; simplify the mesh", file=file)
    return hull


def _has_fine_hull(points: FloatArray) -> bool:
    """Return whether the hull of points has too many corners, tested in many directions.

    Args:
        points: Distinct points, shape (k, 3).
    """
    if len(points) < _MANY_POINTS:
        return False
    drawn, seen = np.random.default_rng(0), set[int]()
    columns = np.ascontiguousarray(points.T)
    for ways in range(1, _MAX_CORNERS // 4):
        seen.update(np.argmax(drawn.normal(size=(8, 3)) @ columns, axis=1).tolist())
        if len(seen) < ways:  # few new corners: further directions find hardly any
            return False
    return len(seen) > _MAX_CORNERS


def dart_mesh(hull: trimesh.Trimesh) -> Any:
    """Create a mesh shape of DART.

    DART reads meshes only from files, so a temporary file is used.

    Args:
        hull: A mesh in metres.
    """
    import dartpy

    with TemporaryDirectory() as folder:
        file = Path(folder) / "hull.obj"
        file.write_text(_obj(hull))
        body = Path(folder) / "hull.urdf"
        body.write_text(_BODY.format(file=file))
        skeleton = dartpy.utils.DartLoader().parseSkeleton(str(body))
    return skeleton.getBodyNode(0).getShapeNode(0).getShape()


def _obj(mesh: trimesh.Trimesh) -> str:
    corners = (f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(mesh.vertices, float).tolist())
    faces = (f"f {a} {b} {c}" for a, b, c in (np.asarray(mesh.faces) + 1).tolist())
    return "\n".join([*corners, *faces, ""])


@contextmanager
def _naming(file: Path, problem: str) -> Iterator[None]:
    """Convert errors of trimesh, which have any type, to InputError with the file name."""
    try:
        yield
    except Exception as error:
        reason = next(iter(str(error).splitlines()), "") or type(error).__name__
        raise InputError(f"{problem}: {reason}", file=file) from error
