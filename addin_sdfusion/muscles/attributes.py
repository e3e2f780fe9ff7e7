"""Attributes of points, faces and the design, as JSON text.

All attributes are in the group `CARDSFlow`. A construction point has the attribute `point` and a
face the attribute `wrap`. The design has the attributes `muscles`, `settings`, and `points` for
points that cannot be stored on a construction point.

Every record has the key `version`. Records without it are of version 1, which stored the link and
the path of the occurrence of every point. Version 2 stores a link only if the user chose it, and
the occurrence by persistent identifiers. Unknown keys of a newer version are kept.
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
from ..snapshot import MuscleSnapshot, PointUse, Role, SurfaceUse, WrapUse

GROUP = "CARDSFlow"
POINT = "point"
WRAP = "wrap"
MUSCLES = "muscles"
POINTS = "points"
SETTINGS = "settings"
UNREAD = "_unread"
"""Suffix of the attribute with the former text of an attribute that is not a list."""

VERSION = 2
"""Version of the records that this add-in writes."""

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
    uses = [{"side": 0, "turns": 0, **_merge(to_plain(use))} for use in wrap.muscles]
    return json_text(
        {"link": "", **_plain(wrap), "muscles": uses}, ensure_ascii=False, sort_keys=True
    )


def muscles_text(muscles: Sequence[MuscleSnapshot], unread: Sequence[Any] = ()) -> str:
    """Return the text of the attribute of a design that lists the muscles, in order."""
    plain = [
        _merge({"version": VERSION, **{f.name: to_plain(getattr(m, f.name)) for f in fields(m)}})
        for m in muscles
    ]
    return json_text([*plain, *unread], ensure_ascii=False)


def settings_text(settings: ExportSettings, before: str = "{}") -> str:
    """Return the text of the attribute of a design that stores the settings of the export.

    Args:
        before: Stored text, whose keys of a newer version are kept.
    """
    plain = {"version": VERSION, **to_plain(settings)}
    try:
        _, extra = _split(ExportSettings, json.loads(before))
    except (InputError, ValueError, RecursionError):
        extra = {}
    plain = _merge({**plain, "extra": extra})
    return json_text(plain, ensure_ascii=False, sort_keys=True)


def _plain(record: Any) -> dict[str, Any]:
    return _merge({"version": VERSION, **to_plain(record)})


def _merge(plain: dict[str, Any]) -> dict[str, Any]:
    """Return a record with the unknown keys of a newer version as they were read."""
    extra = plain.pop("extra", {})
    return {**plain, **{key: json.loads(text) for key, text in extra.items()}}


def _split(cls: type, plain: Any) -> tuple[Any, dict[str, str]]:
    """Return the known keys of a stored record, and the other keys as JSON texts."""
    if not isinstance(plain, dict):
        return plain, {}
    version = plain.get("version", 1)
    if type(version) is not int or version < 1:
        raise InputError(f"must be a version of the record, not {version!r}", key="version")
    names = {f.name for f in fields(cls)} - {"extra"}
    if version <= VERSION:
        return {key: item for key, item in plain.items() if key != "version"}, {}
    extra = {key: json_text(item) for key, item in plain.items() if key not in names}
    return {key: item for key, item in plain.items() if key in names}, extra


def is_newer(record: PointUse | SurfaceUse | MuscleSnapshot) -> bool:
    """Return whether a record was stored by a newer version of the add-in."""
    return bool(record.extra)


def _read(cls: type[Record], plain: Any, where: str) -> Record:
    """Return a record from a stored one of any version."""
    values, extra = _split(cls, plain)
    if cls is SurfaceUse and extra and isinstance(values.get("muscles"), list):
        uses = [_split(WrapUse, {**item, "version": VERSION + 1}) for item in values["muscles"]]
        for _, more in uses:
            del more["version"]
        values = {**values, "muscles": [{**use, "extra": more} for use, more in uses]}
    if extra:
        values = {**values, "extra": extra}
    elif isinstance(values, dict) and "extra" in values:
        raise InputError("unknown key 'extra'", key=where)
    return from_plain(cls, values, where)


def read_kept_point(plain: Any, where: str) -> KeptPoint:
    """Return a point from an item of the attribute of a design.

    Raises:
        InputError: The item cannot be read; the message names the key. The functions below raise
            the same error.
    """
    if not isinstance(plain, dict) or not isinstance(plain.get("use"), dict):
        return from_plain(KeptPoint, plain, where)
    use = _read(PointUse, plain["use"], f"{where}.use")
    others = {key: item for key, item in plain.items() if key != "use"}
    return replace(from_plain(KeptPoint, {**others, "use": {"role": use.role}}, where), use=use)


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


def read_muscles(text: str) -> tuple[MuscleSnapshot, ...]:
    """Return the muscles that are listed in the attribute of a design."""
    return tuple(
        read_muscle(plain, f"{MUSCLES}[{i}]") for i, plain in enumerate(read_list(text, MUSCLES))
    )


def read_settings(text: str) -> ExportSettings:
    """Return the settings of the export that are stored in the design."""
    return from_plain(ExportSettings, _split(ExportSettings, _json(text, SETTINGS))[0], SETTINGS)


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
