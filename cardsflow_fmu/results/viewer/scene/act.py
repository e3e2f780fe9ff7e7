"""A stage with its title."""

from __future__ import annotations

from dataclasses import dataclass

from .stage import Stage


@dataclass(frozen=True)
class Act:
    """A stage with its title.

    Attributes:
        stage: The stage.
        title: Its title.
        notes: Lines below the title.
    """

    stage: Stage
    title: str
    notes: tuple[str, ...] = ()
