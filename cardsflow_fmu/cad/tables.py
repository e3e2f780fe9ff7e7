"""Readers for the tables of a STEP file: joints and materials of its parts."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from addin_sdfusion.robot import InputError, Vector3, limits
from addin_sdfusion.robot.files import read_file
from addin_sdfusion.robot.finding_builders import unknown
from addin_sdfusion.robot.model.rotations import normalized
from addin_sdfusion.snapshot import JointKind, MotionSnapshot

from .assembly import Assembly, Place

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
_RADIANS = {"rad": 1.0, "deg": math.pi / 180.0, "°": math.pi / 180.0}
_LINEAR_SPEEDS = {"m/s": 1.0, "mm/s": 0.001}
_ANGULAR_SPEEDS = {"rad/s": 1.0, "deg/s": math.pi / 180.0, "rpm": math.pi / 30.0}
_DENSITIES = {"kg/m3": 1.0, "kg/m^3": 1.0, "kg/m³": 1.0, "g/cm3": 1e3, "g/cm^3": 1e3, "g/cm³": 1e3}
_MASSES = {"kg": 1.0, "g": 0.001}
_X: Vector3 = (1.0, 0.0, 0.0)
_Y: Vector3 = (0.0, 1.0, 0.0)
_Z: Vector3 = (0.0, 0.0, 1.0)
_HEADER = re.compile(r"(?P<name>[a-z_ ]*[a-z_]) *(?:[\[(](?P<unit>[^\])]+)[\])])?", re.IGNORECASE)
_QUANTITY = re.compile(r"(?P<number>[-+0-9.eE]+) *(?P<unit>[a-zA-Z°/]*)")

KINDS: Mapping[str, JointKind] = {
    "rigid": "rigid",
    "fixed": "rigid",
    "revolute": "revolute",
    "slider": "slider",
    "prismatic": "slider",
    "cylindrical": "cylindrical",
    "ball": "ball",
}
"""Types of joints in tables, and their kinds in a snapshot."""


@dataclass(frozen=True)
class Cell:
    """A cell of a table with its location."""

    text: str
    file: Path
    line: int
    column: str
    unit: str = ""

    def error(self, problem: str) -> InputError:
        """Return an error with the location of the cell."""
        return InputError(problem, file=self.file, line=self.line, key=self.column)

    def number(self, units: Mapping[str, float]) -> float:
        """Return the quantity in SI units.

        A number without unit has the unit of the column, or is in SI units.
        """
        match = _QUANTITY.fullmatch(self.text)
        try:
            value = float(match["number"]) if match else math.nan
        except ValueError:
            value = math.nan
        if not match or not math.isfinite(value):
            raise self.error(f"must be a number, not {self.text!r}")
        unit = match["unit"] or self.unit
        if unit and unit not in units:
            raise self.error(f"{unknown('unit', unit, list(units))}")
        return value * units.get(unit, 1.0)

    def whole(self) -> int:
        """Return the cell as a non-negative integer."""
        if not re.fullmatch("[0-9]{1,6}", self.text, re.ASCII):
            raise self.error(f"must be 0, 1, 2, ..., not {self.text!r}")
        return int(self.text)


@dataclass(frozen=True)
class JointRow:
    """Row of the table of joints.

    Attributes:
        kind: Kind of the joint in a snapshot.
        parent, child: Names of the parts, or `world`; the child moves.
        origin: Position in the root frame, in [m]; None if not specified.
        motions: Motions in order from parent to child, with axes in the root frame.
    """

    name: Cell
    kind: JointKind
    parent: Cell
    child: Cell
    origin: Vector3 | None
    motions: tuple[MotionSnapshot, ...]


@dataclass(frozen=True)
class MaterialRow:
    """Row of the table of materials.

    Attributes:
        density: In [kg/m³]; None if the mass is specified.
        mass: In [kg]; None if the density is specified.
        material: Name of the material; may be empty.
    """

    part: Cell
    density: float | None
    mass: float | None
    material: str


def read_joints(file: Path) -> tuple[JointRow, ...]:
    """Read a table of joints."""
    required = ("name", "type", "parent", "child")
    vectors = ("x", "y", "z", "axis x", "axis y", "axis z")
    numbers = ("lower", "upper", "value", "damping", "friction", "effort", "velocity")
    return tuple(_joint(row) for row in read_rows(file, required, (*vectors, *numbers)))


def read_materials(file: Path) -> tuple[MaterialRow, ...]:
    """Read a table of materials."""
    rows = []
    for row in read_rows(file, ("part",), ("density", "mass", "material")):
        density, mass = row.get("density"), row.get("mass")
        if (density is None) == (mass is None):
            raise row["part"].error("must have either a density or a mass")
        density_value = None if density is None else _positive(density, _DENSITIES)
        mass_value = None if mass is None else _positive(mass, _MASSES)
        material = row["material"].text if "material" in row else ""
        rows.append(MaterialRow(row["part"], density_value, mass_value, material))
    return tuple(rows)


def _positive(cell: Cell, units: Mapping[str, float]) -> float:
    value = cell.number(units)
    if not value > 0.0:
        raise cell.error(f"must be positive, not {cell.text!r}")
    return value


def _joint(row: Mapping[str, Cell]) -> JointRow:
    kind = KINDS.get(row["type"].text)
    if kind is None:
        raise row["type"].error(unknown("type of joint", row["type"].text, list(KINDS)))
    origin = vector(row, ("x", "y", "z"), METRES)
    axis = vector(row, ("axis x", "axis y", "axis z"), {})
    if axis is not None and not any(axis):
        raise row["axis x"].error("an axis must not be 0 0 0")
    if kind in ("revolute", "slider", "cylindrical") and axis is None:
        raise row["name"].error(f"a {kind} joint needs an axis: columns axis x, axis y, axis z")
    if kind in ("revolute", "cylindrical", "ball") and origin is None:
        raise row["name"].error(f"a {kind} joint needs an origin: columns x, y, z")
    if kind in ("cylindrical", "ball"):
        for column in ("lower", "upper", "value"):
            if column in row:
                raise row[column].error(
                    f"a {kind} joint has several coordinates; leave the cell empty"
                )
    ends = row["name"], kind, row["parent"], row["child"]
    return JointRow(*ends, origin, _motions(row, kind, normalized(axis) if axis else _Z))


def _motions(row: Mapping[str, Cell], kind: JointKind, axis: Vector3) -> tuple[MotionSnapshot, ...]:
    is_slider = kind == "slider"
    units = METRES if is_slider else _RADIANS

    def number(column: str, units: Mapping[str, float] = {}) -> float | None:
        return row[column].number(units) if column in row else None

    motion = MotionSnapshot(
        "translation" if is_slider else "rotation",
        axis,
        number("value", units) or 0.0,
        number("lower", units),
        number("upper", units),
        damping=number("damping") or 0.0,
        friction=number("friction") or 0.0,
        effort=number("effort"),
        velocity=number("velocity", _LINEAR_SPEEDS if is_slider else _ANGULAR_SPEEDS),
    )
    if kind == "cylindrical":
        slide = replace(motion, kind="translation", role="slide")
        return replace(motion, role="rotation"), slide
    if kind == "ball":
        axes = ((_X, "pitch"), (_Y, "yaw"), (_Z, "roll"))
        return tuple(replace(motion, axis=axis, role=role) for axis, role in axes)
    return () if kind == "rigid" else (motion,)


def find_place(cell: Cell, assembly: Assembly) -> Place:
    """Return the part that a cell names."""
    try:
        return assembly.find(cell.text)
    except InputError as error:
        raise cell.error(error.problem) from None


def vector(
    row: Mapping[str, Cell], columns: Sequence[str], units: Mapping[str, float]
) -> Vector3 | None:
    """Return a vector from several cells, or None if all cells are empty."""
    filled = [column for column in columns if column in row]
    if not filled:
        return None
    if len(filled) < len(columns):
        missing = next(column for column in columns if column not in row)
        raise row[filled[0]].error(f"also requires a value in column {missing!r}")
    x, y, z = (row[column].number(units) for column in columns)
    return x, y, z


def read_rows(
    file: Path, required: Sequence[str], optional: Sequence[str]
) -> Iterator[dict[str, Cell]]:
    """Yield the rows of a table, without empty cells; separators are comma, semicolon or tab."""
    try:
        text = read_file(file, limits.DESIGN).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("is not UTF-8; save it as 'CSV UTF-8'", file=file) from None
    first = text.split("\n", 1)[0]
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=max(",;\t", key=first.count))
    columns: list[tuple[str, str]] = []
    end = 0
    try:
        for cells in reader:
            line, end = end + 1, reader.line_num
            if not any(cell.strip() for cell in cells):
                continue
            if not columns:
                columns = _columns(cells, required, optional, file, line)
                continue
            if len(cells) > len(columns):
                problem = f"has {len(cells)} cells, but the first line has {len(columns)}"
                raise InputError(problem, file=file, line=line)
            row = {
                name: Cell(cell.strip(), file, line, name, unit)
                for cell, (name, unit) in zip(cells, columns, strict=False)
                if cell.strip()
            }
            missing = [name for name in required if name not in row]
            if missing:
                raise InputError(f"{missing[0]!r} must not be empty", file=file, line=line)
            yield row
    except csv.Error as error:
        raise InputError(f"cannot be read: {error}", file=file, line=end + 1) from None
    if not columns:
        raise InputError(f"is empty; the first line must have {', '.join(required)}", file=file)


def _columns(
    cells: Sequence[str], required: Sequence[str], optional: Sequence[str], file: Path, line: int
) -> list[tuple[str, str]]:
    allowed = (*required, *optional)
    columns = []
    for cell in cells:
        match = _HEADER.fullmatch(cell.strip())
        name = " ".join((match["name"] if match else cell).lower().replace("_", " ").split())
        if match is None or name not in allowed:
            raise InputError(unknown("column", cell.strip(), allowed), file=file, line=line)
        columns.append((name, (match["unit"] or "").strip()))
    names = [name for name, _ in columns]
    for name in required:
        if name not in names:
            raise InputError(f"has no column {name!r}", file=file, line=line)
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"has two columns {name!r}", file=file, line=line)
    return columns
