"""Old names of arguments and options, with their new names for the error message."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

RENAMED_OPTIONS = {
    "calibrate": {"--free": "--parameters"},
    "compare": {"--tol": "--atol"},
    "device": {
        "--differences": "--differentiate-positions",
        "--encoder": "--encoder-counts",
        "--motor-lag": "--motor-time-constant",
    },
    "excite": {"--free": "--parameters"},
    "import-cad": {"FOLDER": "-o FOLDER"},
    "plot": {"--what": "--panels"},
}
"""New option by command and old option; a positional argument is its metavar."""

REMOVED_OPTIONS = {
    "build": dict.fromkeys(("--native", "--python"), "use --compute c or --compute python"),
    "run": dict.fromkeys(
        ("--direct", "--native", "--python"),
        "use --compute c or python, and --coupling fmu or direct",
    ),
}
"""Replacement text by command and removed option."""


def renamed_option(command: str, option: str) -> str | None:
    """Return the message for an old option of a command, or None if the option is not an old one.

    Args:
        command: The words after `cardsflow`, such as `import-cad`.
        option: The option, such as `--free`, or the metavar of a positional argument.
    """
    if new := RENAMED_OPTIONS.get(command, {}).get(option):
        return f"{option} was renamed to {new}"
    if instead := REMOVED_OPTIONS.get(command, {}).get(option):
        return f"{option} is no longer an option; {instead}"
    return None


def reject_arguments(**instead: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator that rejects removed arguments of a function with an InputError.

    Args:
        instead: Replacement text, by the name of the removed argument.
    """

    def decorated(function: Callable[P, R]) -> Callable[P, R]:
        @functools.wraps(function)
        def called(*args: P.args, **options: P.kwargs) -> R:
            for name in instead.keys() & options.keys():
                from addin_sdfusion.robot import InputError

                raise InputError(f"is no longer an argument: {instead[name]}", key=name)
            return function(*args, **options)

        return called

    return decorated
