"""muscles.csv next to robot files: contents, errors with their lines, and round trips."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.robots.rare_muscle import RARE
from support.robots.urdf_arm import HEAD, TABLE, URDF

from addin_sdfusion.robot import InputError, Robot, read_robot
from addin_sdfusion.robot.formats.convert import convert
from addin_sdfusion.robot.formats.muscle_table.document import MuscleDocument
from addin_sdfusion.robot.formats.muscle_table.read import MuscleTableReading, read_table
from addin_sdfusion.robot.formats.muscle_table.write import table_text
from addin_sdfusion.robot.formats.read import Reading, read

EXAMPLES = Path(__file__).parents[4] / "examples"
ROBOTS = [
    *(f"{name}/robot" for name in ("bicycle", "cable_robot", "hill_arm", "pick_up", "planar_2r")),
    *("pneumatic_elbow/robot", "roboy_left_arm/robot", "models/arm.xml", "models/leg.osim"),
]


def _write(folder: Path, table: str, name: str = "muscles.csv") -> Path:
    (folder / "arm.urdf").write_text(URDF)
    (folder / name).write_text(table)
    return folder / "arm.urdf"


def _read_back(robot: Robot, table: str) -> tuple[Robot, MuscleTableReading]:
    reading = read_table(table.encode(), [link.name for link in robot.links], Path("muscles.csv"))
    return reading.document.apply_to(replace(robot, wrap_surfaces=())), reading


@pytest.mark.parametrize("path", ROBOTS)
def test_table_restores_the_muscles_of_examples_exactly(path: str) -> None:
    robot = read_robot(EXAMPLES / path)
    again, reading = _read_back(robot, table_text(MuscleDocument.of(robot)))
    assert reading.findings == ()
    assert again == robot


def test_table_holds_rare_properties() -> None:
    robot = read_robot(EXAMPLES / "hill_arm/robot")
    links = [link.name for link in robot.links]
    rare = replace(robot, cable_sets=(replace(robot.cable_sets[0], muscles=(RARE,)),))
    text = table_text(MuscleDocument.of(rare)).replace("upper,", f"{links[0]},")
    text = text.replace('""upper""', f'""{links[0]}""')
    again, reading = _read_back(rare, text)
    assert reading.findings == ()
    assert table_text(MuscleDocument.of(again)) == text


def test_muscles_next_to_a_urdf_are_read(tmp_path: Path) -> None:
    reading = read(_write(tmp_path, TABLE))
    robot = reading.require()
    assert [(m.name, m.f_max, len(m.via_points)) for m in robot.muscles] == [
        ("front", 100.0, 2),
        ("back", 100.0, 2),
    ]
    assert tmp_path / "muscles.csv" in reading.files
    assert "muscles-replaced" not in _codes(reading)


def test_table_of_the_robot_takes_precedence(tmp_path: Path) -> None:
    file = _write(tmp_path, TABLE)
    _write(tmp_path, TABLE.replace("front", "left"), "arm.muscles.csv")
    assert [m.name for m in read_robot(file).muscles] == ["left", "back"]


def test_replaced_muscles_are_the_first_finding(tmp_path: Path) -> None:
    shutil.copytree(EXAMPLES / "pneumatic_elbow/robot", tmp_path / "robot")
    robot = read_robot(tmp_path / "robot")
    convert(robot, "muscles.csv", tmp_path / "robot")
    assert read(tmp_path / "robot").require() == robot
    assert "muscles-replaced" not in _codes(read(tmp_path / "robot"))
    convert(robot.with_muscles(robot.muscles[:1]), "muscles.csv", tmp_path, overwrite=True)
    (tmp_path / "muscles.csv").replace(tmp_path / "robot/muscles.csv")
    first = read(tmp_path / "robot").findings[0]
    assert "1 muscles of muscles.csv replace the 2 muscles of the robot file" in first.message


def test_other_cable_sets_of_the_robot_remain(tmp_path: Path) -> None:
    shutil.copytree(EXAMPLES / "planar_2r/robot", tmp_path / "robot")
    robot = read_robot(tmp_path / "robot")
    losses = convert(robot, "muscles.csv", tmp_path / "robot").findings
    assert [f.code for f in losses] == ["links-left-out", "cable-sets-left-out"]
    assert read_robot(tmp_path / "robot") == robot
    other = read_robot(tmp_path / "robot", "basic_2018_07")
    assert other == robot.with_cable_set("basic_2018_07")
    again = convert(robot, "caspr", tmp_path / "robot", overwrite=True)
    assert "beside-muscle-table" in [f.code for f in again.findings]


def test_changed_surfaces_of_other_cable_sets_are_reported(tmp_path: Path) -> None:
    robot = read_robot(EXAMPLES / "hill_arm/robot")
    again = replace(robot.cable_sets[0], name="b")
    convert(replace(robot, cable_sets=(*robot.cable_sets, again)), "sdf", tmp_path)
    surfaces = tuple(replace(s, radius=0.9 * s.radius) for s in robot.wrap_surfaces)
    convert(replace(robot, wrap_surfaces=surfaces), "muscles.csv", tmp_path)
    assert _codes(read(tmp_path)).count("shared-surface") == len(surfaces)


@pytest.mark.parametrize(
    ("table", "code", "line"),
    [
        (TABLE.replace("back,link,base", "back,link,bse"), "unknown-link", 4),
        (TABLE.replace("back,link,base", "back,root,base"), "bad-frame", 4),
        (TABLE.replace("frame,", ""), "missing-column", 1),
        (HEAD + "front,link,base,0,0,0,100\n", "too-few-via-points", 2),
        ("role," + HEAD + "eye,m,link,base,0,0,0,1\n", "bad-role", 2),
        ("role,number,surface," + HEAD + "wrap,0,s,m,,,,,,\n", "unknown-muscle", 2),
        ("role,shape," + HEAD + "surface,cone,s,link,base,0,0,0,\n", "bad-shape", 2),
        ("options," + HEAD + "{,m,link,base,0,0,0,1\n", "bad-options", 2),
        ("options," + HEAD + '"{""f"": 1}",m,link,base,0,0,0,1\n', "bad-options", 2),
    ],
)
def test_errors_have_the_line_in_the_table(
    tmp_path: Path, table: str, code: str, line: int
) -> None:
    reading = read(_write(tmp_path, table))
    found = [f for f in reading.findings if f.code == code]
    assert [(f.is_error, f.file, f.line) for f in found] == [(True, tmp_path / "muscles.csv", line)]
    with pytest.raises(InputError):
        reading.require()


def test_wraps_are_counted_from_the_numbers_of_points() -> None:
    robot = read_robot(EXAMPLES / "hill_arm/robot")
    link = robot.links[0].name
    text = (
        "role,name,number,frame,link,x,y,z,surface,side,shape,radius [mm]\n"
        f"via,m,5,link,{link},0,0,0\nvia,m,3,link,{link},1,0,0\nvia,m,9,link,{link},2,0,0\n"
        f"wrap,m,5,,,,,,s,-1,,\nsurface,s,,link,{link},0,0,0,,,sphere,20\n"
    )
    again, reading = _read_back(robot, text)
    assert reading.findings == ()
    wrap = again.muscles[0].wraps[0]
    assert (wrap.segment, wrap.side, again.wrap_surfaces[0].radius) == (1, -1, 0.02)
    assert [p.position[0] for p in again.muscles[0].via_points] == [1.0, 0.0, 2.0]


@given(st.binary(max_size=100))
def test_any_bytes_are_read_without_an_exception(data: bytes) -> None:
    head = b"role,name,number,frame,link,x,y,z,surface,side,turns,inside,shape,radius,options\n"
    for text in (data, head + data, head + b"surface,s,,link,world,0,0,0,,,,,sphere," + data):
        read_table(text, ["arm"], Path("muscles.csv"))


def _codes(reading: Reading) -> list[str]:
    return [finding.code for finding in reading.findings]
