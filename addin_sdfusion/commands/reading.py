"""Reading of the design for the commands: snapshot, links and table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..building.build_robot import link_of
from ..fusion.design import read_design
from ..muscles.design_table import read_table
from ..muscles.rows import MuscleTable
from ..robot.finding import Finding
from ..snapshot import DesignSnapshot

_NOTES = {
    "part": "This is a part design: it has one link only. Muscles need links that move against "
    "each other: make an assembly or hybrid design.",
    "assembly": "This is an assembly design: its components come from other documents. Points can "
    "be stored only in components of this document.",
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


def read(design: Any, *, masses: bool = True) -> Reading:
    """Read a design."""
    snapshot = read_design(design, meshes=False, masses=masses)
    links = link_of(snapshot)
    table, findings = read_table(snapshot, links)
    stored = [finding for finding in snapshot.findings if finding.code == "bad-attribute"]
    return Reading(snapshot, links, table, (*stored, *findings), _NOTES.get(snapshot.intent, ""))
