"""Preview of the muscles in the design while the dialog is open."""

from __future__ import annotations

from typing import Any

import adsk.core
import adsk.fusion

from ...fusion.units import CM
from ...muscles.rows import MuscleTable
from ...robot.model.pose import Vector3

_THIN, _THICK = 2.0, 5.0  # pixels
_TEXT = 0.6  # cm


def draw(design: Any, table: MuscleTable, muscle: str) -> None:
    """Draws all muscles, the chosen one thick and with the numbers of its points.

    Only for `executePreview`: Fusion takes everything back.
    """
    group = design.rootComponent.customGraphicsGroups.add()
    group.isSelectable = False  # nothing that could be picked by mistake
    for row in table.rows:
        points = [point.position for point in table.points_of(row.name)]
        color = _color(row.color)
        if len(points) > 1:
            _line(group, points, color, _THICK if row.name == muscle else _THIN)
        elif points:
            _label(group, points[0], "•", color)
        if row.name == muscle:
            for point in table.points_of(row.name):
                _label(group, point.position, f" {point.number}", color)


def _line(group: Any, points: list[Vector3], color: Any, weight: float) -> None:
    flat = [v / CM for point in points for v in point]
    coordinates = adsk.fusion.CustomGraphicsCoordinates.create(flat)
    line = group.addLines(coordinates, list(range(len(points))), True, [len(points)])
    line.weight = weight
    line.color = color
    line.depthPriority = 1  # not hidden by the faces that it runs through
    line.isSelectable = False


def _label(group: Any, position: Vector3, text: str, color: Any) -> None:
    anchor = adsk.core.Point3D.create(*(v / CM for v in position))
    place = adsk.core.Matrix3D.create()
    place.translation = anchor.asVector()
    label = group.addText(text, "Arial", _TEXT, place)
    label.color = color
    label.depthPriority = 1
    label.isSelectable = False
    board = adsk.fusion.CustomGraphicsBillBoard.create(anchor)
    board.billBoardStyle = adsk.fusion.CustomGraphicsBillBoardStyles.ScreenBillBoardStyle
    label.billBoarding = board


def _color(text: str) -> Any:
    red, green, blue = (int(text[i : i + 2], 16) for i in (1, 3, 5))
    color = adsk.core.Color.create(red, green, blue, 255)
    return adsk.fusion.CustomGraphicsSolidColorEffect.create(color)
