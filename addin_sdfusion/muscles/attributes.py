"""Attributes of points, faces and the design, as JSON text.

All are in the group `CARDSFlow`: `point` on a construction point, `wrap` on a face; `muscles`,
`settings`, and `points`, those that no construction point can hold, on the design.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

from ..records import from_plain, to_plain
from ..robot.errors import InputError
from ..robot.finding import Finding
from ..robot.json_text import json_text
from ..robot.model.pose import Vector3
from ..settings import ExportSettings
from ..snapshot import MuscleSnapshot, PointUse, SurfaceUse
from .checks import finding

GROUP = "CARDSFlow"
POINT = "point"
WRAP = "wrap"
MUSCLES = "muscles"
POINTS = "points"
SETTINGS = "settings"

Record = TypeVar("Record")


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
    """Return the text of the design's attribute that keeps points."""
    return json_text([to_plain(p) for p in points], ensure_ascii=False, sort_keys=True)


def point_text(point: PointUse) -> str:
    """Return the text of a point's attribute."""
    plain = {"link": "", "muscle": "", "number": 0, "name": "", **to_plain(point)}
    return json_text(plain, ensure_ascii=False, sort_keys=True)


def wrap_text(wrap: SurfaceUse) -> str:
    """Return the text of a face's attribute."""
    uses = [{"side": 0, "turns": 0, **to_plain(use)} for use in wrap.muscles]
    return json_text(
        {"link": "", **to_plain(wrap), "muscles": uses}, ensure_ascii=False, sort_keys=True
    )


def muscles_text(muscles: Sequence[MuscleSnapshot]) -> str:
    """Return the text of the design's attribute that lists the muscles, in order."""
    plain = [{f.name: to_plain(getattr(m, f.name)) for f in fields(m)} for m in muscles]
    return json_text(plain, ensure_ascii=False)


def settings_text(settings: ExportSettings) -> str:
    """Return the text of the design's attribute that keeps the settings of the export."""
    return json_text(to_plain(settings), ensure_ascii=False, sort_keys=True)


def read_kept_points(text: str) -> tuple[KeptPoint, ...]:
    """Return the points that the design's attribute keeps.

    Raises:
        InputError: It cannot be read; the message names the key. So do the readers below.
    """
    return _list(KeptPoint, text, POINTS)


def read_point(text: str) -> PointUse:
    """Return the attribute of a point."""
    return from_plain(PointUse, _json(text, POINT), POINT)


def read_wrap(text: str) -> SurfaceUse:
    """Return the attribute of a face."""
    return from_plain(SurfaceUse, _json(text, WRAP), WRAP)


def read_muscles(text: str) -> tuple[MuscleSnapshot, ...]:
    """Return the muscles that the design's attribute lists."""
    muscles = _list(MuscleSnapshot, text, MUSCLES)
    return tuple(replace(muscle, color=muscle.color.lower()) for muscle in muscles)


def read_settings(text: str) -> ExportSettings:
    """Return the settings of the export that the design remembers."""
    return from_plain(ExportSettings, _json(text, SETTINGS), SETTINGS)


def _list(kind: type[Record], text: str, where: str) -> tuple[Record, ...]:
    plain = _json(text, where)
    if not isinstance(plain, list):
        raise InputError("must hold a list", key=where)
    return tuple(from_plain(kind, item, f"{where}[{i}]") for i, item in enumerate(plain))


def _json(text: str, where: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not JSON: {error}", key=where) from None


def stored_point(
    attributes: Mapping[str, str], name: str, findings: list[Finding]
) -> PointUse | None:
    """What a construction point is; None if nothing is stored, or it cannot be read.

    Args:
        attributes: The point's in the add-in's group.
        name: The point's.
        findings: Takes what is wrong.
    """
    what = f"what is stored on the construction point {name!r}"
    todo = "pick it again in Define muscles"
    return _stored(read_point, attributes, POINT, (what, todo), ("point", name), findings)


def stored_surface(
    attributes: Mapping[str, str], where: str, findings: list[Finding]
) -> SurfaceUse | None:
    """What a face is; None if nothing is stored, or it cannot be read.

    Args:
        attributes: The face's in the add-in's group.
        where: The occurrence, or the design.
        findings: Takes what is wrong.
    """
    what = f"what is stored on a wrap face of {where!r}"
    todo = "pick the face again in Define muscles"
    return _stored(read_wrap, attributes, WRAP, (what, todo), ("occurrence", where), findings)


def stored_muscles(
    attributes: Mapping[str, str], design: str, findings: list[Finding]
) -> tuple[MuscleSnapshot, ...]:
    """Return the muscles that a design lists; none if that cannot be read.

    Args:
        attributes: The design's in the add-in's group.
        design: Its name.
        findings: Takes what is wrong.
    """
    what = "the design's list of muscles"
    todo = "open Define muscles, set the force limits and press OK"
    return (
        _stored(read_muscles, attributes, MUSCLES, (what, todo), ("design", design), findings) or ()
    )


def _stored(
    read: Callable[[str], Record],
    attributes: Mapping[str, str],
    key: str,
    text: tuple[str, str],
    subject: tuple[str, str],
    findings: list[Finding],
) -> Record | None:
    """What an attribute holds, with a finding if it cannot be read.

    Args:
        read: Reads the attribute's text.
        attributes: Those of the add-in's group.
        key: Name of the attribute.
        text: What cannot be read, and what to do.
        subject: Kind and name of the finding's subject.
        findings: Takes the finding.
    """
    if key not in attributes:
        return None
    try:
        return read(attributes[key])
    except InputError as error:
        what, todo = text
        message = f"{what} cannot be read ({error}); {todo}"
        new = finding("error", "bad-attribute", message, *subject)
        if new not in findings:  # the same point in several places
            findings.append(new)
    return None
