"""Attributes of points, faces and the design, as JSON text.

All are in the group `CARDSFlow`: `point` on a construction point, `wrap` on a face, `muscles` and
`settings` on the design.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from ..records import from_plain, to_plain
from ..robot.errors import InputError
from ..robot.json_text import json_text
from ..robot.model.muscle import CableKind, CableModel
from ..robot.model.robot import Axis
from ..settings import ExportSettings
from .rows import COLORS, F_MAX, F_MIN, MuscleRow, WrapUse

GROUP = "CARDSFlow"
POINT = "point"
WRAP = "wrap"
MUSCLES = "muscles"
SETTINGS = "settings"

COLOR = re.compile(r"#[0-9a-fA-F]{6}", re.ASCII)
Role = Literal["via", "task", "marker"]


@dataclass(frozen=True, slots=True)
class PointAttribute:
    """What a construction point is.

    Attributes:
        role: `via`, `task` or `marker`.
        link: Name of the link it is fixed to.
        muscle: Of a via point: name of the muscle.
        number: Of a via point: its place along the muscle.
        name: Of a task point or marker: its name.
        axes: Of a task point: which coordinates count; the position's if empty.
        occurrence: Path of the occurrence that is meant where the component is in several places.
        made: Whether the add-in made the point, and so may delete it.
        original: The name that the user gave a point that the add-in did not make.
    """

    role: Role
    link: str
    muscle: str = ""
    number: int = 0
    name: str = ""
    axes: tuple[Axis, ...] = ()
    occurrence: str = ""
    made: bool = False
    original: str = ""


@dataclass(frozen=True, slots=True)
class WrapAttribute:
    """What a face is.

    Attributes:
        name: Name of the wrap surface.
        link: Name of the link it is fixed to.
        muscles: Which muscles wrap over it.
        occurrence: Path of the occurrence that is meant where the component is in several places.
    """

    name: str
    link: str
    muscles: tuple[WrapUse, ...] = ()
    occurrence: str = ""


@dataclass(frozen=True, slots=True)
class _MuscleText:
    """A muscle as the attribute has it, but for its model's parameters."""

    name: str
    color: str = COLORS[0]
    f_min: float = F_MIN
    f_max: float = F_MAX
    model: CableKind = "ideal"


def point_text(point: PointAttribute) -> str:
    """The text of a point's attribute."""
    plain = {"muscle": "", "number": 0, "name": "", **to_plain(point)}
    return json_text(plain, ensure_ascii=False, sort_keys=True)


def wrap_text(wrap: WrapAttribute) -> str:
    """The text of a face's attribute."""
    uses = [{"side": 0, "turns": 0, **to_plain(use)} for use in wrap.muscles]
    return json_text({**to_plain(wrap), "muscles": uses}, ensure_ascii=False, sort_keys=True)


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


def read_point(text: str) -> PointAttribute:
    """The attribute of a point.

    Raises:
        InputError: It cannot be read; the message names the key.
    """
    return from_plain(PointAttribute, _json(text, POINT), POINT)


def read_wrap(text: str) -> WrapAttribute:
    """The attribute of a face.

    Raises:
        InputError: It cannot be read; the message names the key.
    """
    return from_plain(WrapAttribute, _json(text, WRAP), WRAP)


def read_muscles(text: str) -> tuple[MuscleRow, ...]:
    """The muscles that the design's attribute lists.

    Raises:
        InputError: It cannot be read; the message names the key.
    """
    plain = _json(text, MUSCLES)
    if not isinstance(plain, list):
        raise InputError("must hold a list", key=MUSCLES)
    return tuple(_muscle(item, f"{MUSCLES}[{i}]") for i, item in enumerate(plain))


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


def _muscle(plain: Any, where: str) -> MuscleRow:
    if not isinstance(plain, dict):
        raise InputError("must hold an object", key=where)
    parameters = _parameters(plain.get("parameters", {}), f"{where}.parameters")
    rest = {key: value for key, value in plain.items() if key != "parameters"}
    given = from_plain(_MuscleText, rest, where)
    if not COLOR.fullmatch(given.color):
        raise InputError(f"must be #rrggbb, not {given.color!r}", key=f"{where}.color")
    model = CableModel(given.model, parameters)
    return MuscleRow(given.name, given.color.lower(), given.f_min, given.f_max, model)


def _parameters(plain: Any, where: str) -> tuple[tuple[str, float], ...]:
    if not isinstance(plain, dict):
        raise InputError("must hold an object", key=where)
    for name, value in plain.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InputError(f"must be a number, not {value!r}", key=f"{where}.{name}")
        if not math.isfinite(value):
            raise InputError("must be finite", key=f"{where}.{name}")
    return tuple((name, float(value)) for name, value in plain.items())
