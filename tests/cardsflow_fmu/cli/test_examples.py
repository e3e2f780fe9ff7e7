"""`cardsflow examples`, and the wheel that contains them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES

SOURCE_TREE = EXAMPLES.parent
LIBRARIES = ("sim_dart/lib", "controllers/lib", "cardsflow_fmu/runtime/lib")
MARK = "sim_dart/lib/cardsflow_core.sha256"
"""File that contains the compiler flags of a library."""
MAX_WHEEL = 8 * 2**20
"""Maximum size of a wheel for one platform, in bytes."""


def test_list_prints_every_example_with_its_title(cardsflow: CommandLine) -> None:
    names = [folder.name for folder in sorted(EXAMPLES.iterdir()) if folder.is_dir()]
    listed = cardsflow.json("examples", "list")["examples"]
    assert list(listed) == names
    assert all(listed.values())
    code, out, _ = cardsflow("examples", "list")
    assert code == 0
    assert [line.split()[0] for line in out.splitlines()] == names


def test_copy_includes_the_examples_that_an_example_uses(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    copied = cardsflow.json("examples", "copy", "two_arms", tmp_path)["files"]
    assert copied == [str(tmp_path / "two_arms"), str(tmp_path / "pick_up")]
    assert cardsflow("check", tmp_path / "two_arms", "--quiet")[0] == 0
    copied = cardsflow.json("examples", "copy", "no_joint_encoders", tmp_path / "new")["files"]
    assert [Path(folder).name for folder in copied] == ["no_joint_encoders", "roboy_left_arm"]


def test_copy_keeps_existing_folders(tmp_path: Path, cardsflow: CommandLine) -> None:
    mine = tmp_path / "pick_up/experiment.toml"
    mine.parent.mkdir()
    mine.write_text("mine")
    line = cardsflow.error_line("examples", "copy", "pick_up", tmp_path)
    assert f"{tmp_path / 'pick_up'}: already exists; choose another folder" in line
    code, out, err = cardsflow("examples", "copy", "two_arms", tmp_path)
    assert (code, out) == (0, f"{tmp_path / 'two_arms'}\n")
    assert "pick_up already exists and is used as it is" in err
    assert mine.read_text() == "mine"


def test_copy_suggests_the_nearest_example(tmp_path: Path, cardsflow: CommandLine) -> None:
    line = cardsflow.error_line("examples", "copy", "planar2r", tmp_path)
    assert "did you mean 'planar_2r'?" in line


def test_copy_omits_results_and_caches(
    tmp_path: Path, cardsflow: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    examples = tmp_path / "examples"
    shutil.copytree(EXAMPLES / "planar_2r", examples / "planar_2r")
    for name in ("results/results.csv", "__pycache__/a.pyc", ".lock"):
        file = examples / "planar_2r" / name
        file.parent.mkdir(exist_ok=True)
        file.touch()
    monkeypatch.setattr("cardsflow_fmu.cli.setup.examples.examples_folder", lambda: examples)
    assert cardsflow("examples", "copy", "planar_2r", tmp_path)[0] == 0
    names = {file.name for file in (tmp_path / "planar_2r").iterdir()}
    assert "experiment.toml" in names
    assert not names & {"results", "__pycache__", ".lock"}


# The wheel


@pytest.fixture(scope="module")
def dist(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Build the sdist, and the wheel from its files; return their folder.

    The wheel contains the compiled libraries of this source tree if the sdist has the same sources.
    """
    if shutil.which("uv") is None:
        pytest.skip("no uv")
    folder = tmp_path_factory.mktemp("dist")
    _build("--sdist", "-o", folder, SOURCE_TREE)
    (sdist,) = folder.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        archive.extractall(folder, filter="data")
    unpacked = sdist.with_suffix("").with_suffix("")
    for library in LIBRARIES:
        others = shutil.ignore_patterns("prebuilt")
        shutil.copytree(SOURCE_TREE / library, unpacked / library, ignore=others)
    warnings = "-Werror" if "-Werror" in (unpacked / MARK).read_text(encoding="utf-8") else ""
    _build("--wheel", "-o", folder, unpacked, CARDSFLOW_CFLAGS=warnings)
    yield folder
    shutil.rmtree(folder)


def _build(*options: str | Path, **environment: str) -> None:
    done = subprocess.run(
        ["uv", "build", "-q", *options],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode and "hatchling" in done.stderr and "fetch" in done.stderr:
        pytest.skip("no hatchling")
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_wheel_contains_libraries_and_examples_but_no_results(dist: Path) -> None:
    (wheel,) = dist.glob("*.whl")
    assert len(list(dist.glob("*.tar.gz"))) == 1
    assert wheel.stat().st_size < MAX_WHEEL
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    examples = [name for name in names if name.startswith("cardsflow_fmu/examples_data/")]
    assert "cardsflow_fmu/examples_data/planar_2r/experiment.toml" in examples
    assert not any("/results/" in name or "__pycache__" in name for name in examples)
    assert sum("/lib/cardsflow_" in name for name in names) >= 4


@pytest.mark.slow
def test_wheel_runs_an_example_without_the_source_tree(dist: Path, tmp_path: Path) -> None:
    """The dependencies come from the environment of the tests, so that no network is required."""
    (wheel,) = dist.glob("*.whl")
    venv, work = tmp_path / "venv", tmp_path / "work"
    work.mkdir()
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", venv], check=True)
    python = venv / "bin/python"
    install = ["uv", "pip", "install", "-q", "--no-deps", "--python", python, wheel]
    subprocess.run(install, check=True)
    site = next(venv.glob("lib/python*/site-packages"))
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}

    def cardsflow(*words: str) -> str:
        done = subprocess.run(
            [venv / "bin/cardsflow", *words],
            cwd=work,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    where = "import cardsflow_fmu; print(cardsflow_fmu.__file__)"
    found = subprocess.run(
        [python, "-c", where], cwd=work, env=environment, capture_output=True, text=True, check=True
    )
    assert found.stdout.startswith(str(site))
    assert "planar_2r" in cardsflow("examples", "list")
    cardsflow("examples", "copy", "planar_2r", ".")
    assert "RMS" in cardsflow("run", "planar_2r")
    assert (work / "planar_2r/results/results.csv").is_file()
