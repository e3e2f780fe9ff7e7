"""`init`, `info` and `run` report parts of the robot files that are not simulated."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from support.command_line import CommandLine
from support.robots.robots import PLANAR_2R, planar_2r

from addin_sdfusion.robot import CableModel, Wrap, WrapSurface, write_caspr, write_sdf

SPRING = CableModel("linear_spring", (("K", 2000.0),))


@pytest.mark.slow
def test_springs_in_cables_are_reported_with_their_stiffness(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    robot = planar_2r()
    muscles = [replace(m, model=SPRING) for m in robot.muscles]
    write_caspr(robot.with_muscles(muscles), tmp_path / "robot")
    line = "not simulated: muscle 'cable_1' and 3 more: a linear_spring cable"
    size = "f_max 100 N would stretch it by 5 %"  # 100 N over 2000 N
    code, out, _ = cardsflow("info", tmp_path / "robot")
    assert code == 0
    assert out.startswith(f"WARNING: {line}")
    assert size in out
    code, _, err = cardsflow("init", tmp_path / "robot", "-o", tmp_path)
    assert code == 0
    assert line in err
    code, out, err = cardsflow(
        "run", tmp_path, "--coupling", "direct", "--set", "run.duration=0.05"
    )
    assert code == 0
    assert line in err
    assert out.startswith(f"WARNING: {line}")
    summary = json.loads((tmp_path / "results/summary.json").read_text())
    assert size in summary["warnings"][0]


def test_robot_that_cannot_be_simulated_is_shown(tmp_path: Path, cardsflow: CommandLine) -> None:
    robot = planar_2r()
    egg = WrapSurface("egg", "link_1", "ellipsoid", 0.01, half_axes=(0.2, 0.01))
    muscles = [replace(muscle, wraps=(Wrap("egg", 0),)) for muscle in robot.muscles[:1]]
    write_sdf(replace(robot.with_muscles(muscles), wrap_surfaces=(egg,)), tmp_path / "robot")
    info = cardsflow.json("info", tmp_path / "robot")
    assert info["muscles"][0]["length"] is None
    problem = "ellipsoid 'egg' with a half axis more than 10 times as long as another"
    assert problem in info["not_simulated"][0]
    assert f"{problem} is not supported in simulation" in cardsflow.error_line(
        "init", tmp_path / "robot"
    )


def test_too_distant_mass_is_reported(tmp_path: Path, cardsflow: CommandLine) -> None:
    robot = planar_2r()
    links = [replace(k, inertia=replace(k.inertia, com=(-1e308, 1e308, 1.0))) for k in robot.links]
    write_sdf(replace(robot, links=tuple(links)), tmp_path / "robot")
    assert "its inertia is not finite" in cardsflow.error_line("init", tmp_path / "robot")
    code, out, _ = cardsflow("check", tmp_path / "robot")
    assert code == 0
    assert "its inertia is not finite" in out


def test_ideal_cables_have_no_note(cardsflow: CommandLine) -> None:
    assert cardsflow.json("info", PLANAR_2R / "robot")["not_simulated"] == []
