"""Export command: settings, findings, changes since the last export, and the export itself."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import adsk.core

from ...building.build_robot import BuiltRobot, build_robot
from ...exporting.changes import Contents, changes, contents
from ...exporting.export import Exported, export_robot, requested_findings
from ...exporting.manifest import read_contents
from ...exporting.robot_folder import EXPERIMENT
from ...muscles.attributes import GROUP, SETTINGS, UNREAD, can_read_settings, settings_text
from ...muscles.point_names import natural_key
from ...progress import Cancelled
from ...robot.errors import CardsflowError, InputError, RobotError
from ...robot.finding import Finding, errors_first
from ...settings import ExportSettings
from ..check.entry import summary
from ..command import Command, Window
from ..guard import application, ask, message
from ..inputs import CellEdit, Inputs
from ..progress_dialog import ProgressDialog
from ..reading import read, with_meshes
from .dialog import COLLISIONS, DIALOG, FOUND, LINKS, QUALITIES, UP
from .singles import apply_edit, joint_rows, link_rows

_SHOWN = 8
_TICKS = ("fixed_base", "visual", "caspr", "osim", "urdf", "mjcf")
Value = TypeVar("Value", bound=str)


class Export(Window):
    """Open dialog of Export."""

    def __init__(self, inputs: Inputs, design: Any) -> None:
        super().__init__(inputs, design)
        self._reading = read(design, weighed_for=DIALOG.name)
        self.settings = self._reading.snapshot.settings
        self.findings: list[Finding] = []
        self._checked: ExportSettings | None = None
        self._links: list[str] = []
        self._joints: list[str] = []
        self._contents: Contents = {}
        self._problem = ""

    def on_open(self) -> None:
        """Show the stored settings and the findings."""
        inputs, chosen = self.inputs, self.settings
        inputs.set("name", chosen.name)
        inputs.set("folder", chosen.folder)
        for name, words, value in (
            ("links", LINKS, chosen.links),
            ("up_axis", UP, chosen.up_axis),
            ("collision", COLLISIONS, chosen.collision),
            ("quality", QUALITIES, chosen.quality),
        ):
            inputs.choose(name, tuple(words), _word(words, value))
        for name in _TICKS:
            inputs.set(name, getattr(chosen, name))
        self._show()

    def on_change(self, changed: Any) -> None:
        """Handle a changed setting and update the findings."""
        name = str(changed.id)
        if name == "browse":
            self._browse()
        elif name == "components":
            self._picked()
        elif (edit := self.inputs.cell(changed)) is not None:
            self._cell_changed(edit)
        self.settings = self._chosen()
        self._show()

    def valid(self) -> bool:
        """Return whether the design can be exported."""
        checked = self._checked is not None
        return checked and bool(self.settings.folder) and not any(f.is_error for f in self.findings)

    def execute(self) -> None:
        """Store the settings in the design and export; if this fails, the folder is unchanged."""
        attribute = self.design.attributes.itemByName(GROUP, SETTINGS)
        text = settings_text(self.settings)
        if attribute is None or attribute.value != text:
            if attribute is not None and not can_read_settings(attribute.value):
                self.design.attributes.add(GROUP, f"{SETTINGS}{UNREAD}", attribute.value)
            self.design.attributes.add(GROUP, SETTINGS, text)
        warnings = [finding.message for finding in self.findings if not finding.is_error]
        if warnings and not ask(f"{_listed(warnings)}\n\nExport anyway?", DIALOG.name):
            return
        self._export()

    def _export(self) -> None:
        shown = ProgressDialog(DIALOG.name)
        try:
            snapshot = self._reading.snapshot
            if self.settings.needs_meshes:
                snapshot = with_meshes(self._reading, self.design, shown)
            snapshot = replace(snapshot, settings=self.settings)
            done = export_robot(snapshot, self.settings.folder, progress=shown)
        except Cancelled:
            message("The export was cancelled; the folder is unchanged.", DIALOG.name)
            return
        except RobotError as error:
            errors = _listed([f.message for f in error.findings if f.is_error])
            text = f"The robot cannot be exported:\n\n{errors}\n\nCheck shows the objects."
            message(text, DIALOG.name)
            return
        except CardsflowError as error:
            message(str(error), DIALOG.name)
            return
        finally:
            shown.hide()
        folder = self.settings.folder
        lines = [
            f"{len(done.files)} files were written to {folder}.",
            *_next_commands(folder, done),
        ]
        asked = [name for name in done.losses if not getattr(ExportSettings(), name)]
        findings, note = requested_findings(done.findings, done.losses, asked, folder)
        if findings:
            lines.append(f"{summary(findings)} They are in findings.txt in this folder.")
        if note:
            lines.append(f"{note[0].upper()}{note[1:]}.")
        if done.changed is not None:
            changed = _listed(list(done.changed)) or "none"
            lines.append(f"Changes since the previous export:\n{changed}")
        message("\n\n".join(lines), DIALOG.name)

    def _browse(self) -> None:
        dialog = application().userInterface.createFolderDialog()
        dialog.title = "Folder of the robot"
        if self.settings.folder:
            dialog.initialDirectory = self.settings.folder
        if dialog.showDialog() == adsk.core.DialogResults.DialogOK:
            self.inputs.set("folder", dialog.folder)

    def _picked(self) -> None:
        """Add the picked components; remove components that are picked again."""
        paths = list(self.settings.components)
        for picked in self.inputs.picked("components"):
            path = picked.entity.fullPathName
            paths = [p for p in paths if p != path] if path in paths else [*paths, path]
        self.settings = replace(self.settings, components=tuple(paths))

    def _chosen(self) -> ExportSettings:
        """Return the settings of the inputs."""
        value = self.inputs.value
        base = value("base")
        return replace(
            self.settings,
            name=value("name").strip(),
            folder=value("folder").strip(),
            links=LINKS[value("links")],
            base="" if base == FOUND else base,
            cut_joints=tuple(self.inputs.checked("cut_joints")),
            up_axis=UP[value("up_axis")],
            collision=COLLISIONS[value("collision")],
            quality=QUALITIES[value("quality")],
            **{name: value(name) for name in _TICKS},
        )

    def _show(self) -> None:
        checked = replace(self.settings, folder="")
        if checked != self._checked:
            self._checked = None
            self._show_findings(build_robot(replace(self._reading.snapshot, settings=checked)))
            self._checked = checked
        self.inputs.set("status", "\n".join(self._lines()))

    def _show_findings(self, built: BuiltRobot) -> None:
        inputs, settings = self.inputs, self.settings
        self.findings = list(built.findings)
        links = {*built.link_of_occurrence.values(), settings.base} - {""}
        bases = (FOUND, *sorted(links, key=natural_key))
        inputs.choose("base", bases, settings.base or FOUND)
        joints = {joint for loop in built.loops for joint in loop}
        cuts = sorted({*joints, *settings.cut_joints}, key=natural_key)
        inputs.check("cut_joints", cuts, settings.cut_joints)
        inputs["cut_joints"].isVisible = bool(cuts)
        inputs["components"].isVisible = settings.links == "components"
        self._links = sorted(links, key=natural_key)
        if built.robot is not None:
            self._joints = [c.name for c in built.robot.all_coordinates]
            self._contents = contents(built.robot)
        self.inputs.fill("of_links", link_rows(self.settings, self._links))
        self.inputs.fill("of_joints", joint_rows(self.settings, self._joints))

    def _cell_changed(self, edit: CellEdit) -> None:
        """Change the settings of one link or joint; an invalid number is reported and ignored."""
        try:
            self.settings = apply_edit(self.settings, edit, self._links, self._joints)
            self._problem = ""
        except InputError as error:
            self._problem = str(error)

    def _changes(self) -> list[str]:
        """Return the changes since the previous export."""
        folder = self.settings.folder
        before = read_contents(Path(folder)) if folder and Path(folder).is_dir() else None
        return [] if before is None else list(changes(before, self._contents))

    def _lines(self) -> list[str]:
        lines = [] if self.settings.folder else ["Choose the folder."]
        if self._problem:
            lines.append(self._problem)
        if self._reading.note:
            lines.append(self._reading.note)
        if self.settings.links == "components" and self.settings.components:
            lines.append(f"Links: {', '.join(self.settings.components)} (pick again to remove)")
        lines.append(summary(self.findings))
        ordered = errors_first(self.findings)
        lines += [f"{f.severity}: {f.message}" for f in ordered[:_SHOWN]]
        if len(ordered) > _SHOWN:
            lines.append(f"and {len(ordered) - _SHOWN} more: see Check")
        changed = self._changes()
        return [*lines, "Since the last export:", _listed(changed)] if changed else lines


def _word(words: Mapping[str, Value], value: str) -> str:
    return next(word for word, meaning in words.items() if meaning == value)


def _listed(texts: list[str]) -> str:
    lines = [f"• {text}" for text in texts[:_SHOWN]]
    if len(texts) > _SHOWN:
        lines.append(f"and {len(texts) - _SHOWN} more")
    return "\n".join(lines)


def _next_commands(folder: str, done: Exported) -> Iterator[str]:
    """Yield a paragraph with the commands that simulate the robot.

    `cardsflow init` writes an experiment after a test run, which needs libraries that Fusion does
    not provide.
    """
    if any(finding.code == "no-experiment" for finding in done.findings):
        return
    quoted = _quoted(folder)
    commands = [f"cardsflow run {quoted}"]
    if not (Path(folder) / EXPERIMENT).exists():
        commands.insert(0, f"cardsflow init {quoted} -o {quoted}")
    yield "\n    ".join(["To simulate the robot:\n", *commands])


def _quoted(folder: str) -> str:
    """Return a folder quoted for the shells of Windows and other systems."""
    return folder if re.fullmatch(r"[\w.:/\\-]+", folder) else f'"{folder}"'


COMMAND = Command(DIALOG, Export)
