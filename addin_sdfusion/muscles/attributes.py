"""Attributes of points, faces and the design, as JSON text.

All attributes are in the group `CARDSFlow`. A construction point has the attribute `point` and a
face the attribute `wrap`. The design has the attributes `muscles`, `settings`, and `points` for
points that cannot be stored on a construction point.

Records have the key `version`. A record of another version cannot be read; its text is kept.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar, get_args

from ..robot.errors import InputError
from ..robot.json_text import json_text
from ..robot.model.pose import Vector3
from ..robot.records import from_plain, to_plain
from ..settings import ExportSettings
from ..snapshot import MuscleSnapshot, PointUse, Role, SurfaceUse

GROUP = "CARDSFlow"
POINT = "point"
WRAP = "wrap"
MUSCLES = "muscles"
POINTS = "points"
SETTINGS = "settings"
UNREAD = "_unread"
"""Suffix of the attribute with the former text of an attribute that cannot be read."""

VERSION = 2
"""Version of the records."""

Record = TypeVar("Record")


@dataclass(frozen=True, slots=True)
class KeptPoint:
    """A point on a component of another document, stored in the design that contains it.

    Attributes:
        position: In the frame of the occurrence, in [m].
    """

    occurrence: str
    position: Vector3
    use: PointUse


def kept_points_text(points: Sequence[KeptPoint], unread: Sequence[Any] = ()) -> str:
    """Return the text of the attribute of a design that stores points."""
    plain = [{**to_plain(p), "use": _plain(p.use)} for p in points]
    return json_text([*plain, *unread], ensure_ascii=False, sort_keys=True)


def point_text(point: PointUse) -> str:
    """Return the text of a point's attribute."""
    plain = {"link": "", "muscle": "", "number": 0, "name": "", **_plain(point)}
    return json_text(plain, ensure_ascii=False, sort_keys=True)


def wrap_text(wrap: SurfaceUse) -> str:
    """Return the text of a face's attribute."""
    uses = [{"side": 0, "turns": 0, **to_plain(use)} for use in wrap.muscles]
    return json_text(
        {"link": "", **_plain(wrap), "muscles": uses}, ensure_ascii=False, sort_keys=True
    )


def muscles_text(muscles: Sequence[MuscleSnapshot], unread: Sequence[Any] = ()) -> str:
    """Return the text of the attribute of a design that lists the muscles, in order."""
    plain = [
        {"version": VERSION, **{f.name: to_plain(getattr(m, f.name)) for f in fields(m)}}
        for m in muscles
    ]
    return json_text([*plain, *unread], ensure_ascii=False)


def settings_text(settings: ExportSettings) -> str:
    """Return the text of the attribute of a design that stores the settings of the export."""
    return json_text(_plain(settings), ensure_ascii=False, sort_keys=True)


def _plain(record: Any) -> dict[str, Any]:
    return {"version": VERSION, **to_plain(record)}


def _read(cls: type[Record], plain: Any, where: str) -> Record:
    return from_plain(cls, _without_version(plain, where), where)


def _without_version(plain: Any, where: str) -> Any:
    if not isinstance(plain, dict):
        return plain
    version = plain.get("version", VERSION)
    if type(version) is not int or version != VERSION:
        problem = f"has version {version!r}, this version of the add-in reads {VERSION}"
        raise InputError(problem, key=where)
    return {key: item for key, item in plain.items() if key != "version"}


def read_kept_point(plain: Any, where: str) -> KeptPoint:
    """Return a point from an item of the attribute of a design.

    Raises:
        InputError: The item cannot be read; the message names the key. The functions below raise
            the same error.
    """
    if isinstance(plain, dict) and "use" in plain:
        plain = {**plain, "use": _without_version(plain["use"], f"{where}.use")}
    return from_plain(KeptPoint, plain, where)


def read_point(text: str) -> PointUse:
    """Return the use of a point from its attribute."""
    return _read(PointUse, _json(text, POINT), POINT)


def read_wrap(text: str) -> SurfaceUse:
    """Return the use of a face from its attribute."""
    return _read(SurfaceUse, _json(text, WRAP), WRAP)


def read_muscle(plain: Any, where: str) -> MuscleSnapshot:
    """Return a muscle from an item of the attribute of a design."""
    muscle = _read(MuscleSnapshot, plain, where)
    return replace(muscle, color=muscle.color.lower())


def read_settings(text: str) -> ExportSettings:
    """Return the settings of the export that are stored in the design."""
    return _read(ExportSettings, _json(text, SETTINGS), SETTINGS)


def can_read_settings(text: str) -> bool:
    """Return whether stored settings of the export can be read."""
    try:
        read_settings(text)
    except InputError:
        return False
    return True


def partial_use(plain: Any) -> PointUse | None:
    """Return role, muscle, number and name of a record that cannot be read; None if unknown."""
    if not isinstance(plain, dict) or plain.get("role") not in get_args(Role):
        return None
    role: Role = plain["role"]
    muscle, number, name = (plain.get(key) for key in ("muscle", "number", "name"))
    if role == "via":
        is_known = isinstance(muscle, str) and muscle and type(number) is int
        return PointUse(role, muscle=str(muscle), number=int(number)) if is_known else None  # type: ignore[arg-type]
    return PointUse(role, name=name) if isinstance(name, str) and name else None


def updated_record(plain: Any, use: PointUse) -> Any:
    """Return a stored record with muscle, number and name of its row, otherwise unchanged."""
    if not isinstance(plain, dict):
        return plain
    current = {"muscle": use.muscle, "number": use.number, "name": use.name}
    return {**plain, **{key: item for key, item in current.items() if plain.get(key, item) != item}}


def without_tokens(text: str) -> str:
    """Return a stored text without tokens, which differ at every call for the same entity."""
    return re.sub(r'"token": "[^"]*"', "", text)


def read_list(text: str, where: str) -> list[Any]:
    """Return the items of the attribute of a design."""
    plain = _json(text, where)
    if not isinstance(plain, list):
        raise InputError("must hold a list", key=where)
    return plain


def _json(text: str, where: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not JSON: {error}", key=where) from None
