"""Compressed data of a replay page: all frames in a few hundred kilobytes.

The points of a shape in all frames form a table.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.results.viewer.scene import colours, shapes
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.results.viewer.scene.camera import motion_plane
from cardsflow_fmu.results.viewer.scene.stage import Stage

from .robot_data import robot_data
from .tables import TableSequence


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
    tables = TableSequence()
    header = {
        "groups": list(shapes.GROUPS),
        "hidden": list(shapes.HIDDEN_AT_FIRST),
        "ramp": [list(colour) for colour in colours.RAMP],
        "acts": [_act(act, tables) for act in acts],
    }
    text = json_text(header, separators=(",", ":")).encode()
    return zlib.compress(struct.pack("<I", len(text)) + text + tables.encode(), 9)


def _act(act: Act, tables: TableSequence) -> dict[str, Any]:
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
        "events": [{"time": time, "text": text} for time, text in act.events],
        "plane": None if (plane := motion_plane(stage)) is None else plane.tolist(),
        "tensions": _legend(stage),
        **robot_data(act, tables),
        "shapes": [_shape(track, tables) for track in tracks.values()],
    }


def _legend(stage: Stage) -> list[list[float]]:
    """Return the distinct tension ranges of the colours, in [N]."""
    if stage.motion.tensions is None:
        return []
    count = len(stage.robot.muscles)
    return [list(bounds) for bounds in dict.fromkeys(map(stage.tension_range, range(count)))]


def _shape(track: _Track, tables: TableSequence) -> dict[str, Any]:
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
