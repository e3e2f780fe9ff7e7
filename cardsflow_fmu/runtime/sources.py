"""The C libraries: what each is made of, and how they are compiled, here and for other platforms.

hatch_build.py reads this file when the package is built, so that it needs the standard library
only.
"""

from __future__ import annotations

import hashlib
import sys
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]

# Contraction off: a fused multiply-add would make results depend on the processor. Nothing needs
# errno or traps, but a loop that might set or meet one is not made of vector instructions.
_NUMBERS = ("-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math")
FLAGS = ("-std=c99", "-O3", *_NUMBERS, "-fvisibility=hidden")
WARNINGS = ("-Wall", "-Wextra")

RUNTIME = "cardsflow_fmu/runtime/csrc"
FREESTANDING = "sim_dart/csrc/freestanding"
"""In the place of a C library, on machines without one."""
TANGENT = "sim_dart/csrc/tangent"
"""Derivatives, which FMUs and estimators may need, and microcontrollers cannot have."""
GENERATED = "sim_dart/generated"
"""Headers that hatch_build.py makes of the table of tension laws."""
CONTROL_GENERATED = "controllers/generated"
"""The list of control laws in joint space, likewise."""
PREBUILT = "cardsflow_fmu/runtime/lib/prebuilt"


class Library(NamedTuple):
    """A shared library: the C files in folders make `target`, without a suffix.

    Attributes:
        folders: Where its files are, at any depth.
        target: What they make.
        without: Folders and files below these that are not for it.
        flags: Further flags.
    """

    folders: tuple[str, ...]
    target: str
    without: tuple[str, ...]
    flags: tuple[str, ...] = ()

    def sources(self, root: Path = ROOT) -> list[str]:
        """Its C files, relative to the root, in order."""
        return self._files(root, "*.c")

    def headers(self, root: Path = ROOT) -> list[str]:
        """The headers beside them."""
        return self._files(root, "*.h")

    def _files(self, root: Path, pattern: str) -> list[str]:
        return list(_found(self.folders, self.without, root, pattern))

    def fingerprint(self, root: Path = ROOT) -> str:
        """Hash of all sources: a compiled library beside other sources is not theirs."""
        digest = hashlib.sha256(repr((FLAGS, self.flags, SMALL, TARGETS)).encode())
        for name in [*self.sources(root), *self.headers(root)]:
            contents = (root / name).read_bytes()
            digest.update(f"{name}\0{len(contents)}\0".encode() + contents)
        return digest.hexdigest()


@cache
def _found(
    folders: tuple[str, ...], without: tuple[str, ...], root: Path, pattern: str
) -> list[str]:
    paths = {path for folder in folders for path in (root / folder).rglob(pattern)}
    others = [root / name for name in without]
    mine = (path for path in paths if not any(map(path.is_relative_to, others)))
    return sorted(path.relative_to(root).as_posix() for path in mine)


_LIB = "cardsflow_fmu/runtime/lib"
CORE = Library(("sim_dart/csrc", GENERATED), "sim_dart/lib/cardsflow_core", (FREESTANDING,))
_MATHS = "sim_dart/csrc/math"
CONTROL = Library(
    ("controllers/csrc", CONTROL_GENERATED, _MATHS), "controllers/lib/cardsflow_control", ()
)
_ALL = (RUNTIME, *CORE.folders, *CONTROL.folders)
_INSIDE = ("-DCARDSFLOW_INSIDE",)
_NATIVE = f"{RUNTIME}/native/backend_native.c"
_PYTHON, _LOOP = f"{RUNTIME}/python", f"{RUNTIME}/loop"
FMI = Library(_ALL, f"{_LIB}/cardsflow_fmi", (FREESTANDING, _NATIVE), _INSIDE)
"""That of FMUs whose model may be one in Python."""
NATIVE = Library(_ALL, f"{_LIB}/cardsflow_native", (FREESTANDING, _PYTHON, _LOOP), _INSIDE)
"""That of native FMUs: without what starts a Python."""
LIBRARIES = (CORE, CONTROL, FMI, NATIVE)


class Target(NamedTuple):
    """A platform as ziglang knows it: an old C library serves newer ones too."""

    name: str
    suffix: str
    flags: tuple[str, ...]


# Small, for every FMU has it inside; what no exported function needs is left out.
SMALL = ("-Os", "-ffunction-sections")
NO_UNWINDING = ("-fno-unwind-tables", "-fno-asynchronous-unwind-tables")  # there are no exceptions
_LINUX = ("-fPIC", "-D_GNU_SOURCE", *NO_UNWINDING, "-Wl,--gc-sections", "-lm", "-ldl", "-lpthread")
_DARWIN = (
    "-fPIC",
    *NO_UNWINDING,
    "-Wl,-dead_strip",
    "-Wl,-install_name,@rpath/cardsflow_fmi.dylib",
)
# There code is larger, and system functions come inside: small loops stay loops.
_WINDOWS = ("-Wl,--gc-sections", "-fno-unroll-loops", "-fno-vectorize", "-fno-slp-vectorize")
TARGETS = {
    "x86_64-linux": Target("x86_64-linux-gnu.2.17", ".so", _LINUX),
    "aarch64-linux": Target("aarch64-linux-gnu.2.17", ".so", _LINUX),
    "x86_64-windows": Target("x86_64-windows-gnu", ".dll", _WINDOWS),
    "aarch64-windows": Target("aarch64-windows-gnu", ".dll", _WINDOWS),
    "x86_64-darwin": Target("x86_64-macos", ".dylib", _DARWIN),
    "aarch64-darwin": Target("aarch64-macos", ".dylib", _DARWIN),
}
"""By FMI 3.0's name."""

PREBUILT_PLATFORMS = tuple(name for name in TARGETS if name != "aarch64-windows")
"""Those whose native library comes with the package, its fingerprint beside it."""


def cross_command(library: Library, platform: str, file: Path) -> list[str]:
    """The command that compiles a library for a platform with the ziglang package, in the root.

    Args:
        library: Which.
        platform: FMI 3.0's name.
        file: What to make.
    """
    target = TARGETS[platform]
    compiler = [sys.executable, "-m", "ziglang", "cc", "-target", target.name]
    flags = [*FLAGS, *library.flags, *SMALL, "-shared", "-g0", "-s"]
    return [*compiler, *flags, *library.sources(), "-o", str(file.absolute()), *target.flags]
