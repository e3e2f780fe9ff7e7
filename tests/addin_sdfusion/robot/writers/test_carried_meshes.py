"""Conversions copy meshes, so that written robots are complete."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import mujoco
import pytest
import trimesh
from support.robots.one_link import one_link

from addin_sdfusion.robot import Mesh, Pose, write_sdf
from addin_sdfusion.robot.formats.read import read
from cardsflow_fmu.cli.main import main

BOX = trimesh.creation.box((0.1, 0.2, 0.3))


@pytest.fixture
def folder(tmp_path):
    """Return a robot whose meshes are referred to in all ways, in a renamed folder."""
    home = tmp_path / "renamed"
    parts = ("box.stl", "a b.stl", "other/box.stl", "ascii.stl")
    for name in parts:
        file = home / "meshes" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        ascii_too = "stl_ascii" if name == "ascii.stl" else "stl"
        BOX.export(file, file_type=ascii_too)
    (tmp_path / "outside.stl").write_bytes((home / "meshes/box.stl").read_bytes())
    (home / "meshes/no.stl").write_text("no mesh")
    uris = ["model://r/meshes/box.stl", "meshes/a%20b.stl", "meshes/other/box.stl"]
    uris += ["meshes/ascii.stl", "../outside.stl", "meshes/no.stl", f"file://{home}/meshes/box.stl"]
    meshes = tuple(Mesh("visual", uri, Pose((0.1 * k, 0, 0))) for k, uri in enumerate(uris))
    robot = one_link()
    write_sdf(replace(robot, links=(replace(robot.links[0], meshes=meshes),)), home)
    return home


def converted(folder, format_, output):
    assert main(["convert", str(folder), "--to", format_, "-o", str(output)]) == 0
    return sorted(str(f.relative_to(output)) for f in output.rglob("*") if f.is_file())


CARRIED = [f"meshes/{name}" for name in ("a b.stl", "ascii.stl", "box.stl", "other/box.stl")]


@pytest.mark.parametrize("format_", ["sdf", "urdf", "osim"])
def test_meshes_in_the_folder_are_copied_and_others_are_not(folder, format_, tmp_path, capsys):
    files = converted(folder, format_, tmp_path / "new")
    assert [name for name in files if name.endswith(".stl")] == CARRIED
    output = capsys.readouterr().err
    assert "'../outside.stl' is not copied: is outside" in output
    assert "'meshes/no.stl' is not copied: cannot be used as a mesh" in output


def test_written_robot_finds_its_meshes(folder, tmp_path):
    converted(folder, "sdf", tmp_path / "new")
    for name in CARRIED:
        (folder / name).unlink()
    (tmp_path / "outside.stl").unlink()
    (finding,) = [f for f in read(tmp_path / "new").findings if "mesh" in f.code]
    assert "2 of 7 mesh files are not found" in finding.message  # which are not copied
    uris = [mesh.uri for mesh in read(tmp_path / "new").require().links[0].meshes]
    assert uris[0] == "model://r/meshes/box.stl"


def test_urdf_refers_to_files_next_to_it(folder, tmp_path):
    converted(folder, "urdf", tmp_path / "new")
    root = ElementTree.parse(tmp_path / "new/r.urdf").getroot()
    named = [mesh.get("filename") for mesh in root.iter("mesh")]
    assert named[:4] == ["meshes/box.stl", "meshes/a b.stl", "meshes/other/box.stl", CARRIED[1]]


def test_mujoco_opens_copied_meshes(folder, tmp_path, capsys):
    files = converted(folder, "mjcf", tmp_path / "new")
    assert files == [name for name in CARRIED if "ascii" not in name] + ["r.xml"]
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "new/r.xml"))
    assert (model.nmesh, model.body_mass[1]) == (4, 1.0)  # the same file twice
    assert "MuJoCo cannot read 'meshes/ascii.stl'" in capsys.readouterr().err


def test_check_and_convert_repair_equally(shared, capsys):
    robot = str(shared / "robots/cardsflow/test_robot")
    main(["check", robot])
    assert "use --repair to correct them" in capsys.readouterr().out
    main(["check", robot, "--repair"])
    output = capsys.readouterr().out
    assert "[repaired-inertia]" in output
    assert "[inertia-about-origin]" not in output


def test_links_do_not_redirect_meshes(folder, tmp_path, capsys):
    (tmp_path / "new").mkdir()
    (tmp_path / "of others").mkdir()
    (tmp_path / "new/meshes").symlink_to(tmp_path / "of others")
    assert main(["convert", str(folder), "--to", "urdf", "-o", str(tmp_path / "new")]) == 2
    assert "new/meshes: is a link; remove it" in capsys.readouterr().err
    assert list((tmp_path / "of others").iterdir()) == []
    assert [file.name for file in (tmp_path / "new").iterdir()] == ["meshes"]


def test_meshes_are_written_before_the_robot(folder, tmp_path):
    """A written robot is always complete: here its mesh cannot be written."""
    (tmp_path / "new/meshes/other").mkdir(parents=True)
    (tmp_path / "new/meshes/other/box.stl").mkdir()
    assert main(["convert", str(folder), "--to", "urdf", "-o", str(tmp_path / "new")]) == 2
    assert not (tmp_path / "new/r.urdf").exists()
