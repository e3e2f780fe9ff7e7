"""Reads CASPR's operational spaces, as far as they are positions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from ..errors import UnknownNameError
from ..finding import Subject, member
from ..model import WORLD, Axis, Link, TaskFrame, TaskSet
from .caspr_links import link_by_number
from .xml import Node


def read_operational_spaces(root: Node, links: Sequence[Link]) -> tuple[tuple[TaskSet, ...], str]:
    """The task sets of a file and the name of the active one.

    Args:
        root: The root of the file.
        links: The robot's links, by number.
    """
    if root.tag != "operational_spaces":
        root.error("not-caspr", f"<{root.tag}> is not CASPR's <operational_spaces>")
        return (), ""
    nodes = [
        node.about(Subject("task_set", node.attribute("id")))
        for node in root.all("operational_set")
    ]
    nodes = [node for node in nodes if _has_positions(node)]
    active = _active(root, [node.subject.name for node in nodes])
    return tuple(_task_set(node, links, active) for node in nodes), active


def _has_positions(node: Node) -> bool:
    for item in node.all():
        if item.tag != "position":
            item.warning("unsupported-task", f"<{item.tag}> is not supported; left out")
    if not node.all("position"):
        node.warning("empty-task-set", "holds no position; the whole set is left out")
    return bool(node.all("position"))


def _active(root: Node, names: list[str]) -> str:
    default = root.attribute("default_operational_set", "")
    if default and default not in names:
        what = UnknownNameError("operational space", default, names).what
        root.error("unknown-task-set", f"default_operational_set: {what}")
    return default or (names[0] if names else "")


def _task_set(node: Node, links: Sequence[Link], active: str) -> TaskSet:
    name = node.subject.name
    frames = []
    for item in node.all("position"):
        subject = member("task_frame", item.attribute("name"), name, active)
        frames.append(_task_frame(item.about(subject), links))
    return TaskSet(name, tuple(frames))


def _task_frame(node: Node, links: Sequence[Link]) -> TaskFrame:
    link = link_by_number(node, links)
    axes = node.required("axes")
    letters = axes.attribute("active_axes") if axes else ""
    return TaskFrame(
        node.attribute("name"),
        WORLD if link is None else link.name,
        node.vector("offset"),
        tuple(cast(Axis, letter) for letter in letters),
    )
