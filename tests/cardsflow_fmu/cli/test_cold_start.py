"""Imports of the commands. Unnecessary imports would take seconds."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from support.robots.robots import EXAMPLES

HEAVY = {
    "scipy",
    "control",
    "qpsolvers",
    "matplotlib",
    "pandas",
    "pyarrow",
    "dask",
    "trimesh",
    "pydantic",
    "fmpy",
    "dartpy",
    "numpy",
}
ARM = EXAMPLES / "roboy_left_arm"
SHORT = ("--set", "run.duration=0.02", "-o", "out")


def imported_packages(words: tuple[str, ...], folder: Path) -> set[str]:
    """Return the large packages that a command imports."""
    command = [sys.executable, "-X", "importtime", "-m", "cardsflow_fmu.cli", *words]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    names = re.findall(r"^import time:.*\| +([\w.]+)$", done.stderr, re.MULTILINE)
    return {name.partition(".")[0] for name in names} & HEAVY


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "needed"),
    [
        (("--version",), set()),
        (("check", str(ARM / "robot")), {"numpy", "pydantic", "scipy"}),
        (("build", str(ARM), "-o", "out"), {"numpy", "pydantic", "fmpy"}),
        (("run", str(ARM), *SHORT), {"numpy", "pydantic", "fmpy", "matplotlib"}),
        (("info", str(ARM / "robot")), {"numpy"}),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_command_only_imports_required_libraries(
    words: tuple[str, ...], needed: set[str], tmp_path: Path
) -> None:
    """The inverse kinematics of a task position at the start requires no SciPy."""
    assert imported_packages(words, tmp_path) <= needed
