"""Writes .fmu files: byte for byte the same for the same input."""

from __future__ import annotations

import hashlib
import os
import uuid
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath

from addin_sdfusion.robot import InputError

from .model_description import model_description
from .models.model import FmuModel
from .ports import Port
from .runtime.library import library_path, library_suffix, platform_name
from .runtime.model_file import MODEL_FILE, ModelFile, class_path
from .runtime.port_table import encode_port_table, ports_digest
from .version import __version__

_PORTS_FILE = "ports.bin"
_EARLIEST_TIME = (1980, 1, 1, 0, 0, 0)
_UNIX = 3
_READABLE = 0o644 << 16


def write_fmu(
    path: str | Path,
    *,
    model_class: type[FmuModel],
    model_name: str,
    ports: Sequence[Port],
    resources: Mapping[str, bytes | Path],
    step: float,
    stop_time: float | None = None,
) -> Path:
    """Pack a model into an FMU for FMI 2.0 co-simulation.

    Args:
        path: The file to write.
        model_class: The model; the FMU imports it by its name.
        model_name: Name of the model and of its library: a C identifier.
        ports: The variables, as the model made from the resources has them.
        resources: What `model_class.from_resources` reads: relative path with `/`, and contents.
        step: Preferred communication step, in [s].
        stop_time: Preferred end, in [s].

    Returns:
        The path.

    Raises:
        InputError: A name that FMI does not allow, or a file that cannot be read or written.
    """
    path = Path(path)
    files = {_resource_name(name): _contents(source) for name, source in resources.items()}
    record = ModelFile(__version__, class_path(model_class), ports_digest(ports))
    files[f"resources/{MODEL_FILE}"] = record.encode()

    def describe(guid: str) -> bytes:
        return model_description(
            ports,
            model_name=model_name,
            guid=guid,
            description=model_class.description,
            step=step,
            stop_time=stop_time,
        )

    guid = _guid({**files, "modelDescription.xml": describe("")})
    files["modelDescription.xml"] = describe(guid)
    files[f"resources/{_PORTS_FILE}"] = encode_port_table(
        ports, guid=guid, model_name=model_name, package=__version__
    )
    binary = f"binaries/{platform_name()}/{model_name}{library_suffix()}"
    files[binary] = library_path().read_bytes()
    _write_archive(path, files)
    return path


def _resource_name(name: str) -> str:
    parts = PurePosixPath(name).parts
    if not parts or name.startswith("/") or ".." in parts or "\\" in name or ":" in name:
        raise InputError(f"{name!r} is not a relative path below an FMU's resources")
    if name in (MODEL_FILE, _PORTS_FILE):
        raise InputError(f"the resource name {name!r} is taken by the FMU itself")
    return str(PurePosixPath("resources", *parts))


def _contents(source: bytes | Path) -> bytes:
    if isinstance(source, bytes):
        return source
    try:
        return source.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=source) from None


def _guid(files: Mapping[str, bytes]) -> str:
    """A fingerprint of the contents."""
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(f"{name}\0{len(files[name])}\0".encode())
        digest.update(files[name])
    return f"{{{uuid.UUID(bytes=digest.digest()[:16])}}}"


def _write_archive(path: Path, files: Mapping[str, bytes]) -> None:
    """Write aside and move into place, so that nobody sees half a file."""
    aside = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        with zipfile.ZipFile(aside, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in sorted(files):
                archive.writestr(_entry(name), files[name])
        aside.replace(path)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", file=path) from None
    finally:
        aside.unlink(missing_ok=True)


def _entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, _EARLIEST_TIME)
    entry.create_system = _UNIX
    entry.external_attr = _READABLE
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry
