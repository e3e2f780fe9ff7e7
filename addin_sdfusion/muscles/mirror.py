"""Mirroring of muscles from one side of the robot to the other.

A word at the beginning or end of a name specifies the side: `arm_l`, `left_arm`, `ArmRight`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Literal

from ..robot.errors import UnknownNameError
from ..robot.finding import Finding
from ..robot.model.pose import Vector3
from ..robot.model.robot import WORLD
from ..robot.model.rotations import dot, normalized, subtract
from ..snapshot import SurfaceSnapshot, WrapUse
from .checks import finding
from .rows import PointRow, WrapRow
from .table import MuscleTable

FindFace = Callable[[str, SurfaceSnapshot], SurfaceSnapshot | None]
"""Function that finds the only face of a link with the shape and place of a surface."""

_OTHER = {"l": "r", "left": "right"}
_OTHER |= {right: left for left, right in _OTHER.items()}
_MIRRORED_SIDE: dict[Literal[-1, 0, 1], Literal[-1, 0, 1]] = {-1: 1, 0: 0, 1: -1}
_SEPARATED = re.compile(r"(l|r|left|right)(?=[_\-. ])|(?<=[_\-. ])(l|r|left|right)$", re.IGNORECASE)
_JOINED = re.compile(
    r"^(left|right)(?=[A-Z0-9])|^(L|R)(?=[A-Z][a-z])|(?<=[a-z0-9])(Left|Right|L|R)$"
    r"|^(Left|Right)(?=[A-Z0-9])|^(left|right)$",
    re.ASCII,
)


@dataclass(frozen=True, slots=True)
class Plane:
    """Mirror plane.

    Attributes:
        point: Any point of the plane, in [m].
        normal: Normal vector of any nonzero length.
    """

    point: Vector3
    normal: Vector3

    def mirrored(self, p: Vector3) -> Vector3:
        """Return the mirror image of a point, in [m]."""
        return self._shifted(p, dot(subtract(p, self.point), normalized(self.normal)))

    def mirrored_direction(self, v: Vector3) -> Vector3:
        """Return the mirror image of a direction."""
        return self._shifted(v, dot(v, normalized(self.normal)))

    def _shifted(self, p: Vector3, distance: float) -> Vector3:
        n = normalized(self.normal)
        return (
            p[0] - 2.0 * distance * n[0],
            p[1] - 2.0 * distance * n[1],
            p[2] - 2.0 * distance * n[2],
        )


def other_side(name: str) -> str | None:
    """Return the name with left and right exchanged; None if it does not contain a side."""
    match = _SEPARATED.match(name) or _match_at_end(name) or _JOINED.search(name)
    if match is None:
        return None
    word = match[0]
    other = _OTHER[word.lower()]
    if word.isupper():
        other = other.upper()
    elif word[0].isupper():
        other = other.capitalize()
    return name[: match.start()] + other + name[match.end() :]


def _match_at_end(name: str) -> re.Match[str] | None:
    return next((m for m in _SEPARATED.finditer(name) if m.end() == len(name)), None)


def mirror_muscle(
    table: MuscleTable,
    muscle: str,
    plane: Plane,
    links: Collection[str],
    replace_existing: bool = False,
    find_face: FindFace = lambda link, face: None,
) -> tuple[MuscleTable, list[Finding]]:
    """Return the table with the mirror image of a muscle added.

    A link without a side, such as the torso, is its own image.

    Args:
        replace_existing: Whether to replace an existing muscle with the name of the image;
            otherwise it is an error.
        find_face: Finds the face of a wrap surface that has no counterpart yet.

    Returns:
        The new table, or the unchanged table if there are errors, and the findings.
    """
    row = table.row(muscle)
    if row is None:
        problem = UnknownNameError("muscle", muscle, [r.name for r in table.rows]).problem
        return table, [finding("error", "unknown-muscle", problem, "muscle", muscle)]
    name = _image_name(table, muscle)
    findings = []
    if table.row(name) is not None and not replace_existing:
        message = f"muscle {name!r} exists already; delete it, or tick 'Replace'"
        findings.append(finding("error", "mirrored-muscle-exists", message, "muscle", name))
    points = []
    for point in table.points_of(muscle):
        if point.lost:
            message = f"point {point.number} of muscle {muscle!r} is not found: {point.lost}"
            findings.append(finding("error", "lost-point", message, "muscle", muscle))
            continue
        link = other_side(point.link) or point.link
        if link not in links and link != WORLD:
            problem = UnknownNameError("link", link, sorted({*links} - {point.link})).problem
            message = f"point {point.number} of muscle {muscle!r} on link {point.link!r}: {problem}"
            message += "; rename the rigid group or component so that left and right match"
            findings.append(finding("error", "unknown-mirrored-link", message, "link", link))
        image = plane.mirrored(point.position)
        points.append(PointRow("via", link, name, point.number, position=image))
    if any(f.is_error for f in findings):
        return table, findings
    replaced = table.row(name)
    color = replaced.color if replaced else table.next_color()
    table = table.delete_muscle(name).with_muscle(replace(row, name=name, color=color))
    first = min((point.number for point in points), default=0)
    table = table.with_points(name, points, first)
    table = _with_counterparts(table, muscle, plane, find_face)
    return _mirror_wraps(table, muscle, name, plane, findings)


def _image_name(table: MuscleTable, muscle: str) -> str:
    """Return the name of a mirror image.

    A name without a side becomes `motorN` if it has this form; otherwise a suffix is appended.
    """
    other = other_side(muscle)
    if other is not None:
        return other
    if re.fullmatch(r"motor[0-9]+", muscle):
        return table.new_muscle_name()
    return f"{muscle}_mirrored"


def _with_counterparts(
    table: MuscleTable, muscle: str, plane: Plane, find_face: FindFace
) -> MuscleTable:
    """Return the table with the surfaces of the other side that a muscle needs."""
    for wrap, _ in table.wraps_of(muscle):
        name, link = _other_surface(wrap), other_side(wrap.link)
        if name is None or link is None or any(other.name == name for other in table.wraps):
            continue
        image = replace(
            wrap.face,
            centre=plane.mirrored(wrap.face.centre),
            axis=plane.mirrored_direction(wrap.face.axis),
        )
        face = None if wrap.lost else find_face(link, image)
        if face is not None:
            row = WrapRow(name, link, occurrence=face.occurrence, face=face)
            table = replace(table, wraps=(*table.wraps, row))
    return table


def _other_surface(wrap: WrapRow) -> str | None:
    """Return the name of a surface on the other side; None if its name does not contain a side."""
    link = other_side(wrap.link)
    if link is not None and wrap.name.startswith(wrap.link):
        return link + wrap.name[len(wrap.link) :]
    return other_side(wrap.name)


def _mirror_wraps(
    table: MuscleTable, muscle: str, image: str, plane: Plane, findings: list[Finding]
) -> tuple[MuscleTable, list[Finding]]:
    """Return the table in which the image wraps over the surfaces of the other side."""
    wraps = {wrap.name: wrap for wrap in table.wraps}
    for wrap, use in table.wraps_of(muscle):
        other = wraps.get(_other_surface(wrap) or wrap.name)
        if other is None or (other.name == wrap.name and other_side(wrap.link)):
            message = (
                f"muscle {image!r} has no counterpart of surface {wrap.name!r} on its side; pick "
                "the face on the wrap tab"
            )
            findings.append(finding("warning", "wrap-not-mirrored", message, "muscle", image))
            continue
        # A mirrored rotation turns the other way, unless the axis of the face is reversed too.
        same = dot(plane.mirrored_direction(wrap.face.axis), other.face.axis) >= 0.0
        side = _MIRRORED_SIDE[use.side] if same else use.side
        turned = WrapUse(image, use.after, side, use.turns, use.inside)
        wraps[other.name] = replace(other, muscles=(*other.muscles, turned))
    return replace(table, wraps=tuple(wraps[wrap.name] for wrap in table.wraps)), findings
