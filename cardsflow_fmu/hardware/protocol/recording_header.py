"""Header of a recording, and its conversion to JSON data."""

from __future__ import annotations

import datetime
import math
import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

import numpy as np

from cardsflow_fmu.version import __version__

_MAX_SIGNALS = 65535
_MIN_STEP = 1e-6
"""Minimum time step, in [s]; a replay computes every step."""


def _versions() -> dict[str, str]:
    return {
        "cardsflow": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
    }


@dataclass(frozen=True, slots=True)
class RecordingHeader:
    """Header of a recording.

    Attributes:
        command_names: Names of the commands, such as `f.biceps`.
        state_names: Names of the states, such as `q.elbow`.
        signature: Hash of the signals, 64 bits.
        step: Time step of the run, in [s].
        scale: Scale of the values in frames.
        lockstep: Whether the run was in lockstep.
        start_state: State before the first exchange; empty if it is unknown.
        created: Time of creation, as ISO 8601.
        versions: Versions of CARDSFlow, Python and numpy.
    """

    command_names: tuple[str, ...]
    command_units: tuple[str, ...]
    state_names: tuple[str, ...]
    state_units: tuple[str, ...]
    signature: int
    step: float
    scale: float = 1.0
    lockstep: bool = False
    run_id: int = 0
    link: str = ""
    start_state: tuple[float, ...] = ()
    created: str = field(
        default_factory=lambda: datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    )
    versions: Mapping[str, str] = field(default_factory=_versions)

    @property
    def commands(self) -> int:
        """Number of commands."""
        return len(self.command_names)

    @property
    def states(self) -> int:
        """Number of states."""
        return len(self.state_names)


def header_data(header: RecordingHeader) -> dict[str, Any]:
    """Return the header as JSON data.

    The signature is text, since some JSON readers do not preserve integers of 64 bits.
    """
    return {**asdict(header), "signature": f"{header.signature:016x}"}


def header_of(data: dict[str, Any]) -> RecordingHeader:
    """Return the header of JSON data.

    Raises:
        ValueError, TypeError, KeyError: The data is not a valid header.
    """
    values = {item.name: data[item.name] for item in fields(RecordingHeader)}
    for name in ("command_names", "command_units", "state_names", "state_units"):
        values[name] = tuple(values[name])
        if not all(isinstance(text, str) for text in values[name]):
            raise ValueError(f"{name} must be strings")
    values["signature"] = int(values["signature"], 16)
    values["start_state"] = tuple(map(float, values["start_state"]))
    header = RecordingHeader(**values)
    if not _MIN_STEP <= header.step < math.inf or not 0 < header.scale < math.inf:
        raise ValueError(f"step must be at least {_MIN_STEP:g} s, and scale must be positive")
    names = (header.command_names, header.state_names)
    units = (header.command_units, header.state_units)
    if [len(row) for row in names] != [len(row) for row in units]:
        raise ValueError("the numbers of names and units must be equal")
    if not 0 < header.commands <= _MAX_SIGNALS or not 0 < header.states <= _MAX_SIGNALS:
        raise ValueError(f"there must be 1 to {_MAX_SIGNALS} commands and states")
    if len(header.start_state) not in (0, header.states):
        raise ValueError(f"start_state must have {header.states} numbers")
    return header
