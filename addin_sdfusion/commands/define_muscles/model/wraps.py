"""Edits of wrap surfaces and of the muscles that wrap over them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ....muscles.rows import WrapRow, change_uses, free_name
from ....robot.errors import InputError
from ....snapshot import WrapUse
from .model import MuscleModel
from .picks import Pick, picked_link


def pick_surface(model: MuscleModel, pick: Pick) -> None:
    """Add a wrap surface, or choose an existing one."""
    wraps = model.table.wraps
    existing = next((wrap for wrap in wraps if wrap.face.entity == pick.entity), None)
    if existing is not None:
        model.wrap = existing.name
        raise InputError(f"This face is already wrap surface {model.wrap}.")
    link, face = picked_link(model, pick), pick.face
    if face is None:
        return
    names = [f"{link}_{face.shape}{n or ''}" for n in range(len(wraps) + 1)]
    model.wrap = free_name(names, wraps)
    row = WrapRow(model.wrap, link, occurrence=pick.occurrence, face=face)
    model.table = replace(model.table, wraps=(*wraps, row))
    size = f"a {face.shape} of radius {1000 * face.radius:.4g} mm"
    model.message = f"Wrap surface {model.wrap} is {size} on link {link}."


def change_wrap(model: MuscleModel, **changes: Any) -> None:
    """Change properties of the chosen wrap surface."""
    model.table = model.table.change_wrap(model.wrap, lambda wrap: replace(wrap, **changes))


def rename_wrap(model: MuscleModel, name: str) -> None:
    """Rename the chosen wrap surface; reject an empty or existing name."""
    name = name.strip()
    if name == model.wrap:
        return
    if not name or any(wrap.name == name for wrap in model.table.wraps):
        raise InputError(f"Wrap surface {name!r} exists already; choose another name.")
    change_wrap(model, name=name)
    model.wrap = name


def delete_wrap(model: MuscleModel) -> None:
    """Delete the chosen wrap surface."""
    model.table = model.table.change_wrap(model.wrap, lambda wrap: None)
    model.wrap = model.table.wraps[0].name if model.table.wraps else ""


def add_use(model: MuscleModel) -> None:
    """Add the chosen muscle to the wrap surface, after its first point."""
    points, wrap = model.points, model.wrap_row
    if wrap is None or len(points) < 2:
        text = "Pick a face, and choose a muscle with two points on the first tab."
        raise InputError(text)
    change_wrap(model, muscles=(*wrap.muscles, WrapUse(model.muscle, points[0].number)))


def change_use(model: MuscleModel, index: int, **changes: Any) -> None:
    """Change properties of the wrap of one muscle."""
    _edit_use(model, index, lambda use: replace(use, **changes))


def delete_use(model: MuscleModel, index: int) -> None:
    """Remove a muscle from the wrap surface."""
    _edit_use(model, index, lambda use: None)


def _edit_use(model: MuscleModel, index: int, edit: Callable[[WrapUse], WrapUse | None]) -> None:
    model.table = model.table.change_wrap(
        model.wrap,
        lambda wrap: change_uses(wrap, lambda i, use: edit(use) if i == index else use),
    )
