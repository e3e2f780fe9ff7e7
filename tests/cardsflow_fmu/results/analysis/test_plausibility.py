"""Warnings about valid input that is probably wrong: in `check`, in `init` and before a run."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.one_link import cable, one_link
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import (
    WORLD,
    Coordinate,
    Inertia,
    Joint,
    Link,
    Pose,
    Robot,
    Wrap,
    WrapSurface,
    revolute,
    write_sdf,
)
from addin_sdfusion.robot import (
    check as check_description,
)
from cardsflow_fmu import Experiment, check, run
from cardsflow_fmu.results.analysis.moment_arms import SIGN_CHANGE

Y = (0.0, 1.0, 0.0)
LIGHT = Inertia(1.0, (0.2, 0.0, 0.0), 0.01, 0.01, 0.01)
START = (-0.1, 0.0, 0.5)
CHANGE = math.pi + math.atan2(-0.5, -0.1)
"""The angle at which the hinge is between the ends of the muscle `m`, on a straight line."""


def arm(scale: float = 1.0, inertia: Inertia = LIGHT, **more: object) -> Robot:
    """A link with muscles above and below, with all lengths scaled, but not its inertia."""

    def point(x: float, z: float) -> tuple[float, float, float]:
        return (scale * x, 0.0, scale * z)

    muscles = [
        replace(cable(point(-0.1, z), point(0.3, 0.0), f_max=100.0, **more), name=name)
        for name, z in (("m", 0.5), ("lower", -0.5))
    ]
    com = point(0.2, 0.0)
    hinge = {"motions": revolute(Y), "lower": -1.0, "upper": 1.0}
    return one_link(replace(inertia, com=com), muscles, **hinge)


def with_range(robot: Robot, lower: float, upper: float, **more: object) -> Robot:
    (joint,) = robot.joints
    coordinate = Coordinate("q", lower=lower, upper=upper, **more)
    return replace(robot, joints=(replace(joint, coordinates=(coordinate,)),))


def one_sided(upper: float = 2.8) -> Robot:
    """The muscle `m` only, on a hinge with limits beyond `CHANGE`."""
    robot = with_range(arm(), 0.0, upper)
    return robot.with_muscles(robot.muscles[:1])


def over_cylinder(upper: float) -> Robot:
    """The muscle `m` wraps over a cylinder about the hinge, on the side of the shorter path."""
    surface = WrapSurface("axle", "a", "cylinder", 0.05, Pose(rpy=(0.5 * math.pi, 0.0, 0.0)))
    robot = one_sided(upper)
    muscles = [replace(muscle, wraps=(Wrap("axle", 0),)) for muscle in robot.muscles]
    return replace(robot.with_muscles(muscles), wrap_surfaces=(surface,))


def codes(robot: Robot) -> list[str]:
    return [finding.code for finding in check(robot)]


def test_plausible_robot_has_no_warnings() -> None:
    assert codes(arm()) == []


@pytest.mark.parametrize(
    ("robot", "code"),
    [
        (arm(150.0), "lengths-in-millimetres"),  # 45 m
        (arm(1e-3, Inertia(1.0, ixx=1e-9, iyy=1e-9, izz=1e-9)), "tiny-robot"),
        (replace(arm(), links=(Link("a", replace(LIGHT, mass=0.0)),)), "inertia-without-mass"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_implausible_size_or_mass_is_a_warning(robot: Robot, code: str) -> None:
    assert code in codes(robot)
    assert not any(finding.is_error for finding in check(robot))


def test_long_robot_that_is_heavy_has_no_warning() -> None:
    """A crane of 20 m and 2 t."""
    crane = arm(67.0, Inertia(2000.0, ixx=2e4, iyy=2e4, izz=2e4))
    assert check_description(crane) == []


def test_wide_frame_of_cables_has_no_warning() -> None:
    """Cables of 60 m to a platform of 2 kg; only the world's points are far apart."""
    muscles = [
        replace(cable((60.0, 0.0, z), (0.3, 0.0, 0.0), f_max=100.0), name=f"{z}")
        for z in (-30.0, 30.0)
    ]
    assert check_description(arm().with_muscles(muscles)) == []


