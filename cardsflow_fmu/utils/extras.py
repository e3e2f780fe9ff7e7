"""Optional packages: how to install what is missing."""

from __future__ import annotations

from pathlib import Path

_CLONE = Path(__file__).parents[2]


def install(extra: str) -> str:
    """The command that installs an extra, in a clone of the repository or elsewhere."""
    if (_CLONE / "pyproject.toml").is_file():
        return f"uv sync --extra {extra}"
    return f"pip install 'cardsflow[{extra}]'"
