"""Tests of settings of single links and joints, and of files for other programs."""

from __future__ import annotations

import math
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
from addin_sdfusion.snapshot import CouplingSnapshot, DesignSnapshot
from addin_sdfusion.snapshot_file import read_snapshot
from sim_dart import CoreDynamics

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


def test_chosen_effort_velocity_damping_and_friction_are_exported(tmp_path: Path) -> None:
    name = built().coordinates[0].name
    chosen = (JointSettings(name, 7.0, 0.25, 0.125, 4.5),)
    c = built(of_joints=chosen).coordinates[0]
    assert (c.tau_min, c.tau_max, c.damping, c.friction) == (-7.0, 7.0, 0.25, 0.125)
    assert c.max_velocity == 4.5
    export_robot(arm(of_joints=chosen, urdf=True, visual=False, collision="none"), tmp_path)
    (urdf,) = (tmp_path / "urdf").glob("*.urdf")
    for file in (tmp_path / "model.sdf", urdf):
        assert [c.max_velocity for c in read_robot(file).coordinates] == [4.5, math.inf]
    (other,) = built(of_joints=(JointSettings(name, damping=0.5),)).coordinates[1:]
    assert other == built().coordinates[1]


@pytest.mark.parametrize("chosen", [("joint_1",), ("joint_2",), ("joint_1", "joint_2")])
def test_a_reversed_joint_moves_the_same_with_the_opposite_sign(chosen: tuple[str, ...]) -> None:
    limited = (arm().joints[0].motions[0], -0.3, 0.9)
    coupling = CouplingSnapshot("joint_2", "joint_1", 0.5, 0.2)
    for couplings in ((), (coupling,)):
        snapshot = replace(arm(), couplings=couplings)
        motion = replace(limited[0], value=0.4, lower=limited[1], upper=limited[2], rest=0.1)
        first = replace(snapshot.joints[0], motions=(motion,))
        snapshot = replace(snapshot, joints=(first, *snapshot.joints[1:]))
        before = build_robot(snapshot).robot
        settings = tuple(JointSettings(name, reversed=True) for name in chosen)
        snapshot = replace(snapshot, settings=replace(snapshot.settings, of_joints=settings))
        after = build_robot(snapshot).robot
        assert before is not None
        assert after is not None
        signs = np.array([-1.0 if c.name in chosen else 1.0 for c in before.coordinates])
        q = np.random.default_rng(1).uniform(-1.0, 1.0, len(signs))
        ours, theirs = CoreDynamics(before), CoreDynamics(after)
        assert theirs.muscle_lengths(q * signs) == pytest.approx(ours.muscle_lengths(q), abs=1e-15)
        M = signs[:, None] * ours.mass_matrix(q) * signs
        assert theirs.mass_matrix(q * signs) == pytest.approx(M, rel=1e-12)
        if "joint_1" in chosen:
            c = after.coordinates[0]
            assert (c.initial, c.lower, c.upper, c.rest) == (-0.4, -0.9, 0.3, -0.1)


def test_links_have_chosen_names_in_all_files(tmp_path: Path) -> None:
    """Only the name changes; muscles, meshes and settings of the link follow."""
    before = built()
    old = before.links[-1].name
    chosen = (LinkSettings(old, "box", 2.0, "ulna"),)
    export_robot(arm(of_links=chosen, mjcf=True), tmp_path)
    own = read_robot(tmp_path)
    (mjcf,) = (tmp_path / "mjcf").glob("*.xml")
    for robot in (own, read_robot(mjcf)):
        names = {"ulna" if link.name == old else link.name for link in before.links}
        assert {link.name for link in robot.links} == names
        assert robot.link("ulna").inertia.mass == 2.0
    assert kinds(own.link("ulna")) == ["box"]
    q = np.array([0.3, -0.4])
    assert CoreDynamics(own).muscle_lengths(q) == pytest.approx(
        CoreDynamics(before).muscle_lengths(q), abs=1e-15
    )


@pytest.mark.parametrize("name", ["base", "world"])
def test_a_chosen_name_that_exists_is_rejected(name: str) -> None:
    link = built().links[-1].name
    (finding,) = [
        f
        for f in build_robot(arm(of_links=(LinkSettings(link, name=name),))).findings
        if f.is_error
    ]
    assert f"its exported name {name!r} is " in finding.message


@pytest.mark.parametrize(
    ("settings", "code", "is_error"),
    [
        ({"of_links": (LinkSettings("hund", mass=1.0),)}, "setting-of-none", False),
        ({"of_links": (LinkSettings("base", mass=-1.0),)}, "bad-setting", True),
        ({"of_joints": (JointSettings("elbo", damping=1.0),)}, "setting-of-none", False),
        ({"of_joints": (JointSettings("elbow", friction=-1.0),)}, "bad-setting", True),
        ({"of_joints": (JointSettings("elbow", velocity=-1.0),)}, "bad-setting", True),
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
