"""Define muscles command: from the inputs to the pending table and back."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...muscles.csv_import import imported
from ...muscles.csv_reader import read_csv
from ...muscles.csv_writer import csv_text
from ...muscles.edits import renumbered
from ...muscles.mirror import Plane
from ...muscles.rows import NAMED_COLORS, MuscleRow
from ...robot import limits
from ...robot.errors import CardsflowError, InputError
from ...robot.files import read_file, write_files
from ...robot.model.muscle import CableModel
from ...robot.model.pose import Vector3
from ...robot.model.tension_laws import law_of
from .. import clipboard
from ..command import Command, Window
from ..guard import chosen_file
from ..inputs import CellEdit, Inputs
from ..reading import Reading, read
from .dialog import (
    DIALOG,
    INSIDE,
    MARKER,
    NEW_MUSCLE,
    NO_SURFACE,
    OF_PART,
    PICKED_PLANE,
    PLANES,
    SIDES,
)
from .entities import Entities
from .pending import PendingTable
from .picks import Picks, plane
from .preview import draw
from .problems import problems
from .view import SHOWN, parameter_names, position_text, show
from .writing import Writer


class DefineMuscles(Window):
    """The open dialog."""

    def __init__(self, inputs: Inputs, design: Any) -> None:
        super().__init__(inputs, design)
        self._read: Reading = read(design)
        self._picks = Picks()
        self._entities = Entities(design, self._read.snapshot)
        note = "\n".join(f.message for f in self._read.table_findings[:SHOWN])
        self.pending = PendingTable(self._read.table, self._read.link_of, note or self._read.note)
        self._plane: Plane | None = None
        self._works: dict[str, Callable[[], None]] = {
            "pick": self._picked_points,
            "other_pick": self._picked_others,
            "wrap_pick": self._picked_faces,
            "plane_pick": self._picked_plane,
            "muscle": self._chosen,
            "link": self._link,
            "muscle_name": lambda: self.pending.rename(inputs.value("muscle_name")),
            "palette": self._palette,
            "color": self._color,
            "f_min": lambda: self._forces("f_min"),
            "f_max": lambda: self._forces("f_max"),
            "model": self._model,
            "delete_muscle": self.pending.delete,
            "wrap": self._chosen_wrap,
            "wrap_name": lambda: self.pending.rename_wrap(inputs.value("wrap_name")),
            "wrap_link": self._wrap_link,
            "wrap_delete": lambda: self.pending.change_wrap(lambda wrap: None),
            "use_add": self.pending.add_use,
            "use_delete": lambda: self.pending.change_use(
                inputs.selected("wrap_uses"), lambda use: None
            ),
            "other_delete": lambda: self.pending.delete_other(inputs.selected("others")),
            "mirror": self._mirror,
            "paste": lambda: self._take(clipboard.paste().encode(), "The clipboard"),
            "copy": self._copy,
            "csv_import": self._import,
            "csv_export": self._export,
        }

    def opened(self) -> None:
        """Shows the table of the design."""
        show(self.pending, self.inputs)

    def changed(self, changed: Any) -> None:
        """An edit of the pending table; errors are shown in the status."""
        name, selected = str(changed.id), None
        try:
            if name in _FOCUS:
                if changed.isActive:  # else it is the tab that was left
                    self.inputs[_FOCUS[name]].hasFocus = True  # what is clicked now goes there
            elif name in _EDITS:
                selected = self.pending.edit_point(name, self.inputs.selected("points"))
            elif name in self._works:
                self._works[name]()
            elif (edit := self.inputs.cell(changed)) is not None:
                self._cell_changed(edit)
            else:
                return
        except CardsflowError as error:
            self.pending.message = str(error)
        show(self.pending, self.inputs, selected)

    def valid(self) -> bool:
        """Whether the table can be written."""
        return not problems(self.pending.table, self.pending.links)

    def preview(self) -> None:
        """Draws the muscles."""
        draw(self.design, self.pending.table, self.pending.muscle)

    def execute(self) -> None:
        """Writes the table into the design."""
        entities = self._entities
        writer = Writer(
            self.design, self._picks, entities.points, entities.faces, self.pending.link_of
        )
        writer.write(self.pending.before, self.pending.table)

    # Picks

    def _picked_points(self) -> None:
        for entity, _ in self.inputs.picked("pick"):
            self.pending.pick_point(self._picks.point(entity, self._entities.point_key))

    def _picked_others(self) -> None:
        role = self.inputs.value("other_role")
        for entity, _ in self.inputs.picked("other_pick"):
            pick = self._picks.point(entity, self._entities.point_key)
            self.pending.pick_other(pick, "marker" if role == MARKER else "task")

    def _picked_faces(self) -> None:
        for entity, _ in self.inputs.picked("wrap_pick"):
            self.pending.pick_surface(self._picks.surface(entity, self._entities.face_key))

    def _picked_plane(self) -> None:
        for entity, _ in self.inputs.picked("plane_pick"):
            self._plane = plane(entity)
            self.inputs.choose("plane", (*PLANES, PICKED_PLANE), PICKED_PLANE)
            self.pending.message = "The picked plane is used; press Mirror."

    # The chosen muscle

    def _chosen(self) -> None:
        chosen = self.inputs.value("muscle")
        self.pending.choose("" if chosen == NEW_MUSCLE else chosen)

    def _link(self) -> None:
        chosen = self.inputs.value("link")
        self.pending.link = "" if chosen == OF_PART else chosen

    def _color(self) -> None:
        color = self.inputs.value("color").strip().lower()
        self.pending.change(lambda row: replace(row, color=color))

    def _forces(self, name: str) -> None:
        value = float(self.inputs.value(name))
        if name == "f_min":
            self.pending.change(lambda row: replace(row, f_min=value))
        else:
            self.pending.change(lambda row: replace(row, f_max=value))

    def _palette(self) -> None:
        color = NAMED_COLORS.get(self.inputs.value("palette"))
        if color is not None:
            self.pending.change(lambda row: replace(row, color=color))

    def _model(self) -> None:
        kind = self.inputs.value("model")
        self.pending.change(lambda row: replace(row, model=_as_kind(row.model, kind)))

    def _parameter(self, index: int, text: str) -> None:
        def changed(row: MuscleRow) -> MuscleRow:
            name = parameter_names(row.model)[index]
            given = dict(row.model.parameters)
            given.pop(name, None)
            if text.strip():
                given[name] = _number(text)
            return replace(row, model=CableModel(row.model.kind, tuple(given.items())))

        self.pending.change(changed)

    # Wrap surfaces

    def _chosen_wrap(self) -> None:
        chosen = self.inputs.value("wrap")
        self.pending.wrap = "" if chosen == NO_SURFACE else chosen

    def _wrap_link(self) -> None:
        link = self.inputs.value("wrap_link")
        self.pending.change_wrap(lambda wrap: replace(wrap, link=link))

    # Cells of the tables

    def _cell_changed(self, edit: CellEdit) -> None:
        table, row, column, value = edit
        if table == "points" and column == 1:
            self.pending.point_link(row, value)
        elif table == "points":
            point = self.pending.table.points_of(self.pending.muscle)[row]
            self.pending.point_position(row, _position(value, point.position))
        elif table == "parameters":
            self._parameter(row, value)
        elif table == "all":
            self._muscle_changed(self.pending.table.rows[row].name, column, value)
        elif table == "others" and column == 1:
            self.pending.change_other(row, name=value)
        elif table == "others" and column == 2:
            self.pending.change_other(row, link=value)
        elif table == "wrap_uses":
            self._use_changed(row, column, value)

    def _muscle_changed(self, muscle: str, column: int, value: str) -> None:
        if column == 0:
            self.pending.rename(value, muscle)
        elif column == 3:
            self.pending.change(lambda row: replace(row, model=_as_kind(row.model, value)), muscle)
        else:
            force: dict[str, Any] = {"f_min" if column == 1 else "f_max": _number(value)}
            self.pending.change(lambda row: replace(row, **force), muscle)

    def _use_changed(self, row: int, column: int, value: Any) -> None:
        if column == 0:
            self.pending.change_use(row, lambda use: replace(use, muscle=value))
        elif column == 1:
            self.pending.change_use(row, lambda use: replace(use, after=int(value)))
        elif column == 2:
            side, inside = SIDES.get(value, 0), value == INSIDE
            self.pending.change_use(
                row,
                lambda use: replace(
                    use, side=side, inside=inside, turns=0 if inside else use.turns
                ),
            )
        else:
            self.pending.change_use(row, lambda use: replace(use, turns=int(value)))

    # Mirror and CSV

    def _mirror(self) -> None:
        name = self.inputs.value("plane")
        at = self._plane if name == PICKED_PLANE else Plane((0.0, 0.0, 0.0), PLANES[name])
        if at is None:
            raise InputError("Pick a flat face or construction plane first.")
        every, again = self.inputs.value("mirror_all"), self.inputs.value("mirror_replace")
        self.pending.mirror(at, every, again)

    def _import(self) -> None:
        file = chosen_file("Import muscles", "Tables (*.csv;*.txt);;All files (*.*)")
        if file is None:
            return
        self._take(read_file(file, limits.DESIGN), file.name, file)

    def _take(self, data: bytes, name: str, file: Path | None = None) -> None:
        """Takes a table of points, if nothing is wrong with it."""
        table, findings = read_csv(data, self.pending.links, file)
        lines = [f"line {f.line}: {f.message}" for f in findings[:SHOWN]]
        if len(findings) > SHOWN:
            lines.append(f"and {len(findings) - SHOWN} more")
        if any(f.is_error for f in findings):
            lines.insert(0, f"{name} was not taken:")
        else:
            self.pending.table = renumbered(imported(self.pending.table, table))
            if table.rows:
                self.pending.choose(table.rows[0].name)
            counts = f"{len(table.rows)} muscles with {len(table.points)} points"
            lines.insert(0, f"{name}: {counts}.")
        self.pending.message = "\n".join(lines)

    def _copy(self) -> None:
        clipboard.copy(csv_text(self.pending.table, "\t"))
        self.pending.message = "All points are copied; paste them into a spreadsheet."

    def _export(self) -> None:
        file = chosen_file("Export muscles", "Tables (*.csv)", "muscles.csv")
        if file is None:
            return
        # Spreadsheets take a file for UTF-8 only with its mark.
        write_files(file.parent, {file.name: "\ufeff" + csv_text(self.pending.table)})
        self.pending.message = f"{file} is written."


_FOCUS = {
    "tab_muscles": "pick",
    "tab_wraps": "wrap_pick",
    "tab_others": "other_pick",
    "tab_tools": "plane_pick",
}
_EDITS = ("up", "down", "insert", "duplicate", "delete")


def _as_kind(model: CableModel, kind: Any) -> CableModel:
    """The model as another one, with the parameters that this has as well."""
    new = CableModel(kind)
    known = {p.name for p in law_of(new).parameters}
    return CableModel(kind, tuple(pair for pair in model.parameters if pair[0] in known))


def _number(text: str) -> float:
    try:
        return float(text.strip().replace(",", "."))
    except ValueError:
        raise InputError(f"{text!r} is not a number.") from None


def _position(text: str, before: Vector3) -> Vector3:
    """Three numbers in [mm], between them commas or spaces, or semicolons.

    Those that are as they were shown are what they were, with all digits.
    """
    parts = text.split(";") if ";" in text else text.replace(",", " ").split()
    if len(parts) != 3:
        raise InputError(f"{text!r} is not x, y, z in mm.")
    shown = position_text(before).split(", ")
    x, y, z = (
        old if part.strip() == was else 0.001 * _number(part)
        for part, was, old in zip(parts, shown, before, strict=True)
    )
    if not all(map(math.isfinite, (x, y, z))):
        raise InputError(f"{text!r} is not x, y, z in mm.")
    return x, y, z


COMMAND = Command(DIALOG, DefineMuscles)
