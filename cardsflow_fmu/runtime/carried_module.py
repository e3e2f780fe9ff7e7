"""Python modules of models that FMUs carry as files.

Classes in packages are imported from the installed package. A class in a single file next to a
script is usually not importable where the FMU runs, or another file has the same name. Therefore
the FMU contains the file, which is used if the import finds no file or another text.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType

from .model import FmuModel

_FOLDER = "python"


def packed_files(model_class: type[FmuModel]) -> dict[str, Path]:
    """Return the module of a class as a resource by path; empty for classes in packages."""
    name = model_class.__module__
    file = getattr(sys.modules.get(name), "__file__", None)
    if "." in name or file is None or not file.endswith(".py"):
        return {}
    return {f"{_FOLDER}/{name}.py": Path(file)}


def import_module(name: str, folder: Path) -> ModuleType:
    """Import the module of a model.

    Returns:
        The installed module, or the carried one if their texts differ.
    """
    file = folder / _FOLDER / f"{name}.py"
    if not file.is_file():
        return importlib.import_module(name)
    text = file.read_bytes()
    if _installed_text(name) == text:
        return importlib.import_module(name)
    return _load(f"_cardsflow_fmu_{name}_{hashlib.sha256(text).hexdigest()[:16]}", file)


def _installed_text(name: str) -> bytes | None:
    """Return the source of a module without importing it."""
    try:
        spec = importlib.util.find_spec(name)
        return None if spec is None or not spec.origin else Path(spec.origin).read_bytes()
    except (ImportError, OSError, ValueError):
        return None


def _load(alias: str, file: Path) -> ModuleType:
    """Load the module in a file, once per text."""
    if alias in sys.modules:
        return sys.modules[alias]
    spec = importlib.util.spec_from_file_location(alias, file)
    if spec is None or spec.loader is None:
        raise ImportError(f"{file} cannot be loaded")
    module = importlib.util.module_from_spec(spec)
    sys.modules[alias] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[alias]
        raise
    return module
