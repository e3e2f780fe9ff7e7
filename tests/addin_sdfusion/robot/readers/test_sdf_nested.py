"""Nested models in SDF files, and included files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from addin_sdfusion.robot import Robot, RobotError, read_robot
from addin_sdfusion.robot.formats.read import read
from sim_dart import CoreDynamics

INERTIAL = """<inertial><pose>0 0.01 0.02 0 0 0</pose><mass>{mass}</mass>
<inertia><ixx>0.01</ixx><iyy>0.02</iyy><izz>0.015</izz></inertia></inertial>"""


def link(name: str, pose: str, mass: float = 1.0, more: str = "") -> str:
    return f'<link name="{name}">{pose}{INERTIAL.format(mass=mass)}{more}</link>'


def joint(name: str, parent: str, child: str, axis: str, pose: str = "") -> str:
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f'<joint name="{name}" type="revolute">{pose}{ends}<axis>{axis}</axis></joint>'


ARM = link("base", "") + link("upper", "<pose>0 0 0.5 0.1 0 0</pose>")
ARM += joint("shoulder", "world", "base", "<xyz>0 0 1</xyz>")
ARM += joint("elbow", "base", "upper", "<xyz>0 1 0</xyz>")
MESH = "<visual name='v'><geometry><mesh><uri>meshes/palm.stl</uri></mesh></geometry></visual>"
HAND = (
    link("palm", "<pose>0.1 0 0 0 0.3 0</pose>", 0.3, MESH)
    + link("finger", '<pose relative_to="palm">0.05 0 0 0 0 0.2</pose>', 0.1)
    + joint("knuckle", "palm", "finger", '<xyz expressed_in="__model__">0 1 0</xyz>')
)
POSE = '<pose relative_to="upper">0 0 0.3 0 0 0.5</pose>'
WRIST = joint("wrist", "upper", "{prefix}palm", "<xyz>1 0 0</xyz>")
FLAT = (
    ARM
    + f'<frame name="hand">{POSE}</frame>'
    + link("hand_palm", '<pose relative_to="hand">0.1 0 0 0 0.3 0</pose>', 0.3, MESH)
    + link("hand_finger", '<pose relative_to="hand_palm">0.05 0 0 0 0 0.2</pose>', 0.1)
    + WRIST.format(prefix="hand_")
    + joint("hand_knuckle", "hand_palm", "hand_finger", '<xyz expressed_in="hand">0 1 0</xyz>')
)
NESTED = f'{ARM}<model name="hand">{POSE}{HAND}</model>' + WRIST.format(prefix="hand::")
INCLUDE = f"<include><uri>model://gripper</uri><name>hand</name>{POSE}</include>"
INCLUDED = ARM + INCLUDE + WRIST.format(prefix="hand::")


def written(folder: Path, model: str, name: str = "arm") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "model.sdf"
    file.write_text(f'<sdf version="1.9"><model name="{name}">{model}</model></sdf>')
    return file


def by_name(robot: Robot) -> dict[str, object]:
    """Return links and joints by name, independent of their order."""
    bare = [replace(one, meshes=()) for one in robot.links]
    return {one.name: one for one in (*bare, *robot.joints)}


@pytest.fixture
def flat(tmp_path: Path) -> Robot:
    return read_robot(written(tmp_path / "flat", FLAT))


def test_nested_model_equals_its_parts(flat: Robot, tmp_path: Path) -> None:
    reading = read(written(tmp_path / "nested", NESTED))
    assert by_name(reading.require()) == by_name(flat)
    assert "'hand_finger'" in next(f.message for f in reading.findings if f.code == "nested-model")
    q = np.array([0.3, -0.4, 0.5, 0.2])
    order = [[c.name for c in flat.coordinates].index(c.name) for c in reading.robot.coordinates]
    M = CoreDynamics(reading.robot).mass_matrix(q[order])
    np.testing.assert_allclose(M, CoreDynamics(flat).mass_matrix(q)[np.ix_(order, order)])


@pytest.mark.parametrize("place", ["beside", "inside"])
def test_file_is_included(place: str, flat: Robot, tmp_path: Path) -> None:
    file = written(tmp_path / "arm", INCLUDED)
    folder = tmp_path / "gripper" if place == "beside" else tmp_path / "arm/gripper"
    written(folder, HAND, "gripper")
    robot = read_robot(file)
    assert by_name(robot) == by_name(flat)
    (palm,) = [one for one in robot.links if one.name == "hand_palm"]
    assert (file.parent / palm.meshes[0].uri).resolve() == (folder / "meshes/palm.stl").resolve()


def test_world_can_include_its_only_model(tmp_path: Path) -> None:
    written(tmp_path / "arm", FLAT)
    world = tmp_path / "world/model.sdf"
    world.parent.mkdir()
    include = "<include><uri>model://arm</uri><pose>1 0 0 0 0 0</pose></include>"
    world.write_text(f'<sdf version="1.9"><world name="w">{include}</world></sdf>')
    moved, plain = read_robot(world), read_robot(tmp_path / "arm")
    assert moved.joints[0].T_parent_joint.position[0] == 1.0
    assert moved.joints[1:] == plain.joints[1:]


def test_merged_models_keep_their_names(flat: Robot, tmp_path: Path) -> None:
    nested = f'{ARM}<model name="hand" merge="true">{POSE}{HAND}</model>' + WRIST.format(prefix="")
    names = {one.name for one in read_robot(written(tmp_path / "merged", nested)).links}
    assert names == {"base", "upper", "palm", "finger"}


def test_conflicting_names_stay_unique(tmp_path: Path) -> None:
    robot = read_robot(written(tmp_path, NESTED + link("hand_palm", "")))
    assert {"hand_palm", "hand__palm", "hand__finger"} <= {one.name for one in robot.links}


WRONG = {
    "model://nowhere": "include-not-found",
    "https://fuel.gazebosim.org/1.0/x": "include-not-found",
    "../gripper": "include-not-found",
    "model://arm": "nested-too-deep",
    "model://two": "not-one-model",
    "model://broken": "include-not-read",
}


@pytest.mark.parametrize("uri", WRONG)
def test_invalid_include_is_an_error_at_its_element(uri: str, tmp_path: Path) -> None:
    file = written(tmp_path / "arm", f"{ARM}<include><uri>{uri}</uri></include>")
    written(tmp_path / "gripper", HAND)
    written(tmp_path / "two", "")
    (tmp_path / "two/model.sdf").write_text('<sdf version="1.9"><world name="w"/></sdf>')
    written(tmp_path / "broken", "<link>")
    (tmp_path / "broken/model.sdf").write_text("<sdf")
    with pytest.raises(RobotError) as raised:
        read_robot(file)
    assert WRONG[uri] in {finding.code for finding in raised.value.findings}
