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
    """The C library for each platform: those that are there as they are, the others compiled.

    Args:
        platforms: Names as in FMI 2.0, `linux64`, or FMI 3.0, `x86_64-linux`.
        folder: Where to compile to; it exists.
        native: Whether it is for native FMUs, whose libraries come with the package.

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
    there = {this_platform().tuple: library_path(native=native)}
    if native:
        there = prebuilt_libraries() | there
    return {name: there.get(name) or compile_for(name, folder, native=native) for name in names}


def compile_for(platform: str, folder: Path, *, native: bool = False) -> Path:
    """Compile the library for a platform by FMI 3.0's name; returns the file.

    The first time for a platform takes a minute or two: the compiler then makes its C library too.

    Raises:
        InputError: The compiler is missing.
        SimulationError: The compiler fails.
    """
    if importlib.util.find_spec("ziglang") is None:
        prebuilt = " no prebuilt library for it is in this installation, and" if native else ""
        raise InputError(
            f"FMUs for {platform}:{prebuilt} compiling one needs the ziglang package: "
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
