"""Reader of OpenSim wrap objects."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple, cast, get_args

from ....finding import Subject
from ....model.muscle import Quadrant, WrapSurface
from ....model.robot import WORLD
from ....model.transform import IDENTITY, Transform
from ...reading.xml import Node, short_repr
from ..writing.wraps import ENDLESS
from .document import is_true, objects, text
from .frames import Frames, offset, pose_of
from .tori import Torus

SHAPES = ("WrapSphere", "WrapCylinder", "WrapEllipsoid", "WrapTorus")


class WrapObject(NamedTuple):
    """Wrap object of the model.

    Attributes:
        surface: The wrap surface, or a torus, which the robot model does not support.
        quadrant: Half-space to which paths over it are restricted.
    """

    surface: WrapSurface | Torus
    quadrant: Quadrant


def read_wrap_objects(model: Node, frames: Frames) -> dict[str, WrapObject | None]:
    """Return the wrap objects by name; None for disabled ones."""
    wrap_objects: dict[str, WrapObject | None] = {}
    for link, T_link_frame, owner in _owners(model, frames):
        for node in objects(owner, "WrapObjectSet"):
            name = node.attribute("name")
            node = replace(node, subject=Subject("wrap_surface", name))
            if name in wrap_objects:
                problem = "another wrap object has the same name; references use the earlier one"
                node.warning("duplicate-wrap-surface", problem)
            elif is_true(node, "active", True):
                wrap_objects[name] = _read(node, name, link, T_link_frame)
            else:
                node.mark_used()  # without influence in OpenSim
                wrap_objects[name] = None
    return wrap_objects


def _owners(model: Node, frames: Frames) -> Iterator[tuple[str, Transform, Node]]:
    """Yield the owners of wrap objects: link, pose in the link, element."""
    links = [(WORLD, node) for node in model.all("Ground")]
    links += [(body.attribute("name", ""), body) for body in objects(model, "BodySet")]
    for link, node in links:
        yield link, IDENTITY, node
        for path, frame in frames.offsets(link):
            yield link, frames.place(frame, "socket_parent", path)[1], frame


def _read(node: Node, name: str, link: str, T_link_frame: Transform) -> WrapObject | None:
    angles = "xyz_body_rotation"
    T = T_link_frame.compose(offset(node, angles))
    pose = pose_of(T, node if T_link_frame == IDENTITY else None, angles)
    quadrant = _quadrant(node)
    if node.tag == "WrapSphere":
        return WrapObject(WrapSurface(name, link, "sphere", node.number("radius"), pose), quadrant)
    if node.tag == "WrapCylinder":
        radius, length = node.number("radius"), node.number("length", 1.0, infinite=True)
        length = math.inf if length >= ENDLESS else length
        return WrapObject(WrapSurface(name, link, "cylinder", radius, pose, length), quadrant)
    if node.tag == "WrapEllipsoid":
        a, b, c = node.vector("dimensions")
        surface = WrapSurface(name, link, "ellipsoid", a, pose, half_axes=(b, c))
        return WrapObject(surface, quadrant)
    if node.tag == "WrapTorus":
        tube, ring = node.number("inner_radius"), node.number("outer_radius")
        return WrapObject(Torus(node, link, pose, tube, ring), quadrant)
    problem = f"unsupported <{node.tag}> {name!r}; paths are straight there"
    node.warning("wrap-left-out", problem, SHAPES)
    return None


def _quadrant(node: Node) -> Quadrant:
    """Return the quadrant of a wrap object; `x` means `+x`."""
    word = text(node, "quadrant", "all").lower()
    word = f"+{word}" if word in ("x", "y", "z") else word
    quadrants: Sequence[str] = get_args(Quadrant)
    if word not in quadrants:
        node.error("bad-word", f"unknown quadrant {short_repr(word)}", quadrants)
        return "all"
    return cast(Quadrant, word)
