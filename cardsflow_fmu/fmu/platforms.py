"""C libraries for the platforms of an FMU: prebuilt or cross-compiled."""

from __future__ import annotations

import importlib.util
import subprocess
from collections.abc import Iterable
from pathlib import Path

from addin_sdfusion.robot import InputError, SimulationError
from cardsflow_fmu.runtime.library import (
    find_platform,
    library_path,
    prebuilt_libraries,
    this_platform,
)
from cardsflow_fmu.runtime.sources import FMI, NATIVE, ROOT, cross_command
from cardsflow_fmu.utils.extras import install


def libraries_for(
    platforms: Iterable[str], folder: Path, *, native: bool = False
) -> dict[str, Path]:
    """Return the C library for each platform; missing ones are cross-compiled.

    Args:
        platforms: Names as in FMI 2.0, `linux64`, or FMI 3.0, `x86_64-linux`.
        native: Whether the library is for native FMUs, which is part of the package.

    Returns:
        The files, by FMI 3.0's name of the platform.

    Raises:
        UnknownNameError: The platform does not exist.
        InputError: `platforms` is empty, or the compiler is missing.
        SimulationError: The compilation failed.
    """
    names = list(dict.fromkeys(find_platform(name).tuple for name in platforms))
    if not names:
        raise InputError("an FMU requires at least one platform, such as linux64")
    libraries = {this_platform().tuple: library_path(native=native)}
    if native:
        libraries = prebuilt_libraries() | libraries
    return {name: libraries.get(name) or compile_for(name, folder, native=native) for name in names}


def compile_for(platform: str, folder: Path, *, native: bool = False) -> Path:
    """Compile the library for a platform by FMI 3.0's name; return the file.

    The first time takes a minute or two, because the compiler also builds the C library.
    """
    if importlib.util.find_spec("ziglang") is None:
        prebuilt = " this installation contains no prebuilt library for it, and" if native else ""
        raise InputError(
            f"FMUs for {platform}:{prebuilt} compiling one requires the ziglang package: "
            f"{install('cross')}"
        )
    file = folder / f"{platform}{find_platform(platform).suffix}"
    done = subprocess.run(
        cross_command(NATIVE if native else FMI, platform, file),
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        reason = (done.stderr.strip() or "no message").splitlines()[0]
        raise SimulationError(f"the C library cannot be compiled for {platform}: {reason}")
    return file
