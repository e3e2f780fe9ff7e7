"""Compiles the C libraries when the package is built; also a script for the sanitized build.

First it generates headers from the tables of muscle laws and control laws, in folders `generated`.

The compiler is the system's (`CC`, cc, gcc, clang). If there is none, or with `CC=ziglang`, it is
that of the package `ziglang`, which then becomes a build requirement. The libraries need only libc
and libm, so the same files work with every Python.

The environment variable `CARDSFLOW_PLATFORMS` names further platforms of a wheel, for which ziglang
compiles the library of native FMUs: `all`, or names such as `x86_64-linux,x86_64-windows`. This
takes some minutes the first time, since ziglang also compiles the C libraries of the platforms.
`wasm32` is the module for browsers; in a source tree, `cardsflow play` compiles it once.

    python hatch_build.py                            into the source tree
    python hatch_build.py --platforms all            and for the other platforms
    python hatch_build.py --sanitize --output DIR    with the address and UB sanitizers
    python hatch_build.py --sanitize thread --output DIR    with the thread sanitizer
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
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

try:
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface
except ImportError:  # run as a script
    BuildHookInterface = object  # type: ignore[assignment, misc]

ROOT = Path(__file__).parent


def _read(path: str) -> ModuleType:
    """Import a module from its file, since its package cannot be imported yet."""
    name = f"cardsflow_{Path(path).stem.strip('_')}"
    file = ROOT / path
    inside = [str(file.parent)] if file.name == "__init__.py" else None
    spec = importlib.util.spec_from_file_location(name, file, submodule_search_locations=inside)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look up their module
    spec.loader.exec_module(module)
    return module


_SOURCES = _read("cardsflow_fmu/runtime/sources.py")  # the sources of the libraries
_HEADERS = _read("sim_dart/muscles/law_headers.py")
_JOINT_LAWS = _read("controllers/laws/joint_laws.py")
EXAMPLES = "cardsflow_fmu/examples_data"
"""Folder of the examples in a wheel; `cardsflow examples` reads it."""

LIBRARIES = _SOURCES.LIBRARIES
FLAGS = [*_SOURCES.FLAGS, *_SOURCES.WARNINGS]
SANITIZE = {
    "address": ["-O0", "-g1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"],
    "thread": ["-O1", "-g1", "-fsanitize=thread"],
}
SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


def write_headers() -> list[Path]:
    """Write the C headers with the tables of laws into the source tree; return their paths.

    A header whose text has not changed keeps its time.
    """
    table = _read(f"{_HEADERS.TABLE}/__init__.py")
    try:
        texts = _HEADERS.headers(table.MUSCLE_LAWS, table.LAW_NAMES, ROOT)
        texts[_JOINT_LAWS.C_LIST] = _JOINT_LAWS.c_list(ROOT)
    except ValueError as error:
        sys.exit(str(error))
    for name, text in texts.items():
        path = ROOT / name
        path.parent.mkdir(exist_ok=True)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
    return [ROOT / name for name in texts]


def system_compiler() -> list[str] | None:
    """Return the command of the system's C compiler, or None."""
    chosen = os.environ.get("CC")
    if chosen:
        return None if chosen == "ziglang" else shlex.split(chosen)
    for name in ("cc", "gcc", "clang"):
        if shutil.which(name):
            return [name]
    return None


@cache
def compiler() -> list[str]:
    """Return the command of the C compiler: the system's, or else ziglang's."""
    of_system = system_compiler()
    if of_system:
        return of_system
    package = importlib.util.find_spec("ziglang")
    if package and package.origin:
        # hundreds of calls: Python would start before each of them
        return [str(Path(package.origin).with_name("zig")), "cc"]
    sys.exit("no C compiler: install gcc or clang, or `pip install ziglang`")


def platform_flags(is_small: bool) -> list[str]:
    """Return the compiler flags that depend on the system."""
    if sys.platform == "win32":
        return []
    if sys.platform == "darwin":
        return ["-fPIC"]
    return ["-fPIC", *(_SOURCES.NO_UNWINDING if is_small else ()), "-D_GNU_SOURCE"]


