"""Custom classes, in Python files that lie beside what names them."""

from __future__ import annotations

import importlib.util
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from .errors import CardsflowError, InputError, UnknownNameError

T = TypeVar("T")


def load_class(file: Path, name: str, base: type) -> type[Any]:
    """Return a class from a file, which is run.

    Args:
        file: The file.
        name: The class.
        base: What it must be a subclass of.

    Raises:
        InputError: The file cannot be run, or the class is another one.
        UnknownNameError: It has no such class.
    """
    module = f"_own_{file.stem}"
    spec = importlib.util.spec_from_file_location(module, file.absolute())
    if spec is None or spec.loader is None:
        raise InputError("is not a Python file", file=file)
    made = importlib.util.module_from_spec(spec)
    sys.modules[module] = made  # dataclasses look there
    loader = spec.loader
    call_custom(file, lambda: loader.exec_module(made))
    found = getattr(made, name, None)
    if not isinstance(found, type):
        raise UnknownNameError("class", name, [], file=file)
    if not issubclass(found, base):
        raise WrongBaseClassError(found, base, file)
    return found


class WrongBaseClassError(InputError):
    """A custom class that is none of what it must be.

    Attributes:
        found: The class.
    """

    def __init__(self, found: type, base: type, file: Path) -> None:
        package = base.__module__.partition(".")[0]
        super().__init__(
            f"{found.__name__} is not a subclass of {package}.{base.__name__}", file=file
        )
        self.found = found


def call_custom(file: Path, call: Callable[[], T]) -> T:
    """What a call into the file gives; its errors with the line that made them.

    Raises:
        InputError: The call failed.
    """
    try:
        return call()
    except CardsflowError:
        raise
    except Exception as error:
        own = str(file.absolute())
        rows = [r for r in traceback.extract_tb(error.__traceback__) if r.filename == own]
        line = rows[-1].lineno if rows else getattr(error, "lineno", None)
        what = " ".join(f"{type(error).__name__}: {error}".split())
        raise InputError(what, file=file, line=line) from error
