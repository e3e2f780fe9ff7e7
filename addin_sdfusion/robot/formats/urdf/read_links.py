"""Reader of the links of URDF files: masses, inertias and meshes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Literal, cast

from ...model.pose import IDENTITY, Pose, Vector3
from ...model.robot import SHAPE_SIZES, WORLD, Inertia, Link, Mesh, Rgba, Shape, ShapeKind
from ..reading.xml import ZERO, Node

GEOMETRY_TAGS = ("visual", "collision")


def read_link(node: Node, colors: Mapping[str, Rgba]) -> Link:
    """Return a link; without an inertial element its mass is 0."""
    inertial = node.optional("inertial")
    inertia = Inertia(0.0) if inertial is None else _inertia(inertial)
    meshes, shapes = tuple(_meshes(node, colors)), tuple(_shapes(node))
    return Link(node.subject.name, inertia, meshes=meshes, shapes=shapes)


def note_shapes(robot: Node) -> None:
    """Report omitted shapes in one warning, and mass or shapes of link `world`."""
    counts: Counter[str] = Counter()
    first: Node | None = None
    for link in robot.all("link"):
        if link.attribute("name", "") == WORLD and link.all("inertial", *GEOMETRY_TAGS):
            problem = f"link {WORLD!r} is the fixed frame; its mass and shapes are omitted"
            link.warning("world-left-out", problem)
        for node, shape in _geometries(link):
            if shape.tag != "mesh" and (node.tag == "visual" or shape.tag not in SHAPE_SIZES):
                counts[shape.tag] += 1
                first = first or shape
    if first is not None:
        kinds = ", ".join(f"{count} {kind}" for kind, count in sorted(counts.items()))
        problem = f"only meshes are read as visual geometry; ignored: {kinds}"
        first.warning("geometry-left-out", problem)


def read_origin(parent: Node) -> Pose:
    """Return the `<origin>` of an element; the identity if it does not exist."""
    node = parent.optional("origin")
    if node is None:
        return IDENTITY
    return Pose(_vector(node, "xyz"), _vector(node, "rpy"))


def _vector(node: Node, name: str) -> Vector3:
    return node.vector_attribute(name) if node.has(name) else ZERO


def _inertia(inertial: Node) -> Inertia:
    pose = read_origin(inertial)
    mass_node, node = inertial.required("mass"), inertial.optional("inertia")
    mass = 0.0 if mass_node is None else mass_node.number_attribute("value")
    if node is None:
        return Inertia(mass, pose.position)
    moments = {entry: node.number_attribute(entry, 0.0) for entry in ("ixx", "iyy", "izz")}
    products = {entry: node.number_attribute(entry, 0.0) for entry in ("ixy", "ixz", "iyz")}
    return Inertia(mass, ZERO, **moments, **products).in_frame(pose)


def _geometries(link: Node) -> Iterator[tuple[Node, Node]]:
    """Yield each visual and collision element with its shapes."""
    for node in link.all(*GEOMETRY_TAGS):
        for geometry in node.all("geometry"):
            for shape in geometry.all():
                yield node, shape


def _shapes(link: Node) -> Iterator[Shape]:
    for node, shape in _geometries(link):
        if node.tag == "collision" and shape.tag in SHAPE_SIZES:
            yield Shape(shape.tag, _sizes(shape, shape.tag), read_origin(node))


def _sizes(shape: Node, kind: ShapeKind) -> tuple[float, ...]:
    if kind == "box":
        return shape.vector_attribute("size")
    return tuple(shape.number_attribute(n) for n in ("radius", "length")[: SHAPE_SIZES[kind]])


def material_colors(robot: Node) -> dict[str, Rgba]:
    """Return the named colours of materials, which other elements can refer to."""
    colors = {}
    for material in robot.all("material"):
        color = material.optional("color")
        if color is not None:
            colors[material.attribute("name", "")] = _rgba(color)
    return colors


def _color(visual: Node, colors: Mapping[str, Rgba]) -> Rgba | None:
    """Return the colour of a material, defined in place or by the name of a material."""
    material = visual.optional("material") if visual.tag == "visual" else None
    if material is None:
        return None
    color = material.optional("color")
    return colors.get(material.attribute("name", "")) if color is None else _rgba(color)


def _rgba(color: Node) -> Rgba:
    red, green, blue, opacity = color.numbers_attribute("rgba", 4)
    return red, green, blue, opacity


def _meshes(link: Node, colors: Mapping[str, Rgba]) -> Iterator[Mesh]:
    for node in link.all(*GEOMETRY_TAGS):
        geometry = node.required("geometry")
        shape = None if geometry is None else geometry.optional("mesh")
        if shape is not None:
            yield Mesh(
                cast(Literal["visual", "collision"], node.tag),
                shape.attribute("filename"),
                read_origin(node),
                shape.vector_attribute("scale") if shape.has("scale") else (1.0, 1.0, 1.0),
                node.attribute("name", ""),
                _color(node, colors),
            )
