"""The house: floors, the add-in's independence, and names that others build on."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("addin_sdfusion", "cardsflow_fmu", "controllers", "sim_dart")


def test_import_contracts_hold() -> None:
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command as c; c()"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    ("module", "allowed"),
    [
        ("dartpy", "sim_dart/"),
        ("adsk", "addin_sdfusion/"),
        ("fmpy", "cardsflow_fmu/"),
        ("qpsolvers", "controllers/"),
        ("matplotlib", ("cardsflow_fmu/report/", "cardsflow_fmu/studies/analysis/plots.py")),
        ("tqdm", "cardsflow_fmu/cli/progress.py"),
        ("shtab", "cardsflow_fmu/cli/init.py"),
        ("rerun", "cardsflow_fmu/viewer/rerun_file.py"),
        ("viser", "cardsflow_fmu/viewer/live/live.py"),
        ("distributed", "cardsflow_fmu/studies/execution/dask_executor.py"),
        ("cmaes", "cardsflow_fmu/studies/execution/optimisers.py"),
    ],
)
def test_a_library_is_imported_in_its_room_only(
    module: str, allowed: str | tuple[str, ...]
) -> None:
    pattern = re.compile(rf"^\s*(import|from) {module}\b", re.MULTILINE)
    users = [
        file.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for file in (ROOT / package).rglob("*.py")
        if pattern.search(file.read_text())
    ]
    assert [user for user in users if not user.startswith(allowed)] == []


def test_names_that_others_build_on() -> None:
    import addin_sdfusion.robot
    import cardsflow_fmu
    import controllers
    import sim_dart

    for module, names in (
        (addin_sdfusion.robot, "Robot read_robot write_sdf write_caspr check"),
        (sim_dart, "DartDynamics Plant"),
        (controllers, "JointSpaceController ForceDistribution"),
        (cardsflow_fmu, "Experiment build run"),
    ):
        assert all(hasattr(module, name) for name in names.split())


def test_dependencies_are_bounded() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    for requirement in [*project["dependencies"], *extras["test"]]:
        assert re.search(r">=[\d.]+,<[\d.]+$", requirement), requirement