def link_flags(library: Any, is_small: bool, folder: Path) -> list[str]:
    """Return the flags of the linker; `folder` is for a file that it reads."""
    if sys.platform == "win32":
        return ["-shared"]
    if sys.platform == "darwin":
        return ["-shared", *(f"-Wl,-exported_symbol,_{name}" for name in library.exports)]
    flags = ["-shared", *(["-s", "-Wl,--gc-sections"] if is_small else [])]
    if library.exports:
        script = folder / f"{Path(library.target).name}.map"
        script.write_text(f"{{ global: {'; '.join(library.exports)}; local: *; }};\n", "utf-8")
        flags.append(f"-Wl,--version-script={script}")
    return [*flags, "-lm", "-ldl", "-lpthread"]


def compile_libraries(output: Path, extra: Sequence[str] = ()) -> list[Path]:
    """Compile the libraries of this platform below `output`, on all processors.

    Files that several libraries contain are compiled once for each set of flags. Compilers run at
    the root with relative paths, so that their caches hold for every clone.
    """
    with ThreadPoolExecutor(os.cpu_count()) as pool, tempfile.TemporaryDirectory() as folder:

        @cache
        def compiled(source: str, flags: tuple[str, ...]) -> Future[str]:
            file = f"{folder}/{Path(source).stem}{'_small' if _SOURCES.SMALL[0] in flags else ''}.o"
            command = [*compiler(), *flags, "-c", source, "-o", file]
            return pool.submit(lambda: _run(command, ROOT) or file)

        def link(library: Any) -> list[Path]:
            is_small = library is _SOURCES.NATIVE and not extra
            flags = (*_flags(is_small, extra), *platform_flags(is_small))
            fingerprint = f"{library.fingerprint(ROOT)} {_version()} {flags}\n"

            def command_for(aside: Path) -> list[str]:
                objects = [compiled(name, flags) for name in library.sources(ROOT)]
                linked = (*(one.result() for one in objects), "-o", str(aside))
                return [*compiler(), *flags, *linked, *link_flags(library, is_small, Path(folder))]

            return _take_or_make(library.target + SUFFIX, output, fingerprint, command_for)

        return [file for library in LIBRARIES for file in link(library)]


def _flags(is_small: bool, extra: Sequence[str]) -> list[str]:
    of_user = shlex.split(os.environ.get("CARDSFLOW_CFLAGS", ""))
    return [*FLAGS, *(_SOURCES.SMALL if is_small else ()), *of_user, *extra]