@pytest.mark.parametrize(
    ("make", "cause"), [(one_sided, "its via points"), (over_cylinder, "the side of its wraps")]
)
def test_sign_change_names_muscle_coordinate_and_position(
    make: Callable[..., Robot], cause: str
) -> None:
    """The change is where the hinge is between the ends of the muscle."""
    assert SIGN_CHANGE not in codes(make(CHANGE - 0.01))
    found = [finding for finding in check(make(2.8)) if finding.code == SIGN_CHANGE]
    assert [finding.subject.name for finding in found] == ["m"]
    assert f"about coordinate 'q' changes sign at {CHANGE:.3g} rad" in found[0].message
    assert found[0].message.endswith(f"; check {cause}")


@pytest.mark.parametrize("half_range", [0.5 * math.pi, math.pi, math.inf])
def test_sign_change_within_half_a_turn_is_normal(half_range: float) -> None:
    """A straight cable has no moment arm if hinge and both ends are in line, each half turn."""
    assert SIGN_CHANGE not in codes(with_range(arm(), -half_range, half_range))


def test_sign_change_of_a_ball_joint_is_normal() -> None:
    """Two hinges at the same place: a muscle may be on any side of each axis."""
    robot = one_sided()
    (hinge,) = robot.joints
    twist = Joint("twist", WORLD, "b", revolute((0.0, 0.0, 1.0)), (Coordinate("twist"),))
    ball = replace(
        robot,
        links=(Link("b", LIGHT), *robot.links),
        joints=(twist, replace(hinge, parent="b")),
    )
    assert SIGN_CHANGE in codes(robot)
    assert SIGN_CHANGE not in codes(ball)


def test_many_sign_changes_share_one_line(tmp_path: Path, cardsflow: CommandLine) -> None:
    robot = one_sided()
    many = [replace(robot.muscles[0], name=f"m{k}") for k in range(11)]
    write_sdf(robot.with_muscles(many), tmp_path / "robot")
    for words in (("check", tmp_path / "robot"), ("init", tmp_path / "robot", "-o", tmp_path)):
        code, out, err = cardsflow(*words)
        assert code == 0
        assert (out + err).count(SIGN_CHANGE) == 1
        assert "and 10 more of this kind" in out + err


@pytest.mark.parametrize(
    ("robot", "code"),
    [(arm(150.0), "lengths-in-millimetres"), (one_sided(), SIGN_CHANGE)],
    ids=["size", "sign"],
)
def test_check_init_and_run_print_the_same_warning(
    robot: Robot, code: str, tmp_path: Path, cardsflow: CommandLine
) -> None:
    write_sdf(robot, tmp_path / "robot")
    file = tmp_path / "experiment.toml"
    checked = cardsflow("check", tmp_path / "robot")[1]
    started = cardsflow("init", tmp_path / "robot", "-o", file)[2]
    ran = cardsflow("run", file, "--set", "run.duration=0.01", "--coupling", "direct")[2]
    of_experiment = cardsflow("check", file)[1]
    lines = []
    for text in (checked, started, ran, of_experiment):
        (line,) = [line for line in text.splitlines() if code in line]
        lines.append(line.partition("warning: ")[2])
    assert len(set(lines)) == 1


def test_init_that_fails_names_the_missing_mass(tmp_path: Path, cardsflow: CommandLine) -> None:
    write_sdf(replace(arm(), links=(Link("a", replace(LIGHT, mass=0.0)),)), tmp_path / "robot")
    message = cardsflow.error_line("init", tmp_path / "robot", "-o", tmp_path)
    assert "possible cause: link 'a': has an inertia, but its mass is 0" in message


