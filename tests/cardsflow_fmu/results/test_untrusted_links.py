"""Links in an untrusted folder do not redirect output to other files."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from support.robots.robots import PLANAR_2R
from support.small_studies import run_here, small_study

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import write_files
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.utils.archive import write_archive

PRECIOUS = "precious"

pytestmark = pytest.mark.skipif(os.name != "posix", reason="links of POSIX")


@pytest.fixture
def precious(tmp_path: Path) -> Path:
    file = tmp_path / "precious.txt"
    file.write_text(PRECIOUS)
    return file


@pytest.mark.parametrize("name", ["results.csv", "hardware.rec", "experiment.zip"])
@pytest.mark.parametrize("target", ["precious.txt", "nothing.txt"])
def test_run_rejects_a_folder_with_links_instead_of_files(
    tmp_path: Path, precious: Path, name: str, target: str
) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "summary.json").write_text(json.dumps({"versions": {"cardsflow": "0.1.0"}}))
    (folder / name).symlink_to(tmp_path / target)
    experiment = Experiment.load(
        PLANAR_2R,
        {"run.duration": 0.01, "hardware.use": True, "hardware.link": "emulated:"},
    )
    with pytest.raises(InputError, match=f"has a link {name}"):
        run(experiment, folder, coupling="direct")
    assert precious.read_text() == PRECIOUS
    assert not (tmp_path / "nothing.txt").exists()


def test_temporary_files_are_created_again(tmp_path: Path, precious: Path) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    for name in ("a.txt", "b.zip"):
        (folder / f".{name}.{os.getpid()}.cardsflow.tmp").symlink_to(precious)
    write_files(folder, {"a.txt": "new"})
    write_archive(folder / "b.zip", {"c": b"new"})
    assert precious.read_text() == PRECIOUS
    assert (folder / "a.txt").read_text() == "new"


@pytest.mark.slow
def test_table_of_a_study_is_created_again(tmp_path: Path, precious: Path) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / ".table.csv.tmp").symlink_to(precious)
    run_here(small_study(tmp_path), folder)
    assert precious.read_text() == PRECIOUS
    assert (folder / "table.csv").read_text().startswith("run,")
