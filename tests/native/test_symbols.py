"""Names in compiled C: what core and laws call, and what the core for derivatives defines."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from support.cases import LONG
from support.native.targets import (
    DERIVATIVES,
    FLAGS,
    ROOT,
    TARGETS,
    on_targets,
    require,
    run,
    single_flags,
)

from cardsflow_fmu.runtime.sources import CONTROL, CORE, Library
from controllers.qp import dual_newton
from sim_dart.core import library as core

EXACT = {"sqrt", "fmod", "ceil", "round"}
"""IEEE 754 rounds the first in one way, and the others are exact."""

OTHERS = {"memcpy", "memmove", "memset", "strcmp", "_GLOBAL_OFFSET_TABLE_"}
OF_COMPILERS = {"__stack_chk_fail", "__memcpy_chk", "__memset_chk", "__memmove_chk"}

ELEMENTARY = {"arc_cosine", "arc_sine", "arc_tangent", "exponential", "exponential_less_one"}
ELEMENTARY |= {"hyperbolic_tangent", "logarithm", "sine_cosine"}
"""Of plain numbers, below those of numbers with a tangent."""


def symbols(compiler: list[str], sources: list[str], folder: Path) -> tuple[set[str], set[str]]:
    """External names that files define, and those that they call."""
    if shutil.which("nm") is None:
        pytest.skip("no nm")
    command = [*compiler, *FLAGS, "-fno-stack-protector", "-c", *sources]
    subprocess.run(command, cwd=folder, check=True)
    lines = run(["nm", "-g", *sorted(folder.glob("*.o"))]).splitlines()
    words = [line.split() for line in lines if line and line[-1] != ":"]
    return {w[-1] for w in words if w[-2] != "U"}, {w[-1] for w in words if w[-2] == "U"}


@pytest.mark.parametrize("load", [core.library, dual_newton.library], ids=["core", "laws"])
def test_the_packages_libraries_call_no_function_of_the_platform(load: Callable[[], Any]) -> None:
    """But those whose answers are the same everywhere, and what compilers add for their own use."""
    if shutil.which("nm") is None or sys.platform != "linux":
        pytest.skip("no nm")
    if "CARDSFLOW_LIBRARY_DIR" in os.environ:
        pytest.skip("these libraries are not the package's")
    lines = run(["nm", "-D", "--undefined-only", load()._name]).splitlines()
    called = {name.partition("@")[0] for kind, name in map(str.split, lines) if kind == "U"}
    assert {"memcpy", "memset"} & called
    assert called <= EXACT | OTHERS | OF_COMPILERS


@LONG
@pytest.mark.slow
@pytest.mark.parametrize("single", [False, True], ids=["double", "single"])
@pytest.mark.parametrize("library", [CORE, CONTROL], ids=["core", "laws"])
def test_no_function_of_the_platform_is_called(
    library: Library, single: bool, tmp_path: Path
) -> None:
    """But those whose answers are the same everywhere."""
    target = TARGETS["gcc -O3"]
    require(target)
    sources = [str(ROOT / name) for name in library.sources()]
    own = single_flags(target) if single else ()
    defined, called = symbols([*target.compiler, *own], sources, tmp_path)
    assert called - defined <= {f"{name}f" if single else name for name in EXACT} | OTHERS


@on_targets(["gcc -O2"], long=["zig linux64"])
def test_names_of_the_core_for_derivatives(target: str, tmp_path: Path) -> None:
    """All are its own; products and quotients of complex numbers call nothing."""
    require(TARGETS[target])
    defined, called = symbols([*TARGETS[target].compiler, "-O1"], [DERIVATIVES], tmp_path)
    assert all(symbol.startswith("core_tangent_") for symbol in defined)
    assert called - defined <= EXACT | OTHERS | ELEMENTARY
