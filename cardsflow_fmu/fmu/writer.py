"""Writer of FMU files, which are byte-identical for equal input and SOURCE_DATE_EPOCH."""

from __future__ import annotations

import hashlib
import os
import sys
import time
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path, PurePosixPath
from types import MappingProxyType

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.signals.dependencies import Dependencies
from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.cosim.signals.variables import array_variables, scalar_variables
from cardsflow_fmu.runtime.carried_module import packed_files
from cardsflow_fmu.runtime.library import find_platform, library_path, this_platform
from cardsflow_fmu.runtime.model import FmuModel
from cardsflow_fmu.runtime.model_file import (
    MODEL_FILE,
    NATIVE_FILE,
    ModelFile,
    NativeModel,
    class_path,
)
from cardsflow_fmu.runtime.port_table import encode_port_table, ports_digest
from cardsflow_fmu.utils.archive import read_contents, write_archive
from cardsflow_fmu.version import __version__

from .description import FmiVersion, FmuDescription
from .extras import extra_files
from .model_description import model_description
from .native_sources import compiled_files, source_files
from .related_files import ReferenceResults, related_files

_PORTS_FILE = "ports.bin"
_PYTHON_FILE = "python.txt"  # the interpreter for a worker process, if it exists


def write_fmu(
    path: str | Path,
    *,
    model_class: type[FmuModel],
    model_name: str,
    ports: Sequence[Port],
    resources: Mapping[str, bytes | Path],
    step: float,
    stop_time: float | None = None,
    internal_step: float | None = None,
    fmi: FmiVersion = "2.0",
    arrays: bool = True,
    libraries: Mapping[str, Path] | None = None,
    native: NativeModel | None = None,
    dependencies: Dependencies | None = None,
    sources: bool = True,
    is_continuous: bool = False,
    about: Mapping[str, str] = MappingProxyType({}),
    results: ReferenceResults | None = None,
) -> Path:
    """Pack a model into an FMU; further arguments are as for `FmuDescription`.

    Args:
        model_class: Class of the model, which the FMU imports by name.
        resources: Contents by relative path with `/`, for `model_class.from_resources`.
        arrays: Whether adjacent ports form arrays in FMI 3.0. FMI 2.0 has no arrays.
        libraries: C library for each platform, by the FMI 3.0 name of the platform (default: the
            library for the current platform).
        native: Model in C, from `model_in_c`, or None for a model in Python.
        sources: Whether the FMU of a native model contains C sources, for other platforms.

    Raises:
        InputError: FMI does not allow a name, or a file cannot be read or written.
    """
    path = Path(path)
    variables = array_variables(ports) if arrays and fmi == "3.0" else scalar_variables(ports)
    fmu = FmuDescription(
        variables,
        model_name,
        model_class.description,
        step,
        stop_time,
        internal_step,
        native is not None and native.has_internal_steps,
        model_class.any_step,
        native is not None and native.has_derivatives,
        model_class.has_state,
        needs_tool=native is None,
        sources=compiled_files() if native is not None and sources else (),
        dependencies=dependencies,
        is_continuous=is_continuous,
        about=about,
    )
    files = {_resource_name(name): read_contents(source) for name, source in resources.items()}
    if native is None:
        files |= _python_files(model_class, ports)
    else:
        files[f"resources/{NATIVE_FILE}"] = native.contents
        if sources:
            files |= source_files(model_name, fmi)
    guid = _guid({**files, "modelDescription.xml": model_description(fmu, "", fmi)})
    fmu = replace(fmu, generated=_build_time())  # not part of the GUID
    files["modelDescription.xml"] = model_description(fmu, guid, fmi)
    files[f"resources/{_PORTS_FILE}"] = encode_port_table(
        variables, guid=guid, model_name=model_name, package=__version__, step=step
    )
    if native is None:
        # Not part of the GUID, since an FMU does not depend on the Python that builds it.
        files[f"resources/{_PYTHON_FILE}"] = os.fsencode(sys.executable) + b"\n"
    if libraries is None:
        libraries = {this_platform().tuple: library_path(native=native is not None)}
    files |= _binaries(libraries, model_name, fmi) | extra_files(fmu, fmi)
    if results is not None:
        files |= related_files(model_name, results)
    write_archive(path, files)
    return path


def _build_time() -> str:
    """Return the current time, or the time in the environment variable SOURCE_DATE_EPOCH."""
    text = os.environ.get("SOURCE_DATE_EPOCH")
    try:
        seconds = int(time.time() if text is None else text)
        return datetime.fromtimestamp(seconds, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    except (ValueError, OverflowError, OSError):
        problem = f"SOURCE_DATE_EPOCH: {text!r} is not a time in seconds since 1970"
        raise InputError(f"{problem}; set it to a whole number") from None


def _python_files(model_class: type[FmuModel], ports: Sequence[Port]) -> dict[str, bytes]:
    """Return the files from which Python creates the model."""
    record = ModelFile(__version__, class_path(model_class), ports_digest(ports))
    carried = packed_files(model_class)
    files = {f"resources/{name}": read_contents(source) for name, source in carried.items()}
    return files | {f"resources/{MODEL_FILE}": record.encode()}


def _binaries(libraries: Mapping[str, Path], model_name: str, fmi: FmiVersion) -> dict[str, bytes]:
    platforms = {find_platform(name): library for name, library in libraries.items()}
    return {
        f"binaries/{entry.folder(fmi)}/{model_name}{entry.suffix}": read_contents(library)
        for entry, library in platforms.items()
    }


def _resource_name(name: str) -> str:
    parts = PurePosixPath(name).parts
    if not parts or name.startswith("/") or ".." in parts or "\\" in name or ":" in name:
        raise InputError(f"{name!r} is not a relative path in an FMU's resources")
    if name in (MODEL_FILE, NATIVE_FILE, _PORTS_FILE, _PYTHON_FILE):
        raise InputError(f"the resource name {name!r} is reserved")
    return str(PurePosixPath("resources", *parts))


def _guid(files: Mapping[str, bytes]) -> str:
    """Return a GUID that is computed from the contents."""
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(f"{name}\0{len(files[name])}\0".encode())
        digest.update(files[name])
    return f"{{{uuid.UUID(bytes=digest.digest()[:16])}}}"
