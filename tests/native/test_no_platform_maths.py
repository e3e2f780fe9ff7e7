"""Core and laws call no function of the platform whose answer may differ from another's."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from support.cases import few
from support.native.targets import FLAGS, ROOT, TARGETS, single_flags

from cardsflow_fmu.runtime.sources import CONTROL, CORE, Library

EXACT = {"sqrt", "fmod", "ceil", "round"}
"""IEEE 754 rounds the first in one way, and the others are exact."""

MEMORY = {"memcpy", "memmove", "memset", "strcmp"}


@pytest.mark.parametrize("single", few([False, True]), ids=["double", "single"])
@pytest.mark.parametrize("library", [CORE, CONTROL], ids=["core", "laws"])
def test_nothing_else_is_called(library: Library, single: bool, tmp_path: Path) -> None:
    if shutil.which("gcc") is None or shutil.which("nm") is None:
        pytest.skip("no gcc, or no nm")
    sources = [str(ROOT / name) for name in library.sources()]
    own = single_flags(TARGETS["gcc -O3"]) if single else ()
    command = ["gcc", *FLAGS, *own, "-O3", "-fno-stack-protector", "-c", *sources]
    subprocess.run(command, cwd=tmp_path, check=True)
    objects = [str(path) for path in sorted(tmp_path.glob("*.o"))]
    lines = subprocess.run(["nm", *objects], capture_output=True, text=True, check=True).stdout
    symbols = [line.split() for line in lines.splitlines() if line and not line.endswith(":")]
    called = {words[-1] for words in symbols if words[-2] == "U"}
    own = {words[-1] for words in symbols if words[-2] != "U"}
    assert (
        called - own - {"_GLOBAL_OFFSET_TABLE_"}
        <= {f"{name}f" if single else name for name in EXACT} | MEMORY
    )
