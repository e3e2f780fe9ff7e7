"""Attributes of wrap faces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ....muscles.attributes import GROUP, WRAP, read_wrap, wrap_text
from ....muscles.rows import WrapRow
from ....robot.errors import InputError
from ..entities import Entities
from ..model.model import MuscleModel
from ..picks import problem_of
from .construction_points import ErrorContext, set_attribute
from .homes import Homes


def write_faces(model: MuscleModel, entities: Entities, homes: Homes) -> None:
    """Write the attributes of all wrap faces."""
    before, after = model.before, model.table
    remaining = {wrap.face.entity for wrap in after.wraps}
    for wrap in before.wraps:
        face = entities.faces.get(wrap.face.entity)
        if wrap.face.entity not in remaining and face is not None:
            with ErrorContext(f"wrap surface {wrap.name!r}", _problem(wrap, homes)):
                attribute = face.attributes.itemByName(GROUP, WRAP)
                if attribute:
                    attribute.deleteMe()
    for wrap in after.wraps:
        reason = _problem(wrap, homes)
        face = entities.faces.get(wrap.face.entity)
        if wrap.lost or (reason and wrap in before.wraps):  # not found, or of another document
            if wrap not in before.wraps and face is not None:
                _update_lost(wrap, face)
            continue
        if face is None:
            problem = reason or "its face does not exist any more; pick it again"
            raise InputError(f"wrap surface {wrap.name!r}: {problem}")
        text = wrap_text(homes.surface_use(wrap))
        set_attribute(face, WRAP, text, f"wrap surface {wrap.name!r}", reason)


def _problem(wrap: WrapRow, homes: Homes) -> str:
    return problem_of(None, homes.occurrences.get(wrap.occurrence))


def _update_lost(wrap: WrapRow, face: Any) -> None:
    """Store name and muscles of a lost surface, whose record is otherwise unchanged."""
    with ErrorContext(f"wrap surface {wrap.name!r}", ""):
        stored = read_wrap(face.attributes.itemByName(GROUP, WRAP).value)
        use = replace(stored, name=wrap.name, muscles=wrap.muscles)
        face.attributes.add(GROUP, WRAP, wrap_text(use))
