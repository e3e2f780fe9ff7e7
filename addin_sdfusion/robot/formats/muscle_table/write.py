"""Writer for muscles.csv. Pages of `cardsflow edit` write the same text; see its columns there."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from typing import Any

from .document import MuscleDocument, MuscleRecord, SurfaceRecord, WrapRecord

COLUMNS = (
    "role",
    "name",
    "number",
    "frame",
    "link",
    "x [m]",
    "y [m]",
    "z [m]",
    "f_min [N]",
    "f_max [N]",
    "model",
    "parameters",
    "surface",
    "side",
    "turns",
    "inside",
    "shape",
    "radius [m]",
    "length [m]",
    "half_axis_y [m]",
    "half_axis_z [m]",
    "roll [rad]",
    "pitch [rad]",
    "yaw [rad]",
    "options",
)
"""Columns, in the order of the writer; the reader accepts any order and other units."""

ALWAYS = COLUMNS[:12]
"""Columns that are written even if they are empty."""

Line = Mapping[str, str]
"""Cells of a line by column; the other cells are empty."""


def table_text(document: MuscleDocument) -> str:
    """Return the text of a muscles.csv; columns without content are omitted."""
    lines = [line for muscle in document.muscles for line in _muscle(muscle)]
    lines += [_surface(surface) for surface in document.wraps]
    columns = [c for c in COLUMNS if c in ALWAYS or any(line.get(c) for line in lines)]
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([line.get(column, "") for column in columns] for line in lines)
    return stream.getvalue()


def _muscle(muscle: MuscleRecord) -> Iterator[Line]:
    properties = {
        "f_min [N]": repr(muscle.f_min),
        "f_max [N]": "inf" if muscle.f_max is None else repr(muscle.f_max),
        "model": muscle.law,
        "parameters": " ".join(f"{key}={value!r}" for key, value in muscle.parameters.items()),
    }
    named = {"role": "via", "name": muscle.name}
    if muscle.options or not muscle.points:
        yield {**named, **properties, "options": muscle.options}
        properties = {}
    for k, point in enumerate(muscle.points):
        place = _place(point.link, point.position)
        yield {**named, "number": str(k), **place, **properties, "options": point.options}
        properties = {}
    for wrap in muscle.wraps:
        yield {"role": "wrap", "name": muscle.name, **_wrap(wrap)}


def _wrap(wrap: WrapRecord) -> Line:
    return {
        "number": str(wrap.segment),
        "surface": wrap.surface,
        "side": str(wrap.side) if wrap.side else "",
        "turns": str(wrap.turns) if wrap.turns else "",
        "inside": "yes" if wrap.inside else "",
        "options": wrap.options,
    }


def _surface(surface: SurfaceRecord) -> Line:
    cells: dict[str, Any] = {"radius [m]": surface.radius}
    if surface.length is not None:
        cells["length [m]"] = surface.length
    if surface.half_axes is not None:
        cells |= dict(zip(("half_axis_y [m]", "half_axis_z [m]"), surface.half_axes, strict=True))
    if any(surface.rpy):
        cells |= dict(zip(("roll [rad]", "pitch [rad]", "yaw [rad]"), surface.rpy, strict=True))
    return {
        "role": "surface",
        "name": surface.name,
        **_place(surface.link, surface.position),
        "shape": surface.shape,
        **{key: repr(value) for key, value in cells.items()},
    }


def _place(link: str, position: tuple[float, float, float]) -> Line:
    axes = zip(("x [m]", "y [m]", "z [m]"), map(repr, position), strict=True)
    return {"frame": "link", "link": link, **dict(axes)}
