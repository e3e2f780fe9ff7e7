"""Untrusted robots and experiments cannot pack files from outside of their folders."""

from __future__ import annotations

import io
import json
import os
import shutil
import zipfile
from pathlib import Path

import pytest
import trimesh
from support.experiments import resource_bytes, write_resources
from support.robots.one_link import one_link
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError, write_sdf
from addin_sdfusion.robot.formats.mjcf.write import write_mjcf
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.mesh_files import OUTSIDE
from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.packed_files import require_archive_paths, robot_files, robot_folder
from cardsflow_fmu.experiment.writer import experiment_resources
from cardsflow_fmu.results.saved_run import experiment_archive
from cardsflow_fmu.results.viewer.scene.meshes import link_meshes
from cardsflow_fmu.results.viewer.view import robot_act
from cardsflow_fmu.simulation.build import build

SECRET = trimesh.creation.box((0.111, 0.222, 0.333)).export(file_type="stl")
"""A private drawing: a mesh, and still nobody's business."""

OUTER = [
    "{home}/secret.stl",
    "file://{home}/secret.stl",
    "../../secret.stl",
    "%2e%2e/%2e%2e/secret.stl",
    "..%2f..%2fsecret.stl",
    "meshes/%2e%2e/../../secret.stl",
    "file://../../secret.stl",
    "model://robot/../../secret.stl",
    "model://../secret.stl",
    "model://%2e%2e/secret.stl",
    "model://x/..%2f..%2fsecret.stl",
    "package://robot/%2e%2e/%2e%2e/secret.stl",
    "package://%2e%2e/secret.stl",
    "link.stl",
    "model://robot/link.stl",
    "folder/secret.stl",
    "/proc/self/cwd/secret.stl",
]


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Create a home folder with a private mesh, and an untrusted experiment in a subfolder."""
    (tmp_path / "secret.stl").write_bytes(SECRET)
    shutil.copytree(EXAMPLES / "pick_up", tmp_path / "arm")
    (tmp_path / "arm/robot/link.stl").symlink_to(tmp_path / "secret.stl")
    (tmp_path / "arm/robot/folder").symlink_to(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def name_meshes(home: Path, uri: str, role: str) -> None:
    file = home / "arm/robot/model.sdf"
    before, tag, rest = file.read_text().partition(f"<{role} ")
    rest = rest.replace("meshes/pad.stl", uri.format(home=home), 1)
    file.write_text(before + tag + rest)


def contents(archive: bytes) -> list[bytes]:
    with zipfile.ZipFile(io.BytesIO(archive)) as opened:
        return [opened.read(name) for name in opened.namelist()]


@pytest.mark.slow
@pytest.mark.parametrize("uri", OUTER)
def test_visual_mesh_outside_the_allowed_folders_is_omitted_with_a_reason(
    home: Path, uri: str
) -> None:
    name_meshes(home, uri, "visual")
    experiment = Experiment.load(home / "arm")
    (warning,) = experiment.warnings()
    assert repr(uri.format(home=home)) in warning
    assert "is not packed" in warning
    assert OUTSIDE in warning
    assert SECRET not in contents(experiment_archive(experiment))
    assert "left_finger" not in link_meshes(experiment.robot, experiment.folder, experiment.roots)
    act = robot_act(home / "arm/robot")
    assert any("is not packed" in note for note in act.notes)


@pytest.mark.parametrize("uri", OUTER)
def test_collision_mesh_outside_the_allowed_folders_is_rejected(home: Path, uri: str) -> None:
    name_meshes(home, uri, "collision")
    with pytest.raises(InputError, match="is outside"):
        Experiment.load(home / "arm")


def test_mesh_in_the_folder_of_the_experiment_is_packed(home: Path) -> None:
    shutil.copy(home / "secret.stl", home / "arm/own.stl")
    for role in ("visual", "collision"):
        name_meshes(home, "%2e%2e/own.stl", role)
    experiment = Experiment.load(home / "arm")
    assert experiment.warnings() == []
    (home / "out").mkdir()
    with zipfile.ZipFile(io.BytesIO(experiment_archive(experiment))) as archive:
        archive.extractall(home / "out")
    shutil.rmtree(home / "arm")
    back = Experiment.from_resources(home / "out")
    assert "left_finger" in link_meshes(back.robot, back.folder, back.roots)
    assert back.warnings() == []
    assert SECRET in contents(experiment_archive(back))


@pytest.mark.parametrize("name", ["notes.stl", "notes.obj", "notes.txt"])
def test_invalid_mesh_in_the_robot_folder_is_not_packed(home: Path, name: str) -> None:
    text = b"PASSWORD=v 1 2 3\n"
    (home / "arm/robot" / name).write_bytes(text)
    name_meshes(home, name, "visual")
    experiment = Experiment.load(home / "arm")
    (warning,) = experiment.warnings()
    assert "is not packed" in warning
    assert text not in contents(experiment_archive(experiment))


def test_two_meshes_with_one_name_are_not_packed(home: Path) -> None:
    (home / "arm/meshes").mkdir()
    shutil.copy(home / "secret.stl", home / "arm/meshes/pad.stl")
    name_meshes(home, "../meshes/pad.stl", "visual")
    (warning,) = Experiment.load(home / "arm").warnings()
    assert "has the name 'meshes/pad.stl' of another mesh" in warning
    name_meshes(home, "../meshes/pad.stl", "collision")
    with pytest.raises(InputError, match=r"has the name 'meshes/pad\.stl' of another mesh"):
        experiment_resources(Experiment.load(home / "arm"))


def test_robot_files_that_link_outside_are_rejected(home: Path) -> None:
    extra = home / "arm/robot/cardsflow.xml"
    extra.rename(home / "private.xml")
    extra.symlink_to(home / "private.xml")
    experiment = Experiment.load(home / "arm")
    with pytest.raises(InputError, match=r"cardsflow\.xml: is outside"):
        experiment_resources(experiment)


INCLUDED = {
    "model.sdf": """<sdf version="1.7"><model name="arm"><include>
        <uri>model://common</uri></include></model></sdf>""",
    "arm.xml": '<mujoco model="arm"><include file="../common/arm.xml"/></mujoco>',
}
"""Robots whose parts lie in a folder beside theirs."""


