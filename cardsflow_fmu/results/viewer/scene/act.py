"""Stage with a title and notes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from cardsflow_fmu.utils.arrays import FloatArray

from .stage import Stage


@dataclass(frozen=True)
class Act:
    """Stage with a title and notes.

    Attributes:
        notes: Lines below the title.
        signals: Recorded signals at the frames of the stage, shape (K,), by name.
        events: Time, in [s], and text of faults and decisions.
    """

    stage: Stage
    title: str
    notes: tuple[str, ...] = ()
    signals: Mapping[str, FloatArray] = field(default_factory=dict)
    events: tuple[tuple[float, str], ...] = ()
