"""Visual and collision meshes of links, as STL in link frames."""

from __future__ import annotations

import math
import struct
from array import array
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Literal, NamedTuple

from ..robot.errors import InputError
from ..robot.finding import Finding, Subject
from ..robot.finding_builders import listed, warning
from ..robot.model.pose import Pose, Vector3
from ..robot.model.robot import Mesh, Rgba, Shape, ShapeKind
from ..robot.model.rotations import (
    Matrix3,
    add,
    cross,
    dot,
    normalized,
    rotate,
    rotation,
    rpy,
    subtract,
    transpose,
)
from ..settings import ExportSettings
from ..snapshot import BodySnapshot, MeshSnapshot
from .convex_hull import convex_hull

_DIRECTIONS = 5
_PARALLEL = 1e-6
_DIGITS = 6  # number of equal digits of normals of one face
_Frame = tuple[Matrix3, Vector3, Vector3, list[Vector3]]
"""Rotation of a frame, minimum and maximum corner of the points in it, points in it."""
HEADER = b"binary STL in metres, in the frame of the link".ljust(80)
"""Header without date and name, so that equal meshes result in equal files. It must not begin with
`solid`, which marks an ASCII STL file."""
_COUNT = struct.Struct("<I")
_TRIANGLE = struct.Struct("<12fH")
_MAX_TRIANGLES = 2**32 - 1
Corner = tuple[float, float, float]
MAX_HULLS = 16
"""Maximum number of hulls of a link. Links with more bodies get one hull around all bodies, since
each collision shape slows down simulators."""

Role = Literal["visual", "collision"]


class LinkMeshes(NamedTuple):
    """Meshes of one link.

    Attributes:
        meshes: Role, path as URI, and name of each mesh.
        shapes: Collision shapes that replace collision meshes.
        files: Content of each file, by path relative to the robot folder.
        findings: Warnings on bodies without meshes.
    """

    meshes: tuple[Mesh, ...]
    shapes: tuple[Shape, ...]
    files: Mapping[str, bytes]
    findings: tuple[Finding, ...]


class _Triangles(NamedTuple):
    """Triangles in the frame of a link; fields as in a MeshSnapshot."""

    nodes: Sequence[float]
    triangles: Sequence[int]


def link_meshes(
    link: str,
    stem: str,
    bodies: Sequence[BodySnapshot],
    T_link_world: Pose,
    settings: ExportSettings,
) -> LinkMeshes:
    """Return the meshes of a link.

    Args:
        link: Name of the link.
        stem: Prefix of the names of its files.
        bodies: Bodies of the link; hidden bodies are not exported.
        T_link_world: Pose of the world frame, which is the frame of the body meshes.
        settings: Settings of the export.
    """
    collision = settings.collision_of(link)
    if not settings.visual and collision == "none":
        return LinkMeshes((), (), {}, ())
    findings = list(_unexported_bodies(link, bodies))
    looks: dict[Rgba | None, list[_Triangles]] = {}
    for b in bodies:
        if b.visible and b.mesh and _is_valid(b.mesh):
            looks.setdefault(_rgba(b), []).append(_in_link_frame(b.mesh, T_link_world))
    shown = [shape for shapes in looks.values() for shape in shapes]
    named: list[tuple[Role, str, _Triangles]] = []
    colors: dict[str, Rgba | None] = {}
    if shown and settings.visual:
        for name, (color, shapes) in zip(_names("visual", len(looks)), looks.items(), strict=True):
            named.append(("visual", name, _merge(shapes)))
            colors[name] = color
    if shown and collision == "mesh":
        named.append(("collision", "collision", _merge(shown)))
    simple: list[Shape] = []
    if shown and collision != "none" and collision != "mesh":
        hulls = [hull for group in _groups(shown) if (hull := _hull(group)) is not None]
        if collision == "convex_hull":
            names = _names("collision", len(hulls))
            named += [("collision", name, hull) for name, hull in zip(names, hulls, strict=True)]
        else:
            simple = [fit_shape(collision, *hull) for hull in hulls]
        if len(hulls) < len(_groups(shown)):
            problem = "bodies without thickness have no convex hull and do not collide"
            findings.append(warning(Subject("link", link), "flat-collision", problem))
    paths = [f"meshes/{role}/{_file(stem, name)}.stl" for role, name, _ in named]
    return LinkMeshes(
        tuple(
            Mesh(role, path, name=name, color=colors.get(name))
            for (role, name, _), path in zip(named, paths, strict=True)
        ),
        tuple(simple),
        {path: stl_bytes(*shape) for (_, _, shape), path in zip(named, paths, strict=True)},
        tuple(findings),
    )


