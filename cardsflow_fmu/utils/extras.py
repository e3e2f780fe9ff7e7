"""Optional packages: how to install what is missing."""

from __future__ import annotations

import importlib
from pathlib import Path

from addin_sdfusion.robot import InputError

_CLONE = Path(__file__).parents[2]


def install(extra: str) -> str:
    """Return the command that installs an extra, in a clone of the repository or elsewhere."""
    if (_CLONE / "pyproject.toml").is_file():
        return f"uv sync --extra {extra}"
    return f"pip install 'cardsflow[{extra}]'"


def require(what: str, extra: str, *modules: str, key: str | None = None) -> None:
    """Reject early what needs an extra.

    Args:
        what: What needs it, in the plural.
        extra: The extra.
        modules: Of its packages, each with the package's name first.
        key: The option or setting that asks for it.

    Raises:
        InputError: One of them is missing.
    """
    for module in modules:
        try:
            importlib.import_module(module)
        except ImportError:
            package = module.partition(".")[0]
            raise InputError(f"{what} need {package}: {install(extra)}", key=key) from None
