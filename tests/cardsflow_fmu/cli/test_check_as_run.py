"""`cardsflow check` reports the same errors as a run before its first step."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from support.command_line import CommandLine
from support.damaged.kinds import KINDS
from support.robots.robots import EXAMPLES, PLANAR_2R

ARM = f"""[robot]
path = "{PLANAR_2R / "robot"}"
cable_set = "basic"
[controller]
type = "joint_space"
kp = 100.0
kd = 20.0
[run]
duration = 0.01
"""
POINTS = "[reference]\npoints = [{time = 0.0, q = 0.1}, {time = 1.0, q = 0.2}]\n"
HARDWARE = "[hardware]\nuse = true\nlink = "
APPROACH = "[reference.approach]\nduration = "
LINK = "[robot.links.link_2.inertia]\n"
START_SPEED = "[start]\nq = [0.1, 0.1]\nqd = [1e200, 0.0]"
REFUSED = {
    "masses": (POINTS + "[plant]\nmass_scale = 1e-308", "plant.mass_scale: link"),
    "mass": (POINTS + LINK + "mass = 1e308", "its mass matrix is not finite"),
    "far inertia": (POINTS + LINK + "iyy = 1e308", "a motion of these coordinates moves no mass"),
    "no address": (POINTS + "[hardware]\nuse = true", "hardware.link: missing"),
    "address": (POINTS + HARDWARE + "'nobody'", "invalid hardware address 'nobody'"),
    "port": (POINTS + HARDWARE + "'udp://127.0.0.1:0'", "the port must not be 0"),
    "key": (POINTS + HARDWARE + "'loopback:'\nkey_file = 'none.key'", "none.key"),
    "input": (POINTS + "[wiring.plant]\n'w.hand.fx' = 0.0", "no input 'plant.w.hand.fx'"),
    "gap": (POINTS + APPROACH + "1.0\nstart = [1e308, 1e308]\n[start]\nq = 0.1", "part 1 of"),
    "long": (POINTS + APPROACH + "1e308", "duration must be between 1e-100 and 1e+100 s"),
    "steps": (POINTS + "[plant]\nstep = 1e-9", "1e+06 times plant.step"),
    "short": (POINTS + APPROACH + "1e-308", "duration must be between 1e-100 and 1e+100 s"),
    "speed": (POINTS + START_SPEED, "q.joint_1 or its rate is not finite, or beyond 1e9"),
    "far": (POINTS.replace("1.0", "1e-308"), "too uneven for a spline"),
}


def write_experiment(folder: Path, text: str) -> Path:
    """Write an experiment with two links and additional tables."""
    file = folder / "experiment.toml"
    file.write_text(ARM + text)
    return file


@pytest.mark.parametrize("case", REFUSED)
def test_check_rejects_the_same_as_a_run(tmp_path: Path, cardsflow: CommandLine, case: str) -> None:
    text, reason = REFUSED[case]
    file = write_experiment(tmp_path, text)
    line = cardsflow.error_line("run", file, "--coupling", "direct", "-o", tmp_path / "out")
    assert reason in line
    code, out, err = cardsflow("check", file)
    assert (code, err) == (2, line)
    assert " 0 errors" not in out


def test_tiny_mass_causes_no_warnings(tmp_path: Path, cardsflow: CommandLine) -> None:
    file = write_experiment(tmp_path, POINTS + LINK + "mass = 1e-12")
    assert cardsflow("check", file)[::2] == (0, "")


def test_too_large_f_min_is_rejected(tmp_path: Path, cardsflow: CommandLine) -> None:
    text = (EXAMPLES / "hill_arm/experiment.toml").read_text()
    text = text.replace("robot/model.sdf", str(EXAMPLES / "hill_arm/robot/model.sdf"))
    file = tmp_path / "experiment.toml"
    file.write_text(f"{text}\n[muscles]\nshoulder_flexor = {{ f_min = 1e308 }}\n")
    assert "mass or force of the robot is too large" in cardsflow("check", file)[2]


def test_check_rejects_objects_inside_the_robot(tmp_path: Path, cardsflow: CommandLine) -> None:
    text = (EXAMPLES / "pick_up/experiment.toml").read_text()
    text = text.replace("robot/model.sdf", str(EXAMPLES / "pick_up/robot/model.sdf"))
    file = tmp_path / "experiment.toml"
    file.write_text(text.replace("[0.4, 0.0, 0.52]", "[0.4, 0.0, 0.6]"))
    line = cardsflow.error_line("run", file, "--coupling", "direct", "-o", tmp_path / "out")
    assert "m at the start; move one" in line
    assert cardsflow.error_line("check", file) == line
    file.write_text(text.replace("[0.4, 0.0, 0.52]", "[0.4, 0.0, 1e300]"))
    assert "world.objects[1]: position must be within 1e+06" in cardsflow.error_line("check", file)


def test_check_rejects_robot_files_that_may_not_be_packed(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    folder = tmp_path / "arm/robot"
    folder.mkdir(parents=True)
    text = (EXAMPLES / "models/arm.xml").read_text()
    (tmp_path / "arm.xml").write_text(text)
    (folder / "arm.xml").write_text('<mujoco><include file="../../arm.xml"/></mujoco>')
    file = write_experiment(
        tmp_path / "arm", POINTS.replace("0.1", "[0.1, -0.5]").replace("0.2", "[0, 0]")
    )
    arm = f'path = "{PLANAR_2R / "robot"}"\ncable_set = "basic"'
    file.write_text(file.read_text().replace(arm, 'path = "robot"'))
    line = cardsflow.error_line("run", file, "--coupling", "direct", "-o", tmp_path / "out")
    assert "arm.xml: is outside the folders" in line
    assert cardsflow("check", file)[::2] == (2, line)


def test_experiment_with_an_undecodable_path_is_rejected(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    folder = tmp_path / os.fsdecode(b"caf\xe9")
    try:
        folder.mkdir()
    except OSError:
        pytest.skip("this system has no such names")
    file = write_experiment(folder, POINTS)
    line = cardsflow.error_line("run", file, "-o", tmp_path / "out")
    assert "its path is not valid utf-8" in line
    assert cardsflow.error_line("check", file) == line
    assert "robot.cable_set: must be a text" in cardsflow.error_line(
        "run", PLANAR_2R, "--set", f"robot.cable_set={folder.name}"
    )


def test_check_executes_no_third_party_code_and_opens_no_connection(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    trace = tmp_path / "trace"
    (tmp_path / "law.py").write_text(f"open({str(trace)!r}, 'w')\nclass Law: pass\n")
    for name in ("law.py:Law", "joint_space"):
        file = write_experiment(tmp_path, POINTS + HARDWARE + "'udp://127.0.0.1:9'")
        text = file.read_text().replace("joint_space", name)
        file.write_text(text)
        assert cardsflow("check", file)[0] == 0
    assert not trace.exists()


def test_check_compares_external_fmus_with_their_descriptions(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    KINDS["fmu"].make(tmp_path)  # without code
    file = tmp_path / "with.toml"
    assert cardsflow("check", file)[0] == 0
    text = file.read_text()
    for table, reason in (
        ("inputs = { g = 'f' }", "fmus.plant.inputs: no input 'g'"),
        ("parameters = { mass = 1.0 }", "plant.fmu: no variable 'mass'"),
    ):
        file.write_text(f"{text}{table}\n")
        assert reason in cardsflow("check", file)[2]


def test_hardware_address_of_an_external_fmu_is_checked(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    KINDS["fmu"].make(tmp_path)
    file = tmp_path / "with.toml"
    text = file.read_text().replace("[fmus.plant]", "[fmus.hardware]")
    file.write_text(text + HARDWARE + "'nobody'\n")
    line = cardsflow.error_line("run", file, "--coupling", "direct", "-o", tmp_path / "out")
    assert "invalid hardware address 'nobody'" in line
    assert cardsflow("check", file)[::2] == (2, line)
    file.write_text(text + HARDWARE.replace("link = ", ""))
    assert "hardware.link" not in cardsflow("check", file)[2]
