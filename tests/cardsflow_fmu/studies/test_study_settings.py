"""Full keys of settings, and changes of the robot by an experiment."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from support.experiments import write_resources
from support.small_studies import PLANAR

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.cli.common import parse_settings
from cardsflow_fmu.experiment.config.key_path import (
    PathError,
    join_path,
    set_value,
    split_path,
    split_setting,
    toml_value,
)

FILE = Path("experiment.toml")


NAMES = ['a"b', "it's", "'", "a\\b", "a=b", "", " a", "\n\x7f\u202e", "\N{ROBOT FACE}", "a\\"]


@pytest.mark.parametrize(
    "parts",
    [["controller", "kp"], ["kp", "hand.x"], ["a", "p[0]", "b c"], *([n, n] for n in NAMES)],
)
def test_split_paths_equal_the_joined_parts(parts: list[str]) -> None:
    assert split_path(join_path(parts)) == parts


@pytest.mark.parametrize("name", NAMES)
def test_settings_on_the_command_line_support_any_name(name: str) -> None:
    key = join_path(["links", name, "mass"])
    assert split_setting(f"{key}={toml_value({name: name})}") == (key, toml_value({name: name}))
    assert parse_settings([f"{key}={toml_value({name: name})}"]) == {key: {name: name}}


def test_quotes_in_paths_follow_toml() -> None:
    assert split_path(r"""a."b\"\u0041".'c\d'.e""") == ["a", 'b"A', r"c\d", "e"]
    assert split_setting("a") is split_setting("=1") is split_setting('a."=1') is None
    assert split_setting('"a"' * 10000) is None


@pytest.mark.parametrize("path", ["", ".", "a..b", "a.", ".a", 'a."b', '"a"b', r'"\q"', "'a"])
def test_invalid_paths_are_rejected(path: str) -> None:
    with pytest.raises(InputError):
        split_path(path)


def test_setting_one_gain_keeps_the_common_value_of_the_others() -> None:
    data: dict[str, Any] = {"controller": {"kp": 2000.0}}
    set_value(data, "controller.kp.joint_1", 5.0, FILE)
    assert data == {"controller": {"kp": {"*": 2000.0, "joint_1": 5.0}}}


def test_an_element_of_a_list_is_set_by_its_index() -> None:
    data: dict[str, Any] = {"start": {"y": [1.0, 2.0, 3.0]}}
    set_value(data, "start.y[1]", 9.0, FILE)
    assert data == {"start": {"y": [1.0, 9.0, 3.0]}}
    with pytest.raises(PathError, match="3 elements"):
        set_value(data, "start.y[3]", 9.0, FILE)


def test_set_values_are_copies() -> None:
    value = [1.0]
    data: dict[str, Any] = {}
    set_value(data, "a.b", value, FILE)
    set_value(data, "a.b[0]", 2.0, FILE)
    assert value == [1.0]


def test_one_gain_can_differ_from_the_others() -> None:
    kp = Experiment.load(PLANAR, {"controller.kp.joint_2": 7.0}).controller.kp
    assert kp == (2000.0, 7.0)


CHANGES: dict[str, Any] = {
    "robot.muscles.cable_1.points[0].position": [0.6, 0.0, 0.1],
    "robot.muscles.cable_1.points[1].position[2]": 0.7,
    "robot.muscles.cable_2.points[1].link": "link_1",
    "robot.muscles.cable_3.f_max": 80.0,
    "robot.links.link_1.inertia.mass": 2.5,
    "robot.links.link_1.inertia.com[2]": 0.4,
    "robot.coordinates.joint_1.damping": 0.3,
    "robot.joints.joint_2.T_parent_joint.position[2]": 1.1,
}


def test_every_part_of_the_robot_can_be_changed() -> None:
    robot = Experiment.load(PLANAR, CHANGES).robot
    first, second, third, _ = robot.muscles
    assert first.via_points[0].position == (0.6, 0.0, 0.1)
    assert first.via_points[1].position[2] == 0.7
    assert second.via_points[1].link == "link_1"
    assert third.f_max == 80.0
    inertia = robot.link("link_1").inertia
    assert (inertia.mass, inertia.com[2]) == (2.5, 0.4)
    assert robot.coordinates[0].damping == 0.3
    assert robot.joints[1].T_parent_joint.position[2] == 1.1


def test_resources_contain_the_changed_robot(tmp_path: Path) -> None:
    experiment = Experiment.load(PLANAR, CHANGES)
    assert (
        Experiment.from_resources(write_resources(experiment, tmp_path)).robot == experiment.robot
    )


def test_a_row_of_an_array_of_tables_is_set_by_its_index() -> None:
    data: dict[str, Any] = {"world": {"objects": [{"mass": 1.0}, {"mass": 2.0}]}}
    set_value(data, "world.objects[1].mass", 3.0, FILE)
    assert data == {"world": {"objects": [{"mass": 1.0}, {"mass": 3.0}]}}
    with pytest.raises(PathError, match="has 2 elements"):
        set_value(data, "world.objects[2].mass", 3.0, FILE)
