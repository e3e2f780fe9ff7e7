"""FMUs, co-simulation, experiments, results and the command line.

The names below are imported on first use, so that a command only loads the modules it needs.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .version import __version__

if TYPE_CHECKING:
    from .experiment.experiment import Experiment as Experiment
    from .results.analysis.drive_check import check as check
    from .simulation.build import build as build
    from .simulation.result import Result as Result
    from .simulation.run import run as run
    from .simulation.run import run_system as run_system

_MODULES = {
    "Experiment": "experiment.experiment",
    "build": "simulation.build",
    "check": "results.analysis.drive_check",
    "run": "simulation.run",
    "run_system": "simulation.run",
    "Result": "simulation.result",
}

__all__ = ["Experiment", "Result", "__version__", "build", "check", "run", "run_system"]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)
