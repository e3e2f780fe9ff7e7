"""Points and faces that the user clicked."""

from __future__ import annotations

from dataclasses import dataclass

from ....robot.errors import InputError
from ....robot.model.pose import Vector3
from ....snapshot import SurfaceSnapshot
from .model import MuscleModel

HANDLE = "pick:"
"""Prefix of the handles of picked entities that are not construction points."""


@dataclass(frozen=True, slots=True)
class Pick:
    """Point or face that the user clicked.

    Attributes:
        position: Position in the root frame, in [m].
        occurrence: Path of the clicked occurrence.
        entity: Key of the clicked construction point, or handle of another entity; empty for a
            position without an entity, such as a position on a flat face.
        label: Name for messages.
        problem: Reason why it cannot be used, or an empty string.
        face: The cylinder or sphere, if a surface was picked.
    """

    position: Vector3
    occurrence: str
    entity: str
    label: str
    problem: str = ""
    face: SurfaceSnapshot | None = None


def picked_link(model: MuscleModel, pick: Pick) -> str:
    """Return the link of a picked point or face.

    Raises:
        InputError: The pick cannot be used or does not belong to a link.
    """
    if pick.problem:
        raise InputError(pick.problem)
    link = model.link or model.link_of.get(pick.occurrence, "")
    if not link:
        raise InputError(
            f"{pick.label} does not belong to a link: add it to a rigid group EXPORT_<link>, or "
            "choose a link in the drop-down and pick again."
        )
    return link
