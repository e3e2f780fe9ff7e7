"""The four ways of a run: who computes, and how the models are coupled."""

from __future__ import annotations

from typing import Any

WAYS: dict[str, dict[str, Any]] = {
    "fmu": {"compute": "c", "coupling": "fmu"},
    "python": {"compute": "python", "coupling": "fmu"},
    "native": {"compute": "c", "coupling": "direct"},
    "direct": {"compute": "python", "coupling": "direct"},
}
COMPUTE: dict[bool, Any] = {True: "c", False: "python"}
"""Who computes, by whether FMUs are native."""
