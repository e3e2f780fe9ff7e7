"""File `resources/model.json`: Python class of an FMU's model, and versions at build time."""

from __future__ import annotations

import functools
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.files import read_file
from addin_sdfusion.robot.json_text import json_text

from .carried_module import import_module
from .model import FmuModel

MODEL_FILE = "model.json"
NATIVE_FILE = "native.bin"
_FORMAT = 1


class NativeModel(NamedTuple):
    """File of a native FMU's model.

    Attributes:
        contents: Contents of `resources/native.bin`.
        has_derivatives: Whether it has directional derivatives.
        has_internal_steps: Whether communication steps may end after any internal step.
    """

    contents: bytes
    has_derivatives: bool = False
    has_internal_steps: bool = False


@dataclass(frozen=True, slots=True)
class ModelFile:
    """Record of an FMU's model.

    Attributes:
        package: Version of the package that built the FMU.
        model_class: Import path, such as `cardsflow_fmu.models.plant:PlantModel`.
        ports: `ports_digest` of the variables.
    """

    package: str
    model_class: str
    ports: str

    def encode(self) -> bytes:
        """Return the contents of the file."""
        entries = {"format": _FORMAT, **asdict(self)}
        entries["class"] = entries.pop("model_class")
        return json_text(entries, indent=1, sort_keys=True).encode() + b"\n"


def read_model_file(folder: Path) -> ModelFile:
    """Read the file in an FMU's resources.

    Raises:
        InputError: The file is missing, damaged, or in a later format.
    """
    path = folder / MODEL_FILE
    try:
        entries: Any = json.loads(read_file(path, limits.JSON).decode())
    except (ValueError, RecursionError) as error:
        raise InputError(f"{error}; unpack or build the FMU again", file=path) from None
    keys = ("package", "class", "ports")
    if not isinstance(entries, dict) or entries.get("format") != _FORMAT:
        raise InputError(f"is not a model file of format {_FORMAT}", file=path)
    if not all(isinstance(entries.get(key), str) for key in keys):
        raise InputError(f"requires the strings {', '.join(keys)}", file=path)
    return ModelFile(*(entries[key] for key in keys))


def class_path(model_class: type[FmuModel]) -> str:
    """Return the import path of a class, such as `cardsflow_fmu.models.plant:PlantModel`."""
    path = f"{model_class.__module__}:{model_class.__qualname__}"
    if model_class.__module__ == "__main__" or "<locals>" in path:
        raise InputError(f"{path} cannot be imported by an FMU; define the class in a module")
    return path


def load_class(path: str, folder: Path) -> type[FmuModel]:
    """Import the class at a path from `class_path`."""
    module_name, _, name = path.partition(":")
    try:
        module = import_module(module_name, folder)
        loaded = functools.reduce(getattr, name.split("."), module)
    except (ImportError, AttributeError, ValueError) as error:
        raise InputError(f"the model class {path} cannot be imported: {error}") from error
    if not (isinstance(loaded, type) and issubclass(loaded, FmuModel)):
        raise InputError(f"{path} is not an FmuModel")
    return loaded
