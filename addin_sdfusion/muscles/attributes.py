"""Attributes of points, faces and the design, as JSON text.

All attributes are in the group `CARDSFlow`. A construction point has the attribute `point` and a
face the attribute `wrap`. The design has the attributes `muscles`, `settings`, and `points` for
points that cannot be stored on a construction point.
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
    """A point on a component of another document, stored in the design that contains it.

    Attributes:
        occurrence: Path of the occurrence.
        position: In the frame of the occurrence, in [m].
        use: Use of the point.
    """

    occurrence: str
    position: Vector3
    use: PointUse


def kept_points_text(points: Sequence[KeptPoint]) -> str:
    """Return the text of the attribute of a design that stores points."""
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
    """Return the text of the attribute of a design that lists the muscles, in order."""
    plain = [{f.name: to_plain(getattr(m, f.name)) for f in fields(m)} for m in muscles]
    return json_text(plain, ensure_ascii=False)


def settings_text(settings: ExportSettings) -> str:
    """Return the text of the attribute of a design that stores the settings of the export."""
    return json_text(to_plain(settings), ensure_ascii=False, sort_keys=True)


def read_kept_points(text: str) -> tuple[KeptPoint, ...]:
    """Return the points that are stored in the attribute of a design.

    Raises:
        InputError: The attribute cannot be read; the message names the key. The functions below
            raise the same error.
    """
    return _list(KeptPoint, text, POINTS)


def read_point(text: str) -> PointUse:
    """Return the use of a point from its attribute."""
    return from_plain(PointUse, _json(text, POINT), POINT)


def read_wrap(text: str) -> SurfaceUse:
    """Return the use of a face from its attribute."""
    return from_plain(SurfaceUse, _json(text, WRAP), WRAP)


def read_muscles(text: str) -> tuple[MuscleSnapshot, ...]:
    """Return the muscles that are listed in the attribute of a design."""
    muscles = _list(MuscleSnapshot, text, MUSCLES)
    return tuple(replace(muscle, color=muscle.color.lower()) for muscle in muscles)


def read_settings(text: str) -> ExportSettings:
    """Return the settings of the export that are stored in the design."""
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
    """Return the stored use of a construction point; None if it is missing or cannot be read.

    Args:
        attributes: Attributes of the point in the group of the add-in.
        name: Name of the point.
        findings: List to which findings are appended.
    """
    what = f"the attribute of construction point {name!r}"
    todo = "pick it again in Define muscles"
    return _read_attribute(read_point, attributes, POINT, (what, todo), ("point", name), findings)


def stored_surface(
    attributes: Mapping[str, str], where: str, findings: list[Finding]
) -> SurfaceUse | None:
    """Return the stored use of a face; None if it is missing or cannot be read.

    Args:
        attributes: Attributes of the face in the group of the add-in.
        where: Name of the occurrence or design.
        findings: List to which findings are appended.
    """
    what = f"the attribute of a wrap face of {where!r}"
    todo = "pick the face again in Define muscles"
    return _read_attribute(
        read_wrap, attributes, WRAP, (what, todo), ("occurrence", where), findings
    )


def stored_muscles(
    attributes: Mapping[str, str], design: str, findings: list[Finding]
) -> tuple[MuscleSnapshot, ...]:
    """Return the muscles that are listed in a design; empty if the list cannot be read.

    Args:
        attributes: Attributes of the design in the group of the add-in.
        design: Name of the design.
        findings: List to which findings are appended.
    """
    what = "the design's list of muscles"
    todo = "open Define muscles, set the force limits and press OK"
    return (
        _read_attribute(
            read_muscles, attributes, MUSCLES, (what, todo), ("design", design), findings
        )
        or ()
    )


def _read_attribute(
    read: Callable[[str], Record],
    attributes: Mapping[str, str],
    key: str,
    text: tuple[str, str],
    subject: tuple[str, str],
    findings: list[Finding],
) -> Record | None:
    """Return the value of an attribute; None with a finding if it cannot be read.

    Args:
        read: Function that parses the text of the attribute.
        attributes: Attributes in the group of the add-in.
        key: Name of the attribute.
        text: Description of the attribute, and advice to the user, for the message.
        subject: Kind and name of the subject of the finding.
        findings: List to which the finding is appended.
    """
    if key not in attributes:
        return None
    try:
        return read(attributes[key])
    except InputError as error:
        what, todo = text
        message = f"{what} cannot be read ({error}); {todo}"
        new = finding("error", "bad-attribute", message, *subject)
        if new not in findings:  # all occurrences of a component have the same points
            findings.append(new)
    return None
