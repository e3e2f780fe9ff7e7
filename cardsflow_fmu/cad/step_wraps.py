"""Wrap surfaces of STEP files: faces of parts, each identified by a point near it."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
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


def _wrap(row: Mapping[str, Cell]) -> WrapUse:
    side, inside = _option(row, "side", _SIDES), _option(row, "inside", _ANSWERS)
    turns = row["turns"].whole() if "turns" in row else 0
    if inside and (side or turns):
        raise row["inside"].error("a muscle inside its surface cannot have a side or turns")
    return WrapUse(row["muscle"].text, row["after"].whole(), side, turns, inside)


def _option(row: Mapping[str, Cell], column: str, options: Mapping[str, Value]) -> Value:
    text = row[column].text.lower() if column in row else ""
    if text not in options:
        raise row[column].error(unknown("value", text, [option for option in options if option]))
    return options[text]


def wrap_surfaces(
    file: Path, assembly: Assembly, muscles: Collection[str]
) -> tuple[SurfaceSnapshot, ...]:
    """Return the surfaces of a table, each with all muscles that wrap over it.

    Rows of one surface have the same name; the first one has a point near its face.

    Raises:
        InputError: A part, face or muscle does not exist; the message states the line.
    """
    required = ("name", "part", "muscle", "after")
    by_name: dict[str, SurfaceSnapshot] = {}
    for row in read_rows(file, required, ("x", "y", "z", "side", "turns", "inside")):
        wrap, near = _wrap(row), vector(row, ("x", "y", "z"), METRES)
        if wrap.muscle not in muscles:
            raise row["muscle"].error(unknown("muscle", wrap.muscle, list(muscles)))
        name = row["name"].text
        surface = by_name.get(name) or _surface(row["name"], row["part"], near, assembly)
        use = surface.use or SurfaceUse(name)
        by_name[name] = replace(surface, use=replace(use, muscles=(*use.muscles, wrap)))
    return tuple(by_name.values())


def _surface(name: Cell, part: Cell, near: Vector3 | None, assembly: Assembly) -> SurfaceSnapshot:
    """Return the face of a part that is closest to a point."""
    if near is None:
        raise name.error("a point near the face is missing: columns x, y, z")
    whole = find_place(part, assembly)
    faces = [(_distance(face, near), place, face) for place, face in _faces(whole, assembly)]
    if not faces:
        raise part.error(f"part {whole.path!r} has neither cylinder nor sphere faces")
    distance, place, face = min(faces, key=lambda candidate: candidate[0])
    if distance > face.radius * (1.0 + 1e-6):
        problem = f"the nearest cylinder or sphere face is {1000 * distance:.3g} mm away"
        raise name.error(f"{problem}; use a point on the face or on its axis")
    where = face.shape, face.radius, face.centre, face.axis, face.length
    return SurfaceSnapshot(place.path, *where, entity=f"face {name.text}")


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
