"""Studies: many runs of an experiment with variations, optimisation and statistics."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .definition.errors import StudyError as StudyError
    from .definition.study import Study as Study
    from .run import StudyResult as StudyResult
    from .run import run_study as run_study

_MODULES = {
    "Study": "definition.study",
    "StudyError": "definition.errors",
    "StudyResult": "run",
    "run_study": "run",
}

__all__ = ["Study", "StudyError", "StudyResult", "run_study"]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)
