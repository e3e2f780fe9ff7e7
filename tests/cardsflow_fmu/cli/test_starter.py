"""`cardsflow init`: experiments that run unchanged, and with their commented settings."""

from __future__ import annotations

import os
import re
import shutil
import sys
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from support.cases import sample_cases
from support.command_line import CommandLine
from support.robots.bent_cables import with_bent_cables
from support.robots.robots import EXAMPLES, PLANAR_2R, planar_2r

from addin_sdfusion.robot import InputError, RobotError, read_robot, write_caspr, write_sdf
from addin_sdfusion.robot.errors import MachineError
from addin_sdfusion.robot.model.trajectory import Trajectory, TrajectoryPoint
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.cli.setup.init import schema
from cardsflow_fmu.experiment.template import ExperimentDraft, experiment_text
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.simulation import draft_search
from cardsflow_fmu.simulation import starter as starter_module
from cardsflow_fmu.simulation.starter import Starter, init

ROBOTS = sorted(folder / "robot" for folder in EXAMPLES.iterdir() if (folder / "robot").is_dir())
VALID = Draft202012Validator(schema())


@pytest.mark.cases(3)
@pytest.mark.slow
@pytest.mark.parametrize("robot", sample_cases(ROBOTS, 2), ids=lambda robot: robot.parent.name)
def test_first_experiment_runs_unchanged(robot: Path, tmp_path: Path) -> None:
    file = init(robot, tmp_path / "arm/experiment.toml").file
    assert list(VALID.iter_errors(tomllib.loads(file.read_text()))) == []
    experiment = Experiment.load(file)
    assert experiment.warnings() == []
    result = run(experiment, tmp_path / "out", coupling="direct")
    assert result.complete
    assert result.summary["infeasible_ticks"] == 0
    assert result.summary["tracking"]["max"] < 1e-3
    names = [f"q.{c.name}" for c in experiment.robot.coordinates]
    assert max(abs(result[name] - result[name][0]).max() for name in names) > 0.005


@pytest.mark.slow
def test_cable_friction_adds_an_observer(tmp_path: Path) -> None:
    """The observer is fast enough for friction coefficients with an error of 30 %."""
    robot = read_robot(EXAMPLES / "roboy_left_arm/robot/model.sdf")
    write_sdf(with_bent_cables(robot, 0.2, [c.initial for c in robot.coordinates]), tmp_path)
    starter = init(tmp_path, tmp_path / "experiment.toml")
    assert starter.test_run is not None
    assert starter.test_run.is_good
    assert any("compensate for the friction of cables" in note for note in starter.notes)
    settings = Experiment.load(starter.file).controller
    assert settings.observer * settings.period == 0.5


@pytest.mark.slow
@pytest.mark.parametrize("form", ["sdf", "caspr", "file"])
def test_init_accepts_all_robot_formats(form: str, tmp_path: Path) -> None:
    robot = planar_2r()
    folder = tmp_path / "robot"
    if form == "sdf":
        write_sdf(robot, folder)
        path = folder / "model.sdf"
    else:
        write_caspr(robot, folder)
        path = folder if form == "caspr" else next(folder.glob("*_bodies.xml"))
    loaded = Experiment.load(init(path, tmp_path / "experiment.toml").file).robot
    assert [m.name for m in loaded.muscles] == [m.name for m in robot.muscles]


@pytest.mark.slow
def test_cable_set_is_written_to_the_experiment(tmp_path: Path) -> None:
    file = init(PLANAR_2R / "robot", tmp_path, "basic_2018_07").file
    assert file == tmp_path / "experiment.toml"
    assert Experiment.load(file).robot.cable_set == "basic_2018_07"


@pytest.mark.slow
def test_robot_path_is_relative_to_the_experiment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_sdf(planar_2r(), tmp_path / "a robot")
    monkeypatch.chdir(tmp_path / "a robot")
    file = init(".", Path("../experiments/first.toml")).file
    assert tomllib.loads(file.read_text())["robot"]["path"] == "../a robot"
    os.chdir(tmp_path)
    assert Experiment.load(tmp_path / "experiments/first.toml").robot.name == "planar_2r"


COMMENTED = re.compile(r"^# (\[?[a-z_]+(?:\.[\w\"]+)?\]? = .*|\[muscles\..*\])$")


