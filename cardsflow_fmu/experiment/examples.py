"""Folder of the examples."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

EXAMPLES_DATA = "examples_data"
"""Folder of the examples in the package; hatch_build.py creates it in a wheel."""


def examples_folder() -> Path:
    """Return the folder of the examples: in the package, or in a clone of the repository."""
    package = Path(str(files("cardsflow_fmu")))
    data = package / EXAMPLES_DATA
    return data if data.is_dir() else package.parent / "examples"
