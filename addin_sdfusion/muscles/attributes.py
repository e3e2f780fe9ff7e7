"""Attributes of points, faces and the design, as JSON text.

All are in the group `CARDSFlow`: `point` on a construction point, `wrap` on a face; `muscles`,
`settings`, and `points`, those that no construction point can hold, on the design.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..records import from_plain, to_plain
from ..robot.errors import InputError
from ..robot.json_text import json_text
from ..robot.model.pose import Vector3
from ..settings import ExportSettings
from ..snapshot import MuscleSnapshot, PointUse, SurfaceUse
from .rows import MuscleRow

GROUP = "CARDSFlow"
POINT = "point"
WRAP = "wrap"
MUSCLES = "muscles"
POINTS = "points"
SETTINGS = "settings"


@dataclass(frozen=True, slots=True)
class KeptPoint:
    """A point on a component of another document, kept in the design that it is put into.

    Attributes:
        occurrence: Path of the occurrence.
        position: In the occurrence's frame, in [m].
        use: What it is.
    """

    occurrence: str
    position: Vector3
    use: PointUse


def kept_points_text(points: Sequence[KeptPoint]) -> str:
    """The text of the design's attribute that keeps points."""
    return json_text([to_plain(p) for p in points], ensure_ascii=False, sort_keys=True)


def read_kept_points(text: str) -> tuple[KeptPoint, ...]:
    """The points that the design's attribute keeps.

    Raises:
        InputError: It cannot be read; the message names the key.
    """
    plain = _json(text, POINTS)
    if not isinstance(plain, list):
        raise InputError("must hold a list", key=POINTS)
    return tuple(from_plain(KeptPoint, p, f"{POINTS}[{i}]") for i, p in enumerate(plain))


def point_text(point: PointUse) -> str:
    """The text of a point's attribute."""
    plain = {"link": "", "muscle": "", "number": 0, "name": "", **to_plain(point)}
    return json_text(plain, ensure_ascii=False, sort_keys=True)


def wrap_text(wrap: SurfaceUse) -> str:
    """The text of a face's attribute."""
    uses = [{"side": 0, "turns": 0, **to_plain(use)} for use in wrap.muscles]
    return json_text(
        {"link": "", **to_plain(wrap), "muscles": uses}, ensure_ascii=False, sort_keys=True
    )


def muscles_text(rows: Sequence[MuscleRow]) -> str:
    """The text of the design's attribute that lists the muscles, in order."""
    plain = [
        {
            "name": row.name,
            "color": row.color,
            "f_min": to_plain(row.f_min),
            "f_max": to_plain(row.f_max),
            "model": row.model.kind,
            "parameters": {name: to_plain(value) for name, value in row.model.parameters},
        }
        for row in rows
    ]
    return json_text(plain, ensure_ascii=False)


def settings_text(settings: ExportSettings) -> str:
    """The text of the design's attribute that keeps the settings of the export."""
    return json_text(to_plain(settings), ensure_ascii=False, sort_keys=True)


def read_point(text: str) -> PointUse:
    """The attribute of a point.

    Raises:
        InputError: It cannot be read; the message names the key.
    """
    return from_plain(PointUse, _json(text, POINT), POINT)


def read_wrap(text: str) -> SurfaceUse:
    """The attribute of a face.

    Raises:
        InputError: It cannot be read; the message names the key.
    """
    return from_plain(SurfaceUse, _json(text, WRAP), WRAP)


def read_muscles(text: str) -> tuple[MuscleSnapshot, ...]:
    """The muscles that the design's attribute lists.

    Raises:
        InputError: It cannot be read; the message names the key.
    """
    plain = _json(text, MUSCLES)
    if not isinstance(plain, list):
        raise InputError("must hold a list", key=MUSCLES)
    listed = (from_plain(MuscleSnapshot, item, f"{MUSCLES}[{i}]") for i, item in enumerate(plain))
    return tuple(replace(muscle, color=muscle.color.lower()) for muscle in listed)


def read_settings(text: str) -> ExportSettings:
    """The settings of the export that the design remembers.

    Raises:
        InputError: They cannot be read; the message names the key.
    """
    return from_plain(ExportSettings, _json(text, SETTINGS), SETTINGS)


def _json(text: str, where: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not JSON: {error}", key=where) from None
