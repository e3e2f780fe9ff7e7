"""Check command: lists the findings on the design and saves a snapshot; it does not edit."""

from __future__ import annotations

from typing import Any

from ...building.build_robot import check_design
from ...fusion.design import read_design
from ...progress import Cancelled
from ...report import report_text
from ...robot.errors import CardsflowError
from ...robot.finding import Finding, errors_first
from ...snapshot_file import write_snapshot
from .. import clipboard
from ..command import Command, Window
from ..dialogs import Cell
from ..guard import application, chosen_file
from ..inputs import Inputs
from ..progress_dialog import ProgressDialog
from ..reading import read
from .dialog import DIALOG, ICONS
from .locate import entities_of


class Check(Window):
    """Open dialog of Check."""

    def __init__(self, inputs: Inputs, design: Any) -> None:
        super().__init__(inputs, design)
        self._reading = read(design, weighed_for=DIALOG.name)
        self.findings: list[Finding] = []
        self._hint = ""
        self._shown = -1

    def on_open(self) -> None:
        """List the findings."""
        self._list()

    def on_change(self, changed: Any) -> None:
        """Handle a pressed button or a selected row."""
        name = str(changed.id)
        if name == "again":
            self._check_again()
        elif name == "copy":
            self._copy()
        elif name == "save":
            self._save()
        elif (pressed := self.inputs.cell(changed)) is not None and pressed.column == 0:
            self._select(pressed.row)
        self._show_detail()

    def valid(self) -> bool:
        """Return False, because the dialog has no OK button."""
        return False

    def _check_again(self) -> None:
        try:
            self._reading = read(self.design, weighed_for=DIALOG.name)
        except Cancelled:
            self._hint = "The check was cancelled; the list is not up to date."
        else:
            self._list()

    def _list(self) -> None:
        self.findings = errors_first(check_design(self._reading.snapshot))
        rows = [
            (
                Cell(finding.severity, icon=ICONS[finding.severity]),
                Cell(f"{finding.subject.kind} {finding.subject.name}", lines=2),
                Cell(finding.message, lines=3),
            )
            for finding in self.findings
        ]
        self._shown = -1
        self.inputs.select("shown", ())
        self.inputs.fill("findings", rows, -1)
        self.inputs.set("summary", summary(self.findings))
        self._hint = self._reading.note
        self._show_detail()

    def _show_detail(self) -> None:
        lines = [self._hint] if self._hint else []
        if 0 <= self._shown < len(self.findings):
            finding = self.findings[self._shown]
            lines.append(f"{finding.subject.kind} {finding.subject.name}: {finding.message}")
        self.inputs.set("detail", "\n".join(lines))

    def _copy(self) -> None:
        """Copy the report, with the CAD program and its version, to the clipboard."""
        source = self._reading.snapshot.source
        head = f"{self._reading.snapshot.name} in {source.program} {source.version}".rstrip()
        try:
            clipboard.copy(f"{head}\n{report_text(self.findings)}")
        except CardsflowError as error:
            self._hint = str(error)
        else:
            self._hint = "The report is copied to the clipboard."

    def _save(self) -> None:
        """Save the snapshot of the design to a file."""
        title = "Save a snapshot of the design"
        file = chosen_file(title, "Snapshots (*.json)", "design.json")
        if file is None:
            return
        shown = ProgressDialog(DIALOG.name)
        try:
            write_snapshot(read_design(self.design, progress=shown), file)
        except Cancelled:
            self._hint = "Nothing was saved."
        except CardsflowError as error:
            self._hint = str(error)
        else:
            self._hint = (
                f"{file} contains all data that the add-in reads from the design, including "
                "meshes. Attach it to a problem report only if you may share the design."
            )
        finally:
            shown.hide()

    def _select(self, row: int) -> None:
        if not 0 <= row < len(self.findings):
            return
        self._shown = row
        entities = entities_of(self.design, self._reading, self.findings[row].subject)
        self._hint = "" if entities else "The object of this row cannot be shown in the design."
        self.inputs.select("shown", entities)
        if entities:
            _point_camera(entities)


def summary(findings: list[Finding]) -> str:
    """Return a text with the number of errors and warnings."""
    errors = sum(finding.is_error for finding in findings)
    if not findings:
        return "No problems found: the robot can be exported."
    counts = f"{_count(errors, 'error')}, {_count(len(findings) - errors, 'warning')}."
    return f"{counts} Errors must be fixed before the export." if errors else counts


def _count(number: int, noun: str) -> str:
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"


def _point_camera(entities: list[Any]) -> None:
    """Move the target of the camera to the centre of entities, without rotating it."""
    boxes = [box for e in entities if (box := getattr(e, "boundingBox", None)) is not None]
    if not boxes:
        return
    box = boxes[0].copy()
    for other in boxes[1:]:
        box.combine(other)
    low, high = box.minPoint, box.maxPoint
    viewport = application().activeViewport
    camera = viewport.camera
    eye, target = camera.eye, camera.target
    back = eye.x - target.x, eye.y - target.y, eye.z - target.z
    target.x, target.y, target.z = (
        (a + b) / 2 for a, b in ((low.x, high.x), (low.y, high.y), (low.z, high.z))
    )
    eye.x, eye.y, eye.z = target.x + back[0], target.y + back[1], target.z + back[2]
    camera.target, camera.eye = target, eye
    camera.isFitView = False
    viewport.camera = camera


COMMAND = Command(DIALOG, Check)
