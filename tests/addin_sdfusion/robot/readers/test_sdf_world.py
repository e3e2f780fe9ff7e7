"""Static objects of SDF worlds."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from addin_sdfusion.robot import InputError, Pose
from addin_sdfusion.robot.formats.sdf.world import SdfWorld, StaticObject, read_sdf_world


def world(folder: Path, inside: str, *, wrap: bool = True) -> SdfWorld:
    text = f"<world name='w'>{inside}</world>" if wrap else inside
    (folder / "scene.world").write_text(f"<sdf version='1.6'>{text}</sdf>")
    return read_sdf_world(folder / "scene.world")


def model(geometry: str, name: str = "thing", more: str = "", collision: str = "") -> str:
    return (
        f"<model name='{name}'><static>true</static>{more}<link name='l'><collision name='c'>"
        f"{collision}<geometry>{geometry}</geometry></collision></link></model>"
    )


SHAPES = {
    "sphere": ("<sphere><radius>0.2</radius></sphere>", (0.2,)),
    "box": ("<box><size>1 2 3</size></box>", (1.0, 2.0, 3.0)),
    "cylinder": ("<cylinder><radius>0.1</radius><length>2</length></cylinder>", (0.1, 2.0)),
    "capsule": ("<capsule><radius>0.1</radius><length>2</length></capsule>", (0.1, 2.0)),
}


@pytest.mark.parametrize("kind", SHAPES)
def test_all_shapes_are_read(kind: str, tmp_path: Path) -> None:
    text, sizes = SHAPES[kind]
    read = world(tmp_path, model(text))
    assert read.objects == (StaticObject("thing", kind, sizes, Pose()),)
    assert read.findings == ()
    assert read.ground is None


def test_mesh_keeps_its_file_and_scale(tmp_path: Path) -> None:
    mesh = "<mesh><uri>meshes/a.stl</uri><scale>0.001 0.001 0.001</scale></mesh>"
    (thing,) = world(tmp_path, model(mesh)).objects
    assert thing.sizes == (0.001, 0.001, 0.001)
    assert thing.file == tmp_path / "meshes/a.stl"


def test_poses_of_model_link_and_collision_are_composed(tmp_path: Path) -> None:
    text = model(
        SHAPES["sphere"][0],
        more=f"<pose>1 0 0 0 0 {math.pi / 2}</pose>",
        collision="<pose>0.5 0 0 0 0 0</pose>",
    ).replace("<link name='l'>", "<link name='l'><pose>0 2 0 0 0 0</pose>")
    (thing,) = world(tmp_path, text).objects
    assert thing.pose.position == pytest.approx((-1.0, 0.5, 0.0))
    assert thing.pose.rpy == pytest.approx((0.0, 0.0, math.pi / 2))


def test_smaller_friction_and_restitution_are_read(tmp_path: Path) -> None:
    surface = (
        "<surface><friction><ode><mu>0.7</mu><mu2>0.4</mu2></ode></friction><bounce>"
        "<restitution_coefficient>0.3</restitution_coefficient></bounce></surface>"
    )
    (thing,) = world(tmp_path, model(SHAPES["box"][0], collision=surface)).objects
    assert (thing.friction, thing.restitution) == (0.4, 0.3)


def test_horizontal_plane_is_the_ground(tmp_path: Path) -> None:
    plane = "<plane><normal>0 0 1</normal><size>10 10</size></plane>"
    read = world(tmp_path, model(plane, more="<pose>0 0 -0.3 0 0 0</pose>"))
    assert read.ground == -0.3
    assert read.objects == ()


def test_several_shapes_get_unique_names(tmp_path: Path) -> None:
    two = model(SHAPES["box"][0]).replace(
        "</link>",
        f"<collision name='d'><geometry>{SHAPES['sphere'][0]}</geometry></collision></link>",
    )
    assert [o.name for o in world(tmp_path, two).objects] == ["thing_l_c", "thing_l_d"]
    twice = model(SHAPES["box"][0]) * 2
    assert [o.name for o in world(tmp_path, twice).objects] == ["thing", "thing_2"]


LEFT_OUT = {
    "moving": (
        model(SHAPES["box"][0]).replace("true", "false"),
        "moving-model-left-out",
    ),
    "static not specified": (
        model(SHAPES["box"][0]).replace("<static>true</static>", ""),
        "moving-model-left-out",
    ),
    "include": ("<include><uri>model://sun</uri></include>", "include-left-out"),
    "actor": ("<actor name='a'/>", "unread-element"),
    "heightmap": (model("<heightmap/>"), "geometry-left-out"),
    "slanted plane": (
        model("<plane><normal>0 1 1</normal></plane>"),
        "plane-left-out",
    ),
    "bad size": (model("<sphere><radius>-1</radius></sphere>"), "bad-size"),
    "invalid number": (model("<sphere><radius>x</radius></sphere>"), "bad-number"),
    "two grounds": (model("<plane/>") * 2, "second-ground"),
    "nested": (
        model(SHAPES["box"][0]).replace("<link", "<model name='m'/><link"),
        "model-left-out",
    ),
}


@pytest.mark.parametrize("case", LEFT_OUT)
def test_omitted_elements_are_reported_with_their_line(case: str, tmp_path: Path) -> None:
    text, code = LEFT_OUT[case]
    read = world(tmp_path, text)
    found = {finding.code: finding for finding in read.findings}
    assert code in found
    assert found[code].line is not None
    assert found[code].file == tmp_path / "scene.world"


def test_includes_share_one_warning_and_appearance_has_none(tmp_path: Path) -> None:
    include = "<include><uri>model://{}</uri></include>"
    usual = "<physics><max_step_size>0.001</max_step_size></physics><light name='l'/><gui/>"
    visual = "<visual name='v'><geometry/></visual>"
    boxes = model(SHAPES["box"][0], collision="").replace("<link name='l'>", f"<link>{visual}")
    read = world(tmp_path, include.format("sun") + include.format("table") + usual + boxes)
    (finding,) = read.findings
    assert "'model://sun', 'model://table'" in finding.message


def test_models_are_read_without_a_world(tmp_path: Path) -> None:
    assert len(world(tmp_path, model(SHAPES["box"][0]), wrap=False).objects) == 1


def test_other_files_are_rejected(tmp_path: Path) -> None:
    (tmp_path / "a.world").write_text("<robot/>")
    assert read_sdf_world(tmp_path / "a.world").findings[0].code == "not-sdf"
    (tmp_path / "a.world").write_text("no xml")
    with pytest.raises(InputError, match="not well-formed XML"):
        read_sdf_world(tmp_path / "a.world")
    with pytest.raises(InputError, match="cannot be read"):
        read_sdf_world(tmp_path / "none.world")
