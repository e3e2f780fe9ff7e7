"""Define muscles command, which connects the inputs with the editor of the muscle table."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...muscles.csv_reader import read_csv
from ...muscles.csv_writer import csv_text
from ...muscles.mirror import Plane
from ...muscles.table import NAMED_COLORS
from ...robot import limits
from ...robot.errors import CardsflowError, InputError
from ...robot.files import read_file, write_files
from ...snapshot import SurfaceSnapshot
from .. import clipboard
from ..command import Command, Window
from ..guard import chosen_file
from ..inputs import Inputs
from ..reading import Reading, read
from .dialog import (
    DIALOG,
    MARKER,
    NEW_MUSCLE,
    NO_LINK,
    NO_SURFACE,
    OF_PART,
    PICKED_PLANE,
    PLANES,
)
from .editor import MuscleEditor, Pick
from .entities import Entities
from .history import History
from .motion import MotionTab
from .picks import Picks, faces_at, plane
from .preview import draw
from .tables import edit_cell
from .view import SHOWN, show
from .writing import Writer


class DefineMuscles(Window):
    """Open dialog of Define muscles."""

    def __init__(self, inputs: Inputs, design: Any) -> None:
        super().__init__(inputs, design)
        self._read: Reading = read(design)
        self._picks = Picks()
        self._entities = Entities(design, self._read.snapshot)
        note = "\n".join(f.message for f in self._read.table_findings[:SHOWN])
        self.editor = MuscleEditor(self._read.table, self._read.link_of, note or self._read.note)
        self._history = History(self.editor)
        self._motion = MotionTab(self._read.snapshot)
        self._plane: Plane | None = None
        editor, value, selected = self.editor, inputs.value, inputs.selected
        self._works: dict[str, Callable[[], None]] = {
            "pick": lambda: self._picked("pick", lambda e: editor.pick_point(self._point(e))),
            "other_pick": lambda: self._picked("other_pick", self._picked_other),
            "wrap_pick": lambda: self._picked("wrap_pick", self._picked_face),
            "plane_pick": lambda: self._picked("plane_pick", self._picked_plane),
            "muscle": lambda: editor.choose(_chosen(value("muscle"), NEW_MUSCLE)),
            "link": lambda: setattr(editor, "link", _chosen(value("link"), OF_PART)),
            "muscle_name": lambda: editor.rename(value("muscle_name")),
            "palette": self._palette,
            "color": lambda: editor.change(color=value("color").strip().lower()),
            "f_min": lambda: editor.change(f_min=float(value("f_min"))),
            "f_max": lambda: editor.change(f_max=float(value("f_max"))),
            "model": lambda: editor.change_model(editor.muscle, value("model")),
            "delete_muscle": editor.delete,
            "wrap": lambda: setattr(editor, "wrap", _chosen(value("wrap"), NO_SURFACE)),
            "wrap_name": lambda: editor.rename_wrap(value("wrap_name")),
            "wrap_link": lambda: editor.change_wrap(link=value("wrap_link")),
            "wrap_delete": editor.delete_wrap,
            "use_add": editor.add_use,
            "use_delete": lambda: editor.delete_use(selected("wrap_uses")),
            "other_delete": lambda: editor.delete_other(selected("others")),
            "mirror": self._mirror,
            "replace_link": lambda: editor.replace_link(
                _chosen(value("old_link"), NO_LINK), _chosen(value("new_link"), OF_PART)
            ),
            "paste": lambda: self._take(clipboard.paste().encode(), "The clipboard"),
            "copy": self._copy,
            "csv_import": self._import,
            "csv_export": self._export,
            "undo": self._history.undo,
            "redo": self._history.redo,
        }

    def on_open(self) -> None:
        """Show the muscle table of the design."""
        show(self.editor, self.inputs)

    def on_change(self, changed: Any) -> None:
        """Edit the muscle table; errors are shown in the status."""
        name, selected, before = str(changed.id), None, self._history.state()
        try:
            if name in _FOCUS:
                if changed.isActive:  # the event is also sent for the deactivated tab
                    self.inputs[_FOCUS[name]].hasFocus = True  # it receives the next click
            elif name in _MOTION:
                pass  # only the view changes
            elif name in _EDITS:
                selected = self.editor.edit_point(name, self.inputs.selected("points"))
            elif name in self._works:
                self._works[name]()
            elif (edit := self.inputs.cell(changed)) is not None:
                edit_cell(self.editor, edit)
            else:
                return
        except CardsflowError as error:
            self.editor.message = str(error)
        if name not in _UNDO:
            self._history.record(before, name if self.inputs.is_typed(changed) else "")
        show(self.editor, self.inputs, selected)
        self._motion.show(self.inputs, self.editor.table)

    def valid(self) -> bool:
        """Return whether the table can be written."""
        return not self.editor.table.problems(self.editor.links)

    def preview(self) -> None:
        """Draw the muscles."""
        draw(self.design, self.editor.table, self.editor.muscle)

    def execute(self) -> None:
        """Write the muscle table to the design."""
        entities = self._entities
        writer = Writer(
            self.design, self._picks, entities.points, entities.faces, self.editor.link_of
        )
        writer.write(self.editor.before, self.editor.table)

    # Picks

    def _picked(self, name: str, take: Callable[[Any], None]) -> None:
        """Handle each picked entity; a rejected entity does not affect the others."""
        for entity in self.inputs.picked(name):
            try:
                take(entity)
            except CardsflowError as error:
                self.editor.message = str(error)

    def _point(self, entity: Any) -> Pick:
        return self._picks.point(entity, self._entities.point_key)

    def _picked_other(self, entity: Any) -> None:
        is_marker = self.inputs.value("other_role") == MARKER
        self.editor.pick_other(self._point(entity), "marker" if is_marker else "task")

    def _picked_face(self, entity: Any) -> None:
        self.editor.pick_surface(self._picks.surface(entity, self._entities.face_key))

    def _picked_plane(self, entity: Any) -> None:
        self._plane = plane(entity)
        self.inputs.choose("plane", (*PLANES, PICKED_PLANE), PICKED_PLANE)
        self.editor.message = "The picked plane is used; press Mirror."

    def _palette(self) -> None:
        color = NAMED_COLORS.get(self.inputs.value("palette"))
        if color is not None:
            self.editor.change(color=color)

    # Mirror and CSV

    def _mirror(self) -> None:
        name = self.inputs.value("plane")
        at = self._plane if name == PICKED_PLANE else Plane((0.0, 0.0, 0.0), PLANES[name])
        if at is None:
            raise InputError("Pick a flat face or construction plane first.")
        every, again = self.inputs.value("mirror_all"), self.inputs.value("mirror_replace")
        self.editor.mirror(at, every, again, self._find_face)

    def _find_face(self, link: str, image: SurfaceSnapshot) -> SurfaceSnapshot | None:
        """Return the only face of a link at the place of a mirrored surface."""
        entities = faces_at(self.design, link, image, self.editor.link_of)
        if len(entities) != 1:
            return None
        pick = self._picks.surface(entities[0], self._entities.face_key)
        return None if pick.problem else pick.face

    def _import(self) -> None:
        file = chosen_file("Import muscles", "Tables (*.csv;*.txt);;All files (*.*)")
        if file is not None:
            self._take(read_file(file, limits.DESIGN), file.name, file)

    def _take(self, data: bytes, name: str, file: Path | None = None) -> None:
        """Import a muscle table if it has no errors."""
        table, findings = read_csv(data, self.editor.links, file)
        lines = [f"line {f.line}: {f.message}" for f in findings[:SHOWN]]
        if len(findings) > SHOWN:
            lines.append(f"and {len(findings) - SHOWN} more")
        if any(f.is_error for f in findings):
            lines.insert(0, f"{name} was not imported:")
        else:
            self.editor.take(table)
            counts = f"{len(table.rows)} muscles with {len(table.points)} points"
            lines.insert(0, f"{name}: {counts}.")
        self.editor.message = "\n".join(lines)

    def _copy(self) -> None:
        clipboard.copy(csv_text(self.editor.table, "\t"))
        self.editor.message = "All points are copied; paste them into a spreadsheet."

    def _export(self) -> None:
        file = chosen_file("Export muscles", "Tables (*.csv)", "muscles.csv")
        if file is None:
            return
        # Spreadsheets detect UTF-8 only with a byte order mark.
        write_files(file.parent, {file.name: "\ufeff" + csv_text(self.editor.table)})
        self.editor.message = f"{file} is written."


_FOCUS = {
    "tab_muscles": "pick",
    "tab_wraps": "wrap_pick",
    "tab_others": "other_pick",
    "tab_tools": "plane_pick",
}
_MOTION = ("tab_motion", "motion_joint", "motion_percent")
_UNDO = ("undo", "redo")
_EDITS = ("up", "down", "insert", "duplicate", "delete")


def _chosen(item: str, none: str) -> str:
    """Return the chosen item of a drop-down; empty for the item that means none."""
    return "" if item == none else item


COMMAND = Command(DIALOG, DefineMuscles)
