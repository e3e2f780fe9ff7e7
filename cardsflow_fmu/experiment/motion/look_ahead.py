"""Speeds at which a robot can continue its reference after the loss of a muscle."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.config.file import read_settings
from cardsflow_fmu.experiment.config.table import Context, Listed, Table, setting

LOOK_AHEAD_FILE = "look_ahead.json"
"""Name of the file with the table in FMUs."""
POSE, FALL = 0.0, -1.0
"""Speeds of a motion of which only a pose can be held, or not even a pose."""


class LookAhead(Table):
    """Table of relative speeds of the reference."""

    times: Annotated[tuple[float, ...], Listed] = setting("times of the reference, in s")
    speeds: dict[str, Annotated[tuple[float, ...], Listed]] = setting(
        "for each muscle, the speed with which the other muscles can produce the motion from each "
        "time on, relative to its nominal speed; 0 or -1 if they cannot"
    )


def read_look_ahead(file: Path, muscles: Sequence[str]) -> LookAhead | None:
    """Return the table in a file; None if the file does not exist.

    Raises:
        InputError: The table is invalid, or does not contain all of the muscles.
    """
    if not file.is_file():
        return None
    table = LookAhead.read(read_settings(file), Context(file))
    for name in muscles:
        if len(table.speeds.get(name, ())) != len(table.times):
            problem = f"must have one number for each of the {len(table.times)} times"
            raise InputError(problem, file=file, key=f"speeds.{name}")
    return table
