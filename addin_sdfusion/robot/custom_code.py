"""Custom classes from Python files next to the file that refers to them."""

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
    """Execute a Python file and return one of its classes.

    Raises:
        InputError: The file cannot be executed, or the class is not a subclass of `base`.
        UnknownNameError: The class does not exist in the file.
    """
    if not file.is_file():
        raise InputError("does not exist", file=file)
    module = f"_own_{file.stem}"
    spec = importlib.util.spec_from_file_location(module, file.absolute())
    if spec is None or spec.loader is None:
        raise InputError("is not a Python file", file=file)
    loaded = importlib.util.module_from_spec(spec)
    sys.modules[module] = loaded  # dataclasses search for the module there
    loader = spec.loader
    call_custom(file, lambda: loader.exec_module(loaded))
    loaded_class = getattr(loaded, name, None)
    if not isinstance(loaded_class, type):
        raise UnknownNameError("class", name, [], file=file)
    if not issubclass(loaded_class, base):
        raise WrongBaseClassError(loaded_class, base, file)
    return loaded_class


class WrongBaseClassError(InputError):
    """A custom class that is not a subclass of the required base class."""

    def __init__(self, loaded_class: type, base: type, file: Path) -> None:
        package = base.__module__.partition(".")[0]
        super().__init__(
            f"{loaded_class.__name__} is not a subclass of {package}.{base.__name__}", file=file
        )
        self.loaded = loaded_class


def call_custom(file: Path, call: Callable[[], T]) -> T:
    """Call a function of a custom file; errors report the line in that file.

    Raises:
        InputError: The call failed.
    """
    try:
        return call()
    except CardsflowError:
        raise
    except Exception as error:
        filename = str(file.absolute())
        rows = [r for r in traceback.extract_tb(error.__traceback__) if r.filename == filename]
        line = rows[-1].lineno if rows else getattr(error, "lineno", None)
        problem = " ".join(f"{type(error).__name__}: {error}".split())
        raise InputError(problem, file=file, line=line) from error
