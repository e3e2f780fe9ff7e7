"""Tables with the settings of single links and joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ...settings import ExportSettings, JointSettings, LinkSettings
from ..dialogs import Cell, number
from ..inputs import CellEdit
from .dialog import AS_ALL, COLLISIONS

_COLLISION, _NAME = 1, 3
_OF_JOINTS = ("effort", "damping", "friction", "velocity")
_DIRECTIONS = ("As designed", "Reversed")


def link_rows(settings: ExportSettings, links: Sequence[str]) -> list[tuple[Cell, ...]]:
    """Return a table row for each link."""
    chosen = {each.link: each for each in settings.of_links}
    words = {collision: word for word, collision in COLLISIONS.items()}
    rows: list[tuple[Cell, ...]] = []
    for name in links:
        link = chosen.get(name, LinkSettings(name))
        collision = AS_ALL if link.collision is None else words[link.collision]
        cells = Cell(collision, (AS_ALL, *COLLISIONS)), _cell(link.mass)
        rows.append((Cell(name), *cells, Cell(link.name, editable=True)))
    return rows


def joint_rows(settings: ExportSettings, joints: Sequence[str]) -> list[tuple[Cell, ...]]:
    """Return a table row for each coordinate of a joint."""
    by_joint = {each.joint: each for each in settings.of_joints}
    rows: list[tuple[Cell, ...]] = []
    for name in joints:
        joint = by_joint.get(name, JointSettings(name))
        direction = Cell(_DIRECTIONS[joint.reversed], _DIRECTIONS)
        numbers = (_cell(getattr(joint, quantity)) for quantity in _OF_JOINTS)
        rows.append((Cell(name), *numbers, direction))
    return rows


def apply_edit(
    settings: ExportSettings, edit: CellEdit, links: Sequence[str], joints: Sequence[str]
) -> ExportSettings:
    """Return the settings after an edit of one of the tables."""
    if edit.table == "of_links":
        change: dict[str, Any] = {"collision": COLLISIONS.get(edit.value)}
        if edit.column == _NAME:
            change = {"name": edit.value.strip()}
        elif edit.column != _COLLISION:
            change = {"mass": _number(edit.value)}
        by_link = {each.link: each for each in settings.of_links}
        name = links[edit.row]
        by_link[name] = replace(by_link.get(name, LinkSettings(name)), **change)
        of_links = tuple(by_link[n] for n in sorted(by_link) if by_link[n] != LinkSettings(n))
        return replace(settings, of_links=of_links)
    if edit.column > len(_OF_JOINTS):
        change = {"reversed": edit.value == _DIRECTIONS[1]}
    else:
        change = {_OF_JOINTS[edit.column - 1]: _number(edit.value)}
    by_joint = {each.joint: each for each in settings.of_joints}
    name = joints[edit.row]
    by_joint[name] = replace(by_joint.get(name, JointSettings(name)), **change)
    of_joints = tuple(by_joint[n] for n in sorted(by_joint) if by_joint[n] != JointSettings(n))
    return replace(settings, of_joints=of_joints)


def _cell(value: float | None) -> Cell:
    return Cell("" if value is None else f"{value:g}", editable=True)


def _number(text: str) -> float | None:
    return number(text) if text.strip() else None
