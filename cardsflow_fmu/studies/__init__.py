"""Studies: many runs of one experiment, varied; optimisation; what the runs tell together."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .errors import StudyError as StudyError
    from .execution import StudyResult as StudyResult
    from .execution import run_study as run_study
    from .study import Study as Study

_HOMES = {
    "Study": "study",
    "StudyError": "errors",
    "StudyResult": "execution",
    "run_study": "execution",
}

__all__ = ["Study", "StudyError", "StudyResult", "run_study"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
