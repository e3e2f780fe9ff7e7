"""Interface to the geometry kernel Open CASCADE: mass properties, triangles and faces of shapes.

The extra `cad` installs it with build123d. A shape has its own frame and unit of length; a
`Transform` in metres defines its pose.
"""

from __future__ import annotations

import importlib
from array import array
from collections.abc import Iterator
from contextlib import suppress
from typing import Any, Literal, NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, Vector3
from addin_sdfusion.robot.model.transform import Transform
from addin_sdfusion.settings import MeshQuality
from addin_sdfusion.snapshot import MassSnapshot, MeshSnapshot
from cardsflow_fmu.utils.extras import install

MILLIMETRE = 0.001
_MAX_MASS = 1e100  # in [kg]; avoids overflows

_FINENESS: dict[MeshQuality, tuple[float, float]] = {
    "low": (1e-2, 0.8),
    "normal": (2e-3, 0.4),
    "high": (5e-4, 0.2),
    "very_high": (1e-4, 0.1),
}
"""Maximum distance of triangles from a face, relative to the body size, and angle in [rad]."""


def kernel(module: str) -> Any:
    """Return a module of the kernel, such as `gp`.

    Raises:
        InputError: The kernel is not installed.
    """
    try:
        return importlib.import_module(f"OCP.{module}")
    except ImportError as error:
        raise missing() from error


def missing() -> InputError:
    """Return the error for a missing extra `cad`."""
    return InputError(f"STEP files and build123d require the extra `cad`: {install('cad')}")


class Face(NamedTuple):
    """A cylinder or sphere face.

    Attributes:
        shape: `sphere` or `cylinder`.
        radius: In [m].
        centre: Centre of the sphere or cylinder, in [m].
        axis: Axis of the cylinder; z for a sphere.
        length: Length of the cylinder, in [m]; 0 for a sphere.
    """

    shape: Literal["sphere", "cylinder"]
    radius: float
    centre: Vector3
    axis: Vector3 = (0.0, 0.0, 1.0)
    length: float = 0.0


def transform(trsf: Any, unit: float) -> Transform:
    """Convert a transform of the kernel (gp_Trsf).

    Raises:
        ValueError: The transform scales or mirrors.
    """
    rows = [[trsf.Value(i, j) for j in range(1, 5)] for i in range(1, 4)]
    R = np.array(rows)[:, :3]
    if not np.allclose(R @ R.T, np.eye(3), rtol=0.0, atol=1e-6) or np.linalg.det(R) < 0.0:
        raise ValueError("it scales or mirrors")
    a, b, c = ((row[0], row[1], row[2]) for row in rows)
    x, y, z = (unit * row[3] for row in rows)
    return Transform((a, b, c), (x, y, z))


def placed(location: Any, unit: float) -> Transform:
    """Convert a location of build123d."""
    return transform(location.wrapped.Transformation(), unit)


def solids(shape: Any) -> list[Any]:
    """Return the solids of a shape, in order."""
    return list(_explored(shape, "SOLID"))


def _explored(shape: Any, kind: str) -> Iterator[Any]:
    explorer = kernel("TopExp").TopExp_Explorer(
        shape, getattr(kernel("TopAbs").TopAbs_ShapeEnum, f"TopAbs_{kind}")
    )
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def mass_of(shape: Any, T: Transform, density: float, unit: float) -> MassSnapshot | None:
    """Return the mass properties of a solid, or None without a positive volume.

    Args:
        T: Pose T_root_shape, lengths in [m].
        density: In [kg/m³].
        unit: Unit of length of the shape, in [m].

    Raises:
        InputError: The mass exceeds 1e100 kg, or the inertia is not finite.
    """
    properties = kernel("GProp").GProp_GProps()
    kernel("BRepGProp").BRepGProp.VolumeProperties_s(shape, properties, True, False, False)
    mass = density * unit**3 * properties.Mass()
    if not mass > 0.0:
        return None
    if not mass < _MAX_MASS:
        raise InputError(f"a density of {density:.3g} kg/m3 results in a mass of {mass:.3g} kg")
    centre, inertia = properties.CentreOfMass(), properties.MatrixOfInertia()
    unit_inertia = np.array([[inertia.Value(i, j) for j in (1, 2, 3)] for i in (1, 2, 3)])
    R = np.array(T.R)
    J = density * unit**5 * R @ unit_inertia @ R.T
    com = R @ (unit * np.array([centre.X(), centre.Y(), centre.Z()])) + np.array(T.p)
    with np.errstate(over="ignore", invalid="ignore"):
        about_origin = J + mass * (com @ com * np.eye(3) - np.outer(com, com))
    if not np.isfinite([J, about_origin]).all():
        raise InputError(
            "the inertia of a body is not finite; it is too far from the origin, or not closed"
        )
    xx, yy, zz = np.diag(about_origin).tolist()
    xy, yz, xz = (float(about_origin[i, j]) for i, j in ((0, 1), (1, 2), (0, 2)))
    low, middle, high = np.linalg.eigvalsh(J).tolist()
    return MassSnapshot(mass, _vector(com), (xx, yy, zz, xy, yz, xz), (low, middle, high))


