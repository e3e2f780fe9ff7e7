"""Model descriptions of untrusted FMU files, read by FMPy."""

from __future__ import annotations

import io
import math
import re
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import fmpy

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.files import read_file
from cardsflow_fmu.utils.archive import open_archive, read_entry, unpack_archive

DESCRIPTION = "modelDescription.xml"
STRUCTURAL = "structuralParameter"
"""Causality of parameters of FMI 3.0 that specify sizes of arrays."""


def read_description(file: Path) -> Any:
    """Read FMPy's model description of a packed FMU."""
    with open_archive(file, "FMU") as archive:
        data = read_entry(archive, DESCRIPTION, limits.DESCRIPTION)
    return _description(data, file)


_UNUSED_FOLDERS = ("sources/", "documentation/", "terminalsAndIcons/")
"""Folders of an FMU that an instance does not need."""


def read_unpacked_description(file: Path, folder: Path) -> Any:
    """Unpack an FMU and read FMPy's model description.

    Raises:
        InputError: The file is not an FMU.
    """
    if not (folder / DESCRIPTION).is_file():
        unpack_archive(file, folder, "FMU", "an FMU", without=_UNUSED_FOLDERS)
    if not (folder / DESCRIPTION).is_file():
        raise InputError(f"is not an FMU: it has no {DESCRIPTION}", file=file)
    return _description(read_file(folder / DESCRIPTION, limits.DESCRIPTION), file)


def set_structure(description: Any, values: Mapping[str, float], file: Path) -> None:
    """Set structural parameters of FMI 3.0, and the shapes of the arrays that depend on them.

    Raises:
        InputError: A value is not a size, or the FMU has too many variables.
    """
    for variable in description.modelVariables:
        if variable.causality == STRUCTURAL and variable.name in values:
            size = float(values[variable.name])
            if not (size >= 0 and size.is_integer()):
                problem = f"the structural parameter {variable.name} must be a number of items"
                raise InputError(f"{problem}, not {size:g}", file=file)
            variable.start = str(int(size))
    for variable in description.modelVariables:
        lengths = [d.start or d.variable.start for d in variable.dimensions]
        variable.shape = tuple(map(int, lengths))
    _require_few_variables(description, file)


def _require_few_variables(description: Any, file: Path) -> None:
    if sum(math.prod(v.shape or ()) for v in description.modelVariables) > limits.COLUMNS:
        problem = f"cannot be used as an FMU: it has more than {limits.COLUMNS} variables"
        raise InputError(problem, file=file)


def _description(data: bytes, file: Path) -> Any:
    fault = limits.xml_fault(data, limits.DESCRIPTION_TAGS)
    if fault is None and b"<!" in re.sub(rb"<!(--|\[CDATA\[)", b"", data.replace(b"\0", b"")):
        fault = "has a document type or entities, which are not allowed"
    if fault is not None:
        raise InputError(f"cannot be used as an FMU: its {DESCRIPTION} {fault}", file=file)
    try:
        description = fmpy.read_model_description(_as_archive(data), validate=False)
        shapes = [variable.shape or () for variable in description.modelVariables]
        if any(length < 0 for shape in shapes for length in shape):
            raise ValueError("the length of an array must not be negative")
    except Exception as error:
        reason = re.sub(r"\s+", " ", str(error))
        raise InputError(f"is not an FMU: {reason}", file=file) from None
    _require_few_variables(description, file)
    return description


def _as_archive(data: bytes) -> io.BytesIO:
    """Return an archive in memory that contains a model description, for FMPy."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        archive.writestr(DESCRIPTION, data)
    return memory
