"""Reads muscles and end effectors as cardsflow.xml and the SDF plugin have them."""

from __future__ import annotations

import math
from typing import cast

from ..finding import member
from ..model import Axis, TaskFrame, TaskSet
from ..muscle import CableSet, Muscle, ViaPoint
from .xml import Node, shortened


def read_cable_set(parent: Node, name: str, active: str) -> CableSet:
    """The `<myoMuscle>` children of an element as a cable set.

    Args:
        parent: The element.
        name: The name of the set.
        active: The name of the active set.
    """
    muscles = []
    for node in parent.all("myoMuscle"):
        subject = member("muscle", node.attribute("name"), name, active)
        muscles.append(_muscle(node.about(subject)))
    return CableSet(name, tuple(muscles))


def read_task_set(parent: Node, name: str, active: str) -> TaskSet:
    """The `<endEffector>` children of an element as a task set.

    Args:
        parent: The element.
        name: The name of the set.
        active: The name of the active set.
    """
    frames = []
    for node in parent.all("endEffector"):
        subject = member("task_frame", node.attribute("name"), name, active)
        frames.append(_task_frame(node.about(subject)))
    return TaskSet(name, tuple(frames))


def _muscle(node: Node) -> Muscle:
    points = []
    for block in node.all("link"):
        link = block.attribute("name")
        points += [_via_point(point, link) for point in block.all("viaPoint")]
    f_min = node.number_attribute("f_min", 0.0)
    f_max = node.number_attribute("f_max", math.inf, infinite=True)
    return Muscle(node.attribute("name"), tuple(points), f_min, f_max)


def _via_point(node: Node, link: str) -> ViaPoint:
    kind = node.attribute("type")
    if node.has("type") and kind != "FIXPOINT":
        problem = f"via point type {shortened(kind)} is not supported (supported: FIXPOINT)"
        node.error("unsupported-via-point", problem)
    return ViaPoint(link, node.vector3())


def _task_frame(node: Node) -> TaskFrame:
    axes = tuple(cast(Axis, letter) for letter in node.attribute("axes", "xyz"))
    return TaskFrame(node.attribute("name"), node.attribute("link"), node.vector3(), axes)