def _rgba(body: BodySnapshot) -> Rgba | None:
    """Return the colour and opacity of a body, from 0 to 1."""
    if body.color is None:
        return None
    red, green, blue = (int(body.color[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue, body.opacity


def _unexported_bodies(link: str, bodies: Sequence[BodySnapshot]) -> Iterator[Finding]:
    subject = Subject("link", link)
    hidden = [body.name for body in bodies if not body.visible]
    if hidden:
        problem = (
            f"hidden bodies are not exported in its meshes: {listed(hidden, 5)}; show them to "
            "export them"
        )
        yield warning(subject, "hidden-bodies", problem)
    without = [body.name for body in bodies if body.visible and body.mesh is None]
    if without:
        problem = (
            f"bodies without a mesh: {listed(without, 5)}; they are invisible and do not collide"
        )
        yield warning(subject, "bodies-without-mesh", problem)
    broken = [b.name for b in bodies if b.visible and b.mesh is not None and not _is_valid(b.mesh)]
    if broken:
        problem = f"bodies whose mesh is empty or damaged are not exported: {listed(broken, 5)}"
        yield warning(subject, "damaged-mesh", problem)


def _is_valid(mesh: MeshSnapshot) -> bool:
    """Return whether a mesh has triangles, and all of them refer to existing finite nodes."""
    nodes, triangles = mesh.nodes, mesh.triangles
    if not triangles or len(nodes) % 3 or len(triangles) % 3:
        return False
    inside = min(triangles) >= 0 and max(triangles) < len(nodes) // 3
    return inside and all(map(math.isfinite, nodes))


def _in_link_frame(mesh: MeshSnapshot, T_link_world: Pose) -> _Triangles:
    (a, b, c), (d, e, f), (g, h, i) = rotation(T_link_world.rpy)
    px, py, pz = T_link_world.position
    nodes = array("d")
    numbers = iter(mesh.nodes)
    if not any(T_link_world.rpy):
        for x, y, z in zip(numbers, numbers, numbers, strict=True):
            nodes.extend((px + x, py + y, pz + z))
    else:
        for x, y, z in zip(numbers, numbers, numbers, strict=True):
            nodes.extend(
                (px + a * x + b * y + c * z, py + d * x + e * y + f * z, pz + g * x + h * y + i * z)
            )
    return _Triangles(nodes, mesh.triangles)


def _merge(shapes: Sequence[_Triangles]) -> _Triangles:
    if len(shapes) == 1:
        return shapes[0]
    nodes, triangles = array("d"), array("l")
    for shape in shapes:
        first = len(nodes) // 3
        nodes.extend(shape.nodes)
        triangles.extend(first + i for i in shape.triangles)
    return _Triangles(nodes, triangles)


def _groups(shapes: Sequence[_Triangles]) -> list[_Triangles]:
    """Return the groups of bodies that get one hull each.

    Each body gets a separate hull, because a common hull would fill the gaps between bodies.
    """
    return list(shapes) if len(shapes) <= MAX_HULLS else [_merge(shapes)]


def _hull(shape: _Triangles) -> _Triangles | None:
    numbers = iter(shape.nodes)
    hull = convex_hull(zip(numbers, numbers, numbers, strict=True))
    if hull is None:
        return None
    return _Triangles(
        [number for corner in hull.corners for number in corner],
        [i for triangle in hull.triangles for i in triangle],
    )


def _names(role: str, count: int) -> list[str]:
    return [role] if count == 1 else [f"{role}_{k}" for k in range(1, count + 1)]


def _file(stem: str, name: str) -> str:
    """Return the file name of a mesh; it is unique because a stem does not contain a dot."""
    _, _, number = name.partition("_")
    return f"{stem}.{number}" if number else stem


def stl_bytes(nodes: Sequence[float], triangles: Sequence[int]) -> bytes:
    """Return the content of a binary STL file.

    Triangles with two corners that coincide after rounding are not written; the surface remains
    closed. Other triangles without area are written, because adjacent triangles share their edges.

    Args:
        nodes: x, y, z of every node, in [m].
        triangles: Three node indices per triangle, counter-clockwise seen from outside.

    Raises:
        InputError: The mesh exceeds the range of 32-bit floats or the maximum number of triangles.
    """
    rounded = array("f", nodes)
    if not all(map(math.isfinite, rounded)):
        raise InputError("a mesh exceeds the range of 32-bit floats in STL")
    corners = list(zip(rounded[0::3], rounded[1::3], rounded[2::3], strict=True))
    parts = []
    indices = iter(triangles)
    for i, j, k in zip(indices, indices, indices, strict=True):
        a, b, c = corners[i], corners[j], corners[k]
        if a != b and b != c and c != a:
            parts.append(_TRIANGLE.pack(*_normal(a, b, c), *a, *b, *c, 0))
    if len(parts) > _MAX_TRIANGLES:
        raise InputError(f"a mesh has more triangles than STL allows ({_MAX_TRIANGLES})")
    return b"".join((HEADER, _COUNT.pack(len(parts)), *parts))


def _normal(a: Corner, b: Corner, c: Corner) -> Corner:
    """Return the unit normal of a triangle; zero for a degenerate triangle."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    norm = math.hypot(x, y, z)
    if norm == 0.0 or not math.isfinite(norm):
        return 0.0, 0.0, 0.0
    return x / norm, y / norm, z / norm


def fit_shape(kind: ShapeKind, nodes: Sequence[float], triangles: Sequence[int]) -> Shape:
    """Return the smallest enclosing shape of a hull that is aligned with its largest faces.

    The centre of a sphere is the centre of the smallest such box. For hulls of boxes, cylinders and
    spheres, the shape is as exact as the triangles.

    Args:
        kind: Type of the shape.
        nodes: x, y, z of every corner, in [m].
        triangles: Three indices of corners per triangle.
    """
    points = [(nodes[i], nodes[i + 1], nodes[i + 2]) for i in range(0, len(nodes), 3)]
    frames = [_to_frame(R, points) for R in _frames(points, triangles)]
    if kind == "cylinder":
        every = [cylinder for frame in frames for cylinder in _cylinders(*frame)]
        return min(every, key=lambda c: c.sizes[0] ** 2 * c.sizes[1])
    R, low, high, _ = min(frames, key=lambda f: math.prod(subtract(f[2], f[1])))
    middle = rotate(R, _scaled(0.5, add(low, high)))
    if kind == "box":
        return Shape("box", subtract(high, low), Pose(middle, rpy(R)))
    return Shape("sphere", (max(math.dist(middle, p) for p in points),), Pose(middle))


def _to_frame(R: Matrix3, points: Sequence[Vector3]) -> _Frame:
    back = transpose(R)
    own = [rotate(back, p) for p in points]
    xs, ys, zs = zip(*own, strict=True)
    return R, (min(xs), min(ys), min(zs)), (max(xs), max(ys), max(zs)), own


def _cylinders(R: Matrix3, low: Vector3, high: Vector3, points: list[Vector3]) -> Iterator[Shape]:
    """Yield the enclosing cylinder along each axis of a frame."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        middle = _scaled(0.5, add(low, high))
        radius = max(math.hypot(p[i] - middle[i], p[j] - middle[j]) for p in points)
        (a, b, c), (d, e, f), (g, h, m) = transpose(R)
        rows = ((a, b, c), (d, e, f), (g, h, m))
        turned = transpose((rows[i], rows[j], rows[k]))
        pose = Pose(rotate(R, middle), rpy(turned))
        yield Shape("cylinder", (radius, high[k] - low[k]), pose)


def _frames(points: Sequence[Vector3], triangles: Sequence[int]) -> Iterator[Matrix3]:
    """Yield the link frame, and the frames of each pair of normals of the largest faces."""
    yield (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    for z, other in combinations(_directions(points, triangles), 2):
        along = subtract(other, _scaled(dot(other, z), z))
        if dot(along, along) > _PARALLEL:
            x = normalized(along)
            yield transpose((x, cross(z, x), z))


def _directions(points: Sequence[Vector3], triangles: Sequence[int]) -> list[Vector3]:
    """Return the normals of the largest faces; opposite normals are treated as equal.

    A face may consist of many triangles.
    """
    areas: dict[Vector3, float] = {}
    normals: dict[Vector3, Vector3] = {}
    for t in range(0, len(triangles), 3):
        p, q, r = (points[i] for i in triangles[t : t + 3])
        normal = cross(subtract(q, p), subtract(r, p))
        area = math.sqrt(dot(normal, normal))
        if area == 0.0:
            continue
        x, y, z = _scaled(1.0 / area, normal)
        near = round(x, _DIGITS) + 0.0, round(y, _DIGITS) + 0.0, round(z, _DIGITS) + 0.0
        key = max(near, _scaled(-1.0, near))
        areas[key] = areas.get(key, 0.0) + area
        normals.setdefault(key, (x, y, z))
    return [normals[key] for key in sorted(areas, key=lambda k: (-areas[k], k))[:_DIRECTIONS]]


def _scaled(factor: float, v: Vector3) -> Vector3:
    return factor * v[0], factor * v[1], factor * v[2]
