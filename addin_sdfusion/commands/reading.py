"""Reader for the design, used by the commands: snapshot, links and muscle table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..building.build_robot import link_of
from ..fusion.design import read_design
from ..muscles.design_table import read_table
from ..muscles.table import MuscleTable
from ..progress import Progress
from ..robot.finding import Finding
from ..snapshot import DesignSnapshot
from .progress_dialog import ProgressDialog

_NOTES = {
    "part": "This is a part design, which has only one link. Muscles require links that move "
    "relative to each other: create an assembly or hybrid design.",
    "assembly": "This is an assembly design: its components come from other documents. Points are "
    "stored in this design, in the frame of their component.",
}


@dataclass(frozen=True)
class Reading:
    """Data read from a design.

    Attributes:
        snapshot: Snapshot of the design, without meshes.
        link_of: Link of each occurrence, by path.
        table_findings: Findings on the muscle table.
        note: Note for the user on the type of the design, or empty.
    """

    snapshot: DesignSnapshot
    link_of: Mapping[str, str]
    table: MuscleTable
    table_findings: tuple[Finding, ...]
    note: str


def read(design: Any, *, weighed_for: str = "") -> Reading:
    """Read a design.

    Args:
        weighed_for: Title of the progress dialog of the mass calculation; empty to omit masses.

    Raises:
        Cancelled: The user cancelled the mass calculation.
    """
    if not weighed_for:
        return _reading(read_design(design, meshes=False, masses=False))
    shown = ProgressDialog(weighed_for)
    try:
        return _reading(read_design(design, meshes=False, progress=shown))
    finally:
        shown.hide()


def with_meshes(reading: Reading, design: Any, progress: Progress) -> DesignSnapshot:
    """Return the snapshot with meshes and with the masses that were already calculated."""
    snapshot, weighed = read_design(design, masses=False, progress=progress), reading.snapshot
    return replace(
        snapshot,
        bodies=tuple(
            replace(body, mass=other.mass)
            for body, other in zip(snapshot.bodies, weighed.bodies, strict=True)
        ),
        occurrences=weighed.occurrences,
        findings=tuple(dict.fromkeys((*weighed.findings, *snapshot.findings))),
    )


def _reading(snapshot: DesignSnapshot) -> Reading:
    links = link_of(snapshot)
    table, findings = read_table(snapshot, links)
    stored = [finding for finding in snapshot.findings if finding.code == "bad-attribute"]
    return Reading(snapshot, links, table, (*stored, *findings), _NOTES.get(snapshot.intent, ""))
