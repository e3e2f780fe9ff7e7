"""C libraries: their sources, and how they are compiled for this and other platforms.

hatch_build.py imports this file when the package is built, so it uses only the standard library.
"""

from __future__ import annotations

import hashlib
import sys
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]

# No contraction: with fused multiply-add, results would depend on the processor. Without errno and
# traps, which are not used, compilers can vectorise loops.
_NUMBERS = ("-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math")
FLAGS = ("-std=c99", "-O3", *_NUMBERS, "-fvisibility=hidden")
WARNINGS = ("-Wall", "-Wextra", "-Wno-psabi")  # vectors are passed inside one library only

RUNTIME = "cardsflow_fmu/runtime/csrc"
FREESTANDING = "sim_dart/csrc/freestanding"
"""Replacement for the C library on machines without one."""
TANGENT = "sim_dart/csrc/tangent"
"""Derivatives for FMUs and estimators, but not for microcontrollers."""
BATCH = "sim_dart/csrc/batch"
"""Steps of many instances, which no FMU contains."""
GENERATED = "sim_dart/generated"
"""Headers that hatch_build.py generates from the tables of muscle laws."""
CONTROL_GENERATED = "controllers/generated"
"""Generated list of control laws in joint space."""
PREBUILT = "cardsflow_fmu/runtime/lib/prebuilt"


class Library(NamedTuple):
    """Shared library, compiled from the C files in folders.

    Attributes:
        folders: Folders with its files, at any depth.
        target: Path of the library without a suffix.
        without: Folders and files to exclude.
        exports: Patterns of the functions to export; all that the sources declare so if empty.
    """

    folders: tuple[str, ...]
    target: str
    without: tuple[str, ...] = ()
    exports: tuple[str, ...] = ()

    def sources(self, root: Path = ROOT) -> list[str]:
        """Return its C files, relative to the root, in order."""
        return self._files(root, "*.c")

    def headers(self, root: Path = ROOT) -> list[str]:
        """Return its headers, relative to the root, in order."""
        return self._files(root, "*.h")

    def _files(self, root: Path, pattern: str) -> list[str]:
        return list(_find_files(self.folders, self.without, root, pattern))

    def fingerprint(self, root: Path = ROOT) -> str:
        """Return a hash of all sources, which identifies the compiled library."""
        digest = hashlib.sha256(repr((FLAGS, self.exports, SMALL, TARGETS)).encode())
        for name in [*self.sources(root), *self.headers(root)]:
            contents = (root / name).read_bytes()
            digest.update(f"{name}\0{len(contents)}\0".encode() + contents)
        return digest.hexdigest()


@cache
def _find_files(
    folders: tuple[str, ...], without: tuple[str, ...], root: Path, pattern: str
) -> list[str]:
    paths = {path for folder in folders for path in (root / folder).rglob(pattern)}
    excluded = [root / name for name in without]
    included = (path for path in paths if not any(map(path.is_relative_to, excluded)))
    return sorted(path.relative_to(root).as_posix() for path in included)


_LIB = "cardsflow_fmu/runtime/lib"
CORE = Library(("sim_dart/csrc", GENERATED), "sim_dart/lib/cardsflow_core", (FREESTANDING,))
_SHARED = ("sim_dart/csrc/math", "sim_dart/csrc/stage_qp")
CONTROL = Library(
    ("controllers/csrc", CONTROL_GENERATED, *_SHARED), "controllers/lib/cardsflow_control"
)
_MASTER = "cardsflow_fmu/cosim/csrc"
RUN = Library((_MASTER,), f"{_LIB}/cardsflow_run")
"""Library for runs: the co-simulation master."""
_ALL = (RUNTIME, *CORE.folders, *CONTROL.folders)
_FMI = ("fmi2*", "fmi3*")
_NATIVE = f"{RUNTIME}/native/backend_native.c"
_PYTHON, _LOOP = f"{RUNTIME}/python", f"{RUNTIME}/loop"
_BROWSER_LOOP = f"{_LOOP}/native_loop.c"
FMI = Library(
    _ALL,
    f"{_LIB}/cardsflow_fmi",
    (FREESTANDING, BATCH, _NATIVE, _BROWSER_LOOP),
    (*_FMI, "cardsflow_worker_*", "native_model_*"),
)
"""Library of FMUs whose model may be in Python."""
NATIVE = Library(_ALL, f"{_LIB}/cardsflow_native", (FREESTANDING, BATCH, _PYTHON, _LOOP), _FMI)
"""Library of native FMUs, without a Python host."""
LIBRARIES = (CORE, CONTROL, RUN, FMI, NATIVE)
_MODELS = tuple(f"{RUNTIME}/{name}" for name in ("native", "loop", "model", "platform"))
BROWSER = Library(
    (*_MODELS, _MASTER, *CORE.folders, *CONTROL.folders),
    f"{PREBUILT}/wasm32",
    (FREESTANDING, BATCH, _NATIVE, f"{_MASTER}/fmu_step.c"),
)
"""WebAssembly module that simulates in a browser."""


