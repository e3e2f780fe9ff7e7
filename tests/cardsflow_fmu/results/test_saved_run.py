from __future__ import annotations

import json
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest
from support.robots.plants import copies
from support.robots.robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.mesh_files import mesh_file, packed_name
from cardsflow_fmu import Experiment, Result, run
from cardsflow_fmu.results.files import EXPERIMENT
from cardsflow_fmu.results.saved_run import is_run, opened_run, read_results
from cardsflow_fmu.utils.visual_meshes import visual_files

TRIANGLE = (
    b"solid t\nfacet normal 0 0 1\nouter loop\n%s\nendloop\nendfacet\nendsolid t\n"
    % b"\n".join(b"vertex %d %d 0" % corner for corner in ((0, 0), (1, 0), (0, 1)))
)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    folder = tmp_path_factory.mktemp("run")
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 0.05, "plant.mass_scale": 1.1})
    return folder, run(experiment, folder, coupling="direct")


def test_results_folder_is_read_back_as_the_result(finished: tuple[Path, Result]) -> None:
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
        (EXPERIMENT, None, r"has no experiment\.zip, which contains the robot"),
        (EXPERIMENT, b"no zip", "is not a valid archive of an experiment"),
        ("results.csv", b"time,q\n0.0,x\n", "is not a table of results"),
        ("results.csv", b"time,q\n0.0,1.0\n0.1\n", "is not a table of results"),
        ("results.csv", b"t,q\n0.0,1.0\n", "first column must be 'time'"),
        ("results.csv", b"\xff\xfe", "is not a table of results"),
        ("summary.json", None, r"summary\.json: cannot be read"),
        ("summary.json", b"{", "is not valid JSON"),
        ("results.units.json", b"[]", "is invalid"),
    ],
)
def test_damaged_results_folders_are_reported(
    finished: tuple[Path, Result], tmp_path: Path, name: str, content: bytes | None, words: str
) -> None:
    shutil.copytree(finished[0], tmp_path, dirs_exist_ok=True)
    (tmp_path / name).unlink()
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=words), opened_run(tmp_path):
        pass


def test_results_can_be_copied_and_pickled(finished: tuple[Path, Result]) -> None:
    folder, result = finished
    for original in (result, Result.load(folder)):
        for copy in copies(original):
            np.testing.assert_array_equal(copy.rows, result.rows)
            assert copy.summary == result.summary
            assert copy.experiment.robot == original.experiment.robot
            copy.release()


def test_archive_does_not_write_outside_of_its_folder(
    finished: tuple[Path, Result], tmp_path: Path
) -> None:
    shutil.copytree(finished[0], tmp_path, dirs_exist_ok=True)
    with zipfile.ZipFile(tmp_path / EXPERIMENT, "w") as archive:
        archive.writestr("../evil", "")
    with pytest.raises(InputError, match="a path outside of the archive"), opened_run(tmp_path):
        pass


def test_table_without_rows_is_read(finished: tuple[Path, Result], tmp_path: Path) -> None:
    shutil.copytree(finished[0], tmp_path, dirs_exist_ok=True)
    (tmp_path / "results.csv").write_text("time,q.joint_1\n")
    assert read_results(tmp_path).rows.shape == (0, 2)


def test_meshes_are_packed_with_the_results(tmp_path: Path) -> None:
    robot = tmp_path / "arm/robot"
    shutil.copytree(EXAMPLES / "roboy_left_arm", tmp_path / "arm")
    (robot / "meshes").mkdir()
    (robot / "meshes/arm.stl").write_bytes(TRIANGLE)
    visual = "<visual name='v'><geometry><mesh><uri>model://robot/meshes/arm.stl</uri></mesh></geometry></visual>"
    sdf = (robot / "model.sdf").read_text()
    link = '<link name="upper_arm_left">'
    (robot / "model.sdf").write_text(sdf.replace(link, link + visual, 1))
    settings = {"run.duration": 0.01, "reference.flower.duration": 1.0}
    run(Experiment.load(tmp_path / "arm", settings), tmp_path / "out", coupling="direct")
    shutil.rmtree(tmp_path / "arm")
    with opened_run(tmp_path / "out") as back:
        experiment = back.experiment
        (file,) = visual_files(experiment.robot, experiment.robot_path.parent).values()
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
def test_packed_mesh_is_below_the_robot_folder(uri: str, name: str) -> None:
    assert packed_name(uri) == name


def test_the_summary_lists_the_archive(finished: tuple[Path, Result]) -> None:
    summary = json.loads((finished[0] / "summary.json").read_text())
    assert EXPERIMENT in summary["files"]


@pytest.mark.slow
def test_meshes_of_several_robots_are_packed_separately(tmp_path: Path) -> None:
    names = ("left", "right")
    for name in names:
        shutil.copytree(EXAMPLES / "planar_2r/robot", tmp_path / name)
        shutil.copytree(EXAMPLES / "pick_up/robot", tmp_path / name, dirs_exist_ok=True)
        (tmp_path / name / "planar_2r_bodies.xml").unlink()
    pad = tmp_path / "right/meshes/pad.stl"
    other = TRIANGLE.replace(b"vertex 1 0 0", b"vertex 2 0 0")
    (pad.parent / "other one.stl").write_bytes(other)
    sdf = tmp_path / "right/model.sdf"
    sdf.write_text(sdf.read_text().replace("meshes/pad.stl", "meshes/other%20one.stl", 1))
    q = {"*": 0.0, "left_shoulder": -1.8, "right_shoulder": -1.8}
    q |= {"left_elbow": 1.8, "right_elbow": 1.8}
    table = ", ".join(f'"{name}" = {value}' for name, value in q.items())
    (tmp_path / "experiment.toml").write_text(
        "".join(f"[[robots]]\nname = '{n}'\npath = '{n}/model.sdf'\n" for n in names)
        + "[controller]\nkp = 100.0\nkd = 20.0\n[reference]\nspline = 'linear'\n"
        + "".join(f"[[reference.points]]\ntime = {t}\nq = {{ {table} }}\n" for t in (0.0, 0.002))
    )
    run(Experiment.load(tmp_path), tmp_path / "out", coupling="direct")
    for name in names:
        shutil.rmtree(tmp_path / name)
    kept = zipfile.ZipFile(tmp_path / "out" / EXPERIMENT).namelist()
    assert not [name for name in kept if str(tmp_path.parts[1]) in name.split("/")]
    with opened_run(tmp_path / "out") as back:
        robot = back.experiment.robot
        files = visual_files(robot, back.experiment.folder, back.experiment.roots)
        assert set(files) == {m.uri for x in robot.links for m in x.meshes if m.role == "visual"}
        assert other in [file.read_bytes() for file in files.values()]


def test_names_of_meshes_may_be_percent_encoded(tmp_path: Path) -> None:
    (tmp_path / "robot/meshes").mkdir(parents=True)
    for name in ("a b.stl", "c%20d.stl"):
        (tmp_path / "robot/meshes" / name).write_bytes(TRIANGLE)
    folder = tmp_path / "robot"
    for uri, name in {
        "meshes/a%20b.stl": "a b.stl",
        "meshes/a b.stl": "a b.stl",
        "meshes/c%20d.stl": "c%20d.stl",  # a file of that very name comes first
        "model://robot/meshes/a%20b.stl": "a b.stl",
        "model://renamed/meshes/a%20b.stl": "a b.stl",
        "file://meshes/a%20b.stl": "a b.stl",
    }.items():
        found = mesh_file(uri, folder)
        assert found.is_file(), uri
        assert found.name == name
