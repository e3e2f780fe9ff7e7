"""Reading of the design for the commands: snapshot, links and table."""

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
    "part": "This is a part design: it has one link only. Muscles need links that move against "
    "each other: make an assembly or hybrid design.",
    "assembly": "This is an assembly design: its components come from other documents. Points are "
    "kept in this design, each in the frame of the component that it is on.",
}


@dataclass(frozen=True)
class Reading:
    """What was read of a design.

    Attributes:
        snapshot: The design, without meshes.
        link_of: The link of each occurrence's path.
        table: Its muscles.
        table_findings: What is wrong with them.
        note: What the user should know of the design's kind; empty if nothing.
    """

    snapshot: DesignSnapshot
    link_of: Mapping[str, str]
    table: MuscleTable
    table_findings: tuple[Finding, ...]
    note: str


def read(design: Any, *, weighed_for: str = "") -> Reading:
    """Read a design.

    Args:
        design: The design.
        weighed_for: Title of the progress while masses are calculated; they are not if empty.
    """
    if not weighed_for:
        return _reading(read_design(design, meshes=False, masses=None))
    shown = ProgressDialog(weighed_for, cancellable=False)
    try:
        return _reading(read_design(design, meshes=False, masses="high", progress=shown))
    finally:
        shown.hide()


def with_meshes(reading: Reading, design: Any, progress: Progress) -> DesignSnapshot:
    """Return the design with its meshes, and with the masses that were read: it is weighed once."""
    snapshot, weighed = read_design(design, masses=None, progress=progress), reading.snapshot
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
