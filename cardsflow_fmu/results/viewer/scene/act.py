"""Stage with a title and notes."""

from __future__ import annotations

from dataclasses import dataclass

from .stage import Stage


@dataclass(frozen=True)
class Act:
    """Stage with a title and notes.

    Attributes:
        stage: The stage.
        title: Title of the stage.
        notes: Lines below the title.
    """

    stage: Stage
    title: str
    notes: tuple[str, ...] = ()
