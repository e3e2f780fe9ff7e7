"""The four modes of a run: `run.compute` and `run.coupling`."""

from __future__ import annotations

from typing import Any

RUN_MODES: dict[str, dict[str, Any]] = {
    "fmu": {"compute": "c", "coupling": "fmu"},
    "python": {"compute": "python", "coupling": "fmu"},
    "native": {"compute": "c", "coupling": "direct"},
    "direct": {"compute": "python", "coupling": "direct"},
}
COMPUTE: dict[bool, Any] = {True: "c", False: "python"}
"""Value of `run.compute`, by whether FMUs are native."""
