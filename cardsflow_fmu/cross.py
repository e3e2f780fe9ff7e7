"""Compiles the FMUs' C library for other platforms, with the compiler in the `ziglang` package."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from addin_sdfusion.robot import InputError, SimulationError

from .runtime.library import find_platform, library_path, this_platform

FLAGS = [
    "-std=c99",
    "-O3",
    "-ffp-contract=off",
    "-fvisibility=hidden",
    "-DCARDSFLOW_INSIDE",
]
"""Those of the library that comes with the package, see hatch_build.py."""

_ROOT = Path(__file__).parent.parent
_SOURCES = ("cardsflow_fmu/runtime/csrc", "sim_dart/csrc", "controllers/csrc")
_PLAIN = ["-shared", "-g0", "-s"]


class _Target(NamedTuple):
    """A platform as the compiler knows it: an old C library serves newer ones too."""

    name: str
    flags: list[str]


_DARWIN = ["-fPIC", "-Wl,-install_name,@rpath/cardsflow_fmi.dylib"]
_LINUX = ["-fPIC", "-D_GNU_SOURCE", "-lm", "-ldl", "-lpthread"]
_TARGETS = {
    "x86_64-linux": _Target("x86_64-linux-gnu.2.17", _LINUX),
    "aarch64-linux": _Target("aarch64-linux-gnu.2.17", _LINUX),
    "x86_64-windows": _Target("x86_64-windows-gnu", []),
    "aarch64-windows": _Target("aarch64-windows-gnu", []),
    "x86_64-darwin": _Target("x86_64-macos", _DARWIN),
    "aarch64-darwin": _Target("aarch64-macos", _DARWIN),
}


def libraries_for(platforms: Iterable[str], folder: Path) -> dict[str, Path]:
    """The C library for each platform: this platform's own as it is, the others compiled.

    Args:
        platforms: Names in FMI 2.0's way, `linux64`, or FMI 3.0's, `x86_64-linux`.
        folder: Where to compile to; it exists.

    Returns:
        The files, by FMI 3.0's name of the platform.

    Raises:
        UnknownNameError: There is no such platform.
        InputError: None is named, or the compiler is missing.
        SimulationError: The compiler fails.
    """
    names = list(dict.fromkeys(find_platform(name).tuple for name in platforms))
    if not names:
        raise InputError("an FMU needs a platform, such as linux64")
    own = this_platform().tuple
    return {name: library_path() if name == own else compile_for(name, folder) for name in names}


def compile_for(platform: str, folder: Path) -> Path:
    """Compile the library for a platform by FMI 3.0's name; returns the file.

    The first time for a platform takes a minute or two: the compiler then makes its C library too.

    Raises:
        InputError: The compiler is missing.
        SimulationError: The compiler fails.
    """
    if importlib.util.find_spec("ziglang") is None:
        raise InputError(
            f"compiling for {platform} needs the ziglang package: pip install 'cardsflow[cross]'"
        )
    target = _TARGETS[platform]
    sources = sorted(
        path.relative_to(_ROOT).as_posix()
        for folder in _SOURCES
        for path in (_ROOT / folder).glob("*.c")
    )
    file = folder / f"{platform}{find_platform(platform).suffix}"
    compiler = [sys.executable, "-m", "ziglang", "cc", "-target", target.name]
    command = [*compiler, *FLAGS, *_PLAIN, *sources, "-o", str(file.absolute()), *target.flags]
    done = subprocess.run(command, cwd=_ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        reason = (done.stderr.strip() or "no message").splitlines()[0]
        raise SimulationError(f"the C library cannot be compiled for {platform}: {reason}")
    return file
