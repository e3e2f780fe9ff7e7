"""Edits of the via points of the chosen muscle, and of task points and markers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

from ....muscles.rows import PointRow, free_name
from ....robot.errors import InputError
from ....robot.model.pose import Vector3
from ....robot.model.robot import POSITIONS
from ....snapshot import Role
from .model import MuscleModel
from .picks import HANDLE, Pick, picked_link


def pick_point(model: MuscleModel, pick: Pick) -> None:
    """Add a via point to the chosen muscle, which is created if necessary."""
    muscle = model.muscle or model.table.new_muscle_name()
    point = _picked_row(model, "via", pick, muscle=muscle)
    model.table = model.table.insert_point(point, model.insert_at)
    model.muscle = point.muscle
    index = -1
    if model.insert_at is not None:
        index, model.insert_at = model.insert_at, model.insert_at + 1
    model.message = f"{_point(model, index)} is on link {point.link}."


def pick_other(model: MuscleModel, pick: Pick, role: Literal["task", "marker"]) -> None:
    """Add a task point or marker with a unique name."""
    point = _picked_row(model, role, pick, axes=POSITIONS if role == "task" else ())
    tasks, markers = model.table.tasks, model.table.markers
    alike = tasks if role == "task" else markers
    names = (f"{point.link}_{n}" if n else point.link for n in range(len(alike) + 1))
    point = replace(point, name=free_name(list(names), alike))
    others = (*tasks, point, *markers) if role == "task" else (*tasks, *markers, point)
    model.table = replace(model.table, others=others)
    kind = "Task point" if role == "task" else "Marker"
    model.message = f"{kind} {point.name} is on link {point.link}."


def _picked_row(model: MuscleModel, role: Role, pick: Pick, **more: Any) -> PointRow:
    """Return the row of a picked point; a construction point can have only one use."""
    used = {row.entity for row in (*model.table.points, *model.table.others)}
    entity = "" if pick.entity in used and not pick.entity.startswith(HANDLE) else pick.entity
    link, path = picked_link(model, pick), pick.occurrence
    return PointRow(role, link, occurrence=path, position=pick.position, entity=entity, **more)


def edit_point(model: MuscleModel, edit: str, index: int) -> int:
    """Handle a button below the table of points.

    Args:
        edit: `up`, `down`, `insert`, `duplicate` or `delete`.
        index: Index of the selected point, or -1.

    Returns:
        Index of the newly selected point, or -1.
    """
    count = len(model.points)
    if edit == "insert" and model.insert_at is not None:
        model.insert_at = None
        model.message = "The next points are appended."
        return index
    if not 0 <= index < count:
        raise InputError("Select a point in the table first.")
    if edit == "insert":
        model.insert_at = index
        number = model.points[index].number
        model.message = f"The next points are inserted before point {number}."
        return index
    model.insert_at = None
    if edit == "duplicate":
        model.points[index].require_found()
        model.table = model.table.duplicate_point(model.muscle, index)
        return index + 1
    if edit == "delete":
        model.table = model.table.delete_point(model.muscle, index)
        return min(index, count - 2)
    by = -1 if edit == "up" else 1
    model.table = model.table.move_point(model.muscle, index, by)
    return min(max(index + by, 0), count - 1)


def set_link(model: MuscleModel, index: int, link: str) -> None:
    """Change the link of a point of the chosen muscle."""
    if model.points[index].link != link:
        model.table = model.table.change_point(model.muscle, index, lambda p: p.on_link(link))
        model.message = f"{_point(model, index)} is on link {link}."


def set_position(model: MuscleModel, index: int, position: Vector3) -> None:
    """Move a point of the chosen muscle to a position, in [m]."""
    model.points[index].require_found()
    model.table = model.table.change_point(
        model.muscle, index, lambda p: replace(p, position=position, entity="", made=False)
    )
    model.message = f"{_point(model, index)} is moved."


def _point(model: MuscleModel, index: int) -> str:
    return f"Point {model.points[index].number} of {model.muscle}"


# Task points and markers


def rename_other(model: MuscleModel, index: int, name: str) -> None:
    """Rename a task point or marker."""
    _edit_other(model, index, replace(model.table.others[index], name=name.strip()))


def move_other(model: MuscleModel, index: int, link: str) -> None:
    """Change the link of a task point or marker."""
    point = model.table.others[index]
    if point.link != link:
        _edit_other(model, index, point.on_link(link))


def delete_other(model: MuscleModel, index: int) -> None:
    """Delete a task point or marker."""
    if not 0 <= index < len(model.table.others):
        raise InputError("Select a task point or marker in the table first.")
    _edit_other(model, index)


def _edit_other(model: MuscleModel, index: int, *new: PointRow) -> None:
    others = model.table.others
    model.table = replace(model.table, others=(*others[:index], *new, *others[index + 1 :]))
