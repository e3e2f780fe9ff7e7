"""Tab with the points of the chosen muscle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ....muscles.path import path_of
from ....muscles.rows import PointRow
from ....robot.errors import InputError
from ....robot.model.pose import Vector3
from ....robot.model.robot import WORLD
from ...dialogs import Cell, Input, number
from ..model import points
from ..model.model import MuscleModel
from . import properties
from .columns import Column, Rows, link_cell, text_cell

if TYPE_CHECKING:
    from ...inputs import Inputs

NEW_MUSCLE = "+ New muscle"
OF_PART = "Link of the picked part"

POINTS = ("Vertices", "Edges", "Faces", "SketchPoints", "ConstructionPoints")
"""Entities that can be picked as points."""

_TABLE_BUTTONS = (
    Input("up", "button", "Up", "Moves the selected point towards the start of the muscle."),
    Input("down", "button", "Down", "Moves the selected point towards the end of the muscle."),
    Input(
        "insert",
        "button",
        "Insert here",
        "Inserts the next picked points before the selected one. Press again to append points.",
    ),
    Input("duplicate", "button", "Duplicate", "Adds a copy of the selected point."),
    Input("delete", "button", "Delete", "Removes the selected point from the muscle."),
)

TAB = Input(
    "tab_muscles",
    "tab",
    "Muscles",
    children=(
        Input("muscle", "dropdown", "Muscle", "The muscle that picked points are added to."),
        Input("new_muscle", "button", "New muscle", "Adds a muscle; then click its points."),
        Input(
            "pick",
            "selection",
            "Points",
            "Click the points that the muscle passes through, in order: vertices, sketch points, "
            "construction points, centres of circles, spheres and tori, or any position on an edge "
            "or face.",
            filters=POINTS,
            prompt="Pick the next point of the muscle",
        ),
        Input(
            "centres",
            "check",
            "Use centres",
            "A click on a circle, sphere or torus means its centre. Otherwise it means the clicked "
            "position.",
            value=True,
        ),
        Input(
            "link",
            "dropdown",
            "Link",
            "The link that picked points are fixed to.",
            options=(OF_PART,),
            value=OF_PART,
        ),
        Input(
            "points",
            "table",
            "Points",
            "Points of the muscle, in order, at the pose of the design. Edit the coordinates to "
            "move a point.",
            columns=("No.", "Link", "x, y, z [mm]"),
            widths=(1, 3, 4),
            rows=8,
            children=_TABLE_BUTTONS,
        ),
        Input("length", "text", "Length", "Length at the pose of the design."),
        Input("preview", "text", "Preview", "What the canvas shows."),
        properties.GROUP,
    ),
)


def _position(position: Vector3) -> str:
    """Return a position in [mm] as text."""
    return ", ".join(f"{1000 * v:.1f}" for v in position)


def _place(_: MuscleModel, point: PointRow) -> Cell:
    """Return the position of a point, or the reason why it is not found."""
    return Cell(f"not found: {point.lost}") if point.lost else text_cell(_position(point.position))


def _link(model: MuscleModel, point: PointRow) -> Cell:
    return Cell(point.link) if point.lost else link_cell(model, point.link)


def _put(model: MuscleModel, index: int, text: str) -> None:
    """Move a point to a position given as text in [mm].

    The coordinates are separated by commas, spaces or semicolons. An unchanged coordinate keeps its
    full precision, which the text does not show.
    """
    before = model.points[index].position
    parts = text.split(";") if ";" in text else text.replace(",", " ").split()
    if len(parts) != 3:
        raise InputError(f"{text!r} must be x, y, z in mm.")
    x, y, z = (
        old if part.strip() == was else 0.001 * number(part)
        for part, was, old in zip(parts, _position(before).split(", "), before, strict=True)
    )
    if not all(map(math.isfinite, (x, y, z))):
        raise InputError(f"{text!r} must be x, y, z in mm.")
    points.set_position(model, index, (x, y, z))


TABLES = {
    "points": Rows(
        lambda model: model.points,
        (
            Column(lambda _, point: Cell(str(point.number))),
            Column(_link, points.set_link),
            Column(_place, _put),
        ),
    ),
    **properties.TABLES,
}


def show(model: MuscleModel, inputs: Inputs) -> None:
    """Show the chosen muscle."""
    names = [row.name for row in model.table.rows]
    inputs.choose("muscle", (*names, NEW_MUSCLE), model.muscle or NEW_MUSCLE)
    inputs.choose("link", (OF_PART, *model.links, WORLD), model.link or OF_PART)
    path = path_of(model.table, model.muscle)
    inputs.set("length", f"{len(model.points)} points, {path.length_text}")
    lost = sum(bool(point.lost) for point in (*model.table.points, *model.table.others))
    not_drawn = f" {lost} points that are not found are not drawn." if lost else ""
    inputs.set("preview", f"Lines behind bodies are paler.{not_drawn}")
    properties.show(model, inputs)
