"""Conversion of a STEP file and its tables to the snapshot of a design."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from addin_sdfusion.building.build_robot import link_of
from addin_sdfusion.muscles.csv_reader import read_csv
from addin_sdfusion.muscles.table import MuscleTable
from addin_sdfusion.robot import WORLD, InputError, limits
from addin_sdfusion.robot.files import read_file
from addin_sdfusion.robot.finding_builders import listed
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import (
    ROOT,
    DesignSnapshot,
    JointSnapshot,
    PointSnapshot,
    SourceSnapshot,
)

from .assembly import Assembly, Material
from .kernel import MILLIMETRE
from .step_file import read_step
from .step_wraps import wrap_surfaces
from .tables import Cell, JointRow, find_place, read_joints, read_materials


@dataclass(frozen=True)
class Tables:
    """Tables with the information that a STEP file does not contain.

    Attributes:
        joints: Table of the joints between parts (required).
        muscles: Table of muscles in the format of the add-in, or None.
        materials: Table of densities or masses of parts, or None.
        density: Density of all other parts, in [kg/m³], or None if unknown.
        wraps: Table of the faces over which muscles wrap, or None.
    """

    joints: Path | None = None
    muscles: Path | None = None
    materials: Path | None = None
    density: float | None = None
    wraps: Path | None = None


def step_design(file: Path, tables: Tables, settings: ExportSettings) -> DesignSnapshot:
    """Return the snapshot of a STEP file."""
    name, parts = read_step(file)
    assembly = Assembly(parts, MILLIMETRE)
    if tables.joints is None:
        paths = listed([place.path for place in assembly.places], 20)
        raise InputError(f"requires a table of joints, --joints; its parts are {paths}", file=file)
    joints = tuple(_joint(row, assembly) for row in read_joints(tables.joints))
    links = dict.fromkeys(path for joint in joints for path in (joint.two, joint.one) if path)
    moving = {joint.one for joint in joints}
    snapshot = DesignSnapshot(
        name or file.stem,
        settings if settings.components else replace(settings, components=tuple(links)),
        assembly.occurrences({path for path in links if path not in moving}),
        assembly.bodies(settings.quality, _materials(assembly, tables)),
        joints=joints,
        source=SourceSnapshot("STEP", document=file.name),
    )
    if tables.muscles is not None:
        snapshot = _with_muscles(snapshot, tables.muscles)
    if tables.wraps is not None:
        names = [muscle.name for muscle in snapshot.muscles]
        surfaces = wrap_surfaces(tables.wraps, assembly, names)
        snapshot = replace(snapshot, surfaces=surfaces)
    return snapshot


def _materials(assembly: Assembly, tables: Tables) -> dict[str, Material]:
    """Return the materials of parts, by path."""
    materials = {} if tables.density is None else {ROOT: Material(tables.density)}
    for row in () if tables.materials is None else read_materials(tables.materials):
        path = _path(row.part, assembly)
        if row.density is not None:
            materials[path] = Material(row.density, row.material)
            continue
        volume = assembly.volume(path)
        if not volume > 0.0:
            raise row.part.error(f"part {path!r} has no volume, so it cannot have a mass")
        materials[path] = Material((row.mass or 0.0) / volume, row.material)
    return materials


def _path(cell: Cell, assembly: Assembly) -> str:
    """Return the path of the part that a cell names."""
    return ROOT if cell.text == WORLD else find_place(cell, assembly).path


def _joint(row: JointRow, assembly: Assembly) -> JointSnapshot:
    child, parent = _path(row.child, assembly), _path(row.parent, assembly)
    if child == ROOT:
        raise row.child.error("the world does not move; use it as the parent")
    if child == parent:
        raise row.child.error("is the same part as the parent")
    return JointSnapshot(
        row.name.text, row.kind, child, parent, row.origin, row.origin, row.motions
    )


def _with_muscles(snapshot: DesignSnapshot, file: Path) -> DesignSnapshot:
    """Return the design with the muscles, task points and markers of a table."""
    place: dict[str, str] = {WORLD: ROOT}
    for path, link in sorted(link_of(snapshot).items()):
        place.setdefault(link, path)
    table, findings = read_csv(read_file(file, limits.DESIGN), place, file)
    return replace(
        snapshot,
        muscles=table.rows,
        points=tuple(_points(table, place)),
        findings=(*snapshot.findings, *findings),
    )


def _points(table: MuscleTable, place: Mapping[str, str]) -> Iterator[PointSnapshot]:
    for number, p in enumerate((*table.points, *table.others)):
        name = p.name or f"{p.muscle}_{p.number}"
        yield PointSnapshot(name, place[p.link], p.position, str(number), p.use)