@pytest.mark.parametrize("name", INCLUDED)
def test_included_file_keeps_its_relative_path(tmp_path: Path, name: str) -> None:
    """As in the models of MyoSuite and Gazebo; the folder of the experiment contains both files."""
    write_sdf(one_link(), tmp_path / "robots/common")
    write_mjcf(one_link(), tmp_path / "robots/common", name="arm")
    (tmp_path / "robots/arm").mkdir()
    (tmp_path / "robots/arm" / name).write_text(INCLUDED[name])
    robot, findings, own = vars(read(tmp_path / "robots/arm" / name)).values()
    assert "files-outside" in [finding.code for finding in findings]
    files = robot_files("robot", own, [tmp_path])
    for place, file in files.items():
        assert ".." not in Path(place).parts
        target = tmp_path / "elsewhere" / place
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, target)
    assert read(tmp_path / "elsewhere" / robot_folder("robot", own) / name).robot == robot
    with pytest.raises(InputError, match=r"common.* is outside"):
        robot_files("robot", own, [tmp_path / "robots/arm"])


CONTACTS = {"world.contacts": []}
SHAPES = {
    "objects": [{"name": "thing", "shape": "mesh", "file": "../secret.stl"}],
    "shapes": [{"link": "forearm", "shape": "mesh", "file": "robot/link.stl"}],
}


@pytest.mark.parametrize("key", SHAPES)
def test_explicitly_named_world_mesh_is_packed(home: Path, key: str) -> None:
    settings = CONTACTS | {f"world.{key}": SHAPES[key]}
    with pytest.raises(InputError, match=rf"world\.{key}\[0\]\.file: is outside"):
        Experiment.load(home / "arm", settings, names_files=False)
    assert SECRET in experiment_resources(Experiment.load(home / "arm", settings)).values()


@pytest.mark.parametrize("key", SHAPES)
def test_invalid_mesh_of_the_world_is_not_packed(home: Path, key: str) -> None:
    (home / "arm/private.txt").write_text("PASSWORD")
    rows = [{**SHAPES[key][0], "file": "private.txt"}]
    with pytest.raises(InputError, match=r"as a mesh: \.txt is not a mesh type"):
        experiment_resources(Experiment.load(home / "arm", CONTACTS | {f"world.{key}": rows}))


