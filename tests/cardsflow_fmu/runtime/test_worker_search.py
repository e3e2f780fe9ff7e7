"""Search for the Python of a worker process, and the message if the search fails."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest
from support.fmu.fmu_host import cannot_open, opened, plain_run

from cardsflow_fmu.version import __version__

pytestmark = [
    pytest.mark.native,
    pytest.mark.skipif(sys.platform == "win32", reason="scripts replace Python interpreters"),
]


@pytest.fixture(autouse=True)
def worker(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run models in worker processes; CARDSFLOW_PYTHON is not set."""
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", "worker")
    for name in ("CARDSFLOW_PYTHON", "VIRTUAL_ENV"):
        monkeypatch.delenv(name, raising=False)


def script(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


def proxy(path: Path, record: Path) -> Path:
    """Create a script that starts this Python and records that it was started."""
    return script(path, f'echo started >> {record}\nexec {sys.executable} "$@"')


def runs(folder: Path) -> None:
    with opened(folder) as (host,):
        host.start()
        assert (host.drive(0, 5) == plain_run(5)).all()


def test_builder_is_recorded(toy_fmu: Path) -> None:
    assert (toy_fmu / "resources/python.txt").read_text() == f"{sys.executable}\n"


@pytest.mark.slow
@pytest.mark.parametrize("variable", ["CARDSFLOW_PYTHON", "VIRTUAL_ENV", "PATH"])
def test_python_of_a_variable_is_used(
    variable: str, damaged: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The worker uses CARDSFLOW_PYTHON, then the recorded Python, then the other variables."""
    folder, recorded = tmp_path / "bin", damaged / "resources/python.txt"
    python = proxy(folder / "python", tmp_path / "record")
    shutil.copy(python, folder / "python3")
    if variable == "VIRTUAL_ENV":
        recorded.write_text("/no/such/python\n")
    elif variable == "PATH":
        recorded.unlink()
    path = f"{folder}{os.pathsep}{os.environ['PATH']}"
    values = {"CARDSFLOW_PYTHON": python, "VIRTUAL_ENV": tmp_path, "PATH": path}
    monkeypatch.setenv(variable, str(values[variable]))
    runs(damaged)
    assert (tmp_path / "record").read_text() == "started\n"


@pytest.mark.slow
def test_python_without_the_package_is_skipped(
    damaged: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bare = script(tmp_path / "bare", f'shift\nexec {sys.executable} -I -S "$@"')
    (damaged / "resources/python.txt").write_text(f"{bare}\n")
    monkeypatch.setenv("VIRTUAL_ENV", sys.prefix)
    runs(damaged)


def test_candidates_are_reported_in_one_line(
    damaged: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (damaged / "resources/python.txt").write_text("/no/such/python\n")
    script(tmp_path / "environment/bin/python", f'shift\nexec {sys.executable} -I -S "$@"')
    monkeypatch.setenv("VIRTUAL_ENV", str(tmp_path / "environment"))
    script(tmp_path / "bin/python3", "exit 3")
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}")
    assert cannot_open(damaged) == (
        f"no Python with the package cardsflow {__version__}; tried "
        "/no/such/python (recorded in the FMU): cannot be started: No such file or directory; "
        f"{tmp_path}/environment/bin/python (VIRTUAL_ENV): "
        "ModuleNotFoundError: No module named 'cardsflow_fmu'; "
        "python3 (on the path): the worker process has ended with exit code 3"
    )


def test_named_python_is_the_only_candidate(toy_fmu: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CARDSFLOW_PYTHON", "/no/such/python")
    message = cannot_open(toy_fmu)
    assert "/no/such/python (CARDSFLOW_PYTHON): cannot be started" in message
    assert "recorded" not in message


def test_other_version_of_the_package_is_reported(
    damaged: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "other/cardsflow_fmu"
    shutil.copytree(Path(__file__).parents[3] / "cardsflow_fmu", package)
    (package / "version.py").write_text('__version__ = "99.0"\n')
    text = f"import sys; sys.path.insert(0, {str(package.parent)!r}); sys.argv = sys.argv[1:]"
    start = script(
        tmp_path / "python",
        f'shift 2\nprogram="$1"; shift\nexec {sys.executable} -E -c "{text}; exec(sys.argv[0])" '
        '"$program" "$@"',
    )
    monkeypatch.setenv("CARDSFLOW_PYTHON", str(start))
    message = cannot_open(damaged)
    assert message.endswith(f"{start} (CARDSFLOW_PYTHON): has cardsflow 99.0")


def test_python_that_does_not_answer_is_reported(
    toy_fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CARDSFLOW_FMU_START_TIMEOUT", "0.3")
    monkeypatch.setenv("CARDSFLOW_PYTHON", str(script(tmp_path / "slow", "exec sleep 1000")))
    assert cannot_open(toy_fmu).endswith("no answer from the worker process within 0.3 s")


@pytest.mark.slow
def test_current_folder_is_not_imported(
    toy_fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("ctypes", "numpy", "cardsflow_fmu"):
        (tmp_path / f"{name}.py").write_text("raise ImportError('from the current folder')\n")
    monkeypatch.chdir(tmp_path)
    runs(toy_fmu)
