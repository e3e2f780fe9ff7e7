"""Reader of the links of SDF models: masses, inertias and meshes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, cast

from ...model.pose import Pose
from ...model.robot import SHAPE_SIZES, Inertia, Link, Mesh, Rgba, Shape, ShapeKind
from ..reading.xml import TRUE, ZERO, Node, short_repr
from .read_frames import Frames


def read_link(node: Node, frames: Frames) -> Link:
    """Return a link; report features that a robot description cannot hold."""
    name = node.subject.name
    gravity = node.optional("gravity")
    if gravity is not None and gravity.text in ("false", "0"):
        gravity.warning("gravity-not-off", "<gravity> is ignored; gravity acts on the link")
    kinematic = node.optional("kinematic")
    if kinematic is not None and kinematic.text in TRUE:
        kinematic.warning("kinematic-link", "<kinematic> is ignored; forces move the link")
    meshes, shapes = tuple(_meshes(node, frames)), tuple(_shapes(node, frames))
    inertial = node.optional("inertial")
    if inertial is None:
        problem = "has no <inertial>; SDF's defaults 1 kg and 1 kg·m² are used"
        node.warning("default-inertial", problem)
        return Link(name, Inertia(1.0, ixx=1.0, iyy=1.0, izz=1.0), meshes=meshes, shapes=shapes)
    if inertial.attribute("auto", "false") in TRUE:
        problem = "inertia from collision shapes is not supported; specify it explicitly"
        inertial.error("unsupported-inertial", problem)
    if inertial.all("fluid_added_mass"):
        inertial.warning("added-mass-not-simulated", "fluid added mass is not simulated")
    return Link(
        name, _inertia(inertial, frames.in_link(inertial, name)), meshes=meshes, shapes=shapes
    )


def _inertia(inertial: Node, pose: Pose) -> Inertia:
    mass = inertial.number("mass")
    node = inertial.required("inertia")
    if node is None:
        return Inertia(mass, pose.position)
    moments = {entry: node.number(entry) for entry in ("ixx", "iyy", "izz")}
    products = {entry: node.number(entry, 0.0) for entry in ("ixy", "ixz", "iyz")}
    return Inertia(mass, ZERO, **moments, **products).in_frame(pose)


def _meshes(link: Node, frames: Frames) -> Iterator[Mesh]:
    for node in link.all("visual", "collision"):
        geometry = node.required("geometry")
        if geometry is None:
            continue
        for shape in geometry.all():
            if shape.tag == "mesh":
                yield _mesh(node, shape, frames)
            elif shape.tag != "empty" and not _is_kept(node, shape):
                types = "meshes" if node.tag == "visual" else "meshes, boxes, spheres and cylinders"
                problem = (
                    f"a {node.tag} of {short_repr(shape.tag)} is omitted; only {types} are read"
                )
                shape.warning("geometry-left-out", problem)


def _is_kept(node: Node, shape: Node) -> bool:
    return node.tag == "collision" and shape.tag in SHAPE_SIZES


def _shapes(link: Node, frames: Frames) -> Iterator[Shape]:
    for node in link.all("collision"):
        for geometry in node.all("geometry"):
            for shape in geometry.all(*SHAPE_SIZES):
                pose = frames.in_link(node, node.subject.name)
                yield Shape(cast(ShapeKind, shape.tag), read_sizes(shape), pose)


def read_sizes(shape: Node) -> tuple[float, ...]:
    """Return the sizes of a shape, as in `Shape.sizes`."""
    if shape.tag == "box":
        return shape.vector("size")
    names = ("radius",) if shape.tag == "sphere" else ("radius", "length")
    return tuple(shape.number(name) for name in names)


def _mesh(node: Node, shape: Node, frames: Frames) -> Mesh:
    uri, scale = shape.required("uri"), shape.optional("scale")
    if shape.all("submesh"):
        shape.warning("submesh-left-out", "the whole mesh is used instead of the submesh")
    return Mesh(
        cast(Literal["visual", "collision"], node.tag),
        "" if uri is None else uri.text,
        frames.in_link(node, node.subject.name),
        (1.0, 1.0, 1.0) if scale is None else scale.vector3(),
        node.attribute("name", ""),
        _color(node),
    )


def _color(visual: Node) -> Rgba | None:
    """Return the diffuse colour; the opacity is 1 if not specified."""
    material = visual.optional("material") if visual.tag == "visual" else None
    diffuse = None if material is None else material.optional("diffuse")
    if diffuse is None:
        return None
    red, green, blue, *opacity = diffuse.numbers(3 if len(diffuse.text.split()) == 3 else 4)
    return red, green, blue, opacity[0] if opacity else 1.0
