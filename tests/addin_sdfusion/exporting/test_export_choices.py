"""Tests of settings of single links and joints, and of files for other programs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from addin_sdfusion.building.build_robot import build_robot
from addin_sdfusion.exporting.export import export_robot
from addin_sdfusion.robot import Link, Robot
from addin_sdfusion.robot.formats.read import read_robot
from addin_sdfusion.settings import JointSettings, LinkSettings
from addin_sdfusion.snapshot import DesignSnapshot
from addin_sdfusion.snapshot_file import read_snapshot

ARM = Path(__file__).parents[3] / "examples/from_cad/two_link_arm.json"


def arm(**settings: object) -> DesignSnapshot:
    snapshot = read_snapshot(ARM)
    return replace(snapshot, settings=replace(snapshot.settings, **settings))


def built(**settings: object) -> Robot:
    robot = build_robot(arm(**settings)).robot
    assert robot is not None
    return robot


def test_a_chosen_mass_scales_the_inertia_and_nothing_else() -> None:
    before = built()
    name = before.links[-1].name
    after = built(of_links=(LinkSettings(name, mass=2.5),))
    own, new = before.link(name).inertia, after.link(name).inertia
    assert (new.mass, new.com) == (2.5, own.com)
    np.testing.assert_allclose(new.matrix, np.array(own.matrix) * 2.5 / own.mass, rtol=1e-15)
    assert after.links[:-1] == before.links[:-1]


def test_chosen_effort_damping_and_friction_are_exported() -> None:
    name = built().coordinates[0].name
    c = built(of_joints=(JointSettings(name, 7.0, 0.25, 0.125),)).coordinates[0]
    assert (c.tau_min, c.tau_max, c.damping, c.friction) == (-7.0, 7.0, 0.25, 0.125)
    (other,) = built(of_joints=(JointSettings(name, damping=0.5),)).coordinates[1:]
    assert other == built().coordinates[1]


@pytest.mark.parametrize(
    ("settings", "code", "is_error"),
    [
        ({"of_links": (LinkSettings("hund", mass=1.0),)}, "setting-of-none", False),
        ({"of_links": (LinkSettings("base", mass=-1.0),)}, "bad-setting", True),
        ({"of_joints": (JointSettings("elbo", damping=1.0),)}, "setting-of-none", False),
        ({"of_joints": (JointSettings("elbow", friction=-1.0),)}, "bad-setting", True),
    ],
)
def test_invalid_settings_are_reported(settings: dict, code: str, is_error: bool) -> None:
    (finding,) = [f for f in build_robot(arm(**settings)).findings if f.code == code]
    assert finding.is_error == is_error


def kinds(link: Link) -> list[str]:
    meshes = ["mesh" for mesh in link.meshes if mesh.role == "collision"]
    return meshes + [shape.kind for shape in link.shapes]


def test_each_link_has_its_chosen_collision(tmp_path: Path) -> None:
    first, second, *_ = (link.name for link in built().links)
    chosen = (LinkSettings(first, "none"), LinkSettings(second, "mesh"))
    export_robot(arm(collision="cylinder", of_links=chosen), tmp_path / "arm")
    robot = read_robot(tmp_path / "arm")
    assert kinds(robot.link(first)) == []
    assert kinds(robot.link(second)) == ["mesh"]
    for link in robot.links[2:]:
        assert set(kinds(link)) == {"cylinder"}


def test_urdf_and_mjcf_folders_are_self_contained(tmp_path: Path) -> None:
    export_robot(arm(urdf=True, mjcf=True, collision="box"), tmp_path / "arm")
    moved = tmp_path / "elsewhere"
    (tmp_path / "arm/mjcf").rename(moved)
    (file,) = moved.glob("*.xml")
    model = mujoco.MjModel.from_xml_path(str(file))
    robot = read_robot(tmp_path / "arm")
    assert sum(model.body_mass) == pytest.approx(sum(link.inertia.mass for link in robot.links))
    assert model.nmesh == len(robot.links)
    (urdf,) = (tmp_path / "arm/urdf").glob("*.urdf")
    again = read_robot(urdf)
    assert [c.name for c in again.coordinates] == [c.name for c in robot.coordinates]
    assert [len(link.shapes) for link in again.links] == [len(link.shapes) for link in robot.links]
    for link in again.links:
        assert all((urdf.parent / mesh.uri).is_file() for mesh in link.meshes)
