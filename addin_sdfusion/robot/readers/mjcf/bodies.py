"""The bodies of an MJCF file with what is on them, `<frame>` elements resolved."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass, field, replace
from typing import Any

from ...finding import Subject
from ...formats.reading.xml import ZERO, Node
from ...model.robot import WORLD
from ...model.transform import IDENTITY, Transform
from .compiler import Compiler
from .document import Document

ON_BODIES = ("joint", "geom", "site")
SOFT = ("composite", "flexcomp")
"""What makes ropes, cloths and soft bodies."""
MOST_COPIES = 10_000
"""So many elements may be made by `<replicate>`."""


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
    names, copies = _taken(document), _Copies()
    world = Body(WORLD, "", document.root)
    found, ordered = [world], [world]
    waiting = [_Place(node, world, IDENTITY, "") for node in document.sections("worldbody")]
    waiting.reverse()
    while waiting:
        place = waiting.pop()
        if place.body is not ordered[-1] and place.node.tag == "body":
            ordered.append(place.body)
        inner = list(_inside(document, compiler, place, found, names, copies))
        waiting += reversed(inner)
    return ordered


def _taken(document: Document) -> set[str]:
    found = {WORLD}
    for section in document.sections("worldbody"):
        found |= {str(e.get("name")) for e in section.element.iter("body")}
    return found


class _Copies:
    """Copies of what a `<replicate>` holds.

    Attributes:
        left: How many elements may still be made.
    """

    def __init__(self) -> None:
        self.left = MOST_COPIES

    def of(
        self, node: Node, compiler: Compiler, place: Transform
    ) -> Iterator[tuple[Node, Transform]]:
        """Each copy, with its place: an offset, turned as the copy before, from that one's.

        The angles are multiples of those given. Names get the separator and the copy's number,
        with as many digits as the count has.
        """
        count = int(min(max(node.number_attribute("count", 0.0), 0.0), MOST_COPIES + 1.0))
        self.left -= count * sum(1 for _ in node.element.iter())
        if self.left < 0:
            node.error("too-many-copies", f"<replicate> makes over {MOST_COPIES} elements")
            return
        offset = node.vector_attribute("offset") if node.has("offset") else ZERO
        angles = node.vector_attribute("euler") if node.has("euler") else ZERO
        at = ZERO
        between, behind = node.attribute("sep", ""), node.element.get(BEHIND, "")
        for k in range(count):
            copy = deepcopy(node.element)
            number = f"{between}{k:0{len(str(count))}d}{behind}"
            for element in copy.iterdescendants():
                if any(above.tag == "replicate" for above in _between(element, copy)):
                    continue
                if element.tag == "replicate":
                    element.set(BEHIND, number + element.get(BEHIND, ""))
                elif element.get("name"):
                    element.set("name", f"{element.get('name')}{number}")
            x, y, z = (k * angle for angle in angles)
            T = Transform(compiler.of_euler((x, y, z)), at)
            yield replace(node, element=copy), place.compose(T)
            at = T.apply(offset)


BEHIND = "_behind"
"""What copies within copies have behind their own numbers: an attribute that no file has."""


def _between(element: Any, top: Any) -> Iterator[Any]:
    """What an element is in, up to another one that it is in, without that."""
    above = element.getparent()
    while above is not top:
        yield above
        above = above.getparent()


def _inside(
    document: Document,
    compiler: Compiler,
    place: _Place,
    bodies: list[Body],
    names: set[str],
    copies: _Copies,
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
        elif child.tag == "replicate":
            for copy, T in copies.of(child, compiler, place.T):
                yield _Place(copy, place.body, T, class_)
        elif child.tag in SOFT:
            problem = f"<{child.tag}> is left out; have MuJoCo save the model, which expands it"
            child.warning("soft-body-left-out", problem)
        elif child.tag == "attach":
            problem = "<attach> is not supported; have MuJoCo save the model, which expands it"
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
