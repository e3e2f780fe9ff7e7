"""The core for derivatives beside the core: in one library, and on any platform."""

from __future__ import annotations

import subprocess
from pathlib import Path

from targets import ALONG, FLAGS, TARGETS, on_targets, require
from test_no_platform_maths import EXACT, MEMORY

ELEMENTARY = {"arc_cosine", "arc_sine", "arc_tangent", "exponential", "exponential_less_one"}
ELEMENTARY |= {"hyperbolic_tangent", "logarithm", "sine_cosine"}
"""Of plain numbers, below those that carry a derivative along."""


def symbols(compiler: list[str], folder: Path) -> tuple[set[str], set[str]]:
    """External names that it defines, and those that it calls."""
    sources = [str(path) for path in sorted(ALONG.glob("*.c"))]
    command = [*compiler, *FLAGS, "-O1", "-fno-stack-protector", "-c", *sources]
    subprocess.run(command, cwd=folder, check=True)
    objects = [str(path) for path in folder.glob("*.o")]
    lines = subprocess.run(["nm", "-g", *objects], capture_output=True, text=True, check=True)
    words = [line.split() for line in lines.stdout.splitlines() if line and line[-1] != ":"]
    return {w[-1] for w in words if w[-2] != "U"}, {w[-1] for w in words if w[-2] == "U"}


@on_targets(["gcc -O2", "zig linux64"], quick="gcc -O2")
def test_names(target: str, tmp_path: Path) -> None:
    """All are its own; products and quotients of complex numbers call nothing."""
    require(TARGETS[target])
    defined, called = symbols(TARGETS[target].compiler, tmp_path)
    assert all(symbol.startswith(("along_", "core_along_")) for symbol in defined)
    allowed = EXACT | MEMORY | ELEMENTARY | {"refuse", "_GLOBAL_OFFSET_TABLE_"}
    assert called - defined <= allowed


def test_every_law_is_there() -> None:
    """A law's file without its twin would only be missed by the linker of the FMUs."""
    twins = {path.name for path in ALONG.glob("*.c")}
    laws = {path.name for path in ALONG.parent.glob("law_*.c")}
    assert laws <= twins
