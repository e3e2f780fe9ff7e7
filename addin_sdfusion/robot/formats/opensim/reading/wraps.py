"""Wrap objects of OpenSim."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple, cast, get_args

from ....finding import Subject
from ....model.muscle import Quadrant, WrapSurface
from ....model.robot import WORLD
from ....model.transform import IDENTITY, Transform
from ...reading.xml import Node, shortened
from .document import is_true, objects, text
from .frames import Frames, offset, pose_of
from .tori import Torus

SHAPES = ("WrapSphere", "WrapCylinder", "WrapEllipsoid", "WrapTorus")


class WrapObject(NamedTuple):
    """A wrap object.

    Attributes:
        surface: The surface; a torus, which is none of ours.
        quadrant: The half of space that paths over it keep to.
    """

    surface: WrapSurface | Torus
    quadrant: Quadrant


def read_wrap_objects(model: Node, frames: Frames) -> dict[str, WrapObject | None]:
    """Return the wrap objects by name; None for those that are switched off."""
    found: dict[str, WrapObject | None] = {}
    for link, T_link_frame, owner in _owners(model, frames):
        for node in objects(owner, "WrapObjectSet"):
            name = node.attribute("name")
            node = replace(node, subject=Subject("wrap_surface", name))
            if name in found:
                problem = "an earlier wrap object has the same name; references use the earlier one"
                node.warning("duplicate-wrap-surface", problem)
            elif is_true(node, "active", True):
                found[name] = _read(node, name, link, T_link_frame)
            else:
                found[name] = None
    return found


def _owners(model: Node, frames: Frames) -> Iterator[tuple[str, Transform, Node]]:
    """What wrap objects hang on: the link, the place in it, the element."""
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
    known = ", ".join(SHAPES)
    problem = f"<{node.tag}> {name!r} is not supported ({known} are): paths go straight there"
    node.warning("wrap-left-out", problem)
    return None


ENDLESS = 100.0
"""In [m]: a cylinder as long as this has no ends; our own files write none longer."""


def _quadrant(node: Node) -> Quadrant:
    """`x` is short for `+x`."""
    word = text(node, "quadrant", "all").lower()
    word = f"+{word}" if word in ("x", "y", "z") else word
    known: Sequence[str] = get_args(Quadrant)
    if word not in known:
        problem = f"quadrant {shortened(word)} is not one of {', '.join(known)}"
        node.error("bad-word", problem)
        return "all"
    return cast(Quadrant, word)