@pytest.mark.slow
def test_every_commented_setting_is_valid(tmp_path: Path) -> None:
    """Each setting is tested separately, and all together."""
    file = init(PLANAR_2R / "robot", tmp_path).file
    plain, lines = experiment_data(Experiment.load(file)), file.read_text().splitlines()
    commented = [k for k, line in enumerate(lines) if COMMENTED.match(line)]
    assert len(commented) >= 14
    head = next(k for k in commented if lines[k].startswith("# [muscles."))
    for used in [*([k] for k in commented), commented]:
        in_muscles = {head} if head + 2 >= used[0] >= head else set()
        chosen = {*used, *in_muscles}
        text = "\n".join(x.removeprefix("# ") if k in chosen else x for k, x in enumerate(lines))
        file.write_text(text)
        assert experiment_data(Experiment.load(file)) == plain, [lines[k] for k in chosen]


@pytest.mark.parametrize(
    "name", ["ellenbogen größe", 'a "quoted" \\ name', "日本", "a.b", "x\ny", "#", "\u202e"]
)
def test_unusual_names_are_read_back(name: str) -> None:
    robot = planar_2r()
    muscles = [replace(m, name=f"{name}{k}") for k, m in enumerate(robot.muscles)]
    odd = replace(robot.with_muscles(muscles), name=name)
    rest = tuple(TrajectoryPoint(t, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0)) for t in (0.0, 1.0))
    motion = Trajectory("reference", "quintic", rest, 0.001)
    draft = ExperimentDraft(
        motion,
        f_max={m.name: 10.0 + k for k, m in enumerate(odd.muscles)},
        f_max_reason=f"from {name}",
        kp=400.0,
        kd=40.0,
        period=0.001,
        step=0.001,
    )
    data = tomllib.loads(experiment_text(odd, f"robots/{name}", draft))
    assert data["robot"]["path"] == f"robots/{name}"
    assert data["muscles"] == {m.name: {"f_max": 10.0 + k} for k, m in enumerate(odd.muscles)}


def test_existing_file_is_not_overwritten(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "experiment.toml"
    file.write_text("mine")
    for place in (file, tmp_path):
        with pytest.raises(InputError, match="already exists; choose another file"):
            init(PLANAR_2R / "robot", place)
    assert main(["init", str(PLANAR_2R / "robot"), "-o", str(file)]) == 2
    assert str(file) in capsys.readouterr().err
    assert file.read_text() == "mine"
    dangling = tmp_path / "link.toml"
    dangling.symlink_to(tmp_path / "nowhere.toml")
    with pytest.raises(InputError, match="already exists"):
        init(PLANAR_2R / "robot", dangling)


@pytest.mark.skipif(sys.platform == "win32", reason="needs a limit on the length of files")
def test_full_disk_leaves_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import resource

    write, limits = starter_module._write_new, resource.getrlimit(resource.RLIMIT_FSIZE)

    def write_little(file: Path, text: str) -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, limits[1]))
        try:
            write(file, text)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)

    monkeypatch.setattr(starter_module, "_write_new", write_little)
    with pytest.raises(MachineError, match="cannot be written"):
        init(PLANAR_2R / "robot", tmp_path / "experiment.toml")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("output", "message"),
    [
        ("experiment.json", "must have the suffix .toml"),
        ("file/experiment.toml", "cannot be written"),
        ("x" * 300 + ".toml", "cannot be written"),
        ("a\0b.toml", "cannot be written"),
    ],
)
def test_init_rejects_invalid_output_paths(output: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match=message):
        init(PLANAR_2R / "robot", tmp_path / output)
    assert [file.name for file in tmp_path.iterdir()] == ["file"]


def robots_without(what: str) -> Any:
    robot = planar_2r()
    if what == "muscles":
        return robot.with_muscles([])
    joints = tuple(replace(j, motions=(), coordinates=()) for j in robot.joints)
    return replace(robot, joints=joints)


@pytest.mark.parametrize("what", ["muscles", "movable joints"])
def test_init_rejects_a_robot_that_cannot_move(what: str, tmp_path: Path) -> None:
    write_sdf(robots_without(what), tmp_path / "robot")
    with pytest.raises((InputError, RobotError), match=what):
        init(tmp_path / "robot", tmp_path / "experiment.toml")
    assert not (tmp_path / "experiment.toml").exists()