def mesh_of(shape: Any, T: Transform, quality: MeshQuality, unit: float) -> MeshSnapshot | None:
    """Return the triangles of a shape, or None without any; arguments as for `mass_of`."""
    deflection, angle = _FINENESS[quality]
    box = kernel("Bnd").Bnd_Box()
    kernel("BRepBndLib").BRepBndLib.Add_s(shape, box)
    if box.IsVoid():
        return None
    size = box.SquareExtent() ** 0.5
    kernel("BRepMesh").BRepMesh_IncrementalMesh(shape, deflection * size, False, angle, False)
    nodes: list[Any] = []
    triangles: list[int] = []
    for face in _explored(shape, "FACE"):
        _add_face(face, nodes, triangles)
    if not triangles:
        return None
    placed = unit * np.array(nodes) @ np.array(T.R).T + np.array(T.p)
    return MeshSnapshot(array("d", placed.ravel().tolist()), array("i", triangles))


def _add_face(face: Any, nodes: list[Any], triangles: list[int]) -> None:
    """Append the triangles of a face, counter-clockwise as seen from outside."""
    location = kernel("TopLoc").TopLoc_Location()
    mesh = kernel("BRep").BRep_Tool.Triangulation_s(kernel("TopoDS").TopoDS.Face(face), location)
    if mesh is None:
        return
    first, trsf = len(nodes), location.Transformation()
    for i in range(1, mesh.NbNodes() + 1):
        node = mesh.Node(i).Transformed(trsf)
        nodes.append((node.X(), node.Y(), node.Z()))
    reversed_ = face.Orientation() == kernel("TopAbs").TopAbs_Orientation.TopAbs_REVERSED
    for i in range(1, mesh.NbTriangles() + 1):
        a, b, c = (first + corner - 1 for corner in mesh.Triangle(i).Get())
        triangles += (a, c, b) if reversed_ else (a, b, c)


def face_of(face: Any, T: Transform, unit: float) -> Face:
    """Return a cylinder or sphere face, over which muscles can wrap.

    Raises:
        ValueError: The face is neither a cylinder nor a sphere.
    """
    surface = kernel("BRepAdaptor").BRepAdaptor_Surface(face)
    kinds = kernel("GeomAbs").GeomAbs_SurfaceType
    if surface.GetType() == kinds.GeomAbs_Sphere:
        sphere = surface.Sphere()
        return Face("sphere", unit * sphere.Radius(), T.apply(_point(sphere.Location(), unit)))
    if surface.GetType() != kinds.GeomAbs_Cylinder:
        raise ValueError("it is neither a cylinder nor a sphere")
    cylinder = surface.Cylinder()
    direction = cylinder.Axis().Direction()
    axis = np.array([direction.X(), direction.Y(), direction.Z()])
    first, last = surface.FirstVParameter(), surface.LastVParameter()
    middle = np.array(_point(cylinder.Location(), unit)) + unit * (first + last) / 2.0 * axis
    length = unit * abs(last - first)
    centre, along = T.apply(_vector(middle)), T.rotate(_vector(axis))
    return Face("cylinder", unit * cylinder.Radius(), centre, along, length)


def round_faces(shape: Any, T: Transform, unit: float) -> list[Face]:
    """Return all cylinder and sphere faces of a shape; arguments as for `face_of`."""
    faces = []
    for face in _explored(shape, "FACE"):
        with suppress(ValueError):
            faces.append(face_of(kernel("TopoDS").TopoDS.Face(face), T, unit))
    return faces


def _point(point: Any, unit: float) -> Vector3:
    return unit * point.X(), unit * point.Y(), unit * point.Z()


def _vector(v: Any) -> Vector3:
    x, y, z = (float(value) for value in v)
    return x, y, z