class Target(NamedTuple):
    """Target platform of ziglang, with an old C library for compatibility."""

    name: str
    suffix: str
    flags: tuple[str, ...]


# Small, because every FMU contains it. Unused functions are removed, so few may be exported.
SMALL = ("-Os", "-ffunction-sections", "-DCARDSFLOW_INSIDE")
NO_UNWINDING = ("-fno-unwind-tables", "-fno-asynchronous-unwind-tables")  # C has no exceptions
_LINUX = ("-fPIC", "-D_GNU_SOURCE", *NO_UNWINDING, "-Wl,--gc-sections", "-lm", "-ldl", "-lpthread")
_DARWIN = (
    "-fPIC",
    *NO_UNWINDING,
    "-Wl,-dead_strip",
    "-Wl,-install_name,@rpath/cardsflow_fmi.dylib",
)
# Code is larger there and contains system functions, so loops are not unrolled.
_WINDOWS = ("-Wl,--gc-sections", "-fno-unroll-loops", "-fno-vectorize", "-fno-slp-vectorize")
TARGETS = {
    "x86_64-linux": Target("x86_64-linux-gnu.2.17", ".so", _LINUX),
    "aarch64-linux": Target("aarch64-linux-gnu.2.17", ".so", _LINUX),
    "x86_64-windows": Target("x86_64-windows-gnu", ".dll", _WINDOWS),
    "aarch64-windows": Target("aarch64-windows-gnu", ".dll", _WINDOWS),
    "x86_64-darwin": Target("x86_64-macos", ".dylib", _DARWIN),
    "aarch64-darwin": Target("aarch64-macos", ".dylib", _DARWIN),
}
"""Platforms by FMI 3.0's name."""

PREBUILT_PLATFORMS = tuple(name for name in TARGETS if name != "aarch64-windows")
"""Platforms whose native library is part of the package, with its fingerprint."""

WASM = "wasm32"
"""Platform of the WebAssembly module in `CARDSFLOW_PLATFORMS`."""


def wasm_command(file: Path) -> list[str]:
    """Return the command that compiles the WebAssembly module with the ziglang package."""
    compiler = [sys.executable, "-m", "ziglang", "cc", "-target", "wasm32-wasi"]
    module = ["-mexec-model=reactor", "-Wl,--gc-sections", "-Wl,--export-dynamic"]
    memory = [f"-Wl,--export={name}" for name in ("malloc", "free")]
    flags = [*FLAGS, *SMALL, "-g0", "-s", *module, *memory]
    return [*compiler, *flags, *BROWSER.sources(), "-o", str(file.absolute())]


def cross_command(library: Library, platform: str, file: Path) -> list[str]:
    """Return the command that compiles a library for a platform with the ziglang package."""
    target = TARGETS[platform]
    compiler = [sys.executable, "-m", "ziglang", "cc", "-target", target.name]
    flags = [*FLAGS, *SMALL, "-shared", "-g0", "-s"]
    return [*compiler, *flags, *library.sources(), "-o", str(file.absolute()), *target.flags]
