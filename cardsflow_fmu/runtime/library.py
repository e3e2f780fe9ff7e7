"""The C library that every FMU carries: where it is built, and what FMI calls its platform."""

from __future__ import annotations

import os
import platform
import sys
from pathlib import Path

from addin_sdfusion.robot import InputError

_SUFFIXES = {"linux64": ".so", "win64": ".dll", "darwin64": ".dylib"}
_SYSTEMS = {"linux": "linux64", "win32": "win64", "darwin": "darwin64"}
_LOCATION = Path("cardsflow_fmu", "runtime", "lib", "cardsflow_fmi")


def platform_name() -> str:
    """FMI 2.0's name of this platform, such as `linux64`.

    Raises:
        InputError: FMI 2.0 has no name for it.
    """
    machine = platform.machine()
    if sys.platform not in _SYSTEMS or machine.lower() not in ("x86_64", "amd64"):
        raise InputError(
            f"FMI 2.0 has no platform name for {sys.platform} on {machine}; "
            "FMUs run on Linux, Windows and macOS on x86_64"
        )
    return _SYSTEMS[sys.platform]


def library_suffix() -> str:
    """How the file name of a shared library ends on this platform."""
    return _SUFFIXES[platform_name()]


def library_path() -> Path:
    """Path of the built library.

    The environment variable `CARDSFLOW_LIBRARY_DIR` names another folder than the installation to
    look below, such as one with a sanitized build.

    Raises:
        InputError: There is no library.
    """
    root = Path(os.environ.get("CARDSFLOW_LIBRARY_DIR") or Path(__file__).parents[2])
    path = root / _LOCATION.with_suffix(library_suffix())
    if not path.is_file():
        raise InputError(
            "the FMI library is missing: install the package again, "
            "or run `python hatch_build.py` in a source tree",
            file=path,
        )
    return path
