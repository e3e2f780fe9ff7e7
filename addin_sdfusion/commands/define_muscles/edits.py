"""Single edits of the design, with errors that name their object."""

from __future__ import annotations

import re
from typing import Any

from ...robot.errors import InputError


class About:
    """What fails within names the object that it failed for."""

    def __init__(self, what: str, why: str) -> None:
        self._what = what
        self._why = why

    def __enter__(self) -> None:
        pass

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        if isinstance(error, Exception):
            why = self._why or str(error) or type(error).__name__
            raise InputError(f"{self._what} cannot be written: {why}") from error


def is_called(point: Any, name: str) -> bool:
    """Whether the point has that name, or the one that Fusion makes of a name that is taken.

    Via points have names of their own; a link may have several task points and markers.
    """
    if name.startswith("VP_"):
        return bool(point.name == name)
    return re.fullmatch(re.escape(name) + r"(?: ?\([0-9]+\))?", point.name) is not None


def added(points: Any, new: Any) -> Any:
    """The construction point that Fusion makes of an input."""
    made = points.add(new)
    if made is None:
        raise InputError("Fusion refuses to make a construction point there")
    return native(made)


def native(entity: Any) -> Any:
    """The entity itself, for a proxy: attributes and names belong to it."""
    return None if entity is None else entity.nativeObject or entity
