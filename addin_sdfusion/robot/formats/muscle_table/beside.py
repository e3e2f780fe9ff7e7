"""The muscle table next to a robot file: its name, its use by readers, and its writer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ...files import read_file, write_files
from ...finding import Finding, Subject
from ...finding_builders import listed, warning
from ...limits import XML
from ...model.robot import Robot
from .document import MuscleDocument
from .read import read_table
from .write import table_text

if TYPE_CHECKING:  # readers require lxml, which Fusion does not provide
    from ..reading.xml import Notes

MUSCLES_CSV = "muscles.csv"


def table_of(file: Path) -> Path | None:
    """Return the muscle table of a robot file, or None if it has none.

    The table of `arm.urdf` is `arm.muscles.csv`, or `muscles.csv` if that does not exist.
    """
    for name in (f"{file.stem}.{MUSCLES_CSV}", MUSCLES_CSV):
        if file.with_name(name).exists():
            return file.with_name(name)
    return None


def with_table(robot: Robot, table: Path, notes: Notes) -> Robot:
    """Replace the muscles and wrap surfaces of a robot by those of a table."""
    links = [link.name for link in robot.links]
    reading = read_table(read_file(table, XML), links, table)
    notes.files.append(table)
    notes.findings += reading.findings
    if any(finding.is_error for finding in reading.findings):
        return robot
    changed = reading.document.apply_to(robot)
    if robot.muscles and changed != robot:
        count = f"{len(robot.muscles)} muscles of the robot file"
        problem = f"{len(changed.muscles)} muscles of {table.name} replace the {count}"
        replaced = warning(Subject("robot", robot.name), "muscles-replaced", problem)
        notes.findings.insert(0, replace(replaced, file=table))
    for subject, line in reading.lines.items():
        notes.locations[subject] = (table, line)
    notes.findings += [replace(f, file=table) for f in _shared_surfaces(robot, changed)]
    return changed


def _shared_surfaces(robot: Robot, changed: Robot) -> Iterator[Finding]:
    """Report surfaces that a table changes although other cable sets use them."""
    used = {
        wrap.surface
        for group in robot.cable_sets
        if group.name != robot.cable_set
        for muscle in group.muscles
        for wrap in muscle.wraps
    }
    before = {surface.name: surface for surface in robot.wrap_surfaces}
    for surface in changed.wrap_surfaces:
        if surface.name in used and surface != before.get(surface.name):
            problem = "the muscle table changes it, also for other cable sets; rename it there"
            yield warning(Subject("wrap_surface", surface.name), "shared-surface", problem)


def write_table(robot: Robot, folder: Path) -> list[Path]:
    """Write the active muscles of a robot as `muscles.csv`; returns the file."""
    return write_files(folder, {MUSCLES_CSV: table_text(MuscleDocument.of(robot))})


def table_losses(robot: Robot) -> list[Finding]:
    """Return findings on everything that a muscle table cannot hold."""
    return list(_losses(robot))


def _losses(robot: Robot) -> Iterator[Finding]:
    subject = Subject("robot", robot.name)
    problem = "holds muscles and wrap surfaces; links, joints and end-effector points are omitted"
    yield warning(subject, "links-left-out", f"{MUSCLES_CSV} {problem}")
    others = [group.name for group in robot.cable_sets if group.name != robot.cable_set]
    if others:
        problem = f"{MUSCLES_CSV} holds one cable set; omitted: {listed(others, len(others))}"
        yield warning(subject, "cable-sets-left-out", problem)