@cache
def _version() -> str:
    """Return the version of the compiler, as it prints it."""
    command = [*compiler(), "--version"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout


def compile_prebuilt(platform: str, output: Path) -> list[Path]:
    """Compile the library of native FMUs for a platform, by FMI 3.0's name; returns its files."""
    if platform == _SOURCES.WASM:
        return compile_wasm(output)
    native = _SOURCES.NATIVE
    name = f"{_SOURCES.PREBUILT}/{platform}{_SOURCES.TARGETS[platform].suffix}"
    return _take_or_make(
        name,
        output,
        f"{native.fingerprint(ROOT)}\n",
        lambda aside: _SOURCES.cross_command(native, platform, aside),
    )


def compile_wasm(output: Path) -> list[Path]:
    """Compile the WebAssembly module of pages that simulate; returns its files."""
    module = _SOURCES.BROWSER
    name, fingerprint = f"{module.target}.wasm", f"{module.fingerprint(ROOT)}\n"
    return _take_or_make(name, output, fingerprint, _SOURCES.wasm_command)


def compile_all_prebuilt(platforms: list[str], output: Path) -> list[Path]:
    """Compile the libraries of several platforms on all processors; return their files."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        made = pool.map(lambda platform: compile_prebuilt(platform, output), platforms)
        return [file for files in made for file in files]


def parse_platforms(names: str) -> list[str]:
    """Return the platforms of a text: `all`, or names separated by commas; none if it is empty."""
    known = (*_SOURCES.PREBUILT_PLATFORMS, _SOURCES.WASM)
    platforms = list(known) if names == "all" else [name for name in names.split(",") if name]
    unknown = sorted(set(platforms) - set(known))
    if unknown:
        sys.exit(f"no platform {', '.join(unknown)}; platforms: {', '.join(known)}, or all")
    return platforms


def example_files() -> dict[Path, str]:
    """Return the files of the examples with their paths in a wheel: no results, no caches."""
    root = ROOT / "examples"
    return {
        file: f"{EXAMPLES}/{file.relative_to(root).as_posix()}"
        for file in sorted(root.rglob("*"))
        if file.is_file()
        and file.suffix not in (".fmu", ".pyc", ".so", ".dll", ".dylib")
        and not any(
            part in ("results", "__pycache__") or part.startswith(".")
            for part in file.relative_to(root).parts
        )
    }


def _take_or_make(
    name: str, output: Path, fingerprint: str, command_for: Callable[[Path], list[str]]
) -> list[Path]:
    """Compile a file below `output`, with its fingerprint in a file next to it; return both.

    A file in the source tree with the same fingerprint is copied instead.
    """
    file, existing = output / name, ROOT / name
    mark, existing_mark = file.with_suffix(".sha256"), existing.with_suffix(".sha256")
    is_made = existing.is_file() and existing_mark.is_file()
    if is_made and existing_mark.read_text("utf-8") == fingerprint:
        if output.resolve() != ROOT.resolve():
            file.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(existing, file)
    else:
        mark.unlink(missing_ok=True)
        _make(file, command_for)
    mark.write_text(fingerprint, "utf-8")
    return [file, mark]


def _make(target: Path, command_for: Callable[[Path], list[str]]) -> None:
    """Run a compiler.

    It writes into a temporary folder, since linkers may write further files. The result is then
    moved, so that a running program keeps the file that it has open.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent) as folder:
        aside = Path(folder, target.name)
        _run(command_for(aside), ROOT)
        aside.replace(target)


def _run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{shlex.join(command)}\n{done.stdout}{done.stderr}")
    sys.stderr.write(done.stderr)


class CustomBuildHook(BuildHookInterface):  # type: ignore[type-arg, unused-ignore]
    """Compiles the libraries: into the source tree for an editable install, else into the wheel."""

    def dependencies(self) -> list[str]:
        """Require ziglang if the system has no C compiler, and for other platforms."""
        needed = not system_compiler() or os.environ.get("CARDSFLOW_PLATFORMS")
        return ["ziglang>=0.13,<1"] if needed else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile the libraries; hatchling calls this before it builds any kind of wheel."""
        if self.target_name != "wheel":
            return
        self._temporary = None if version == "editable" else tempfile.mkdtemp()
        output = Path(self._temporary or ROOT)
        platforms = parse_platforms(os.environ.get("CARDSFLOW_PLATFORMS", ""))
        headers = write_headers()
        compiled = compile_libraries(output)
        compiled += compile_all_prebuilt(platforms, output)
        for folder, files in ((ROOT, headers), (output, compiled)):
            for file in files:
                build_data["force_include"][str(file)] = file.relative_to(folder).as_posix()
        if version != "editable":
            for file, target in example_files().items():
                build_data["force_include"][str(file)] = target
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove temporary files; hatchling calls this after it has built a wheel."""
        if self.target_name == "wheel" and self._temporary:
            shutil.rmtree(self._temporary)


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description="compile the C libraries")
    parser.add_argument("--output", type=Path, default=ROOT, help="folder to build below")
    parser.add_argument(
        "--sanitize",
        nargs="?",
        const="address",
        choices=tuple(SANITIZE),
        help="address, which also finds undefined behaviour, or thread (default: address)",
    )
    parser.add_argument(
        "--platforms", default="", help="for native FMUs: all, or x86_64-windows, ...; by ziglang"
    )
    arguments = parser.parse_args()
    write_headers()
    made = compile_libraries(arguments.output, SANITIZE.get(arguments.sanitize, ()))
    made += compile_all_prebuilt(parse_platforms(arguments.platforms), arguments.output)
    print(*made, sep="\n")


if __name__ == "__main__":
    main()
