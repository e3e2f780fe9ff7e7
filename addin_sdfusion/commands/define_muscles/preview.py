"""Preview of the muscles in the design while the dialog is open."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import adsk.core
import adsk.fusion

from ...fusion.units import CM
from ...muscles.path import path_of
from ...robot.model.pose import Vector3
from .model.model import MuscleModel

_THIN, _THICK, _TEXT = 2.0, 5.0, 14.0  # pixels
_COVERED = 0.6
"""Opacity of lines and labels behind bodies."""


def draw(design: Any, model: MuscleModel, colors: Mapping[str, str]) -> None:
    """Draw all muscles, the chosen one thick and with the numbers of its points.

    Lines and labels are visible through bodies that cover them. The function must be called only in
    `executePreview`, whose changes Fusion reverts.

    Args:
        colors: Colours of muscles that replace their own colours.
    """
    table, muscle = model.table, model.muscle
    group = design.rootComponent.customGraphicsGroups.add()
    group.isSelectable = False  # the preview cannot be picked by mistake
    for row in table.rows:
        points = path_of(table, row.name).points
        color = _color(colors.get(row.name, row.color))
        if len(points) > 1:
            _line(group, points, color, _THICK if row.name == muscle else _THIN)
        elif points:
            _label(group, points[0], "•", color)
        if row.name == muscle:
            for point in (p for p in table.points_of(row.name) if not p.lost):
                _label(group, point.position, f" {point.number}", color)


def _line(group: Any, points: list[Vector3], color: Any, weight: float) -> None:
    flat = [v / CM for point in points for v in point]
    coordinates = adsk.fusion.CustomGraphicsCoordinates.create(flat)
    line = group.addLines(coordinates, list(range(len(points))), True, [len(points)])
    line.weight = weight
    line.color = color
    line.depthPriority = 1  # not hidden by coincident faces
    line.isSelectable = False


def _label(group: Any, position: Vector3, text: str, color: Any) -> None:
    anchor = adsk.core.Point3D.create(*(v / CM for v in position))
    place = adsk.core.Matrix3D.create()
    place.translation = anchor.asVector()
    scale = adsk.fusion.CustomGraphicsViewScale.create(1.0, anchor)  # the unit is a pixel
    label = group.addText(text, "Arial", _TEXT, place)
    label.color = color
    label.depthPriority = 1
    label.isSelectable = False
    board = adsk.fusion.CustomGraphicsBillBoard.create(anchor)
    board.billBoardStyle = adsk.fusion.CustomGraphicsBillBoardStyles.ScreenBillBoardStyle
    label.billBoarding = board
    label.viewScale = scale


def _color(text: str) -> Any:
    red, green, blue = (int(text[i : i + 2], 16) for i in (1, 3, 5))
    color = adsk.core.Color.create(red, green, blue, 255)
    return adsk.fusion.CustomGraphicsShowThroughColorEffect.create(color, _COVERED)
