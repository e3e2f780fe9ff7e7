"""Platforms and compilers on which C programs of the tests are built and run."""

from __future__ import annotations

import atexit
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from support.cases import LONG

from cardsflow_fmu.runtime.sources import BATCH, CONTROL, CORE, TANGENT

from .objects import compile_objects

ROOT = Path(__file__).parents[3]
PROGRAMS = ROOT / "tests/native/csrc"
"""Folder of the C programs of the tests."""
SOURCES = sorted(
    str(ROOT / name)
    for name in {*CORE.sources(), *CONTROL.sources()}
    if not name.startswith((TANGENT, BATCH))
)
"""C files of the core and the control laws, without derivatives and batches."""
DERIVATIVES = str(ROOT / TANGENT / "tangent.c")
"""C files of the core for derivatives, which only FMUs contain."""
TRANSITION = str(ROOT / TANGENT / "transition.c")
"""C files of the transition matrix of estimators, which uses derivatives."""
FLAGS = ["-std=c99", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-DCARDSFLOW_INSIDE"]
ZIG = [sys.executable, "-m", "ziglang", "cc", "-target"]
_OF_PROGRAMS = ("-I", "-l", "-D_GNU_SOURCE", "-DFUZZ", "-DCARDSFLOW_LIBFUZZER", "-DVECTORS")
TIMEOUT = 900  # in [s]: ziglang first builds the C library of a platform


class Target(NamedTuple):
    """Command of a compiler, and command that runs its programs; empty for this machine."""

    compiler: list[str]
    runner: tuple[str, ...] = ()
    suffix: str = ""


_QEMU = ("qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu")
GCC = Target(["gcc", "-O1", "-fPIC"])
"""For programs and shared libraries, which have the same object files."""

TARGETS = {
    "gcc -O1": GCC,
    "gcc -O2": Target(["gcc", "-O2"]),
    "gcc -O3": Target(["gcc", "-O3"]),
    "gcc -O1 -march=native": Target(["gcc", "-O1", "-ftree-vectorize", "-march=native"]),
    "gcc -O3 -march=native": Target(["gcc", "-O3", "-march=native"]),
    "clang -O3": Target(["clang", "-O3"]),
    "zig linux64": Target([*ZIG, "x86_64-linux-gnu.2.17", "-O3"]),
    "zig linux64 v3": Target([*ZIG, "x86_64-linux-gnu.2.17", "-mcpu=x86_64_v3", "-O3"]),
    "zig linux-aarch64, qemu": Target([*ZIG, "aarch64-linux-gnu.2.17", "-O3"], _QEMU),
    "zig win64, wine": Target([*ZIG, "x86_64-windows-gnu", "-O3"], ("wine64",), ".exe"),
}


def parametrize_targets(names: Iterable[str], long: Iterable[str] = ()) -> pytest.MarkDecorator:
    """Parametrize a test by the name of the target, with marks for slow and emulated targets."""
    cases = [_case(name) for name in names]
    cases += [_case(name, LONG) for name in long]
    return pytest.mark.parametrize("target", cases)


def _case(name: str, *marks: pytest.MarkDecorator) -> Any:
    is_own = TARGETS[name].compiler[0] in ("gcc", "clang")
    return pytest.param(name, marks=(pytest.mark.slow if is_own else pytest.mark.cross, *marks))


def single_flags(target: Target) -> tuple[str, ...]:
    """Return the compiler flags of a target for single precision, including literals."""
    literals = ("-fsingle-precision-constant",)
    if target.compiler[0] != "gcc":
        literals = ("-Xclang", "-cl-single-precision-constant")
    return ("-DCARDSFLOW_FLOAT", *literals)


@cache
def environment() -> dict[str, str]:
    """Return the environment without preloaded sanitizers, and with settings of wine."""
    files = tempfile.mkdtemp(prefix="wine")
    atexit.register(shutil.rmtree, files, ignore_errors=True)
    kept = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}
    return kept | {"WINEDEBUG": "-all", "WINEPREFIX": files, "WINEDLLOVERRIDES": "mscoree,mshtml="}


def find_runner(name: str) -> str | None:
    """Return the path of an emulator; on Debian, wine is next to its libraries."""
    return shutil.which(name) or shutil.which(name, path="/usr/lib/wine")


def require(target: Target) -> list[str]:
    """Return the command of the emulator; skip the test if it or the compiler is missing."""
    if target.compiler[0] == sys.executable:
        if importlib.util.find_spec("ziglang") is None:
            pytest.skip("no ziglang: the extra `cross`")
    elif shutil.which(target.compiler[0]) is None:
        pytest.skip(f"no {target.compiler[0]}")
    if not target.runner:
        return []
    found = find_runner(target.runner[0])
    libraries = [Path(word) for word in target.runner if word.startswith("/")]
    if found is None or not all(folder.is_dir() for folder in libraries):
        pytest.skip(f"no {target.runner[0]}, or no libraries for its platform")
    return [found, *target.runner[1:]]


def run(
    command: Sequence[str | Path],
    folder: Path | None = None,
    variables: Mapping[str, str] | None = None,
) -> str:
    """Run a command in a folder with further variables; return its output.

    Messages on stderr fail the test.
    """
    done = subprocess.run(
        list(map(str, command)),
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
        env=environment() | dict(variables or {}),
        timeout=TIMEOUT,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout or done.stderr


def build_program(
    target: Target,
    folder: Path,
    sources: Sequence[str],
    *more: str,
    libraries: Sequence[str] = SOURCES,
) -> list[str]:
    """Compile a program that is named after its first source; return the command that runs it.

    `libraries` are the files of core and control laws, as sources or object files.
    """
    runner = require(target)
    program = folder / f"{Path(sources[0]).stem}{target.suffix}"
    own = [PROGRAMS / name for name in sources]
    others = [*libraries, *(word for word in more if word.endswith(".c"))]
    flags = [*FLAGS, *(word for word in more if not word.endswith(".c")), f"-I{ROOT}"]
    if target.compiler[0] != sys.executable:  # ziglang has its own cache
        others = compiled(target, flags, others)
    run([*target.compiler, *flags, *own, *others, "-o", program, "-lm"])
    return [*runner, str(program)]


def compiled(target: Target, flags: Sequence[str], files: Sequence[str]) -> list[str]:
    """Return object files of the C files of the package, without the flags of a program."""
    shared = [word for word in flags if not word.startswith(_OF_PROGRAMS)]
    command = [*target.compiler, *shared, "-D_GNU_SOURCE", f"-I{ROOT}"]
    made = compile_objects(command, [name for name in files if name.endswith(".c")], run)
    return [*made, *(name for name in files if not name.endswith(".c"))]
