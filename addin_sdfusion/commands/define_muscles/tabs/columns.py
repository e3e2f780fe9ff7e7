"""Columns of the tables of the dialog."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ....robot.model.robot import WORLD
from ...dialogs import Cell
from ..model.model import MuscleModel


@dataclass(frozen=True)
class Column:
    """Column of a table.

    Attributes:
        shown: Function that returns the cell of an item.
        edited: Handler of an edited cell; None for a read-only column.
    """

    shown: Callable[[MuscleModel, Any], Cell]
    edited: Callable[[MuscleModel, int, Any], None] | None = None


@dataclass(frozen=True)
class Rows:
    """Table with one row per item."""

    items: Callable[[MuscleModel], Sequence[Any]]
    columns: tuple[Column, ...]

    def cells(self, model: MuscleModel) -> list[list[Cell]]:
        """Return the cells of the table."""
        return [
            [column.shown(model, item) for column in self.columns] for item in self.items(model)
        ]


def with_chosen(options: tuple[str, ...], chosen: str) -> tuple[str, ...]:
    """Return the options, including the current choice."""
    return options if chosen in options else (*options, chosen)


def text_cell(text: str) -> Cell:
    """Return a cell with a text that the user may edit."""
    return Cell(text, editable=True)


def link_cell(model: MuscleModel, link: str) -> Cell:
    """Return a cell with a drop-down of all links."""
    return Cell(link, with_chosen((*model.links, WORLD), link))
