"""Wrap surfaces of STEP files: faces of parts, each identified by a point near it."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np

from addin_sdfusion.robot import Vector3
from addin_sdfusion.robot.finding_builders import unknown
from addin_sdfusion.snapshot import SurfaceSnapshot, SurfaceUse, WrapUse

from .assembly import Assembly, Place
from .kernel import Face
from .tables import METRES, Cell, find_place, read_rows, vector

_SIDES: Mapping[str, Literal[-1, 0, 1]] = {
    "": 0,
    "0": 0,
    "1": 1,
    "+": 1,
    "+1": 1,
    "-1": -1,
    "-": -1,
}
_ANSWERS = {
    "": False,
    "no": False,
    "false": False,
    "0": False,
    "yes": True,
    "true": True,
    "1": True,
}


Value = TypeVar("Value")


@dataclass(frozen=True)
class WrapRow:
    """Row of the table: a muscle that wraps over a face.

    Attributes:
        name: Name of the surface; the same for all muscles that wrap over it.
        near: Point near the face in the root frame, in [m]; None if an earlier row specifies it.
        use: Segment, side, turns and inside.
    """

    name: Cell
    part: Cell
    near: Vector3 | None
    muscle: Cell
    use: WrapUse


def read_wraps(file: Path) -> tuple[WrapRow, ...]:
    """Read a table of wraps."""
    required = ("name", "part", "muscle", "after")
    rows = read_rows(file, required, ("x", "y", "z", "side", "turns", "inside"))
    return tuple(_wrap(row) for row in rows)


def _wrap(row: Mapping[str, Cell]) -> WrapRow:
    side, inside = _option(row, "side", _SIDES), _option(row, "inside", _ANSWERS)
    turns = row["turns"].whole() if "turns" in row else 0
    use = WrapUse(row["muscle"].text, row["after"].whole(), side, turns, inside)
    if use.inside and (side or turns):
        raise row["inside"].error("a muscle inside its surface cannot have a side or turns")
    near = vector(row, ("x", "y", "z"), METRES)
    return WrapRow(row["name"], row["part"], near, row["muscle"], use)


def _option(row: Mapping[str, Cell], column: str, options: Mapping[str, Value]) -> Value:
    text = row[column].text.lower() if column in row else ""
    if text not in options:
        raise row[column].error(unknown("value", text, [option for option in options if option]))
    return options[text]


def wrap_surfaces(
    rows: Collection[WrapRow], assembly: Assembly, muscles: Collection[str]
) -> tuple[SurfaceSnapshot, ...]:
    """Return the surfaces of a table, each with all muscles that wrap over it.

    Raises:
        InputError: A part, face or muscle does not exist; the message states the line.
    """
    by_name: dict[str, SurfaceSnapshot] = {}
    for row in rows:
        if row.muscle.text not in muscles:
            raise row.muscle.error(unknown("muscle", row.muscle.text, list(muscles)))
        surface = by_name.get(row.name.text) or _surface(row, assembly)
        use = surface.use or SurfaceUse(row.name.text)
        by_name[row.name.text] = replace(surface, use=replace(use, muscles=(*use.muscles, row.use)))
    return tuple(by_name.values())


def _surface(row: WrapRow, assembly: Assembly) -> SurfaceSnapshot:
    """Return the face of a row's part that is closest to its point."""
    if row.near is None:
        raise row.name.error("a point near the face is missing: columns x, y, z")
    part = find_place(row.part, assembly)
    faces = [(_distance(face, row.near), place, face) for place, face in _faces(part, assembly)]
    if not faces:
        raise row.part.error(f"part {part.path!r} has neither cylinder nor sphere faces")
    distance, place, face = min(faces, key=lambda candidate: candidate[0])
    if distance > face.radius * (1.0 + 1e-6):
        problem = f"the nearest cylinder or sphere face is {1000 * distance:.3g} mm away"
        raise row.name.error(f"{problem}; use a point on the face or on its axis")
    where = face.shape, face.radius, face.centre, face.axis, face.length
    return SurfaceSnapshot(place.path, *where, entity=f"face {row.name.text}")


def _faces(part: Place, assembly: Assembly) -> Iterator[tuple[Place, Face]]:
    for place in assembly.below(part.path):
        for face in assembly.faces(place):
            yield place, face


def _distance(face: Face, point: Vector3) -> float:
    """Return the distance of a point from the sphere, or from the cylinder between its ends."""
    apart = np.subtract(point, face.centre)
    if face.shape == "sphere":
        return abs(float(np.linalg.norm(apart)) - face.radius)
    along = float(np.dot(apart, face.axis))
    across = float(np.linalg.norm(apart - along * np.array(face.axis)))
    return math.hypot(across - face.radius, max(0.0, abs(along) - face.length / 2.0))
