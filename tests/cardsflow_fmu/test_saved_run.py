from __future__ import annotations

import json
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest
from robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, Result, run
from cardsflow_fmu.mesh_files import mesh_files, own_name
from cardsflow_fmu.saved_run import EXPERIMENT, is_run, opened_run, read_results

TRIANGLE = (
    b"solid t\nfacet normal 0 0 1\nouter loop\n%s\nendloop\nendfacet\nendsolid t\n"
    % b"\n".join(b"vertex %d %d 0" % corner for corner in ((0, 0), (1, 0), (0, 1)))
)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    folder = tmp_path_factory.mktemp("run")
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 0.05, "plant.mass_scale": 1.1})
    return folder, run(experiment, folder, through="direct")


def test_a_folder_gives_back_what_was_run(finished: tuple[Path, Result]) -> None:
    folder, result = finished
    assert is_run(folder)
    for path in (folder, folder / "results.csv"):
        with opened_run(path) as back:
            assert back.names == result.names
            np.testing.assert_array_equal(back.rows, result.rows)
            assert dict(back.units) == dict(result.units)
            assert back.summary == result.summary
            assert back.experiment.robot == result.experiment.robot
            assert back.experiment.plant == result.experiment.plant
            assert back.experiment.controller == result.experiment.controller


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        (EXPERIMENT, None, r"holds no experiment\.zip, so its robot is not known"),
        (EXPERIMENT, b"no zip", "is no archive of an experiment"),
        ("results.csv", b"time,q\n0.0,x\n", "is no table of results"),
        ("results.csv", b"time,q\n0.0,1.0\n0.1\n", "is no table of results"),
        ("results.csv", b"\xff\xfe", "is no table of results"),
        ("summary.json", None, r"summary\.json: cannot be read"),
        ("summary.json", b"{", "is no JSON"),
        ("results.units.json", b"[]", "is not what a run writes"),
    ],
)
def test_damaged_folders_say_what_is_wrong(
    finished: tuple[Path, Result], tmp_path: Path, name: str, content: bytes | None, words: str
) -> None:
    shutil.copytree(finished[0], tmp_path, dirs_exist_ok=True)
    (tmp_path / name).unlink()
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=words), opened_run(tmp_path):
        pass


def test_an_archive_does_not_write_elsewhere(finished: tuple[Path, Result], tmp_path: Path) -> None:
    shutil.copytree(finished[0], tmp_path, dirs_exist_ok=True)
    with zipfile.ZipFile(tmp_path / EXPERIMENT, "w") as archive:
        archive.writestr("../evil", "")
    with pytest.raises(InputError, match="leads out of the archive"), opened_run(tmp_path):
        pass


def test_a_table_without_rows_is_read(finished: tuple[Path, Result], tmp_path: Path) -> None:
    shutil.copytree(finished[0], tmp_path, dirs_exist_ok=True)
    (tmp_path / "results.csv").write_text("time,q.joint_1\n")
    assert read_results(tmp_path).rows.shape == (0, 2)


def test_meshes_travel_with_the_results(tmp_path: Path) -> None:
    robot = tmp_path / "arm/robot"
    shutil.copytree(EXAMPLES / "roboy_left_arm", tmp_path / "arm")
    (robot / "meshes").mkdir()
    (robot / "meshes/arm.stl").write_bytes(TRIANGLE)
    visual = "<visual name='v'><geometry><mesh><uri>model://robot/meshes/arm.stl</uri></mesh></geometry></visual>"
    sdf = (robot / "model.sdf").read_text()
    link = '<link name="upper_arm_left">'
    (robot / "model.sdf").write_text(sdf.replace(link, link + visual, 1))
    settings = {"run.duration": 0.01, "reference.flower.duration": 1.0}
    run(Experiment.load(tmp_path / "arm", settings), tmp_path / "out", through="direct")
    shutil.rmtree(tmp_path / "arm")
    with opened_run(tmp_path / "out") as back:
        experiment = back.experiment
        (file,) = mesh_files(experiment.robot, experiment.robot_path.parent).values()
        assert file.read_bytes() == TRIANGLE


@pytest.mark.parametrize(
    ("uri", "name"),
    [
        ("model://arm/meshes/a.stl", "meshes/a.stl"),
        ("model://arm/../../etc/a.stl", "etc/a.stl"),
        ("../meshes/a%20b.stl", "meshes/a b.stl"),
        ("file:///srv/a.stl", "srv/a.stl"),
        ("C:\\a.stl", "C__a.stl"),
    ],
)
def test_a_mesh_travels_below_its_robots_folder(uri: str, name: str) -> None:
    assert own_name(uri) == name


def test_the_summary_lists_the_archive(finished: tuple[Path, Result]) -> None:
    summary = json.loads((finished[0] / "summary.json").read_text())
    assert EXPERIMENT in summary["files"]
