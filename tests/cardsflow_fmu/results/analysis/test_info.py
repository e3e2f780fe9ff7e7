from __future__ import annotations

from pathlib import Path

import pytest
from support.command_line import CommandLine
from support.robots.robots import PLANAR_2R

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, build
from cardsflow_fmu.results.analysis.info import fmu_info, robot_info


def test_info_of_the_planar_arm_matches_its_files() -> None:
    info = robot_info(PLANAR_2R / "robot")
    assert info["mass"] == pytest.approx(0.2)
    assert info["reach"] == pytest.approx(2.0)  # two links of 1 m
    assert [c["name"] for c in info["coordinates"]] == ["joint_1", "joint_2"]
    assert [m["links"] for m in info["muscles"]][:2] == [["world", "link_1"], ["world", "link_2"]]
    # from (0.5, 0, 0) to (0.1, 0, 0.8)
    assert info["muscles"][0]["length"] == pytest.approx((0.4**2 + 0.8**2) ** 0.5)


@pytest.mark.slow
def test_info_of_an_fmu_lists_its_variables(tmp_path: Path) -> None:
    file = build(Experiment.load(PLANAR_2R), tmp_path)["plant"]
    info = fmu_info(file)
    units = {v["name"]: v["unit"] for v in info["variables"]}
    assert units["f.cable_1"] == "N"
    assert units["q.joint_2"] == "rad"
    assert units["y.tip.z"] == "m"
    (tmp_path / "no.fmu").write_text("no")
    with pytest.raises(InputError, match=r"no\.fmu: is not a valid FMU"):
        fmu_info(tmp_path / "no.fmu")


@pytest.mark.parametrize("thing", ["robot", "fmu"])
def test_info_prints_tables_or_json(thing: str, tmp_path: Path, cardsflow: CommandLine) -> None:
    path = PLANAR_2R / "robot"
    if thing == "fmu":
        path = build(Experiment.load(PLANAR_2R), tmp_path)["controller"]
    code, table, _ = cardsflow("info", path)
    assert code == 0
    info = cardsflow.json("info", path)
    names = info["muscles"] if thing == "robot" else info["variables"]
    assert all(item["name"] in table for item in names)
