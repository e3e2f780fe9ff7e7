"""Tab with the wrap surfaces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from ....robot.model.robot import WORLD
from ....snapshot import WrapUse
from ...dialogs import Cell, Input
from ..model import wraps
from ..model.model import MuscleModel
from .columns import Column, Rows, with_chosen

if TYPE_CHECKING:
    from ...inputs import Inputs

SIDES: dict[str, Literal[-1, 0, 1]] = {"Shorter path": 0, "Turning +": 1, "Turning -": -1}
INSIDE = "Inside"
"""Additional side: the muscle passes through the inside of the surface."""
NO_SURFACE = "(none yet)"

TAB = Input(
    "tab_wraps",
    "tab",
    "Wrap surfaces",
    children=(
        Input(
            "wrap_pick",
            "selection",
            "Faces",
            "Click cylinders and spheres that muscles wrap over.",
            filters=("CylindricalFaces", "SphericalFaces"),
            prompt="Pick a cylinder or sphere",
        ),
        Input("wrap", "dropdown", "Surface", "The surface shown below.", options=(NO_SURFACE,)),
        Input("wrap_name", "string", "Name", "Name of the surface in all files."),
        Input("wrap_link", "dropdown", "Link", "The link that the surface is fixed to."),
        Input(
            "wrap_uses",
            "table",
            "Muscles",
            "Muscles that wrap over this surface, and the point before the surface.",
            columns=("Muscle", "After point", "Side", "Turns"),
            widths=(3, 2, 3, 2),
            rows=6,
            children=(
                Input("use_add", "button", "Add", "Adds the muscle of the first tab."),
                Input("use_delete", "button", "Delete", "Removes the selected muscle."),
            ),
        ),
        Input(
            "wrap_delete", "button", "Delete surface", "Deletes the wrap surface but not the face."
        ),
    ),
)


def _uses(model: MuscleModel) -> tuple[WrapUse, ...]:
    return () if model.wrap_row is None else model.wrap_row.muscles


def _muscle(model: MuscleModel, use: WrapUse) -> Cell:
    names = tuple(row.name for row in model.table.rows)
    return Cell(use.muscle, with_chosen(names, use.muscle))


def _side(_: MuscleModel, use: WrapUse) -> Cell:
    text = next(text for text, number in SIDES.items() if number == use.side)
    return Cell(INSIDE if use.inside else text, (*SIDES, INSIDE))


def _set_side(model: MuscleModel, index: int, text: str) -> None:
    if text == INSIDE:
        wraps.change_use(model, index, side=0, inside=True, turns=0)
    else:
        wraps.change_use(model, index, side=SIDES[text], inside=False)


TABLES = {
    "wrap_uses": Rows(
        _uses,
        (
            Column(_muscle, lambda m, i, value: wraps.change_use(m, i, muscle=value)),
            Column(
                lambda _, use: Cell(use.after),
                lambda m, i, value: wraps.change_use(m, i, after=int(value)),
            ),
            Column(_side, _set_side),
            Column(
                lambda _, use: Cell(use.turns),
                lambda m, i, value: wraps.change_use(m, i, turns=int(value)),
            ),
        ),
    ),
}


def show(model: MuscleModel, inputs: Inputs) -> None:
    """Show the chosen wrap surface."""
    names = [wrap.name for wrap in model.table.wraps]
    inputs.choose("wrap", names or (NO_SURFACE,), model.wrap or NO_SURFACE)
    row = model.wrap_row
    if row is not None:
        inputs.set("wrap_name", row.name)
        inputs.choose("wrap_link", with_chosen((*model.links, WORLD), row.link), row.link)
