"""Define muscles command, which connects the inputs with the editor of the muscle table."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...fusion.occurrences import readable_occurrences
from ...muscles.csv_reader import read_csv
from ...muscles.csv_writer import csv_text
from ...muscles.mirror import Plane
from ...muscles.table import NAMED_COLORS
from ...robot import limits
from ...robot.errors import InputError
from ...robot.files import read_file, write_files
from ...snapshot import SurfaceSnapshot
from .. import clipboard
from ..command import Command, Window
from ..guard import chosen_file
from ..inputs import Inputs, Picked
from ..reading import Reading, read
from .dialog import DIALOG, SHOWN, edit_cell, show
from .entities import Entities
from .model import links, muscles, points, wraps
from .model.model import MuscleModel
from .model.parts import replace_part
from .model.picks import Pick
from .picks import faces_at, picked_point, picked_surface, plane
from .preview import draw
from .tabs.motion import MotionTab
from .tabs.muscles import NEW_MUSCLE, OF_PART
from .tabs.others import MARKER
from .tabs.tools import NO_LINK, NO_PART, PICKED_PLANE, PLANES
from .tabs.wraps import NO_SURFACE
from .writing.writer import Writer


class DefineMuscles(Window):
    """Open dialog of Define muscles."""

    def __init__(self, inputs: Inputs, design: Any) -> None:
        super().__init__(inputs, design)
        self._read: Reading = read(design)
        self._entities = Entities(design, self._read.snapshot)
        note = "\n".join(f.message for f in self._read.table_findings[:SHOWN])
        self.model = MuscleModel(self._read.table, self._read.link_of, note or self._read.note)
        self._motion = MotionTab(self._read.snapshot)
        self._plane: Plane | None = None
        model, value, selected = self.model, inputs.value, inputs.selected
        self._works: dict[str, Callable[[], None]] = {
            "pick": lambda: self._picked("pick", self._pick_point),
            "other_pick": lambda: self._picked("other_pick", self._pick_other),
            "wrap_pick": lambda: self._picked("wrap_pick", self._pick_face),
            "plane_pick": lambda: self._picked("plane_pick", self._pick_plane),
            "muscle": lambda: muscles.choose(model, _chosen(value("muscle"), NEW_MUSCLE)),
            "new_muscle": lambda: muscles.choose(model, ""),
            "link": lambda: setattr(model, "link", _chosen(value("link"), OF_PART)),
            "muscle_name": lambda: muscles.rename(model, value("muscle_name")),
            "palette": self._palette,
            "color": lambda: muscles.change(model, color=value("color").strip().lower()),
            "f_min": lambda: muscles.change(model, f_min=float(value("f_min"))),
            "f_max": lambda: muscles.change(model, f_max=float(value("f_max"))),
            "model": lambda: muscles.change_law(model, model.muscle, value("model")),
            "delete_muscle": lambda: muscles.delete(model),
            "wrap": lambda: setattr(model, "wrap", _chosen(value("wrap"), NO_SURFACE)),
            "wrap_name": lambda: wraps.rename_wrap(model, value("wrap_name")),
            "wrap_link": lambda: wraps.change_wrap(model, link=value("wrap_link")),
            "wrap_delete": lambda: wraps.delete_wrap(model),
            "use_add": lambda: wraps.add_use(model),
            "use_delete": lambda: wraps.delete_use(model, selected("wrap_uses")),
            "other_delete": lambda: points.delete_other(model, selected("others")),
            "mirror": self._mirror,
            "replace_link": lambda: links.replace_link(
                model, _chosen(value("old_link"), NO_LINK), _chosen(value("new_link"), OF_PART)
            ),
            "replace_part": self._replace_part,
            "paste": lambda: self._take(clipboard.paste().encode(), "The clipboard"),
            "copy": self._copy,
            "csv_import": self._import,
            "csv_export": self._export,
        }

    def on_open(self) -> None:
        """Show the muscle table of the design."""
        show(self.model, self.inputs)

    def on_change(self, changed: Any) -> None:
        """Edit the muscle table; errors are shown in the status."""
        name, selected, model = str(changed.id), None, self.model
        if name in _FOCUS:
            if changed.isActive:  # the event is also sent for the deactivated tab
                self.inputs[_FOCUS[name]].hasFocus = True  # it receives the next click
        elif name in _UNDO:
            with model.reporting():
                model.undo() if name == "undo" else model.redo()
        elif name not in _MOTION:
            cell = self.inputs.cell(changed)
            with model.step(name if self.inputs.is_typed(changed) else ""):
                if name in _EDITS:
                    selected = points.edit_point(model, name, self.inputs.selected("points"))
                elif name in self._works:
                    self._works[name]()
                elif cell is not None:
                    edit_cell(model, cell)
                else:
                    return
        show(model, self.inputs, selected)
        self._motion.show(model, self.inputs)

    def valid(self) -> bool:
        """Return whether the table can be written."""
        return not self.model.problems()

    def preview(self) -> None:
        """Draw the muscles."""
        draw(self.design, self.model, self._motion.colors)

    def execute(self) -> None:
        """Write the muscle table to the design."""
        Writer(self.design, self._entities, self.model).write()

    # Picks

    def _picked(self, name: str, take: Callable[[Picked], None]) -> None:
        """Handle each picked entity; a rejected entity does not affect the others."""
        for picked in self.inputs.picked(name):
            with self.model.reporting():
                take(picked)

    def _point(self, picked: Picked) -> Pick:
        return picked_point(
            picked.entity, self._entities, picked.point, bool(self.inputs.value("centres"))
        )

    def _pick_point(self, picked: Picked) -> None:
        points.pick_point(self.model, self._point(picked))

    def _pick_other(self, picked: Picked) -> None:
        is_marker = self.inputs.value("other_role") == MARKER
        points.pick_other(self.model, self._point(picked), "marker" if is_marker else "task")

    def _pick_face(self, picked: Picked) -> None:
        wraps.pick_surface(self.model, picked_surface(picked.entity, self._entities))

    def _pick_plane(self, picked: Picked) -> None:
        self._plane = plane(picked.entity)
        self.inputs.choose("plane", (*PLANES, PICKED_PLANE), PICKED_PLANE)
        self.model.message = "The picked plane is used; press Mirror."

    def _palette(self) -> None:
        color = NAMED_COLORS.get(self.inputs.value("palette"))
        if color is not None:
            muscles.change(self.model, color=color)

    # Mirror and CSV

    def _mirror(self) -> None:
        name = self.inputs.value("plane")
        at = self._plane if name == PICKED_PLANE else Plane((0.0, 0.0, 0.0), PLANES[name])
        if at is None:
            raise InputError("Pick a flat face or construction plane first.")
        every, again = self.inputs.value("mirror_all"), self.inputs.value("mirror_replace")
        muscles.mirror(self.model, at, every, again, self._find_face)

    def _replace_part(self) -> None:
        old, new = (_chosen(self.inputs.value(n), NO_PART) for n in ("old_part", "new_part"))
        occurrences = readable_occurrences(self.design.rootComponent)
        poses = {path: occurrence.T for path, occurrence in occurrences.items()}
        replace_part(self.model, old, new, poses, self._find_face)

    def _find_face(self, link: str, image: SurfaceSnapshot) -> SurfaceSnapshot | None:
        """Return the only face of a link at the place of a mirrored surface."""
        entities = faces_at(self.design, link, image, self.model.link_of)
        if len(entities) != 1:
            return None
        pick = picked_surface(entities[0], self._entities)
        return None if pick.problem else pick.face

    def _import(self) -> None:
        file = chosen_file("Import muscles", "Tables (*.csv;*.txt);;All files (*.*)")
        if file is not None:
            self._take(read_file(file, limits.DESIGN), file.name, file)

    def _take(self, data: bytes, name: str, file: Path | None = None) -> None:
        """Import a muscle table if it has no errors."""
        table, findings = read_csv(data, self.model.links, file)
        lines = [f"line {f.line}: {f.message}" for f in findings[:SHOWN]]
        if len(findings) > SHOWN:
            lines.append(f"and {len(findings) - SHOWN} more")
        if any(f.is_error for f in findings):
            lines.insert(0, f"{name} was not imported:")
        else:
            muscles.take(self.model, table)
            counts = f"{len(table.rows)} muscles with {len(table.points)} points"
            lines.insert(0, f"{name}: {counts}.")
        self.model.message = "\n".join(lines)

    def _copy(self) -> None:
        clipboard.copy(csv_text(self.model.table, "\t"))
        self.model.message = "All points are copied; paste them into a spreadsheet."

    def _export(self) -> None:
        file = chosen_file("Export muscles", "Tables (*.csv)", "muscles.csv")
        if file is None:
            return
        # Spreadsheets detect UTF-8 only with a byte order mark.
        write_files(file.parent, {file.name: "\ufeff" + csv_text(self.model.table)})
        self.model.message = f"{file} is written."


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
