"""Check of optional packages, with the command that installs missing ones."""

from __future__ import annotations

import importlib
from pathlib import Path

from addin_sdfusion.robot import InputError

_CLONE = Path(__file__).parents[2]


def install(extra: str) -> str:
    """Return the command that installs an extra, with uv in a clone and with pip elsewhere."""
    if (_CLONE / "pyproject.toml").is_file():
        return f"uv sync --extra {extra}"
    return f"pip install 'cardsflow[{extra}]'"


def require(feature: str, extra: str, *modules: str, key: str | None = None) -> None:
    """Require the packages of an extra.

    Args:
        feature: Feature that needs the extra, in the plural, for the message.
        modules: Modules to import; their top-level package is named in the message.
        key: Option or setting that uses the feature.
    """
    for module in modules:
        try:
            importlib.import_module(module)
        except ImportError:
            package = module.partition(".")[0]
            raise InputError(f"{feature} need {package}: {install(extra)}", key=key) from None
