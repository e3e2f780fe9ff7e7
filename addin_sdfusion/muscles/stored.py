"""Reader for the attributes of a design, with findings on attributes that cannot be read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

from ..robot.errors import InputError
from ..robot.finding import Finding
from ..snapshot import MuscleSnapshot, PointUse, SurfaceUse
from .attributes import (
    MUSCLES,
    POINT,
    WRAP,
    read_list,
    read_muscle,
    read_point,
    read_wrap,
)
from .checks import finding

Record = TypeVar("Record")


def stored_point(
    attributes: Mapping[str, str], name: str, findings: list[Finding]
) -> PointUse | None:
    """Return the stored use of a construction point; None if it is missing or cannot be read.

    Args:
        attributes: Attributes of the point in the group of the add-in.
        findings: List to which findings are appended.
    """
    label = f"the attribute of construction point {name!r}"
    todo = "pick it again in Define muscles"
    return _read_attribute(read_point, attributes, POINT, (label, todo), ("point", name), findings)


def stored_surface(
    attributes: Mapping[str, str], where: str, findings: list[Finding]
) -> SurfaceUse | None:
    """Return the stored use of a face; None if it is missing or cannot be read."""
    label = f"the attribute of a wrap face of {where!r}"
    todo = "pick the face again in Define muscles"
    return _read_attribute(
        read_wrap, attributes, WRAP, (label, todo), ("occurrence", where), findings
    )


def stored_muscles(
    attributes: Mapping[str, str], design: str, findings: list[Finding]
) -> tuple[MuscleSnapshot, ...]:
    """Return the muscles that are listed in a design; empty if the list cannot be read."""
    if MUSCLES not in attributes:
        return ()
    muscles = []
    try:
        for i, plain in enumerate(read_list(attributes[MUSCLES], MUSCLES)):
            try:
                muscles.append(read_muscle(plain, f"{MUSCLES}[{i}]"))
            except InputError as error:
                findings.append(_bad_muscles(error, design))
    except InputError as error:
        findings.append(_bad_muscles(error, design))
    return tuple(muscles)


def _bad_muscles(error: InputError, design: str) -> Finding:
    message = (
        f"the design's list of muscles cannot be read ({error}); set the force limits in Define "
        "muscles, which keeps the stored text"
    )
    return finding("error", "bad-attribute", message, "design", design)


def _read_attribute(
    read: Callable[[str], Record],
    attributes: Mapping[str, str],
    key: str,
    text: tuple[str, str],
    subject: tuple[str, str],
    findings: list[Finding],
) -> Record | None:
    """Return the value of an attribute; None with a finding if it cannot be read."""
    if key not in attributes:
        return None
    try:
        return read(attributes[key])
    except InputError as error:
        label, todo = text
        message = f"{label} cannot be read ({error}); {todo}"
        new = finding("error", "bad-attribute", message, *subject)
        if new not in findings:  # all occurrences of a component have the same points
            findings.append(new)
    return None