def write_experiment(folder: Path, robot: Robot, *q: float) -> Path:
    write_sdf(robot, folder / "robot")
    points = ", ".join(f"{{ time = {0.01 * k}, q = [{x}] }}" for k, x in enumerate(q))
    file = folder / "experiment.toml"
    file.write_text(
        '[robot]\npath = "robot"\n[reference]\nspline = "linear"\n'
        f"points = [{points}]\n[controller]\nkp = 1.0\nkd = 1.0\n[run]\nduration = 0.02\n"
    )
    return file


@pytest.mark.parametrize(
    ("peak", "said"),
    [
        (0.9, ""),
        (1.5, "outside its limits -1 to 1; change the reference or the limits"),
        (45.0, "outside its limits -1 to 1; is it in degrees?"),
        (80.0, "outside its limits -1 to 1; change the reference or the limits"),  # 1.4 rad
    ],
)
def test_reference_outside_limits_is_a_warning(
    peak: float, said: str, tmp_path: Path, cardsflow: CommandLine
) -> None:
    file = write_experiment(tmp_path, arm(), 0.0, peak, 0.0)
    texts = cardsflow("check", file)[1], cardsflow("run", file, "--coupling", "direct")[2]
    for text in texts:
        found = [line for line in text.splitlines() if "[reference-" in line]
        assert len(found) == bool(said)
        assert said in "".join(found)


def test_summaries_of_runs_and_studies_contain_the_warning(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    file = write_experiment(tmp_path, arm(), 0.0, 1.5, 0.0)
    expected = "outside its limits -1 to 1; change the reference or the limits"
    result = run(Experiment.load(file, {"run.accept": "any"}), coupling="direct")
    (warning,) = [line for line in result.summary["warnings"] if "its reference" in line]
    assert expected in warning
    (tmp_path / "study.toml").write_text(
        'experiment = "experiment.toml"\nmetrics = ["tracking.rms"]\n'
        '[[vary]]\npath = "controller.kp"\nvalues = [1.0]\n'
    )
    out, err = cardsflow("study", tmp_path / "study.toml", "-j", "1")[1:]
    assert expected in err, out


@pytest.mark.parametrize("motor", [False, True])
def test_turns_of_a_coordinate_without_limits(
    motor: bool, tmp_path: Path, cardsflow: CommandLine
) -> None:
    """Muscles cannot turn a joint several times, but a motor can."""
    drive = {"actuated": True, "tau_min": -1.0, "tau_max": 1.0} if motor else {}
    robot = with_range(arm(), -math.inf, math.inf, **drive)
    out = cardsflow("check", write_experiment(tmp_path, robot, 0.0, 90.0))[1]
    assert ("which is 14.3 turns; is it in degrees?" in out) == (not motor)


def test_start_in_degrees_is_an_error_that_says_so(tmp_path: Path, cardsflow: CommandLine) -> None:
    message = cardsflow.error_line("run", write_experiment(tmp_path, arm(), 30.0, 45.0))
    assert "must be within the joint limits -1.0 to 1.0, not 30.0; is it in degrees?" in message


def test_target_out_of_reach_is_a_warning_before_a_run(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    file = tmp_path / "experiment.toml"
    text = (EXAMPLES / "hill_arm/experiment.toml").read_text()
    robot = EXAMPLES / "hill_arm/robot/model.sdf"
    file.write_text(text.replace("robot/model.sdf", str(robot)).replace("0.5, -0.12", "0.8, -0.12"))
    err = cardsflow("run", file, "--set", "run.duration=1.2", "--coupling", "direct")[2]
    (line,) = [line for line in err.splitlines() if "[motion-not-reached]" in line]
    found = re.search(r"reaches hand.x (.+), hand.z (.+): .* is hand.x (.+), hand.z (.+); ", line)
    assert found is not None
    target, nearest = np.array(found.groups(), float).reshape(2, 2)
    reach = 0.3 + 0.36  # upper arm and forearm; the hand is nearest with the arm stretched
    np.testing.assert_allclose(nearest, target * reach / np.linalg.norm(target), atol=1e-4)
