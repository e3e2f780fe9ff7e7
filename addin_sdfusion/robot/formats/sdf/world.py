"""Reader of the static objects of an SDF world."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from ...finding import Finding, Subject
from ...mesh_files import mesh_file
from ...model.pose import IDENTITY, Pose, Vector3
from ...model.rotations import apply, compose
from ..reading.xml import TRUE, Node, Notes, parse, shortened
from .read_frames import Frames, read_pose

_LEVEL = 1e-9
_SHAPES = ("sphere", "box", "capsule", "cylinder", "mesh", "plane")


@dataclass(frozen=True, slots=True)
class StaticObject:
    """A shape at rest.

    Attributes:
        name: `<model>`, or `<model>_<link>_<collision>` where a model has several shapes.
        kind: `sphere`, `box`, `capsule`, `cylinder` or `mesh`.
        sizes: The radius; the edges x, y, z; the radius and length; or a mesh's scale x, y, z.
        pose: In the world.
        file: Of a mesh.
        friction: Coefficient of Coulomb friction; None if the file is silent.
        restitution: None if the file is silent.
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
    """Objects at rest in an SDF world.

    Attributes:
        objects: The shapes.
        ground: Height of a level ground, in [m]; None if there is none.
        findings: What was left out, and what is wrong, with places.
    """

    objects: tuple[StaticObject, ...]
    ground: float | None
    findings: tuple[Finding, ...]


def read_sdf_world(file: Path) -> SdfWorld:
    """Return the static models of an SDF world. Models that move, lights and plugins are left out.

    Raises:
        InputError: It is not readable XML.
    """
    notes = Notes()
    root = parse(file, Subject("world", file.stem), notes)
    if root.tag != "sdf":
        root.error("not-sdf", f"<{root.tag}> is not <sdf>")
        return SdfWorld((), None, tuple(notes.findings))
    objects: list[StaticObject] = []
    heights: list[float] = []
    for place in [root, *root.all("world")]:
        for node in place.all("include"):
            node.warning("include-left-out", "<include> is not followed; put the model itself here")
        for node in place.all("model"):
            model = node.about(Subject("model", node.attribute("name")))
            for shape in _static_shapes(model):
                if isinstance(shape, StaticObject):
                    objects.append(shape)
                else:
                    heights.append(shape)
    for extra in heights[1:]:
        root.warning("second-ground", f"a second ground at {extra!r} m is left out")
    unique = _named_apart(objects)
    return SdfWorld(tuple(unique), heights[0] if heights else None, tuple(notes.findings))


def _named_apart(objects: list[StaticObject]) -> Iterator[StaticObject]:
    """The objects, numbered where they share a name."""
    seen: dict[str, int] = {}
    for each in objects:
        count = seen[each.name] = seen.get(each.name, 0) + 1
        yield each if count == 1 else replace(each, name=f"{each.name}_{count}")


def _static_shapes(model: Node) -> Iterator[StaticObject | float]:
    """The shapes of a static model; the height of a level plane."""
    static = model.optional("static")
    if static is None or static.text not in TRUE:
        model.warning("moving-model-left-out", "it is not static; only static models are read")
        return
    for node in model.all("model", "include"):
        node.warning("model-left-out", f"<{node.tag}> in a model is not read")
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
        own = f"{model.subject.name}_{name}_{collision.attribute('name', '')}"
        label = model.subject.name if len(collisions) == 1 else own
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
                shape.error("bad-size", f"<{shape.tag}> has a size that is not above 0: {listed}")
                continue
            friction, restitution = _surface(collision)
            yield StaticObject(name, shape.tag, sizes, pose, file, friction, restitution)
        elif shape.tag != "empty":
            problem = f"a collision of {shortened(shape.tag)} is left out"
            shape.warning("geometry-left-out", problem)


def _plane(shape: Node, pose: Pose) -> Iterator[float]:
    """The height of a level plane; SDF's planes have no ends for contacts."""
    normal: Vector3 = (0.0, 0.0, 1.0)
    given = shape.optional("normal")
    if given is not None:
        normal = given.vector3()
    x, y, z = (a - b for a, b in zip(apply(pose, normal), pose.position, strict=True))
    if z <= 0 or math.hypot(x, y) > _LEVEL * z:
        shape.warning("plane-left-out", "a plane that is not level is left out; use a box")
        return
    yield pose.position[2]


def _sizes(shape: Node) -> tuple[tuple[float, ...], Path | None]:
    if shape.tag == "box":
        return shape.vector("size"), None
    if shape.tag == "sphere":
        return (shape.number("radius"),), None
    if shape.tag == "mesh":
        uri, scale = shape.required("uri"), shape.optional("scale")
        file = mesh_file("" if uri is None else uri.text, shape.file.parent)
        return ((1.0, 1.0, 1.0) if scale is None else scale.vector3()), file
    return (shape.number("radius"), shape.number("length")), None


def _surface(collision: Node) -> tuple[float | None, float | None]:
    """Friction (the smaller of ODE's two) and restitution, where the file has them."""
    surface = collision.optional("surface")
    if surface is None:
        return None, None
    friction = _inner(surface, "friction", "ode")
    bounce = surface.optional("bounce")
    mu = None
    if friction is not None:
        given = [node for tag in ("mu", "mu2") if (node := friction.optional(tag)) is not None]
        mu = min((friction.number(node.tag) for node in given), default=None)
    known = bounce is not None and bounce.optional("restitution_coefficient") is not None
    restitution = bounce.number("restitution_coefficient") if bounce and known else None
    return mu, restitution


def _inner(node: Node, *tags: str) -> Node | None:
    found: Node | None = node
    for tag in tags:
        found = None if found is None else found.optional(tag)
    return found
