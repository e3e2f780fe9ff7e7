"""The house: floors, the add-in's independence, and names that others build on."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("addin_sdfusion", "cardsflow_fmu", "controllers", "sim_dart")
MAX_FILES = 16

_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
_DEFINITION = re.compile(r"^(?!static)[A-Za-z_][\w \t*]*?\b(\w+)\s*\([^;{}]*\)\s*\{", re.MULTILINE)
_CALL = re.compile(r"\b(\w+)\s*\(")


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
        (
            "matplotlib",
            ("cardsflow_fmu/results/report/", "cardsflow_fmu/studies/analysis/plots.py"),
        ),
        ("tqdm", "cardsflow_fmu/cli/terminal/progress.py"),
        ("shtab", "cardsflow_fmu/cli/setup/init.py"),
        ("mcap", "cardsflow_fmu/ros/mcap_file.py"),
        ("rosbags", "cardsflow_fmu/ros_interface/message_types.py"),
        ("rclpy", "cardsflow_fmu/ros_interface/rclpy_node.py"),
        ("mujoco", "addin_sdfusion/robot/formats/mjcf/compiler.py"),
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


JSON_WRITERS = {
    "addin_sdfusion/robot/json_text.py",
    "addin_sdfusion/robot/formats/mjcf/compiler.py",  # a program that imports nothing of ours
}


@pytest.mark.parametrize(("call", "places"), [("json.dump", JSON_WRITERS)], ids=["json"])
def test_what_is_done_in_one_place_only(call: str, places: set[str]) -> None:
    users = {
        file.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for file in (ROOT / package).rglob("*.py")
        if call in file.read_text()
    }
    assert users == places


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


def test_no_folder_is_too_full() -> None:
    """A newcomer takes in about fifteen files at a glance."""
    files = Counter(
        file.parent.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for file in (ROOT / package).rglob("*.*")
        if file.suffix in (".py", ".c", ".h")
    )
    assert {folder: n for folder, n in files.items() if n > MAX_FILES} == {}
    assert len(list((ROOT / "cardsflow_fmu").glob("*.py"))) <= 3


def test_names_of_test_files_are_unique() -> None:
    """Tests are modules of the top level: pytest collects nothing if two share a name."""
    names = Counter(file.name for file in (ROOT / "tests").rglob("test_*.py"))
    assert [name for name, count in names.items() if count > 1] == []


def test_c_files_call_and_include_without_circles() -> None:
    """A source and its header count as one; import-linter holds the same for Python."""
    graph = _c_graph()
    assert sum(map(len, graph.values())) > 100  # it did find the includes and calls
    assert [unit for unit in graph if unit in _reached(graph, unit)] == []


def _c_graph() -> dict[str, set[str]]:
    """What each C unit includes, or calls where one unit alone defines the name."""
    sources = {
        file.relative_to(ROOT): _COMMENT.sub(" ", file.read_text())
        for package in PACKAGES
        for file in (ROOT / package).rglob("*.[ch]")
    }
    owners: dict[str, set[str]] = {}
    for path, text in sources.items():
        for name in _DEFINITION.findall(text) if path.suffix == ".c" else ():
            owners.setdefault(name, set()).add(_unit(path))
    graph: dict[str, set[str]] = {_unit(path): set() for path in sources}
    for path, text in sources.items():
        included = {_unit(Path(os.path.normpath(path.parent / i))) for i in _INCLUDE.findall(text)}
        called = set(_CALL.findall(text)) if path.suffix == ".c" else set()
        alone = {unit for name in called for unit in _only(owners.get(name, set()))}
        graph[_unit(path)] |= (included | alone) - {_unit(path)}
    return graph


def _only(owners: set[str]) -> set[str]:
    return owners if len(owners) == 1 else set()


def _unit(path: Path) -> str:
    return path.with_suffix("").as_posix()


def _reached(graph: dict[str, set[str]], start: str) -> set[str]:
    found: set[str] = set()
    waiting = [start]
    while waiting:
        new = graph.get(waiting.pop(), set()) - found
        found |= new
        waiting += new
    return found