def test_sdf_world_only_names_meshes_in_its_folder(home: Path) -> None:
    box = "<mesh><uri>{}</uri></mesh>"
    world = (
        "<sdf version='1.9'><world name='w'><model name='m'><static>1</static><link name='l'>"
        f"<collision name='c'><geometry>{box}</geometry></collision></link></model></world></sdf>"
    )
    file = home / "arm/world.sdf"
    file.write_text(world.format("../secret.stl"))
    with pytest.raises(InputError, match="is outside"):
        Experiment.load(home / "arm", {"world.sdf": "world.sdf"})
    file.write_text(world.format("robot/meshes/pad.stl"))
    Experiment.load(home / "arm", {"world.sdf": "world.sdf"})


def test_explicitly_named_muscle_law_is_executed(home: Path) -> None:
    (home / "law.py").write_text("class Own:\n    command = None\n")
    with (home / "arm/experiment.toml").open("a") as stream:
        stream.write('\n[muscles.elbow_bend]\nmodel = "../law.py:Own"\n')
    with pytest.raises(InputError, match=r"muscles\.elbow_bend\.model: is outside"):
        Experiment.load(home / "arm")
    named = Experiment.load(home / "arm", {"muscles.elbow_bend.model": f"{home}/law.py:Own"})
    carried = experiment_resources(named)["muscles/law.py"]
    assert carried == home / "law.py"
    assert home / "law.py" in named.roots


def test_explicitly_named_motion_is_read(home: Path) -> None:
    toml = home / "arm/experiment.toml"
    before, _, rest = toml.read_text().partition("[reference]")
    _, _, plant = rest.partition("[plant]")
    toml.write_text(f"{before}[reference]\nfile = '../mine.csv'\n[plant]{plant}")
    head = "time,shoulder,elbow,left_grip,right_grip\n"
    (home / "mine.csv").write_text(head + "".join(f"{t},-1.8,1.8,0,0\n" for t in range(7)))
    with pytest.raises(InputError, match=r"reference\.file: is outside"):
        Experiment.load(home / "arm")
    mine = Experiment.load(home / "arm", {"reference.file": "../mine.csv"})
    assert mine.reference.duration == 6.0


@pytest.mark.slow
def test_explicitly_named_fmu_is_packed(home: Path) -> None:
    (home / "mine.fmu").write_bytes(b"no FMU")
    settings = {"fmus.plant": "../mine.fmu"}
    stranger = Experiment.load(home / "arm", settings, names_files=False)
    with pytest.raises(InputError, match=r"fmus\.plant: is outside"):
        build(stranger, home / "fmus")
    with pytest.raises(InputError, match=r"mine\.fmu: is not an FMU"):
        build(Experiment.load(home / "arm", settings), home / "fmus")


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("robot", {"path": "/srv/robot"}),
        ("robot", {"path": "../robot"}),
        ("robot", {"path": "robot/../../x"}),
        ("robot", {"path": "..\\robot"}),
        ("robot", {"path": "C:\\robot"}),
        ("robots", [{"path": "robots/a"}, {"path": "../b"}]),
        ("world", {"objects": [{"file": "/etc/passwd"}]}),
        ("world", {"shapes": [{"file": "../x.stl"}]}),
        ("world", {"sdf": "../world.sdf"}),
        ("reference", {"file": "/srv/motion.csv"}),
        ("hardware", {"key_file": "/srv/device.key"}),
        ("fmus", {"plant": "../plant.fmu"}),
        ("fmus", {"plant": {"path": "/plant.fmu"}}),
    ],
)
def test_experiment_in_an_archive_only_names_files_of_the_archive(
    tmp_path: Path, key: str, value: object
) -> None:
    file = tmp_path / "experiment.json"
    with pytest.raises(InputError, match=rf"{key}.* outside of the archive") as caught:
        require_archive_paths({key: value}, file)
    assert caught.value.file == file
    file.write_text(json.dumps({key: value}))
    with pytest.raises(InputError, match="outside of the archive"):
        Experiment.from_resources(tmp_path)


