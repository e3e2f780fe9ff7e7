"""The core for derivatives beside the core: in one library, and on any platform."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from support.native.targets import DERIVATIVES, FLAGS, TARGETS, on_targets, require
from test_no_platform_maths import EXACT, MEMORY

ELEMENTARY = {"arc_cosine", "arc_sine", "arc_tangent", "exponential", "exponential_less_one"}
ELEMENTARY |= {"hyperbolic_tangent", "logarithm", "sine_cosine"}
"""Of plain numbers, below those of numbers with a tangent."""


def symbols(compiler: list[str], folder: Path) -> tuple[set[str], set[str]]:
    """External names that it defines, and those that it calls."""
    command = [*compiler, *FLAGS, "-O1", "-fno-stack-protector", "-c", DERIVATIVES]
    subprocess.run(command, cwd=folder, check=True)
    target = folder / "tangent.o"
    lines = subprocess.run(["nm", "-g", target], capture_output=True, text=True, check=True)
    words = [line.split() for line in lines.stdout.splitlines() if line and line[-1] != ":"]
    return {w[-1] for w in words if w[-2] != "U"}, {w[-1] for w in words if w[-2] == "U"}


@on_targets(["gcc -O2", "zig linux64"], quick="gcc -O2")
def test_names(target: str, tmp_path: Path) -> None:
    """All are its own; products and quotients of complex numbers call nothing."""
    require(TARGETS[target])
    defined, called = symbols(TARGETS[target].compiler, tmp_path)
    assert all(symbol.startswith("core_tangent_") for symbol in defined)
    allowed = EXACT | MEMORY | ELEMENTARY | {"_GLOBAL_OFFSET_TABLE_"}
    assert called - defined <= allowed


def test_every_law_is_there() -> None:
    """In one file with the rest, as docs/extend.md asks."""
    tangent = Path(DERIVATIVES)
    included = set(re.findall(r'#include "\.\./([^"]*\.c)"', tangent.read_text()))
    csrc = tangent.parents[1]
    assert {path.relative_to(csrc).as_posix() for path in csrc.rglob("law_*.c")} <= included
