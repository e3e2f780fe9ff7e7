"""Reader of the static objects of SDF worlds."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from ...finding import Finding, Subject
from ...mesh_files import mesh_file
from ...model.pose import IDENTITY, Pose, Vector3
from ...model.rotations import apply, compose
from ..reading.unread import note_unread
from ..reading.xml import TRUE, Node, Notes, parse, short_repr
from .read_frames import Frames, read_pose
from .read_links import read_sizes

_IGNORED = frozenset({
    "atmosphere", "audio", "gravity", "gui", "inertial", "light", "magnetic_field", "max_contacts",
    "physics", "plugin", "scene", "self_collide", "spherical_coordinates", "state", "visual",
})  # fmt: skip
"""Tags of elements without influence on static objects, and settings that experiments define."""
_LEVEL = 1e-9
_SHAPES = ("sphere", "box", "capsule", "cylinder", "mesh", "plane")


@dataclass(frozen=True, slots=True)
class StaticObject:
    """Static collision shape.

    Attributes:
        name: `<model>`, or `<model>_<link>_<collision>` if a model has several shapes.
        kind: `sphere`, `box`, `capsule`, `cylinder` or `mesh`.
        sizes: Radius; edges x, y, z; radius and length; or scale x, y, z of a mesh. Lengths in [m].
        pose: Pose in the world frame.
        file: File of a mesh.
        friction: Coefficient of Coulomb friction, or None if not specified.
        restitution: Coefficient of restitution, or None if not specified.
    """

    name: str
    kind: str
    sizes: tuple[float, ...]
    pose: Pose
    file: Path | None = None
    friction: float | None = None
    restitution: float | None = None


@dataclass(frozen=True)
class SdfWorld:
    """Static objects of an SDF world.

    Attributes:
        ground: Height of a horizontal ground plane, in [m], or None.
        findings: Findings on errors and omitted elements, with file and line.
    """

    objects: tuple[StaticObject, ...]
    ground: float | None
    findings: tuple[Finding, ...]


def read_sdf_world(file: Path) -> SdfWorld:
    """Return the static models of an SDF world; a finding reports each other kind of content."""
    notes = Notes()
    root = parse(file, Subject("world", file.stem), notes)
    if root.tag != "sdf":
        root.error("not-sdf", f"<{root.tag}> is not <sdf>")
        return SdfWorld((), None, tuple(notes.findings))
    objects: list[StaticObject] = []
    heights: list[float] = []
    for place in [root, *root.all("world")]:
        _note_includes(place.all("include"))
        for node in place.all("model"):
            model = node.named("model")
            for shape in _static_shapes(model):
                if isinstance(shape, StaticObject):
                    objects.append(shape)
                else:
                    heights.append(shape)
    for extra in heights[1:]:
        root.warning("second-ground", f"a second ground at {extra!r} m is omitted")
    note_unread(notes, _IGNORED)
    unique = _with_unique_names(objects)
    return SdfWorld(tuple(unique), heights[0] if heights else None, tuple(notes.findings))


def _note_includes(nodes: list[Node]) -> None:
    """Report included models, which are not read."""
    uris = []
    for node in nodes:
        node.mark_used()
        uri = node.optional("uri")
        uris.append(short_repr("" if uri is None else uri.text))
    if nodes:
        problem = f"<include> is not supported; insert the content of {', '.join(uris)} here"
        nodes[0].warning("include-left-out", problem)


def _with_unique_names(objects: list[StaticObject]) -> Iterator[StaticObject]:
    """Yield the objects, numbered if they have the same name."""
    seen: dict[str, int] = {}
    for item in objects:
        count = seen[item.name] = seen.get(item.name, 0) + 1
        yield item if count == 1 else replace(item, name=f"{item.name}_{count}")


def _static_shapes(model: Node) -> Iterator[StaticObject | float]:
    """Yield the shapes of a static model, or the height of a horizontal plane."""
    static = model.optional("static")
    if static is None or static.text not in TRUE:
        problem = "is not static and is omitted; add <static>true</static>, or [[world.objects]]"
        model.warning("moving-model-left-out", problem)
        model.mark_used()
        return
    for node in model.all("model", "include"):
        node.warning("model-left-out", f"<{node.tag}> in a model is not supported; omitted")
        node.mark_used()
    pose = model.optional("pose")
    T_world_model = IDENTITY if pose is None else read_pose(pose)
    frames = Frames(model)
    collisions = [
        (link, collision) for link in model.all("link") for collision in link.all("collision")
    ]
    for link, collision in collisions:
        name = link.attribute("name", "")
        T_model_link = frames.in_model(("link", name))
        T_world_shape = compose(
            T_world_model, compose(T_model_link, frames.in_link(collision, name))
        )
        full_name = f"{model.subject.name}_{name}_{collision.attribute('name', '')}"
        label = model.subject.name if len(collisions) == 1 else full_name
        yield from _shape(collision, label, T_world_shape)


def _shape(collision: Node, name: str, pose: Pose) -> Iterator[StaticObject | float]:
    geometry = collision.required("geometry")
    for shape in [] if geometry is None else geometry.all():
        if shape.tag == "plane":
            yield from _plane(shape, pose)
        elif shape.tag in _SHAPES:
            sizes, file = _sizes(shape)
            if not all(math.isfinite(size) and size > 0 for size in sizes):
                listed = " ".join(f"{size:g}" for size in sizes)
                problem = f"sizes of <{shape.tag}> must be positive and finite: {listed}"
                shape.error("bad-size", problem)
                continue
            friction, restitution = _surface(collision)
            yield StaticObject(name, shape.tag, sizes, pose, file, friction, restitution)
        elif shape.tag != "empty":
            problem = f"a collision of {short_repr(shape.tag)} is omitted"
            shape.warning("geometry-left-out", problem)


def _plane(shape: Node, pose: Pose) -> Iterator[float]:
    """Yield the height of a horizontal plane, which is infinite for contacts in SDF."""
    normal: Vector3 = (0.0, 0.0, 1.0)
    child = shape.optional("normal")
    if child is not None:
        normal = child.vector3()
    x, y, z = (a - b for a, b in zip(apply(pose, normal), pose.position, strict=True))
    if z <= 0 or math.hypot(x, y) > _LEVEL * z:
        shape.warning("plane-left-out", "a plane that is not horizontal is omitted; use a box")
        return
    yield pose.position[2]


def _sizes(shape: Node) -> tuple[tuple[float, ...], Path | None]:
    if shape.tag != "mesh":
        return read_sizes(shape), None
    uri, scale = shape.required("uri"), shape.optional("scale")
    file = mesh_file("" if uri is None else uri.text, shape.file.parent)
    return ((1.0, 1.0, 1.0) if scale is None else scale.vector3()), file


def _surface(collision: Node) -> tuple[float | None, float | None]:
    """Return friction (the smaller value of ODE) and restitution; None if not specified."""
    surface = collision.optional("surface")
    if surface is None:
        return None, None
    contact = surface.optional("friction")
    friction = None if contact is None else contact.optional("ode")
    bounce = surface.optional("bounce")
    mu = None
    if friction is not None:
        nodes = [node for tag in ("mu", "mu2") if (node := friction.optional(tag)) is not None]
        mu = min((friction.number(node.tag) for node in nodes), default=None)
    is_specified = bounce is not None and bounce.optional("restitution_coefficient") is not None
    restitution = bounce.number("restitution_coefficient") if bounce and is_specified else None
    return mu, restitution
