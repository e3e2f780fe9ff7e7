"""Properties of the chosen muscle, on the tab of its points."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ....muscles.table import NAMED_COLORS
from ....robot.model.laws import MUSCLE_LAWS
from ....robot.model.laws.law import Parameter
from ....robot.model.muscle_laws import law_of
from ....snapshot import MuscleSnapshot
from ...dialogs import Cell, Input, number
from ..model import muscles
from ..model.model import MuscleModel
from .columns import Column, Rows, text_cell, with_chosen

if TYPE_CHECKING:
    from ...inputs import Inputs

MODELS = tuple(MUSCLE_LAWS)
"""Muscle laws that can be simulated; imported tables may contain others."""
_OTHER_COLOR = "Custom"

GROUP = Input(
    "properties",
    "group",
    "Properties",
    children=(
        Input("muscle_name", "string", "Name", "Name of the muscle in all files."),
        Input(
            "palette",
            "dropdown",
            "Colour",
            "Colour of the muscle in drawings and files.",
            options=(*NAMED_COLORS, _OTHER_COLOR),
        ),
        Input("color", "string", "As #rrggbb", "Custom colour."),
        Input(
            "f_min",
            "number",
            "Minimum force [N]",
            "Minimum force that a controller commands, which keeps the cable taut.",
            value=10.0,
        ),
        Input(
            "f_max",
            "number",
            "Maximum force [N]",
            "Maximum force that a controller commands: the limit of the motor.",
            value=80.0,
        ),
        Input(
            "model",
            "dropdown",
            "Muscle law",
            "Law that determines the tension: 'ideal' is the commanded force; the others compute "
            "the tension from the command and the length and speed of the muscle.",
            options=MODELS,
            value="ideal",
        ),
        Input(
            "parameters",
            "table",
            "Parameters",
            "Parameters of the muscle law; an empty value is the default next to the unit.",
            columns=("Parameter", "Value", "Unit, default, meaning"),
            widths=(4, 2, 5),
            rows=6,
        ),
        Input(
            "delete_muscle", "button", "Delete muscle", "Deletes the muscle and all of its points."
        ),
    ),
)


# Parameters of the muscle law: pairs of a muscle and the name of a parameter


def _parameters(model: MuscleModel) -> list[tuple[MuscleSnapshot, str]]:
    row = model.row
    return [] if row is None else [(row, name) for name in muscles.parameter_names(row)]


def _value(_: MuscleModel, item: tuple[MuscleSnapshot, str]) -> Cell:
    row, name = item
    return text_cell(f"{row.parameters[name]:g}" if name in row.parameters else "")


def _meaning(_: MuscleModel, item: tuple[MuscleSnapshot, str]) -> Cell:
    row, name = item
    by_name: dict[str, Parameter] = {p.name: p for p in law_of(row.cable_model).parameters}
    if name not in by_name:
        return Cell("unknown to this muscle law")
    p = by_name[name]
    default = "" if p.default is None else f", {p.default:g}"
    return Cell(f"{p.unit}{default}: {p.meaning}")


def _set_parameter(model: MuscleModel, index: int, text: str) -> None:
    row, name = _parameters(model)[index]
    parameters = {key: number for key, number in row.parameters.items() if key != name}
    if text.strip():
        parameters[name] = number(text)
    muscles.change(model, parameters=parameters)


TABLES = {
    "parameters": Rows(
        _parameters,
        (
            Column(lambda _, item: Cell(item[1])),
            Column(_value, _set_parameter),
            Column(_meaning),
        ),
    ),
}


def show(model: MuscleModel, inputs: Inputs) -> None:
    """Show the properties of the chosen muscle."""
    row = model.row
    if row is None:
        return
    inputs.set("muscle_name", row.name)
    palette = {color: name for name, color in NAMED_COLORS.items()}
    inputs.choose("palette", (*NAMED_COLORS, _OTHER_COLOR), palette.get(row.color, _OTHER_COLOR))
    inputs.set("color", row.color)
    inputs.set("f_min", row.f_min)
    inputs.set("f_max", min(row.f_max, 1e9))
    inputs.choose("model", with_chosen(MODELS, row.model), row.model)
