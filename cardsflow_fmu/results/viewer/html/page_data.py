"""Compressed data of a replay page: all frames in a few hundred kilobytes.

The points of a shape in all frames form a table. Each table is scaled to 16-bit integers between
its minimum and maximum. It is stored column by column as differences between rows, and compressed
with deflate. The differences are small because successive frames are similar.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.results.viewer.scene import colours, shapes
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.results.viewer.scene.stage import Stage

_LEVELS = 0xFFFF


class _TableSequence:
    """Sequence of tables of 16-bit integers."""

    def __init__(self) -> None:
        self._parts: list[NDArray[np.uint16]] = []
        self._size = 0

    def add(self, values: ArrayLike, *, exact: bool = False) -> dict[str, Any]:
        """Add a table and return its entry in the header; only one of equal rows is stored.

        Args:
            values: Table, shape (rows, columns).
            exact: Whether the values are integers from 0 to 65535, which are not scaled.
        """
        table = np.asarray(values, dtype=np.float64)
        if len(table) > 1 and not exact and (table == table[0]).all():
            table = table[:1]
        low, high = (0.0, float(_LEVELS)) if exact else _bounds(table)
        scaled = np.rint((table - low) * (_LEVELS / (high - low)))
        numbers = np.nan_to_num(scaled).clip(0, _LEVELS).astype(np.uint16)
        differences = np.diff(numbers, axis=0, prepend=np.zeros_like(numbers[:1]))  # modulo 65536
        entry = {"at": self._size, "rows": len(table), "low": low, "high": high}
        self._parts.append(differences.T.reshape(-1))
        self._size += differences.size
        return entry | {"columns": table.shape[1]}

    def encode(self) -> bytes:
        """Return all low bytes, then all high bytes. High bytes are mostly 0 or 255."""
        numbers = np.concatenate(self._parts) if self._parts else np.zeros(0, np.uint16)
        low, high = (numbers & 0xFF).astype(np.uint8), (numbers >> 8).astype(np.uint8)
        return low.tobytes() + high.tobytes()


def _bounds(table: NDArray[np.float64]) -> tuple[float, float]:
    finite = table[np.isfinite(table)]
    if not finite.size:
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    return low, high if high > low else low + 1.0


@dataclass
class _Track:
    """Shape in all frames.

    Attributes:
        last: The shape in the last frame.
        points: Points of each frame, as a row.
        colours: Colour of each frame.
        values: Value of a label, or number of points of a trail, in each frame.
    """

    last: shapes.Shape
    points: list[NDArray[np.float64]] = field(default_factory=list)
    colours: list[shapes.Colour] = field(default_factory=list)
    values: list[float] = field(default_factory=list)

    def add(self, shape: shapes.Shape) -> None:
        self.last = shape
        if isinstance(shape, shapes.Trail):  # the path of the last frame contains all earlier paths
            self.values.append(len(shape.path))
        else:
            points = shape.points.reshape(-1)
            is_still = bool(self.points) and np.array_equal(points, self.points[0], equal_nan=True)
            self.points.append(self.points[0] if is_still else points)
        self.colours.append(shape.colour)
        if isinstance(shape, shapes.Label):
            self.values.append(shape.value)


def encode(acts: Sequence[Act]) -> bytes:
    """Return the compressed data: length of the header, header as JSON, tables."""
    tables = _TableSequence()
    header = {
        "groups": list(shapes.GROUPS),
        "hidden": list(shapes.HIDDEN_AT_FIRST),
        "ramp": [list(colour) for colour in colours.RAMP],
        "acts": [_act(act, tables) for act in acts],
    }
    text = json_text(header, separators=(",", ":")).encode()
    return zlib.compress(struct.pack("<I", len(text)) + text + tables.encode(), 9)


def _act(act: Act, tables: _TableSequence) -> dict[str, Any]:
    stage = act.stage
    tracks: dict[str, _Track] = {}
    for k in range(len(stage)):
        for shape in stage.scene(k):
            tracks.setdefault(shape.name, _Track(shape)).add(shape)
    return {
        "title": act.title,
        "notes": list(act.notes),
        "up": stage.up.tolist(),
        "reach": stage.reach,
        "box": [corner.tolist() for corner in stage.box],
        "floor": stage.floor,
        "time": [round(float(t), 6) for t in stage.motion.time],
        "tensions": _legend(stage),
        "shapes": [_shape(track, tables) for track in tracks.values()],
    }


def _legend(stage: Stage) -> list[list[float]]:
    """Return the distinct tension ranges of the colours, in [N]."""
    if stage.motion.tensions is None:
        return []
    count = len(stage.robot.muscles)
    return [list(bounds) for bounds in dict.fromkeys(map(stage.tension_range, range(count)))]


def _shape(track: _Track, tables: _TableSequence) -> dict[str, Any]:
    shape = track.last
    if isinstance(shape, shapes.Trail):
        points = shape.points
    elif all(row is track.points[0] for row in track.points):
        points = track.points[0][np.newaxis]
    else:
        points = np.stack(track.points)
    data: dict[str, Any] = {
        "name": shape.name,
        "kind": type(shape).__name__,
        "group": shapes.GROUPS.index(shape.group),
        "points": tables.add(points),
        "colours": tables.add(np.array(track.colours)),
    }
    if shape.opacity < 1.0:
        data["opacity"] = shape.opacity
    if hasattr(shape, "radius"):
        data["radius"] = shape.radius
    if isinstance(shape, shapes.Label):
        data["label"] = shape.title
    if track.values:
        exact = isinstance(shape, shapes.Trail)
        data["values"] = tables.add(np.array(track.values)[:, np.newaxis], exact=exact)
    if isinstance(shape, shapes.MeshShape):
        data["lever"] = shape.lever
        data["vertices"] = tables.add(shape.triangles.vertices)
        data["faces"] = tables.add(shape.triangles.faces, exact=True)
    return data