def test_link_to_a_file_outside_of_an_unpacked_archive_is_rejected(home: Path) -> None:
    (home / "out").mkdir()
    (home / "out/robot").symlink_to(home / "arm/robot")
    (home / "out/experiment.json").write_text('{"robot": {"path": "robot/model.sdf"}}')
    with pytest.raises(InputError, match="is a link to a file outside of the archive"):
        Experiment.from_resources(home / "out")


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_stored_warnings_do_not_contain_the_path_of_a_key(home: Path) -> None:
    key = home / "arm/device.key"
    key.write_bytes(b"k" * 32)
    key.chmod(0o644)
    settings = {
        "hardware.use": True,
        "hardware.link": "emulated:",
        "hardware.key_file": "device.key",
    }
    experiment = Experiment.load(home / "arm", settings)
    (warning,) = experiment.warnings()
    assert "hardware.key_file: other users can read this key" in warning
    assert str(home) not in warning
    for name, data in resource_bytes(experiment, with_hardware=True).items():
        assert b"device.key" not in data, name
        assert b"k" * 32 not in data, name


EXPERIMENT = """[robot]
path = "robot/arm.xml"
[reference]
points = [{time = 0.0, q = [0.1, -0.5]}, {time = 1.0, q = [0.2, -0.6]}]
[controller]
type = "joint_space"
kp = 100.0
kd = 20.0
"""


@pytest.fixture
def mjcf(tmp_path: Path) -> Path:
    """Write an MJCF arm: a mesh defines the forearm mass, actuators are in an included file."""
    folder = tmp_path / "arm"
    (folder / "robot").mkdir(parents=True)
    text = (EXAMPLES / "models/arm.xml").read_text()
    start = text.index("  <actuator>")
    parts = f"<mujocoinclude>{text[start : text.index('</mujoco>')]}</mujocoinclude>"
    (folder / "robot/parts.xml").write_text(parts)
    forearm = '<geom fromto="0 0 0 0 0 -0.26"/>'
    assert forearm in text
    text = text[:start].replace(forearm, '<geom type="mesh" mesh="bone" mass="1"/>')
    asset = '<asset><mesh name="bone" file="bone.stl"/></asset>'
    (folder / "robot/arm.xml").write_text(f'{text}{asset}<include file="parts.xml"/></mujoco>')
    (folder / "robot/bone.stl").write_bytes(SECRET)
    (folder / "experiment.toml").write_text(EXPERIMENT)
    return folder


def test_mesh_that_defines_a_mass_is_packed(mjcf: Path, tmp_path: Path) -> None:
    experiment = Experiment.load(mjcf)
    assert experiment.robot.link("forearm").inertia.mass > 1.0
    write_resources(experiment, tmp_path / "fmu")
    shutil.rmtree(mjcf)
    assert Experiment.from_resources(tmp_path / "fmu").robot == experiment.robot


@pytest.mark.parametrize("name", ["parts.xml", "bone.stl"])
def test_packed_experiment_contains_no_absolute_path(mjcf: Path, name: str) -> None:
    robot = mjcf / "robot/arm.xml"
    robot.write_text(robot.read_text().replace(f'"{name}"', f'"{mjcf}/robot/{name}"'))
    (finding,) = (each for each in read(robot).findings if each.code == "absolute-path")
    with pytest.raises(InputError, match="is an absolute path") as refused:
        Experiment.load(mjcf)
    assert (refused.value.problem, refused.value.line) == (finding.message, finding.line)


@pytest.mark.parametrize("name", ["parts.xml", "bone.stl"])
def test_robot_in_an_archive_must_not_refer_to_files_outside(
    mjcf: Path, tmp_path: Path, name: str
) -> None:
    archive = write_resources(Experiment.load(mjcf), tmp_path / "archive/fmu")
    (archive / "robot" / name).rename(tmp_path / name)
    main = archive / "robot/arm.xml"
    main.write_text(main.read_text().replace(f'"{name}"', f'"../../../{name}"'))
    with pytest.raises(InputError, match="is outside of the archive"):
        Experiment.from_resources(archive)
