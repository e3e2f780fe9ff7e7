"""Attributes of a design as the records of its snapshot, with findings on the way."""

from __future__ import annotations

from collections.abc import Mapping

from ..robot.errors import InputError
from ..robot.finding import Finding
from ..snapshot import MuscleSnapshot, PointUse, SurfaceUse
from .attributes import MUSCLES, POINT, WRAP, read_muscles, read_point, read_wrap
from .checks import finding


def stored_point(
    attributes: Mapping[str, str], name: str, findings: list[Finding]
) -> PointUse | None:
    """What a construction point is; None where nothing is stored, or it cannot be read.

    Args:
        attributes: The point's in the add-in's group.
        name: The point's.
        findings: Takes what is wrong.
    """
    text = attributes.get(POINT)
    if text is None:
        return None
    try:
        return read_point(text)
    except InputError as error:
        message = f"what is stored on the construction point {name!r} cannot be read"
        message += f" ({error}); pick it again in Define muscles"
        _note(findings, message, "point", name)
    return None


def stored_surface(
    attributes: Mapping[str, str], where: str, findings: list[Finding]
) -> SurfaceUse | None:
    """What a face is; None where nothing is stored, or it cannot be read.

    Args:
        attributes: The face's in the add-in's group.
        where: The occurrence, or the design.
        findings: Takes what is wrong.
    """
    text = attributes.get(WRAP)
    if text is None:
        return None
    try:
        return read_wrap(text)
    except InputError as error:
        message = f"what is stored on a wrap face of {where!r} cannot be read ({error}); "
        message += "pick the face again in Define muscles"
        _note(findings, message, "occurrence", where)
    return None


def stored_muscles(
    attributes: Mapping[str, str], design: str, findings: list[Finding]
) -> tuple[MuscleSnapshot, ...]:
    """The muscles that a design lists; none where that cannot be read.

    Args:
        attributes: The design's in the add-in's group.
        design: Its name.
        findings: Takes what is wrong.
    """
    try:
        return read_muscles(attributes.get(MUSCLES, "[]"))
    except InputError as error:
        message = f"the design's list of muscles cannot be read ({error}); open Define muscles, "
        message += "set the force limits and press OK"
        _note(findings, message, "design", design)
    return ()


def _note(findings: list[Finding], message: str, kind: str, name: str) -> None:
    new = finding("error", "bad-attribute", message, kind, name)
    if new not in findings:  # the same point in several places
        findings.append(new)
