"""Runs of .ssp files whose files are not kept."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cardsflow_fmu.simulation.result import SystemResult
from cardsflow_fmu.simulation.run import run_system
from cardsflow_fmu.utils.temporary import temporary_folder


def simulate_system(path: str | Path, settings: Mapping[str, Any] | None = None) -> SystemResult:
    """Return the result of a run."""
    with temporary_folder() as folder:
        return run_system(path, folder / "results", settings)
