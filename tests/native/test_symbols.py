"""Symbols in compiled C: functions that core and laws call, and those of the core with tangents."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable
from typing import Any

import pytest
from support.cases import LONG
from support.native.targets import (
    DERIVATIVES,
    FLAGS,
    ROOT,
    TARGETS,
    Target,
    compiled,
    parametrize_targets,
    require,
    run,
    single_flags,
)

from cardsflow_fmu.runtime.sources import CONTROL, CORE, LIBRARIES, Library
from controllers.qp import dual_newton
from sim_dart.core import library as core

EXACT = {"sqrt", "fmod", "ceil", "round"}
"""IEEE 754 specifies the rounding of the first; the others are exact."""

OTHERS = {"memcpy", "memmove", "memset", "strcmp", "_GLOBAL_OFFSET_TABLE_"}
OF_COMPILERS = {"__stack_chk_fail", "__memcpy_chk", "__memset_chk", "__memmove_chk"}

ELEMENTARY = {"arc_cosine", "arc_sine", "arc_tangent", "exponential", "exponential_less_one"}
ELEMENTARY |= {"hyperbolic_tangent", "logarithm", "sine_cosine"}
SEARCH = {"taut_search", "taut_fields"}
"""For plain numbers; functions for numbers with a tangent call them."""


def symbols(compiler: list[str], sources: list[str]) -> tuple[set[str], set[str]]:
    """Return the external symbols that files define, and those that they call."""
    if shutil.which("nm") is None:
        pytest.skip("no nm")
    lines = run(["nm", "-g", *compiled(Target(compiler), FLAGS, sources)]).splitlines()
    words = [line.split() for line in lines if line and line[-1] != ":"]
    return {w[-1] for w in words if w[-2] != "U"}, {w[-1] for w in words if w[-2] == "U"}


@pytest.mark.parametrize("load", [core.library, dual_newton.library], ids=["core", "laws"])
def test_libraries_of_the_package_call_no_platform_function(load: Callable[[], Any]) -> None:
    """Exceptions: functions with platform-independent results, and functions added by compilers."""
    if shutil.which("nm") is None or sys.platform != "linux":
        pytest.skip("no nm")
    if "CARDSFLOW_LIBRARY_DIR" in os.environ:
        pytest.skip("these libraries are not part of the package")
    lines = run(["nm", "-D", "--undefined-only", load()._name]).splitlines()
    called = {name.partition("@")[0] for kind, name in map(str.split, lines) if kind == "U"}
    assert {"memcpy", "memset"} & called
    assert called <= EXACT | OTHERS | OF_COMPILERS


@LONG
@pytest.mark.slow
@pytest.mark.parametrize("single", [False, True], ids=["double", "single"])
@pytest.mark.parametrize("library", [CORE, CONTROL], ids=["core", "laws"])
def test_no_platform_function_is_called(library: Library, single: bool) -> None:
    """Exceptions: functions with platform-independent results."""
    target = TARGETS["gcc -O3"]
    require(target)
    sources = [str(ROOT / name) for name in library.sources()]
    own = single_flags(target) if single else ()
    defined, called = symbols([*target.compiler, *own], sources)
    assert (
        called - defined
        <= {f"{name}f" if single else name for name in EXACT} | OTHERS | OF_COMPILERS
    )


@parametrize_targets(["gcc -O1"], long=["zig linux64"])
def test_symbols_of_the_core_with_tangents(target: str) -> None:
    """All are prefixed; products and quotients of complex numbers call no function."""
    require(TARGETS[target])
    defined, called = symbols(TARGETS[target].compiler, [DERIVATIVES])
    assert all(symbol.startswith("core_tangent_") for symbol in defined)
    assert called - defined <= EXACT | OTHERS | OF_COMPILERS | ELEMENTARY | SEARCH


@pytest.mark.parametrize("library", LIBRARIES, ids=[one.target for one in LIBRARIES])
def test_libraries_have_no_variables_outside_of_instances(library: Library) -> None:
    """Therefore, instances in several threads are independent."""
    if shutil.which("readelf") is None or sys.platform != "linux":
        pytest.skip("no readelf")
    if "CARDSFLOW_LIBRARY_DIR" in os.environ:
        pytest.skip("sanitizers add variables")
    lines = run(["readelf", "-SW", ROOT / f"{library.target}.so"]).splitlines()
    rows = [line.partition("]")[2].split() for line in lines if "]" in line]
    sizes = {row[0]: int(row[4], 16) for row in rows if len(row) > 4 and row[0].startswith(".")}
    of_the_compiler = 8  # bytes in each section
    assert sizes.get(".data", 0) <= of_the_compiler
    assert sizes.get(".bss", 0) <= of_the_compiler
    assert not {".tdata", ".tbss"} & set(sizes)
