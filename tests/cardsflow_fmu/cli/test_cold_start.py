"""Imports of the commands: libraries that a command does not need cost seconds at its start."""

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
    "viser",
    "pydantic",
    "fmpy",
    "dartpy",
    "numpy",
}
ARM = EXAMPLES / "roboy_left_arm"
SHORT = ("--set", "run.duration=0.02", "-o", "out")


def imported(words: tuple[str, ...], folder: Path) -> set[str]:
    """The heavy packages that a command has imported."""
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
def test_a_command_imports_what_it_needs(
    words: tuple[str, ...], needed: set[str], tmp_path: Path
) -> None:
    """A task position at the start, of which the joints are found, needs no SciPy."""
    assert imported(words, tmp_path) <= needed
