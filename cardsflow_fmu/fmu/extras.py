"""Additional files of an FMU: documentation, licence, icon, terminals, elements of arrays."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.cosim.signals.variables import ELEMENTS_FILE, Variable

from .description import FmiVersion, FmuDescription
from .documentation import documentation_page
from .terminals import terminals_and_icons

_HERE = Path(__file__).parent


def extra_files(fmu: FmuDescription, fmi: FmiVersion) -> dict[str, bytes]:
    """Return the contents of the files, by path in the FMU."""
    icon, drawing = (_read(_HERE / "icon" / f"icon.{kind}") for kind in ("png", "svg"))
    files = {
        "documentation/index.html": documentation_page(fmu),
        "documentation/licenses/license.txt": _license().encode(),
    }
    if fmi == "2.0":  # FMI Library rejects FMUs of FMI 2.0 with terminals, which FMI 3.0 defines
        return files | {"model.png": icon}
    if arrays := [variable for variable in fmu.variables if variable.is_array]:
        files[ELEMENTS_FILE] = _array_elements(arrays)
    return files | {
        "terminalsAndIcons/terminalsAndIcons.xml": terminals_and_icons(fmu.variables),
        "terminalsAndIcons/icon.png": icon,
        "terminalsAndIcons/icon.svg": drawing,
    }


def _array_elements(arrays: Sequence[Variable]) -> bytes:
    """Return names and units of the elements of arrays as JSON, by the name of the array."""
    rows = {
        array.name: [{"name": port.name, "unit": port.unit} for port in array.ports]
        for array in arrays
    }
    return json_text(rows).encode() + b"\n"


def _license() -> str:
    """Return the licence text from the source tree or from the metadata of the package."""
    path = _HERE.parents[1] / "LICENSE"
    if path.is_file():
        return path.read_text("utf-8")
    try:
        text = distribution("cardsflow").read_text("licenses/LICENSE")
    except PackageNotFoundError:
        text = None
    if text is None:
        raise InputError("the licence of the package is missing; install the package again")
    return text


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        raise InputError("is missing; install the package again", file=path) from None
