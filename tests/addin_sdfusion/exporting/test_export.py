"""Tests of exported robots: they are read back, checked and run."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from support.designs.built_stubs import Built, body, box, built, zero_poses
from support.process_output import files_of
from support.robots.random_robots import random_robot, robots
from support.robots.robots import chain, planar_2r

from addin_sdfusion.exporting.export import Exported, export_built
from addin_sdfusion.progress import Cancelled
from addin_sdfusion.robot import (
    WORLD,
    Finding,
    Inertia,
    Joint,
    Link,
    Pose,
    Robot,
    RobotError,
    Subject,
    read_robot,
    sdf_losses,
)
from addin_sdfusion.robot.formats.caspr.read_trajectories import read_trajectory, trajectory_names
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.settings import ExportSettings

ALL = ExportSettings()
CHECKER = shutil.which("ign")


def codes(exported: Exported) -> list[str]:
    return [finding.code for finding in exported.findings]


def without_meshes(robot: Robot) -> Robot:
    return replace(robot, links=tuple(replace(link, meshes=()) for link in robot.links))


def test_export_lists_every_file_it_writes(tmp_path):
    exported = export_built(built(bodies=2), ALL, tmp_path / "arm")
    names = [file.relative_to(tmp_path / "arm").as_posix() for file in exported.files]
    assert names == [
        "cardsflow.xml",
        "caspr/planar_2r_bodies.xml",
        "caspr/planar_2r_cables.xml",
        "caspr/planar_2r_operational_spaces.xml",
        "caspr/planar_2r_trajectories.xml",
        "findings.json",
        "findings.txt",
        "meshes/collision/link_1.1.stl",
        "meshes/collision/link_1.2.stl",
        "meshes/collision/link_2.1.stl",
        "meshes/collision/link_2.2.stl",
        "meshes/visual/link_1.stl",
        "meshes/visual/link_2.stl",
        "model.config",
        "model.sdf",
        "planar_2r.osim",
    ]
    assert set(files_of(tmp_path / "arm")) == {*names, ".cardsflow-export.json"}


def test_exported_robot_is_read_back_unchanged(tmp_path):
    given_ = built(random_robot(2))
    export_built(given_, ALL, tmp_path / "model")
    reading = read(tmp_path / "model")
    assert without_meshes(reading.require()) == given_.robot
    assert "missing-meshes" not in [finding.code for finding in reading.findings]
    assert all(len(link.meshes) == 2 for link in reading.require().links)
    assert read_robot(tmp_path / "model/caspr").coordinates


def test_exported_meshes_equal_the_body_meshes(tmp_path):
    """Meshes are in the frame of the link, which is rotated and far from the origin."""
    robot = random_robot(4)
    export_built(built(robot), ALL, tmp_path / "model")
    for link in read_robot(tmp_path / "model").links:
        for mesh in link.meshes:
            assert mesh.uri.startswith("model://model/meshes/")
            loaded = trimesh.load(tmp_path / mesh.uri.removeprefix("model://"))
            np.testing.assert_allclose(loaded.bounds, box(0.1, 0.1, 0.3).bounds, atol=1e-6)
            assert loaded.volume == pytest.approx(0.003, rel=1e-5)
            assert loaded.is_watertight


def test_collisions_are_hulls_of_single_bodies(tmp_path):
    """A hull of two adjacent boxes would fill the gap between them."""
    export_built(built(bodies=2), ALL, tmp_path / "arm")
    parts = [trimesh.load(tmp_path / f"arm/meshes/collision/link_1.{k}.stl") for k in (1, 2)]
    assert sum(part.volume for part in parts) == pytest.approx(0.006, rel=1e-6)
    export_built(built(bodies=17), ALL, tmp_path / "arm")
    one = trimesh.load(tmp_path / "arm/meshes/collision/link_1.stl")
    assert one.volume == pytest.approx(0.1 * 0.3 * (0.1 + 16 * 0.2), rel=1e-6)


def test_a_hollow_body_collides_as_hull_or_as_mesh(tmp_path):
    tube = trimesh.creation.annulus(0.04, 0.05, 0.2)
    one = Robot("tube", (Link("a", Inertia(1.0)),), (Joint("j", WORLD, "a"),))
    given_ = Built(one, (), {"a": Pose()}, {"a": (body(tube),)})
    export_built(given_, ALL, tmp_path / "m")
    hull = trimesh.load(tmp_path / "m/meshes/collision/a.stl")
    assert hull.volume == pytest.approx(tube.convex_hull.volume, rel=1e-6)
    export_built(given_, ExportSettings(collision="mesh"), tmp_path / "m")
    whole = trimesh.load(tmp_path / "m/meshes/collision/a.stl")
    assert whole.volume == pytest.approx(tube.volume, rel=1e-5)


@pytest.mark.parametrize(
    ("chosen", "roles"),
    [
        (ExportSettings(visual=False), {"collision"}),
        (ExportSettings(collision="none"), {"visual"}),
        (ExportSettings(visual=False, collision="none"), set()),
        (ExportSettings(collision="mesh"), {"visual", "collision"}),
    ],
)
def test_meshes_are_options(tmp_path, chosen, roles):
    export_built(built(), chosen, tmp_path / "arm")
    robot = read_robot(tmp_path / "arm")
    assert {mesh.role for link in robot.links for mesh in link.meshes} == roles
    assert (tmp_path / "arm/meshes").exists() == bool(roles)


def test_bodies_without_meshes_are_reported(tmp_path):
    one = Robot("r", (Link("a", Inertia(1.0)),), (Joint("j", WORLD, "a"),))
    sheet = trimesh.Trimesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], process=False)
    broken = replace(body(box(1, 1, 1), "broken").mesh, triangles=body(sheet).mesh.triangles[:2])
    bodies = (
        body(box(1, 1, 1), "hidden", visible=False),
        body(sheet, "sheet"),
        replace(body(box(1, 1, 1), "broken"), mesh=broken),
        replace(body(box(1, 1, 1), "bare"), mesh=None),
    )
    given_ = Built(one, (), {"a": Pose()}, {"a": bodies})
    exported = export_built(given_, ALL, tmp_path / "m")
    reported = {f.code: f.message for f in exported.findings if f.subject.kind == "link"}
    assert "'hidden'" in reported["hidden-bodies"]
    assert "'bare'" in reported["bodies-without-mesh"]
    assert "'broken'" in reported["damaged-mesh"]
    assert "flat-collision" in reported
    assert [mesh.role for mesh in read_robot(tmp_path / "m").links[0].meshes] == ["visual"]


def test_invalid_file_names_are_replaced(tmp_path):
    names = ["a/b", "a\\b", "A/b", "con", "é关", "x.1", "..", "a b "[:3]]
    links = tuple(Link(name, Inertia(1.0)) for name in names)
    joints = tuple(Joint(f"joint {k}", WORLD, name) for k, name in enumerate(names))
    robot = Robot("my/robot: 2*", links, joints)
    poses = zero_poses(robot)
    given_ = Built(robot, (), poses, {name: (body(box(1, 1, 1)),) for name in names})
    exported = export_built(given_, ALL, tmp_path / "m")
    written = [file.relative_to(tmp_path / "m").as_posix() for file in exported.files]
    assert len({name.casefold() for name in written}) == len(written)
    assert all(not set(name) & set('<>:"\\|?*') for name in written)
    assert "my_robot__2_.osim" in written
    assert "meshes/visual/_con.stl" in written
    assert without_meshes(read_robot(tmp_path / "m")) == robot
    assert all(len(link.meshes) == 2 for link in read_robot(tmp_path / "m").links)


def test_long_names_are_cut_in_file_names_only(tmp_path):
    names = ["𝐋" * 300 + end for end in "ab"]
    links = tuple(Link(name, Inertia(1.0)) for name in names)
    joints = tuple(Joint(f"joint {k}", WORLD, name) for k, name in enumerate(names))
    robot = Robot("関" * 300, links, joints)
    bodies = {name: (body(box(1, 1, 1)),) for name in names}
    exported = export_built(Built(robot, (), zero_poses(robot), bodies), ALL, tmp_path / "m")
    assert max(len(file.name.encode()) for file in exported.files) < 240
    assert without_meshes(read_robot(tmp_path / "m")) == robot


def test_exports_to_different_folders_are_identical(tmp_path):
    for parent in ("first", "second", "second"):
        export_built(built(bodies=2), ALL, tmp_path / parent / "arm")
    assert files_of(tmp_path / "first") == files_of(tmp_path / "second")
    for content in files_of(tmp_path / "first").values():
        assert str(tmp_path).encode() not in content


def test_formats_are_options(tmp_path):
    export_built(built(), ExportSettings(caspr=False, osim=False), tmp_path / "arm")
    assert not (tmp_path / "arm/caspr").exists()
    assert not list((tmp_path / "arm").glob("*.osim"))


def test_caspr_files_contain_a_gentle_motion(tmp_path):
    export_built(built(), ALL, tmp_path / "arm")
    file = tmp_path / "arm/caspr/planar_2r_trajectories.xml"
    assert list(trajectory_names(file)) == ["reference"]
    assert [p.time for p in read_trajectory(file, "reference").points] == [0.0, 2.0, 4.0]


def test_a_format_that_does_not_support_the_robot_is_not_written(tmp_path):
    robot = replace(planar_2r(), gravity=(0.0, -9.81, 0.0))
    exported = export_built(built(robot), ALL, tmp_path / "arm")
    assert not (tmp_path / "arm/caspr").exists()
    (finding,) = [f for f in exported.findings if f.code == "caspr-gravity"]
    assert not finding.is_error
    assert finding.message.startswith("no files for CASPR are written: ")
    assert (tmp_path / "arm/planar_2r.osim").is_file()


def test_all_errors_are_reported_and_nothing_is_written(tmp_path):
    wrong = Finding("error", "closed-loop", "joint 'a': closes a loop", Subject("joint", "a"))
    robot = replace(planar_2r(), name="world", links=planar_2r().links[:1])
    with pytest.raises(RobotError) as caught:
        export_built(Built(robot, (wrong,)), ALL, tmp_path / "a/b")
    reported = [finding.code for finding in caught.value.findings]
    assert "closed-loop" in reported
    assert "unknown-child" in reported
    assert not (tmp_path / "a").exists()
    with pytest.raises(RobotError):
        export_built(Built(None, (wrong,)), ALL, tmp_path / "a")


def test_errors_of_the_sdf_writer_are_errors_of_the_export(tmp_path):
    robot = planar_2r()
    links = (replace(robot.links[0], name="joint_1"), robot.links[1])
    joints = (
        replace(robot.joints[0], child="joint_1"),
        replace(robot.joints[1], parent="joint_1"),
    )
    clash = replace(robot, links=links, joints=joints, cable_sets=(), cable_set="", task_sets=())
    with pytest.raises(RobotError, match="SDF requires unique names"):
        export_built(Built(replace(clash, task_set="")), ALL, tmp_path / "a")


def test_report_contains_the_findings(tmp_path):
    doubt = Finding("warning", "suppressed", "joint 'a' is switched off", Subject("joint", "a"))
    exported = export_built(replace(built(), findings=(doubt,)), ALL, tmp_path / "arm")
    assert doubt in exported.findings
    rows = json.loads((tmp_path / "arm/findings.json").read_text())
    assert rows == [finding.as_dict() for finding in exported.findings]
    lines = (tmp_path / "arm/findings.txt").read_text().splitlines()
    assert lines == [*map(str, exported.findings), f"0 errors, {len(rows)} warnings"]


def test_similar_findings_on_a_format_are_merged(tmp_path):
    exported = export_built(built(chain(20, 5)), ALL, tmp_path / "chain")
    assert codes(exported).count("caspr-meshes") == 1
    (finding,) = [f for f in exported.findings if f.code == "caspr-meshes"]
    assert "19 more like it" in finding.message


def test_progress_counts_up_to_its_end(tmp_path):
    reported: list[tuple[int, int]] = []
    export_built(
        built(),
        ALL,
        tmp_path / "arm",
        progress=lambda done, whole, _: reported.append((done, whole)),
    )
    assert [done for done, _ in reported] == list(range(len(reported)))
    assert {whole for _, whole in reported} == {len(reported)}


@pytest.mark.slow
def test_cancelled_export_leaves_the_folder_unchanged(tmp_path):
    export_built(built(), ALL, tmp_path / "arm")
    before = files_of(tmp_path)
    for last in range(7):

        def cancel(done: int, whole: int, what: str, last: int = last) -> None:
            if done == last:
                raise Cancelled

        with pytest.raises(Cancelled):
            export_built(built(chain(4, 3)), ALL, tmp_path / "arm", progress=cancel)
        assert files_of(tmp_path) == before
        with pytest.raises(Cancelled):
            export_built(built(chain(4, 3)), ALL, tmp_path / "new", progress=cancel)
        assert not (tmp_path / "new").exists()


@pytest.mark.slow
@given(robots())
def test_any_valid_robot_is_read_back(tmp_path, robot):
    robot = replace(robot, links=tuple(replace(link, end=None) for link in robot.links))
    shutil.rmtree(tmp_path / "robot", ignore_errors=True)
    try:
        export_built(Built(robot), ALL, tmp_path / "robot")
    except RobotError:
        assert any(finding.is_error for finding in sdf_losses(robot))
        return
    assert read_robot(tmp_path / "robot") == robot


@pytest.mark.slow
@pytest.mark.skipif(CHECKER is None, reason="libsdformat's checker is not installed")
def test_libsdformat_accepts_an_export(tmp_path):
    for robot in (planar_2r(), random_robot(1), chain(5, 5)):
        export_built(built(robot, bodies=2), ALL, tmp_path / "robot")
        command = [str(CHECKER), "sdf", "-k", str(tmp_path / "robot/model.sdf")]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
        assert "Valid." in done.stdout, done.stdout + done.stderr


SCRIPT = """
import sys
sys.path.insert(0, sys.argv[1])
from array import array
from addin_sdfusion.exporting.export import export_built
from addin_sdfusion.robot import *
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import BodySnapshot, MeshSnapshot
class Built:
    robot = Robot("r", (Link("a", Inertia(1.0)),), (Joint("j", WORLD, "a"),))
    findings = ()
    T_world_link = {"a": Pose()}
    nodes, triangles = [0,0,0, 1,0,0, 0,1,0, 0,0,1], [0,2,1, 0,1,3, 0,3,2, 1,2,3]
    mesh = MeshSnapshot(array("d", nodes), array("i", triangles))
    bodies_of_link = {"a": (BodySnapshot("b", "", mesh=mesh),)}
print(len(export_built(Built(), ExportSettings(), sys.argv[2]).files))
"""


@pytest.mark.slow
def test_export_requires_only_the_standard_library(tmp_path):
    """Fusion's Python has no site-packages and no environment variables."""
    root = str(Path(__file__).parents[3])
    command = [sys.executable, "-I", "-S", "-c", SCRIPT, root, str(tmp_path / "r")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("8\n", "")
