from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.robots import PLANAR_2R, planar_2r
from support.ways import WAYS

from addin_sdfusion.robot import InputError, write_sdf
from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.config.file import read_settings
from cardsflow_fmu.experiment.writer import experiment_resources
from cardsflow_fmu.simulation.run import simulate


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of the example without its results."""
    shutil.copytree(PLANAR_2R, tmp_path / "arm", ignore=shutil.ignore_patterns("results"))
    return tmp_path / "arm"


def edit(folder: Path, old: str, new: str) -> None:
    file = folder / "experiment.toml"
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))


def test_the_example_says_what_the_paper_says() -> None:
    experiment = Experiment.load(PLANAR_2R)
    assert experiment.controller.kp == (2000.0, 2000.0)
    assert experiment.controller.kd == (90.0, 90.0)
    assert experiment.run.steps == 8000
    assert experiment.start.q == (-0.5, 0.5)
    assert [(m.name, m.f_min, m.f_max) for m in experiment.robot.muscles] == [
        (f"cable_{k}", 10.0, 100.0) for k in (1, 2, 3, 4)
    ]


@pytest.mark.parametrize("name", ["basic_multi_segment", "basic_4_cables_2018_10", "basic_2018_07"])
def test_every_published_variant_is_a_cable_set(name: str) -> None:
    experiment = Experiment.load(PLANAR_2R, {"robot.cable_set": name})
    assert experiment.robot.cable_set == name
    assert len(experiment.robot.muscles) == 4


def test_what_travels_in_an_fmu_reads_back_as_the_same_experiment(
    folder: Path, tmp_path: Path
) -> None:
    edit(folder, "[plant]", "[muscles.cable_2]\nf_min = 12.5\n\n[plant]")
    settings = {"start.q": {"joint_2": 0.1}, "controller.kp": {"joint_1": 1.0, "joint_2": 2.0}}
    experiment = Experiment.load(folder, settings)
    resources = tmp_path / "elsewhere"
    for name, content in experiment_resources(experiment).items():
        target = resources / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content if isinstance(content, bytes) else content.read_bytes())
    shutil.rmtree(folder)
    again = Experiment.from_resources(resources)
    assert again.robot == experiment.robot
    assert again.robot.muscles[1].f_min == 12.5
    assert again.start == experiment.start
    assert again.controller == experiment.controller
    assert again.plant == experiment.plant
    assert again.run.duration == experiment.run.duration
    assert again.reference.curve.points == experiment.reference.curve.points


def test_points_of_a_reference_may_stand_in_the_experiment(folder: Path) -> None:
    points = (
        'spline = "cubic"\n'
        "points = [{ time = 0, q = { joint_1 = 0.1, joint_2 = 0.2 } },"
        " { time = 2, q = [0.3, 0.4], qd = { joint_1 = 1.0 } }]"
    )
    edit(folder, 'trajectory = "simple_joint_motion"', points)
    experiment = Experiment.load(folder, {"run.duration": 2.0})
    first, last = experiment.reference.curve.points
    assert (first.q, first.qd, first.qdd) == ((0.1, 0.2), (0.0, 0.0), ())
    assert (last.time, last.q, last.qd) == (2.0, (0.3, 0.4), (1.0, 0.0))
    assert experiment.start.q == (0.1, 0.2)


def before_plant(tables: str, message: str) -> tuple[str, str, str]:
    """Further tables in the file, and what is said of them."""
    return "[plant]", f"{tables}\n[plant]", message


BAD = [
    ("kp = 2000.0", "kpp = 2000.0", "controller.kpp: no key 'kpp'; did you mean 'kp'"),
    ("[plant]", "[plant]\nstpe = 1", "plant.stpe: .*did you mean 'step'"),
    ("[plant]", "[plnt]", "plnt: no key 'plnt'; did you mean 'plant'"),
    before_plant(
        "[muscles.cabel_1]\nf_min = 1",
        "muscles.cabel_1: no muscle 'cabel_1'; did you mean 'cable_1'.*cable_4",
    ),
    before_plant(
        "[start]\nq = { joint1 = 0.0 }",
        "start.q.joint1: no coordinate 'joint1'; did you mean 'joint_1'",
    ),
    (
        "kd = 90.0",
        "kd = { joint_1 = 1.0, joint_3 = 1.0 }",
        "controller.kd.joint_3: no coordinate 'joint_3'",
    ),
    before_plant("[start]\nq = { joint_1 = nan }", "start.q.joint_1: must be a finite number"),
    before_plant("[start]\nq = { joint_1 = 4.0 }", "start.q.joint_1: 4.0 is outside the limits"),
    ("kp = 2000.0", "kp = inf", "controller.kp: must be a finite number"),
    ("kp = 2000.0", "kp = -1", "controller.kp: must be above 0"),
    before_plant(
        "[muscles.cable_3]\nf_min = 200.0", "muscles.cable_3: f_min 200.0 N is above f_max 100.0 N"
    ),
    before_plant("[muscles.cable_3]\nf_min = -1.0", "muscles.cable_3.f_min: must not be negative"),
    ("period = 0.001", "period = 0.0015", "controller.period: 0.0015 s is not a whole"),
    ("period = 0.001", "period = 0.0005", "controller.period: 0.0005 s is not a whole"),
    (
        "[plant]\nstep = 0.001 ",
        "[plant]\nstep = 0.0003 ",
        "run.step: 0.001 s is not a whole multiple of plant.step, 0.0003 s",
    ),
    ("duration = 8.0", "duration = 8.0005", "run.duration: 8.0005 s is not"),
    ("[run]\nstep = 0.001", "[run]\nstep = 0", "run.step: must be above 0"),
    ("duration = 8.0", "duration = 1e12", "run.duration: .* more than a run can hold"),
    ("kd = 90.0", 'kd = "90"', "controller.kd: must be a number, not '90'"),
    ("kd = 90.0", "kd = true", "controller.kd: must be a number, not True"),
    ("kp = 2000.0", "kp = [1.0]", "controller.kp: must have 2 numbers"),
    ('"joint_space" ', '"joint" ', "controller.type: .*did you mean 'joint_space'"),
    ('"dual_newton"', '"dapq"', "controller.solver: .*did you mean 'daqp'"),
    (
        'cable_set = "basic"',
        'cable_set = "basics"',
        "robot.cable_set: no cable set 'basics'; did you mean 'basic'",
    ),
    (
        "simple_joint_motion",
        "simple_motion",
        "reference.trajectory: no trajectory 'simple_motion'; did you mean 'simple_joint_motion'",
    ),
    ("planar_2r_bodies.xml", "none_bodies.xml", "none_bodies.xml: "),
    ("[plant]", "[plant", "line"),
    before_plant("[hardware]\nmax_missed = 1e308", "hardware.max_missed: .* less than 64 bits"),
    before_plant("[hardware]\nmax_missed = inf", "hardware.max_missed: must be a finite number"),
    before_plant(
        '[wiring.controler]\n"q.joint_1" = "plant.q.joint_1"',
        "wiring.controler: no key 'controler'; did you mean 'controller'",
    ),
]


@pytest.mark.parametrize(("old", "new", "message"), BAD)
def test_bad_input_is_one_line_with_file_and_key(
    folder: Path, old: str, new: str, message: str
) -> None:
    edit(folder, old, new)
    with pytest.raises(InputError, match=message) as caught:
        Experiment.load(folder)
    text = str(caught.value)
    assert "\n" not in text
    assert str(folder) in text


def test_whole_numbers_are_kept_exactly(folder: Path) -> None:
    key, large = "hardware.emulator.seed", 2**53 + 1
    assert Experiment.load(folder, {key: large}).hardware.emulator.seed == large
    assert Experiment.load(folder, {key: 3.0}).hardware.emulator.seed == 3


def test_a_number_in_the_place_of_a_table_is_refused(folder: Path) -> None:
    edit(folder, "[plant]\nstep", "# step")
    edit(folder, "[robot]", "plant = 3\n[robot]")
    with pytest.raises(InputError, match="plant: must be a table, not 3"):
        Experiment.load(folder)


@pytest.mark.parametrize("content", [b"\xff\xfe", b"a = [" + b"[" * 5000])
def test_files_that_are_no_toml_are_refused(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "experiment.toml"
    file.write_bytes(content)
    with pytest.raises(InputError, match=r"experiment\.toml: "):
        Experiment.load(file)


@pytest.mark.parametrize(
    ("text", "is_too_deep"),
    [
        (".".join(["a"] * 51) + " = 1", True),
        (".".join(["a"] * 20_000) + " = 1", True),
        ("[" + " . ".join(["a", "'b.c'", '"d"'] * 70_000) + "]", True),
        ("a = " + "[" * 200 + "]" * 200, True),
        ("a = " + "{b = " * 60 + "1" + "}" * 60, True),
        ("[" + ".".join("a" * 30) + "]\n" + ".".join("b" * 30) + " = 1", True),
        (".".join(["a"] * 40) + " = 1", False),
        ("a = [" + "0.5, " * 10_000 + "]", False),
        ("a = '" + "/x.y/" * 10_000 + "'", False),
    ],
    ids=range(9),
)
def test_settings_are_not_nested_without_end(text: str, is_too_deep: bool, tmp_path: Path) -> None:
    """Tomllib takes minutes for a header of 200000 names; what it gives ended the recursion."""
    file = tmp_path / "experiment.toml"
    file.write_text(text)
    if not is_too_deep:
        assert "a" in read_settings(file)
        return
    with pytest.raises(InputError, match=r"experiment\.toml: is nested too deeply"):
        read_settings(file)


def test_a_missing_experiment_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"experiment\.toml: cannot be read: No such file"):
        Experiment.load(tmp_path)


def test_a_setting_may_be_changed_by_its_key() -> None:
    experiment = Experiment.load(
        PLANAR_2R, {"controller.period": 0.01, "muscles.cable_1.f_max": 50.0}
    )
    assert experiment.controller.period == 0.01
    assert experiment.robot.muscle("cable_1").f_max == 50.0


@pytest.mark.slow
def test_a_robot_without_operational_space_travels_in_an_fmu(tmp_path: Path) -> None:
    robot = replace(planar_2r(), task_sets=(), task_set="")
    write_sdf(robot, tmp_path / "arm")
    text = (PLANAR_2R / "experiment.toml").read_text()
    text = text.replace("robot/planar_2r_bodies.xml", "model.sdf")
    trajectories = PLANAR_2R / "robot/planar_2r_trajectories.xml"
    changes = {"reference.file": str(trajectories), "run.duration": 0.01}
    (tmp_path / "arm/experiment.toml").write_text(text)
    experiment = Experiment.load(tmp_path / "arm", changes)
    fmu, direct = (simulate(experiment, **WAYS[way]) for way in ("python", "direct"))
    np.testing.assert_array_equal(fmu.rows, direct.rows)


def test_an_approach_begins_at_rest_whatever_the_velocity_of_what_it_leads_to() -> None:
    points = [{"time": t, "q": [0.1 + t, 0.2], "qd": [1.0, 0.0]} for t in (0.0, 1.0)]
    reference = {"spline": "cubic", "points": points}
    assert Experiment.load(PLANAR_2R, {"reference": reference}).start.qd == (1.0, 0.0)
    approach = {"duration": 1.0, "start": [0.0, 0.2]}
    start = Experiment.load(PLANAR_2R, {"reference": reference | {"approach": approach}}).start
    assert start.q == (0.0, 0.2)
    assert start.qd == (0.0, 0.0)


@pytest.mark.parametrize(("effort", "bounds"), [(30.0, (-30.0, 30.0)), ([-5.0, 9.0], (-5.0, 9.0))])
def test_a_joint_gets_a_motor_when_asked(effort: object, bounds: tuple[float, float]) -> None:
    changes = {"robot.joints.joint_2.motor": True, "robot.joints.joint_2.effort": effort}
    (motor,) = Experiment.load(PLANAR_2R, changes).robot.motors
    assert (motor.name, motor.tau_min, motor.tau_max) == ("joint_2", *bounds)
