"""C libraries of FMUs: their files and platforms."""

from __future__ import annotations

import os
import platform
import sys
from pathlib import Path
from typing import NamedTuple

from addin_sdfusion.robot import InputError, UnknownNameError

from .sources import FMI, NATIVE, PREBUILT, PREBUILT_PLATFORMS


class Platform(NamedTuple):
    """Platform on which FMUs run.

    Attributes:
        tuple: FMI 3.0's name, such as `x86_64-linux`.
        fmi2: FMI 2.0's name, such as `linux64`; None if FMI 2.0 has no name.
        suffix: Suffix of shared libraries.
    """

    tuple: str
    fmi2: str | None
    suffix: str

    def folder(self, fmi: str) -> str:
        """Return the name of its folder in an FMU's binaries.

        Args:
            fmi: `2.0` or `3.0`.
        """
        if fmi != "2.0":
            return self.tuple
        if self.fmi2 is None:
            raise InputError(f"FMI 2.0 has no name for the platform {self.tuple}; FMI 3.0 does")
        return self.fmi2


PLATFORMS = {
    entry.tuple: entry
    for entry in (
        Platform("x86_64-linux", "linux64", ".so"),
        Platform("aarch64-linux", None, ".so"),
        Platform("x86_64-windows", "win64", ".dll"),
        Platform("aarch64-windows", None, ".dll"),
        Platform("x86_64-darwin", "darwin64", ".dylib"),
        Platform("aarch64-darwin", None, ".dylib"),
    )
}
"""Platforms by FMI 3.0's name."""

_SYSTEMS = {"linux": "linux", "win32": "windows", "darwin": "darwin"}
_MACHINES = {"x86_64": "x86_64", "amd64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64"}


def find_platform(name: str) -> Platform:
    """Find a platform by its name in FMI 2.0 or 3.0, such as `linux64` or `x86_64-linux`."""
    for entry in PLATFORMS.values():
        if name in (entry.tuple, entry.fmi2):
            return entry
    names = [entry.fmi2 or entry.tuple for entry in PLATFORMS.values()]
    raise UnknownNameError("platform", name, names)


def this_platform() -> Platform:
    """Return the platform of this process."""
    machine, system = platform.machine(), sys.platform
    entry = PLATFORMS.get(f"{_MACHINES.get(machine.lower())}-{_SYSTEMS.get(system)}")
    if entry is None:
        raise InputError(
            f"FMUs run on Linux, Windows and macOS, on x86_64 and aarch64, "
            f"not on {system} on {machine}"
        )
    return entry


def library_path(*, native: bool = False) -> Path:
    """Return the path of the library for this platform.

    The environment variable `CARDSFLOW_LIBRARY_DIR` replaces the folder of the installation, for
    example by one with a sanitized build.
    """
    target = (NATIVE if native else FMI).target
    path = _root() / f"{target}{this_platform().suffix}"
    if not path.is_file():
        raise InputError(
            "the FMI library is missing; install the package again, "
            "or run `python hatch_build.py` in a source tree",
            file=path,
        )
    return path


def prebuilt_libraries() -> dict[str, Path]:
    """Return the prebuilt libraries of native FMUs, by FMI 3.0's name of the platform.

    An installed package contains one for each of `PREBUILT_PLATFORMS`; a source tree those that
    `python hatch_build.py --platforms` has compiled from the current sources.
    """
    folder = _root() / PREBUILT
    files = {name: folder / f"{name}{PLATFORMS[name].suffix}" for name in PREBUILT_PLATFORMS}
    existing = {name: file for name, file in files.items() if file.is_file()}
    fingerprint = NATIVE.fingerprint() if existing else ""
    return {name: file for name, file in existing.items() if _mark(file) == fingerprint}


def _mark(file: Path) -> str:
    """Return the fingerprint of the sources of a library."""
    try:
        return file.with_suffix(".sha256").read_text("ascii").strip()
    except (OSError, UnicodeDecodeError):
        return ""


def _root() -> Path:
    return Path(os.environ.get("CARDSFLOW_LIBRARY_DIR") or Path(__file__).parents[2])
