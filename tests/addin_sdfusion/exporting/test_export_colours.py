"""Tests of colours of bodies, from Fusion to all files."""

from __future__ import annotations

from pathlib import Path

import fake_fusion
import pytest
from fake_fusion import Builder, designs

from addin_sdfusion.robot.formats.read import read_robot
from addin_sdfusion.robot.formats.urdf.write import write_urdf
from cardsflow_fmu.results.viewer.scene.meshes import link_meshes

with fake_fusion.modules():
    from support.designs.exported import export


def test_colours_of_bodies_reach_every_file(tmp_path: Path) -> None:
    """Bodies with the same appearance are merged into one mesh."""
    with fake_fusion.install():
        build = Builder("colours")
        paths = designs.chain(build, ("base", "upper"))
        for size, opacity in ((1.0, 0.5), (2.0, 0.5), (3.0, 1.0)):
            body = build.sphere(paths[1], size)
            body.color, body.opacity = (255, 0, 51), opacity
        robot = export(build.done(), tmp_path / "colours").robot
    seen = [m.color for m in robot.link("upper").meshes if m.role == "visual"]
    grey = tuple([160 / 255] * 3 + [1.0])
    expected = [grey, (1.0, 0.0, 0.2, 0.5), (1.0, 0.0, 0.2, 1.0)]
    assert seen == [pytest.approx(color) for color in expected]
    assert {m.color for m in robot.link("upper").meshes if m.role == "collision"} == {None}
    (file,) = (f for f in write_urdf(robot, tmp_path / "urdf") if f.suffix == ".urdf")
    again = read_robot(file).link("upper")
    assert [m.color for m in again.meshes if m.role == "visual"] == seen
    shown = link_meshes(robot, tmp_path / "colours", [tmp_path])
    assert [t.colour for t in shown["upper"]] == [(160, 160, 160), (255, 0, 51), (255, 0, 51)]


def test_urdf_has_materials_by_name(tmp_path: Path) -> None:
    link = '<visual><geometry><mesh filename="a.stl"/></geometry><material name="{}"/></visual>'
    (tmp_path / "r.urdf").write_text(
        '<robot name="r"><material name="blue"><color rgba="0 0 1 1"/></material>'
        f'<link name="a">{link.format("blue")}{link.format("none")}</link></robot>'
    )
    (robot_link,) = read_robot(tmp_path / "r.urdf").links
    assert [m.color for m in robot_link.meshes] == [(0.0, 0.0, 1.0, 1.0), None]
