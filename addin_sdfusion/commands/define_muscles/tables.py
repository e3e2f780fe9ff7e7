"""Tables of the dialog: content of each column, and handlers of edits."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ...muscles.path import path_of
from ...muscles.table import PointRow
from ...robot.errors import InputError
from ...robot.model.laws.law import Parameter
from ...robot.model.muscle_laws import law_of
from ...robot.model.pose import Vector3
from ...robot.model.robot import WORLD
from ...snapshot import MuscleSnapshot, WrapUse
from ..inputs import Cell, CellEdit
from .dialog import INSIDE, MARKER, MODELS, SIDES, TASK
from .editor import MuscleEditor, parameter_names


@dataclass(frozen=True)
class Column:
    """Column of a table.

    Attributes:
        shown: Function that returns the cell of an item.
        edited: Handler of an edited cell; None for a read-only column.
    """

    shown: Callable[[MuscleEditor, Any], Cell]
    edited: Callable[[MuscleEditor, int, Any], None] | None = None


@dataclass(frozen=True)
class Rows:
    """Table with one row per item."""

    items: Callable[[MuscleEditor], Sequence[Any]]
    columns: tuple[Column, ...]

    def cells(self, editor: MuscleEditor) -> list[list[Cell]]:
        """Return the cells of the table."""
        return [
            [column.shown(editor, item) for column in self.columns] for item in self.items(editor)
        ]


def edit_cell(editor: MuscleEditor, edit: CellEdit) -> None:
    """Handle an edited cell.

    Raises:
        InputError: The value is invalid for the cell.
    """
    edited = TABLES[edit.table].columns[edit.column].edited
    if edited is not None:
        edited(editor, edit.row, edit.value)


def with_chosen(options: tuple[str, ...], chosen: str) -> tuple[str, ...]:
    """Return the options, including the current choice."""
    return options if chosen in options else (*options, chosen)


def _text(text: str) -> Cell:
    return Cell(text, editable=True)


def _link(editor: MuscleEditor, link: str) -> Cell:
    return Cell(link, with_chosen((*editor.links, WORLD), link))


# Points of the chosen muscle


def _position(position: Vector3) -> str:
    """Return a position in [mm] as text."""
    return ", ".join(f"{1000 * v:.1f}" for v in position)


def _place(_: MuscleEditor, point: PointRow) -> Cell:
    """Return the position of a point, or the reason why it is not found."""
    return Cell(f"not found: {point.lost}") if point.lost else _text(_position(point.position))


def _point_link(editor: MuscleEditor, point: PointRow) -> Cell:
    return Cell(point.link) if point.lost else _link(editor, point.link)


def _put(editor: MuscleEditor, index: int, text: str) -> None:
    """Move a point to a position given as text in [mm].

    The coordinates are separated by commas, spaces or semicolons. An unchanged coordinate keeps its
    full precision, which the text does not show.
    """
    before = editor.table.points_of(editor.muscle)[index].position
    parts = text.split(";") if ";" in text else text.replace(",", " ").split()
    if len(parts) != 3:
        raise InputError(f"{text!r} must be x, y, z in mm.")
    x, y, z = (
        old if part.strip() == was else 0.001 * _number(part)
        for part, was, old in zip(parts, _position(before).split(", "), before, strict=True)
    )
    if not all(map(math.isfinite, (x, y, z))):
        raise InputError(f"{text!r} must be x, y, z in mm.")
    editor.point_position(index, (x, y, z))


def _number(text: str) -> float:
    try:
        return float(text.strip().replace(",", "."))
    except ValueError:
        raise InputError(f"{text!r} is not a number.") from None


def _other_link(editor: MuscleEditor, point: PointRow) -> Cell:
    return Cell(f"not found: {point.lost}") if point.lost else _link(editor, point.link)


# Parameters of the muscle law: pairs of a muscle and the name of a parameter


def _parameters(editor: MuscleEditor) -> list[tuple[MuscleSnapshot, str]]:
    row = editor.table.row(editor.muscle)
    return [] if row is None else [(row, name) for name in parameter_names(row)]


def _value(_: MuscleEditor, item: tuple[MuscleSnapshot, str]) -> Cell:
    row, name = item
    return _text(f"{row.parameters[name]:g}" if name in row.parameters else "")


def _meaning(_: MuscleEditor, item: tuple[MuscleSnapshot, str]) -> Cell:
    row, name = item
    known: dict[str, Parameter] = {p.name: p for p in law_of(row.cable_model).parameters}
    if name not in known:
        return Cell("unknown to this muscle law")
    p = known[name]
    default = "" if p.default is None else f", {p.default:g}"
    return Cell(f"{p.unit}{default}: {p.meaning}")


def _set_parameter(editor: MuscleEditor, index: int, text: str) -> None:
    row, name = _parameters(editor)[index]
    given = {key: number for key, number in row.parameters.items() if key != name}
    if text.strip():
        given[name] = _number(text)
    editor.change(parameters=given)


# All muscles


def _muscle(editor: MuscleEditor, index: int) -> str:
    return editor.table.rows[index].name


def _size(editor: MuscleEditor, row: MuscleSnapshot) -> Cell:
    count, path = len(editor.table.points_of(row.name)), path_of(editor.table, row.name)
    return Cell(f"{count}, {path.length_text}")


# Muscles that wrap over a surface


def _uses(editor: MuscleEditor) -> tuple[WrapUse, ...]:
    wrap = editor.wrap_row()
    return () if wrap is None else wrap.muscles


def _side(_: MuscleEditor, use: WrapUse) -> Cell:
    text = next(text for text, number in SIDES.items() if number == use.side)
    return Cell(INSIDE if use.inside else text, (*SIDES, INSIDE))


def _set_side(editor: MuscleEditor, index: int, text: str) -> None:
    if text == INSIDE:
        editor.change_use(index, side=0, inside=True, turns=0)
    else:
        editor.change_use(index, side=SIDES[text], inside=False)


TABLES = {
    "points": Rows(
        lambda e: e.table.points_of(e.muscle),
        (
            Column(lambda e, point: Cell(str(point.number))),
            Column(_point_link, MuscleEditor.point_link),
            Column(_place, _put),
        ),
    ),
    "parameters": Rows(
        _parameters,
        (
            Column(lambda e, item: Cell(item[1])),
            Column(_value, _set_parameter),
            Column(_meaning),
        ),
    ),
    "all": Rows(
        lambda e: e.table.rows,
        (
            Column(lambda e, row: _text(row.name), lambda e, i, v: e.rename(v, _muscle(e, i))),
            Column(
                lambda e, row: _text(f"{row.f_min:g}"),
                lambda e, i, v: e.change(_muscle(e, i), f_min=_number(v)),
            ),
            Column(
                lambda e, row: _text(f"{row.f_max:g}"),
                lambda e, i, v: e.change(_muscle(e, i), f_max=_number(v)),
            ),
            Column(
                lambda e, row: Cell(row.model, with_chosen(MODELS, row.model)),
                lambda e, i, v: e.change_model(_muscle(e, i), v),
            ),
            Column(_size),
        ),
    ),
    "wrap_uses": Rows(
        _uses,
        (
            Column(
                lambda e, use: Cell(
                    use.muscle, with_chosen(tuple(row.name for row in e.table.rows), use.muscle)
                ),
                lambda e, i, v: e.change_use(i, muscle=v),
            ),
            Column(lambda e, use: Cell(use.after), lambda e, i, v: e.change_use(i, after=int(v))),
            Column(_side, _set_side),
            Column(lambda e, use: Cell(use.turns), lambda e, i, v: e.change_use(i, turns=int(v))),
        ),
    ),
    "others": Rows(
        lambda e: e.table.others,
        (
            Column(lambda e, point: Cell(TASK if point.role == "task" else MARKER)),
            Column(lambda e, point: _text(point.name), MuscleEditor.rename_other),
            Column(_other_link, MuscleEditor.move_other),
        ),
    ),
}
