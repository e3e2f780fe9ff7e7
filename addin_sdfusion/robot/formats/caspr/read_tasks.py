"""Reader of the operational spaces of CASPR."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from ...caspr_vocabulary import CASPR_AXES, CASPR_TASKS, ORIENTATION
from ...errors import UnknownNameError
from ...finding import member
from ...model.robot import WORLD, Axis, Link, TaskFrame, TaskSet
from ..reading.unique_names import with_unique_names
from ..reading.xml import ZERO, Node, short_repr
from .read_links import link_by_number


def read_operational_spaces(root: Node, links: Sequence[Link]) -> tuple[tuple[TaskSet, ...], str]:
    """Return the task sets of a file and the name of the active set.

    Orientations are read with the convention of task frames. The convention of CASPR is not
    consistent: its y contains angles, but its Jacobian returns the angular velocity. The order of
    the angles also differs between poses and orientations.

    A pose becomes two task frames: a position with its name, and an orientation with the name plus
    `_orientation`.
    """
    if root.tag != "operational_spaces":
        root.error("not-caspr", f"<{root.tag}> is not CASPR's <operational_spaces>")
        return (), ""
    nodes = [node.named("task_set", "id") for node in root.all("operational_set")]
    nodes = [node for node in nodes if _has_items(node)]
    active = _active(root, [node.subject.name for node in nodes])
    return tuple(_task_set(node, links, active) for node in nodes), active


def _has_items(node: Node) -> bool:
    for item in node.all():
        if item.tag not in CASPR_TASKS:
            item.warning("unsupported-task", f"unknown <{item.tag}>; ignored", CASPR_TASKS)
    items = node.all(*CASPR_TASKS)
    if not items:
        problem = f"contains no {', '.join(CASPR_TASKS)}; the whole set is ignored"
        node.warning("empty-task-set", problem)
    return bool(items)


def _active(root: Node, names: list[str]) -> str:
    default = root.attribute("default_operational_set", "")
    if default and default not in names:
        problem = UnknownNameError("operational space", default, names).problem
        root.error("unknown-task-set", f"default_operational_set: {problem}")
    return default or (names[0] if names else "")


def _task_set(node: Node, links: Sequence[Link], active: str) -> TaskSet:
    name = node.subject.name
    frames: list[TaskFrame] = []
    items = node.all(*CASPR_TASKS)
    for item in with_unique_names(items, partial(member, "task_frame", of=name, active=active)):
        subject = member("task_frame", item.attribute("name"), name, active)
        for frame in _task_frames(item.with_subject(subject), links):
            item.with_subject(member("task_frame", frame.name, name, active))
            frames.append(frame)
    return TaskSet(name, tuple(frames))


def _task_frames(node: Node, links: Sequence[Link]) -> list[TaskFrame]:
    """Return the frame of an item; a pose has a frame for its position and its orientation."""
    name = node.attribute("name")
    number = link_by_number(node, links)
    link = WORLD if number is None else number.name
    offset = ZERO if node.tag == "orientation_euler_xyz" else node.vector("offset")
    axes = _axes(node)
    lengths = tuple(axis for axis in axes if axis in ("x", "y", "z"))
    angles = tuple(axis for axis in axes if axis not in lengths)
    if not angles:
        return [TaskFrame(name, link, offset, lengths)]
    if not lengths:
        return [TaskFrame(name, link, ZERO, angles)]
    problem = "its angles are read as R = Rx Ry Rz, as in orientations; CASPR's poses differ"
    node.warning("pose-angles", problem)
    if axes != lengths + angles:
        node.warning("task-order", "the position coordinates come before the angles in y")
    point = TaskFrame(name, link, offset, lengths)
    return [point, TaskFrame(name + ORIENTATION, link, ZERO, angles)]


def _axes(node: Node) -> tuple[Axis, ...]:
    axes = node.required("axes")
    letters = axes.attribute("active_axes") if axes else ""
    allowed = CASPR_TASKS[node.tag]
    if axes and not set(letters) <= set(allowed):
        problem = f"active_axes {short_repr(letters)}: use only {', '.join(allowed)}, each once"
        axes.error("bad-task-axes", problem)
    return tuple(CASPR_AXES[letter] for letter in letters if letter in allowed)
