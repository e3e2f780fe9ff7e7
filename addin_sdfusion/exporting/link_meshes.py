"""Visual and collision meshes of links, as STL in link frames."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, NamedTuple

from ..robot.finding import Finding, Subject
from ..robot.finding_builders import listed, warning
from ..robot.model.pose import Pose
from ..robot.model.robot import Mesh, Rgba, Shape
from ..robot.model.transform import Transform
from ..settings import ExportSettings
from ..snapshot import BodySnapshot, MeshSnapshot
from .convex_hull import convex_hull
from .primitives import fit_shape
from .stl import stl_bytes

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
        stem: Prefix of the names of its files.
        bodies: Bodies of the link; hidden bodies are not exported.
        T_link_world: Pose of the world frame, which is the frame of the body meshes.
    """
    collision = settings.collision_of(link)
    if not settings.visual and collision == "none":
        return LinkMeshes((), (), {}, ())
    findings = list(_unexported_bodies(link, bodies))
    looks: dict[Rgba | None, list[_Triangles]] = {}
    T = Transform.of(T_link_world)
    for b in bodies:
        if b.visible and b.mesh and _is_valid(b.mesh):
            nodes = T.apply_all(b.mesh.nodes)
            looks.setdefault(_rgba(b), []).append(_Triangles(nodes, b.mesh.triangles))
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
