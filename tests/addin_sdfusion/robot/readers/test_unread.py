"""Elements that no reader uses are findings; components of OpenSim models are used."""

from __future__ import annotations

from pathlib import Path

import pytest
from lxml import etree
from support.robots.robots import EXAMPLES, planar_2r
from support.third_party_models import OSIM, URDF

from addin_sdfusion.robot import Robot, read_robot, write_sdf
from addin_sdfusion.robot.formats.opensim.write import write_osim
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.formats.urdf.write import write_urdf

ROBOY = read_robot(EXAMPLES / "roboy_left_arm/robot")
SETS = ("BodySet", "JointSet", "ForceSet", "ConstraintSet", "MarkerSet", "ComponentSet")


def unread(file: Path) -> list[str]:
    return [str(f) for f in read(file).findings if f.code == "unread-element"]


def with_components(text: str) -> str:
    """Return an .osim file with the objects of all sets in `<components>` of the model."""
    root = etree.fromstring(text.encode())
    model = root.find("Model")
    assert model is not None
    components = etree.SubElement(model, "components")
    for name in SETS:
        for group in model.findall(name):
            components.extend(list(group.iterfind("objects/*")))
            model.remove(group)
    moved = etree.tostring(root, encoding="unicode")
    for name in SETS:
        moved = moved.replace(f"/{name.lower()}/", "/")
    return moved


@pytest.mark.parametrize("robot", [planar_2r(), ROBOY], ids=lambda robot: robot.name)
def test_components_of_an_opensim_model_are_read_like_sets(robot: Robot, tmp_path: Path) -> None:
    write_osim(robot, tmp_path)
    (file,) = tmp_path.glob("*.osim")
    before = read(file).require()
    file.write_text(with_components(file.read_text()))
    after = read(file)
    assert after.require() == before
    assert before.muscles


def test_components_of_a_published_model_are_read_like_sets(shared: Path, tmp_path: Path) -> None:
    for name in ("arm26", "leg6dof9musc"):
        file = shared / f"models/opensim/{name}.osim"
        text = file.read_text()
        moved = tmp_path / file.name
        moved.write_text(with_components(text))
        assert read(moved).require() == read(file).require()


def test_a_component_of_another_kind_is_reported(tmp_path: Path) -> None:
    file = tmp_path / "leg.osim"
    component = '<components><Thermostat name="t1"/><Thermostat name="t2"/></components>'
    file.write_text(OSIM.replace("</Model>", component + "</Model>"))
    (finding,) = [text for text in unread(file) if "Thermostat" in text]
    line = file.read_text().splitlines().index(next(
        text for text in file.read_text().splitlines() if "Thermostat" in text)) + 1  # fmt: skip
    assert f"leg.osim:{line}: " in finding
    assert "<components><Thermostat> is not supported and was ignored" in finding
    assert "(2 times: 't1', 't2')" in finding


def test_unknown_elements_are_reported_at_any_depth(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(URDF.replace("</inertial>", "<stray/></inertial>", 1))
    assert any("<inertial><stray> is not supported" in text for text in unread(file))
    write_sdf(planar_2r(), tmp_path / "sdf")
    file = tmp_path / "sdf/model.sdf"
    assert unread(file) == []
    file.write_text(file.read_text().replace("</link>", "<stray/></link>"))
    (finding,) = unread(file)
    assert "<link><stray> is not supported and was ignored (" in finding


def test_our_own_files_have_no_unread_elements(tmp_path: Path) -> None:
    write_osim(ROBOY, tmp_path / "osim")
    write_urdf(ROBOY, tmp_path / "urdf")
    for file in (*tmp_path.glob("*/*.osim"), *tmp_path.glob("*/*.urdf")):
        assert unread(file) == []


def test_muscles_beside_cable_sets_are_reported_if_they_differ(tmp_path: Path) -> None:
    write_sdf(planar_2r(), tmp_path)
    beside = tmp_path / "cardsflow.xml"
    assert [f.code for f in read(tmp_path).findings if f.code == "elements-ignored"] == []
    text = beside.read_text()
    beside.write_text(text.replace('f_max="', 'f_max="1', 1))
    (finding,) = [f for f in read(tmp_path).findings if f.code == "elements-ignored"]
    assert "differ from the cable sets" in finding.message


def test_bytes_of_latin_1_are_read_with_a_finding(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    text = URDF.replace('<robot name="', '<robot name="bras dépl\u2013acé ', 1)
    file.write_text(text)
    assert "not-utf-8" not in [finding.code for finding in read(file).findings]
    file.write_bytes(text.replace("\u2013", "").encode("latin-1"))
    reading = read(file)
    assert reading.require().name.startswith("bras déplacé ")
    assert [f.code for f in reading.findings].count("not-utf-8") == 1


def test_disabled_wrap_objects_and_colours_are_not_reported(tmp_path: Path) -> None:
    wrap = (
        "<WrapObjectSet><objects><WrapSphere name='s'><active>false</active><radius>0.1</radius>"
        "<xyz_body_rotation>1 2 3</xyz_body_rotation></WrapSphere></objects></WrapObjectSet>"
    )
    osim = tmp_path / "m.osim"
    osim.write_text(OSIM)
    before = unread(osim)
    osim.write_text(OSIM.replace("</Body>", f"{wrap}</Body>", 1))
    assert unread(osim) == before
    write_sdf(ROBOY, tmp_path / "sdf")
    sdf = tmp_path / "sdf/model.sdf"
    visual = (
        "<visual name='v'><geometry><mesh><uri>a.stl</uri></mesh></geometry><material>"
        "<ambient>1 0 0 1</ambient><specular>1 0 0 1</specular></material></visual></link>"
    )
    sdf.write_text(sdf.read_text().replace("</link>", visual, 1))
    assert unread(sdf) == []
