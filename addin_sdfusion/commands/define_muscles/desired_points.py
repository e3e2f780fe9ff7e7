"""Desired construction points of a table, with names and attributes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from ...muscles.attributes import read_point
from ...muscles.point_names import marker_name, motor_numbers, task_point_name, via_point_name
from ...muscles.rows import MarkerRow, MuscleTable, TaskRow, ViaPointRow
from ...robot.errors import InputError
from ...snapshot import PointUse

AnyRow = ViaPointRow | TaskRow | MarkerRow


@dataclass(frozen=True)
class DesiredPoint:
    """A construction point as it shall be.

    Attributes:
        row: The row of the table.
        name: The name that it is given.
        attribute: What it is.
    """

    row: AnyRow
    name: str
    attribute: PointUse


def rows_of(table: MuscleTable) -> Iterator[AnyRow]:
    """All rows that are construction points."""
    yield from table.points
    yield from table.tasks
    yield from table.markers


def desired_points(table: MuscleTable) -> Iterator[DesiredPoint]:
    """All construction points as the table has them."""
    motors = motor_numbers(row.name for row in table.rows)
    for p in table.points:
        attribute = PointUse("via", p.link, p.muscle, p.number)
        yield _item(p, via_point_name(motors[p.muscle], p.link, p.number), attribute)
    for t in table.tasks:
        attribute = PointUse("task", t.link, name=t.name, axes=t.axes)
        yield _item(t, task_point_name(t.link), attribute)
    for m in table.markers:
        yield _item(m, marker_name(m.link), PointUse("marker", m.link, name=m.name))


def _item(row: AnyRow, name: str, attribute: PointUse) -> DesiredPoint:
    return DesiredPoint(row, name, replace(attribute, occurrence=row.occurrence, made=row.made))


def as_made(item: DesiredPoint) -> DesiredPoint:
    """The same, as a point that the add-in made."""
    return replace(item, attribute=replace(item.attribute, made=True))


def original_name(attribute: Any) -> str:
    """The name that the user gave a point, if its attribute remembers one."""
    try:
        return read_point(attribute.value).original if attribute else ""
    except InputError:
        return ""
