"""Compiles the C libraries when the package is built; also a script for the sanitized build.

The system's C compiler is used where there is one (`CC`, cc, gcc, clang), else, or with
`CC=ziglang`, the one in the `ziglang` package, which is then asked for as a build requirement.
Nothing is linked but libc and libm, so one library serves every Python.

    python hatch_build.py                            into the source tree
    python hatch_build.py --sanitize --output DIR    with the address and UB sanitizers
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

try:
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface
except ImportError:  # run as a script
    BuildHookInterface = object  # type: ignore[assignment, misc]

ROOT = Path(__file__).parent


class Library(NamedTuple):
    """A shared library: every C file in the folders `sources` makes `target` (without a suffix)."""

    sources: tuple[str, ...]
    target: str
    flags: tuple[str, ...] = ()


LIBRARIES = (
    Library(("sim_dart/csrc",), "sim_dart/lib/cardsflow_core"),
    Library(("controllers/csrc",), "controllers/lib/cardsflow_control"),
    Library(
        ("cardsflow_fmu/runtime/csrc", "sim_dart/csrc", "controllers/csrc"),
        "cardsflow_fmu/runtime/lib/cardsflow_fmi",
        ("-DCARDSFLOW_INSIDE",),
    ),
)

# Contraction off: a fused multiply-add would make results depend on the processor.
FLAGS = ["-std=c99", "-O3", "-ffp-contract=off", "-fvisibility=hidden", "-Wall", "-Wextra"]
SANITIZE = ["-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


def system_compiler() -> list[str] | None:
    """The command of the system's C compiler, or None."""
    wanted = os.environ.get("CC")
    if wanted:
        return None if wanted == "ziglang" else shlex.split(wanted)
    for name in ("cc", "gcc", "clang"):
        if shutil.which(name):
            return [name]
    return None


def compiler() -> list[str]:
    """The command of the C compiler to use: the system's, else ziglang's."""
    found = system_compiler()
    if found:
        return found
    if importlib.util.find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc"]
    sys.exit("no C compiler: install gcc or clang, or `pip install ziglang`")


def platform_flags() -> list[str]:
    """Flags that depend on the system."""
    if sys.platform == "win32":
        return ["-shared"]
    flags = ["-shared", "-fPIC"]
    if sys.platform == "darwin":
        return flags
    return [*flags, "-D_GNU_SOURCE", "-lm", "-ldl", "-lpthread"]


def compile_library(library: Library, output: Path, extra: list[str]) -> Path:
    """Compile one library below `output`; returns its path.

    Written aside and moved into place, so that a running program keeps the file it has open.
    """
    sources = sorted(
        str(path) for folder in library.sources for path in (ROOT / folder).glob("*.c")
    )
    target = output / (library.target + SUFFIX)
    target.parent.mkdir(parents=True, exist_ok=True)
    aside = target.with_name(f"{target.name}.{os.getpid()}")
    flags = [*FLAGS, *shlex.split(os.environ.get("CARDSFLOW_CFLAGS", "")), *extra, *library.flags]
    command = [*compiler(), *flags, *sources, "-o", str(aside), *platform_flags()]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        aside.unlink(missing_ok=True)
        sys.exit(f"{shlex.join(command)}\n{done.stdout}{done.stderr}")
    sys.stderr.write(done.stderr)
    aside.replace(target)
    return target


class CustomBuildHook(BuildHookInterface):  # type: ignore[type-arg, unused-ignore]
    """Compiles the libraries: into the source tree for an editable install, else into the wheel."""

    def dependencies(self) -> list[str]:
        """Ziglang, where the system has no C compiler."""
        return [] if system_compiler() else ["ziglang>=0.13"]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Called by hatchling before a wheel, an editable one included, is built."""
        if self.target_name != "wheel":
            return
        self._aside = None if version == "editable" else tempfile.mkdtemp()
        output = Path(self._aside or ROOT)
        for library in LIBRARIES:
            built = compile_library(library, output, [])
            build_data["force_include"][str(built)] = built.relative_to(output).as_posix()
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Called by hatchling after the wheel is built."""
        if self.target_name == "wheel" and self._aside:
            shutil.rmtree(self._aside)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="compile the C libraries")
    parser.add_argument("--output", type=Path, default=ROOT, help="folder to build below")
    parser.add_argument("--sanitize", action="store_true", help="address, undefined behaviour")
    arguments = parser.parse_args()
    for library in LIBRARIES:
        print(compile_library(library, arguments.output, SANITIZE if arguments.sanitize else []))


if __name__ == "__main__":
    main()
