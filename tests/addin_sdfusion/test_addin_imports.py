"""Tests that the add-in can be imported like in Fusion: by folder, renamed, without packages."""

from __future__ import annotations

import ast
import json
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ADDIN = ROOT / "addin_sdfusion"
NAME = "__main__C%3A%2FAddIns%2Faddin_sdfusion_py"

SCRIPT = """
import importlib, importlib.util, json, sys
from pathlib import Path

folder, name, files, others = Path(sys.argv[1]), sys.argv[2], *map(json.loads, sys.argv[3:5])

if others:  # paths of the fake and numpy; removed before the add-in is imported
    sys.path[:0] = others
    from fake_fusion.install import adsk_modules
    adsk = adsk_modules()
    standard = {*sys.stdlib_module_names, "__main__"}
    for module in list(sys.modules):
        if module.partition(".")[0] not in standard:
            del sys.modules[module]
    sys.modules.update(adsk)
    del sys.path[: len(others)]

class OnlyStandard:
    def find_spec(self, module, path=None, target=None):
        if module.partition(".")[0] not in {*sys.stdlib_module_names, name}:
            raise ImportError(f"{module} is not in the standard library")

sys.meta_path.insert(0, OnlyStandard())
spec = importlib.util.spec_from_file_location(
    name, folder / "__init__.py", submodule_search_locations=[str(folder)]
)
package = importlib.util.module_from_spec(spec)
sys.modules[name] = package
spec.loader.exec_module(package)
for file in files:
    imported = importlib.import_module(f"{name}.{file}")
    assert imported.__file__.startswith(str(folder)), imported.__file__
assert not any(m.partition(".")[0] == "addin_sdfusion" for m in sys.modules), "absolute import"
print(len(files))
"""


def modules() -> dict[str, bool]:
    """Return all modules except file readers of `robot`, and whether each requires adsk."""
    found = {}
    for file in sorted(ADDIN.rglob("*.py")):
        parts = file.relative_to(ADDIN).with_suffix("").parts
        if parts == ("__init__",) or (parts[0] == "robot" and _reads(file)):
            continue
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        found[name] = _needs("adsk", file, set())
    return found


def _reads(file: Path) -> bool:
    """Return whether a file belongs to the readers, which may use lxml and MuJoCo."""
    return _needs("lxml", file, set()) or _needs("mujoco", file, set())


def _needs(package: str, file: Path, seen: set[Path]) -> bool:
    """Return whether a file imports a package, directly or through another file."""
    seen.add(file)
    packages, others = _imports(file)
    return package in packages or any(
        _needs(package, other, seen) for other in others if other not in seen
    )


@cache
def _imports(file: Path) -> tuple[set[str], tuple[Path, ...]]:
    """Return the packages and the files that a file imports."""
    packages: set[str] = set()
    others: list[Path] = []
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            packages |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level:
            base = file.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            for target in (base, *(base / alias.name for alias in node.names)):
                others += [target.with_suffix(".py"), target / "__init__.py"]
        elif isinstance(node, ast.ImportFrom):
            packages.add((node.module or "").partition(".")[0])
    return packages, tuple(other for other in others if other.is_file())


def run(python: str, names: list[str], others: list[str]) -> subprocess.CompletedProcess[str]:
    command = [python, "-I", "-S", "-B", "-c", SCRIPT, str(ADDIN), NAME]
    command += [json.dumps(names), json.dumps(others)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)


@pytest.mark.slow
def test_every_module_imports_with_the_standard_library_and_adsk() -> None:
    names = list(modules())
    assert len(names) > 50
    others = [
        str(ROOT / "tests/support"),
        str(ROOT),
        *(p for p in sys.path if p.endswith("-packages")),
    ]
    done = run(sys.executable, names, others)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [str(len(names))]


@pytest.mark.parametrize("version", ["3.11", "3.12", "3.13", "3.14"])
def test_modules_without_adsk_import_in_every_python_version_of_fusion(version: str) -> None:
    python = shutil.which(f"python{version}")
    if python is None or subprocess.run([python, "-V"], capture_output=True).returncode:
        pytest.skip(f"Python {version} is not available")
    names = [name for name, needs in modules().items() if not needs]
    assert {"snapshot", "robot.errors", "robot.formats.sdf.write"} <= set(names)
    assert "fusion.design" not in names
    done = run(python, names, [])
    assert done.returncode == 0, done.stderr


def test_a_module_that_requires_a_package_is_detected() -> None:
    """The import hook rejects packages that Fusion's Python does not have."""
    script = SCRIPT.replace("for file in files:", "import numpy\nfor file in files:")
    command = [sys.executable, "-I", "-S", "-c", script, str(ADDIN), NAME, "[]", "[]"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "numpy is not in the standard library" in done.stderr


def test_only_fusion_and_commands_import_adsk() -> None:
    for file in ADDIN.rglob("*.py"):
        name = file.relative_to(ADDIN).as_posix()
        if "adsk" in _imports(file)[0]:
            assert name == "addin_sdfusion.py" or name.startswith(("commands/", "fusion/")), name