def test_failed_test_run_is_the_first_line_and_the_exit_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    failed = draft_search.TestRun(0.3, 10.0, 7, True, "elbow", "rad")
    starter = Starter(tmp_path / "experiment.toml", ("test run failed: ...",), (), failed)
    monkeypatch.setattr(starter_module, "init", lambda *_, **__: starter)
    for options in ([], ["--json"]):
        assert main(["init", str(PLANAR_2R / "robot"), "-o", str(tmp_path), *options]) == 1
        assert capsys.readouterr().err.startswith("FAILED: the test run does not follow")


UNDRIVEN = {
    "arm.urdf": (
        '<robot name="arm"><link name="a"/><link name="b"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
        '</link><joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
        '<limit lower="-1" upper="1" effort="0" velocity="1"/></joint></robot>',
        "no muscles and no motors; add muscles with `cardsflow edit .*, efforts above 0",
    ),
    "arm.xml": (
        '<mujoco><worldbody><site name="s"/><body><joint/><geom size="0.1"/></body></worldbody>'
        '<actuator><general site="s" gear="1 0 0 0 0 0"/></actuator></mujoco>',
        "in <actuator>.*omitted drives: 1, such as: .*drives site",
    ),
}


@pytest.mark.parametrize("name", UNDRIVEN)
def test_init_of_a_robot_without_drives_names_the_elements_to_add(
    name: str, tmp_path: Path
) -> None:
    text, message = UNDRIVEN[name]
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        init(tmp_path / name, tmp_path / "e.toml")
    assert caught.value.file == tmp_path / name


@pytest.mark.slow
def test_findings_on_the_robot_files_are_printed(tmp_path: Path, cardsflow: CommandLine) -> None:
    """With line and consequence; also for an initial pose that the start pose replaces."""
    shutil.copytree(PLANAR_2R / "robot", tmp_path / "robot")
    cables, bodies = (tmp_path / f"robot/planar_2r_{name}.xml" for name in ("cables", "bodies"))
    text = cables.read_text(encoding="utf-8")
    cables.write_text(text.replace('name="cable_2"', 'name="cable_1"'), encoding="utf-8")
    text = bodies.read_text(encoding="utf-8")
    bodies.write_text(text.replace('q_initial="0.0"', 'q_initial="9.0"', 1), encoding="utf-8")
    (tmp_path / "experiment").mkdir()
    code, _, err = cardsflow("init", tmp_path / "robot", "-o", tmp_path / "experiment")
    assert code == 0
    renamed = r"'cable_1_2': the name 'cable_1' is used by an earlier element"
    assert re.search(rf"planar_2r_cables\.xml:\d+: warning: muscle {renamed}", err)
    assert "the initial pose violates the limits of joint_1; the start pose does not" in err
    assert "no-force-limit" not in err
    read = Experiment.load(tmp_path / "experiment").robot_files
    assert set(read) >= {cables, bodies}  # and not experiment/../robot


def test_tracking_error_of_the_test_run_has_a_unit(tmp_path: Path, cardsflow: CommandLine) -> None:
    write_caspr(planar_2r(), tmp_path / "robot")
    code, out, _ = cardsflow("init", tmp_path / "robot", "-o", tmp_path / "experiment.toml")
    assert code == 0
    assert re.search(r"test run passed: largest tracking error \S+ rad, muscle forces up to", out)


def test_experiment_must_be_above_all_robot_files(
    tmp_path: Path, cardsflow: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run only opens files in the folder of the robot or of the experiment."""
    monkeypatch.chdir(tmp_path)
    for name in ("arm", "parts"):
        (tmp_path / name).mkdir()
    (tmp_path / "parts/body.xml").write_text(
        '<mujocoinclude><body pos="0 0 1"><joint name="j" axis="0 1 0" range="-60 60"/>'
        '<geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.03"/></body></mujocoinclude>'
    )
    (tmp_path / "arm/arm.xml").write_text(
        '<mujoco><worldbody><include file="../parts/body.xml"/></worldbody>'
        '<actuator><motor joint="j" ctrlrange="-20 20"/></actuator></mujoco>'
    )
    said = cardsflow.error_line("init", "arm/arm.xml", "-o", "arm/experiment")
    assert "write the experiment to a folder that contains all files: -o ." in said
    assert not (tmp_path / "arm/experiment").exists()
    assert cardsflow("init", "arm/arm.xml", "-o", ".")[0] == 0
    run(Experiment.load(tmp_path, {"run.duration": 0.1}), tmp_path / "out")
