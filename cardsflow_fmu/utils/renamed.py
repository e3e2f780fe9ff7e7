"""What has another name now: arguments, flags and keys, refused with a line that says which."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from addin_sdfusion.robot import InputError

P = ParamSpec("P")
R = TypeVar("R")


def refuse_arguments(**instead: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Refuse old arguments of a function with an InputError.

    Args:
        instead: What to do instead, by the name of the old argument.
    """

    def decorated(function: Callable[P, R]) -> Callable[P, R]:
        @functools.wraps(function)
        def called(*args: P.args, **options: P.kwargs) -> R:
            for name in instead.keys() & options.keys():
                raise InputError(f"is no longer an argument: {instead[name]}", key=name)
            return function(*args, **options)

        return called

    return decorated
