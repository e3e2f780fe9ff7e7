from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.experiments import copy_arm, with_robot, write_resources
from support.robots.robots import PLANAR_2R, planar_2r
from support.run_modes import RUN_MODES

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.config.file import read_settings
from cardsflow_fmu.simulation.run import simulate


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a copy of the example without its results."""
    return copy_arm(tmp_path)


def edit(folder: Path, old: str, new: str) -> None:
    file = folder / "experiment.toml"
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))


def test_example_has_the_values_of_the_paper() -> None:
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


def test_experiment_in_an_fmu_is_read_back_unchanged(folder: Path, tmp_path: Path) -> None:
    edit(folder, "[plant]", "[muscles.cable_2]\nf_min = 12.5\n\n[plant]")
    settings = {"start.q": {"joint_2": 0.1}, "controller.kp": {"joint_1": 1.0, "joint_2": 2.0}}
    experiment = Experiment.load(folder, settings)
    resources = write_resources(experiment, tmp_path / "elsewhere")
    shutil.rmtree(folder)
    again = Experiment.from_resources(resources)
    assert again.robot == experiment.robot
    assert again.robot.muscles[1].f_min == 12.5
    assert again.start == experiment.start
    assert again.controller == experiment.controller
    assert again.plant == experiment.plant
    assert again.run.duration == experiment.run.duration
    assert again.reference.curve.points == experiment.reference.curve.points


def test_experiment_may_contain_the_points_of_a_reference(folder: Path) -> None:
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


def test_unknown_key_is_reported_with_file_and_key(folder: Path) -> None:
    edit(folder, "kp = 2000.0", "kpp = 2000.0")
    with pytest.raises(InputError) as caught:
        Experiment.load(folder)
    text = str(caught.value)
    assert "\n" not in text
    place = f"{folder / 'experiment.toml'}: controller.kpp"
    assert text.startswith(f"{place}: no key 'kpp'; did you mean 'kp'?")


def test_large_integers_are_exact(folder: Path) -> None:
    key, large = "hardware.emulator.seed", 2**53 + 1
    assert Experiment.load(folder, {key: large}).hardware.emulator.seed == large
    assert Experiment.load(folder, {key: 3.0}).hardware.emulator.seed == 3


@pytest.mark.parametrize("content", [b"\xff\xfe", b"a = [" + b"[" * 5000, b"[plant"])
def test_files_that_are_not_toml_are_rejected(tmp_path: Path, content: bytes) -> None:
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
def test_too_deeply_nested_settings_are_rejected(
    text: str, is_too_deep: bool, tmp_path: Path
) -> None:
    """Tomllib would take minutes for 200000 names, and exceed the recursion limit afterwards."""
    file = tmp_path / "experiment.toml"
    file.write_text(text)
    if not is_too_deep:
        assert "a" in read_settings(file)
        return
    with pytest.raises(InputError, match=r"experiment\.toml: is nested too deeply"):
        read_settings(file)


def test_missing_experiment_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"experiment\.toml: cannot be read: No such file"):
        Experiment.load(tmp_path)


def test_setting_is_changed_by_its_key() -> None:
    experiment = Experiment.load(
        PLANAR_2R, {"controller.period": 0.01, "muscles.cable_1.f_max": 50.0}
    )
    assert experiment.controller.period == 0.01
    assert experiment.robot.muscle("cable_1").f_max == 50.0


@pytest.mark.slow
def test_robot_without_operational_space_is_packed(tmp_path: Path) -> None:
    robot = replace(planar_2r(), task_sets=(), task_set="")
    trajectories = PLANAR_2R / "robot/planar_2r_trajectories.xml"
    changes = {"reference.file": str(trajectories), "run.duration": 0.01}
    experiment = with_robot("planar_2r", robot, tmp_path / "arm", **changes)
    fmu, direct = (simulate(experiment, **RUN_MODES[way]) for way in ("python", "direct"))
    np.testing.assert_array_equal(fmu.rows, direct.rows)


def test_approach_begins_at_rest_for_any_final_velocity() -> None:
    points = [{"time": t, "q": [0.1 + t, 0.2], "qd": [1.0, 0.0]} for t in (0.0, 1.0)]
    reference = {"spline": "cubic", "points": points}
    assert Experiment.load(PLANAR_2R, {"reference": reference}).start.qd == (1.0, 0.0)
    approach = {"duration": 1.0, "start": [0.0, 0.2]}
    start = Experiment.load(PLANAR_2R, {"reference": reference | {"approach": approach}}).start
    assert start.q == (0.0, 0.2)
    assert start.qd == (0.0, 0.0)


@pytest.mark.parametrize(("effort", "bounds"), [(30.0, (-30.0, 30.0)), ([-5.0, 9.0], (-5.0, 9.0))])
def test_motor_setting_adds_a_motor_to_a_joint(effort: object, bounds: tuple[float, float]) -> None:
    changes = {"robot.joints.joint_2.motor": True, "robot.joints.joint_2.effort": effort}
    (motor,) = Experiment.load(PLANAR_2R, changes).robot.motors
    assert (motor.name, motor.tau_min, motor.tau_max) == ("joint_2", *bounds)
