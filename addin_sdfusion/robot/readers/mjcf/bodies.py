"""The bodies of an MJCF file with what is on them, `<frame>` elements resolved."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from ...finding import Subject
from ...model.robot import WORLD
from ...model.transform import IDENTITY, Transform
from ..xml import Node
from .compiler import Compiler
from .document import Document

ON_BODIES = ("joint", "geom", "site")
UNSUPPORTED = ("composite", "flexcomp", "replicate", "attach")


@dataclass(frozen=True)
class Part:
    """A joint, geom or site with its class's attributes.

    Attributes:
        node: Its element.
        T: What its place is relative to, in the body: a frame.
        link: The body.
    """

    node: Node
    T: Transform
    link: str


@dataclass
class Body:
    """A body.

    Attributes:
        name: Its name; `world` of the world.
        parent: Its parent's.
        node: Its element.
        T: Its place in the parent.
        joints, geoms, sites: What is on it, in order.
        inertial: Its `<inertial>`, and the frame that it is in.
    """

    name: str
    parent: str
    node: Node
    T: Transform = IDENTITY
    joints: list[Part] = field(default_factory=list)
    geoms: list[Part] = field(default_factory=list)
    sites: list[Part] = field(default_factory=list)
    inertial: Part | None = None


@dataclass(frozen=True)
class _Place:
    node: Node
    body: Body
    T: Transform
    class_: str


def read_bodies(document: Document, compiler: Compiler) -> list[Body]:
    """The world and all bodies, parents first, in MuJoCo's order: depth first."""
    names = _taken(document)
    world = Body(WORLD, "", document.root)
    found, ordered = [world], [world]
    waiting = [_Place(node, world, IDENTITY, "") for node in document.sections("worldbody")]
    waiting.reverse()
    while waiting:
        place = waiting.pop()
        if place.body is not ordered[-1] and place.node.tag == "body":
            ordered.append(place.body)
        inner = list(_inside(document, compiler, place, found, names))
        waiting += reversed(inner)
    return ordered


def _taken(document: Document) -> set[str]:
    found = {WORLD}
    for section in document.sections("worldbody"):
        found |= {str(e.get("name")) for e in section.element.iter("body")}
    return found


def _inside(
    document: Document, compiler: Compiler, place: _Place, bodies: list[Body], names: set[str]
) -> Iterator[_Place]:
    """Sort what an element holds onto its body; what is to be read next."""
    for child in document.children(place.node):
        class_ = child.attribute("childclass", place.class_)
        if child.tag == "body":
            T = place.T.compose(compiler.place(child))
            name = _name(child, names, len(bodies))
            about = child.about(Subject("link", name))
            body = Body(name, place.body.name, about, T)
            bodies.append(body)
            yield _Place(about, body, IDENTITY, class_)
        elif child.tag == "frame":
            yield _Place(child, place.body, place.T.compose(compiler.place(child)), class_)
        elif child.tag == "freejoint":
            place.body.joints.append(Part(child, place.T, place.body.name))
        elif child.tag in ON_BODIES:
            node = document.with_defaults(child, place.class_)
            lists = {"joint": place.body.joints, "geom": place.body.geoms, "site": place.body.sites}
            lists[child.tag].append(Part(node, place.T, place.body.name))
        elif child.tag == "inertial":
            place.body.inertial = Part(child, place.T, place.body.name)
        elif child.tag in UNSUPPORTED:
            problem = (
                f"<{child.tag}> is not supported; have MuJoCo save the model, which expands it"
            )
            child.error("unsupported-element", problem)


def _name(node: Node, names: set[str], number: int) -> str:
    """The name of a body; one without a name gets a number, unique in the model."""
    given = node.attribute("name", "")
    if given and given != WORLD:
        return given
    name = f"body_{number}"
    while name in names:
        name += "_"
    names.add(name)
    return name
