from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from addin_sdfusion.robot import InputError, RobotError, read_robot, write_sdf
from addin_sdfusion.robot.formats.read import read

EXAMPLE = Path(__file__).parents[4] / "examples/planar_2r/robot"
BOMB = "".join(
    f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefghi", "bcdefghij", strict=True)
)


@pytest.fixture
def folder(tmp_path):
    return Path(shutil.copytree(EXAMPLE, tmp_path / "robot"))


@pytest.fixture
def sdf(tmp_path):
    write_sdf(read_robot(EXAMPLE), tmp_path)
    return tmp_path / "model.sdf"


def rejection_message(path):
    """Return the single-line message that rejects a robot file."""
    with pytest.raises(InputError) as caught:
        read_robot(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


UNREADABLE = {
    "entity bomb": (f'<!DOCTYPE a [<!ENTITY a "ha">{BOMB}]><a>&j;</a>', ":1: uses XML entities"),
    "unused entity": ('<!DOCTYPE a [\n<!ENTITY a "ha">]><a/>', ":2: uses XML entities"),
    "external entity": (
        '<!DOCTYPE a [<!ENTITY a SYSTEM "file:///etc/passwd">]><a>&a;</a>',
        ":1: uses XML entities",
    ),
    "parameter entity": ('<!DOCTYPE a [<!ENTITY % a "b"> %a;]><a/>', ":1: uses XML entities"),
    "entity of an unread DTD": ('<!DOCTYPE a SYSTEM "a.dtd">\n<a>&b;</a>', ":2: uses XML entities"),
    "entity in an attribute": (
        '<!DOCTYPE a SYSTEM "a.dtd">\n<a b="&c;"/>',
        ":2: uses XML entities",
    ),
    "entity in UTF-16": (
        '<?xml version="1.0" encoding="utf-16"?><!DOCTYPE a [<!ENTITY a "b">]><a/>'.encode(
            "utf-16"
        ),
        ":1: uses XML entities",
    ),
    "entity in UTF-7": (
        '<?xml version="1.0" encoding="UTF-7"?><!DOCTYPE a [+ADwAIQ-ENTITY a "b">]><a/>',
        ": uses XML entities",
    ),
    "truncated": ("<bodies_system>\n<links>\n", "is not well-formed XML"),
    "no XML at all": ("robot", ":1: is not well-formed XML"),
    "empty": ("", ": is empty"),
    "binary": (b"\x00\x01\x02\xff", "is not well-formed XML"),
    "unknown encoding": ('<?xml version="1.0" encoding="klingon"?><a/>', ":1:"),
    "too deep": ("<a>" * 100_000, "is not well-formed XML"),
    "another kind of file": ("<html/>", ":1: robot 'planar_2r': <html> is not CASPR's"),
}


@pytest.mark.parametrize("case", UNREADABLE)
def test_harmful_or_invalid_xml_is_rejected_in_one_line(folder, case):
    content, message = UNREADABLE[case]
    file = folder / "planar_2r_bodies.xml"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    text = rejection_message(file)
    assert text.startswith(str(file))
    assert message in text


def test_parts_of_a_robot_are_rejected_with_their_file_names(folder):
    file = folder / "planar_2r_cables.xml"
    file.write_text("<cables>\n<cable_set")
    assert rejection_message(folder).startswith(f"{file}:2: is not well-formed XML")


def test_path_without_robot_is_rejected(tmp_path):
    assert "No such file" in rejection_message(tmp_path / "model.sdf")
    assert "cannot be read" in rejection_message(tmp_path / ("x" * 5000 + ".sdf"))
    assert "null byte" in rejection_message(tmp_path / "a\0b.sdf")
    (tmp_path / "folder.sdf").mkdir()
    assert "contains no robot" in rejection_message(tmp_path / "folder.sdf")
    os.mkfifo(tmp_path / "pipe.sdf")
    assert "is not a regular file" in rejection_message(tmp_path / "pipe.sdf")


def test_folder_in_place_of_a_file_is_rejected(folder):
    (folder / "planar_2r_cables.xml").unlink()
    (folder / "planar_2r_cables.xml").mkdir()
    assert "is a folder" in rejection_message(folder)


def test_huge_file_is_rejected_before_reading(tmp_path):
    file = tmp_path / "model.sdf"
    with file.open("wb") as stream:
        stream.truncate(17 * 2**20)
    assert "larger than 16 MiB" in rejection_message(file)


def test_folder_without_robot_or_with_several_lists_its_files(folder):
    shutil.copy(folder / "planar_2r_bodies.xml", folder / "other_bodies.xml")
    text = rejection_message(folder)
    assert "2 robots" in text
    assert "other_bodies.xml" in text
    assert "is not a robot" in rejection_message(folder / "planar_2r_cables.xml")


LINK_2 = '<link_rigid num="2" name="link_2">'

DEFECTS = [
    ("bodies", "<mass>0.1</mass>", "<mass>nan</mass>", "bad-number", 8),
    ("bodies", "<mass>0.1</mass>", "<mass>1e999</mass>", "bad-number", 8),
    ("bodies", "<mass>0.1</mass>", "<mass>1_0</mass>", "bad-number", 8),
    ("bodies", "<mass>0.1</mass>", f"<mass>{'9' * 5000}</mass>", "bad-number", 8),
    ("bodies", "<mass>0.1</mass>", "<mass>-1</mass>", "negative-mass", 5),
    ("bodies", "<mass>0.1</mass>", "", "missing-element", 7),
    ("bodies", "<mass>0.1</mass>", "<mass>1</mass><mass>1</mass>", "repeated-element", 8),
    ("bodies", "0.0 0.0 0.5", "0.0 0.5", "bad-vector", 9),
    ("bodies", 'q_min="-3.1416"', 'q_min="4"', "limits-reversed", 6),
    ("bodies", 'q_min="-3.1416"', 'q_min="nan"', "bad-number", 6),
    ("bodies", 'q_initial="0.0"', "", "missing-attribute", 6),
    ("bodies", '"R_Y"', '"S_QUATERNION"', "unsupported-joint", 6),
    ("bodies", '"R_Y"', '"R_AXIS"', "missing-attribute", 6),
    ("bodies", '"R_Y"', '"R_AXIS" axis="0 0 0"', "zero-axis", 6),
    ("bodies", '"R_Y"', '"R_AXIS" axis="1.7e308 1.7e308 0"', "axis-not-unit", 6),
    ("bodies", 'ref="com"', 'ref="here"', "bad-reference", 11),
    ("bodies", LINK_2, LINK_2.replace("2", "1", 1), "wrong-number", 25),
    ("bodies", LINK_2, LINK_2.replace("link_2", "world"), "reserved-name", 25),
    ("bodies", LINK_2, LINK_2.replace("link_2", ""), "bad-name", 25),
    ("bodies", LINK_2, '<link_rigid num="2">', "missing-attribute", 25),
    ("bodies", "<num>1</num>", "<num>2</num>", "unknown-parent", 40),
    ("bodies", "<num>1</num>", "<num>-1</num>", "bad-number", 41),
    ("bodies", "<num>1</num>", "<num>x</num>", "bad-number", 41),
    ("cables", "<link>1</link>", "<link>3</link>", "unknown-link", 15),
    ("cables", "<force_min>10.0", "<force_min>1000.0", "force-limits-reversed", 5),
    ("cables", "<force_min>10.0", "<force_min>-1", "negative-force", 5),
    ("cables", "<force_min>10.0", "<force_min>inf", "bad-number", 7),
    ("cables", 'attachment_reference="joint"', "", "missing-attribute", 5),
    ("cables", '"joint"', '"base"', "bad-reference", 5),
    ("cables", 'id="basic_2018_07"', 'id="basic"', "duplicate-cable-set", None),
    ("cables", 'default_cable_set="basic"', 'default_cable_set="basik"', "unknown-cable-set", 3),
    ("operational_spaces", "<link>2</link>", "<link>0</link>", "unknown-task-link", 5),
    ("operational_spaces", '"xz"', '"xx"', "bad-task-axes", 5),
    ("operational_spaces", '"xz"', '""', "bad-task-axes", 5),
    ("operational_spaces", '_set="tip"', '_set="top"', "unknown-task-set", 3),
]


@pytest.mark.parametrize(("part", "old", "new", "code", "line"), DEFECTS)
def test_defect_in_a_caspr_file_is_reported_with_its_line(folder, part, old, new, code, line):
    file = folder / f"planar_2r_{part}.xml"
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    errors = [finding for finding in read(folder).findings if finding.is_error]
    (finding,) = [finding for finding in errors if finding.code == code]
    assert finding.file == file
    assert line is None or finding.line == line
    assert rejection_message(folder).startswith(str(file))


@pytest.mark.parametrize(
    ("part", "old", "new", "code", "line", "name"),
    [
        ("bodies", LINK_2, LINK_2.replace("link_2", "link_1"), "duplicate-link", 25, "link_1_2"),
        ("cables", '"cable_2"', '"cable_1"', "duplicate-muscle", 21, "cable_1_2"),
    ],
)
def test_repeated_name_gets_a_number(folder, part, old, new, code, line, name):
    before, file = read_robot(folder), folder / f"planar_2r_{part}.xml"
    file.write_text(file.read_text().replace(old, new, 1))
    reading = read(folder)
    (finding,) = [finding for finding in reading.findings if finding.code == code]
    assert (finding.severity, finding.line, finding.subject.name) == ("warning", line, name)
    robot = reading.require()
    names = [part.name for part in (*robot.links, *robot.muscles)]
    assert name in names
    assert len(set(names)) == len(names)
    ways = [[point.position for point in muscle.via_points] for muscle in robot.muscles]
    assert ways == [[p.position for p in muscle.via_points] for muscle in before.muscles]


def test_defects_in_all_files_are_reported_at_once(folder):
    for part, old, new, _, _ in (DEFECTS[0], DEFECTS[23], DEFECTS[32]):
        file = folder / f"planar_2r_{part}.xml"
        file.write_text(file.read_text().replace(old, new, 1))
    codes = {finding.code for finding in read(folder).findings if finding.is_error}
    assert codes == {"bad-number", "unknown-link", "bad-task-axes"}
    with pytest.raises(RobotError, match="and 2 more"):
        read_robot(folder)


SDF_DEFECTS = [
    ("<mass>0.1</mass>", "<mass>inf</mass>", "bad-number"),
    ("<mass>0.1</mass>", "", "missing-element"),
    ("<child>link_2</child>", "<child>link_3</child>", "unknown-child"),
    ("<child>link_2</child>", "", "missing-element"),
    ("<parent>link_1</parent>", "<parent>link_3</parent>", "unknown-parent"),
    ("<parent>link_1</parent>", "<parent>link_2</parent>", "closed-loop"),
    ('type="revolute"', 'type="gearbox"', "unsupported-joint"),
    ('type="revolute"', 'type="universal"', "missing-element"),
    ('type="revolute"', "", "missing-attribute"),
    ("<xyz>0.0 1.0 0.0</xyz>", "", "missing-element"),
    ("<xyz>0.0 1.0 0.0</xyz>", "<xyz>0 0 0</xyz>", "zero-axis"),
    ("<xyz>0.0 1.0 0.0</xyz>", '<xyz expressed_in="nowhere">0 1 0</xyz>', "unknown-frame"),
    ('relative_to="link_1"', 'relative_to="nowhere"', "unknown-frame"),
    ('relative_to="link_1"', 'relative_to="link_2"', "pose-loop"),
    ('relative_to="link_1"', 'rotation_format="axis_angle"', "unsupported-pose"),
    ('<pose relative_to="link_1">', '<pose relative_to="link_1">1 ', "bad-vector"),
    ('link name="link_2"', 'link name="link_1"', "unknown-child"),
    ('type="FIXPOINT"', 'type="MESH"', "unsupported-via-point"),
    ('type="FIXPOINT"', 'type="SPHERICAL" radius="1"', "wrap-not-between-points"),
    ('type="FIXPOINT"', "", "missing-attribute"),
    ('f_min="10.0"', 'f_min="ten"', "bad-number"),
    ('active="false"', 'active="true"', "two-active-sets"),
    ("</plugin>", '<link_end link="x">0 0 0</link_end></plugin>', "unknown-link"),
    ("</model>", "<include/></model>", "missing-element"),
    ("</model>", '</model><model name="b"/>', "not-one-model"),
    ("1.0 0.0 0.0 0.0</pose>", "1e308 0 0 1e308</pose>", None),
]


@pytest.mark.parametrize(("old", "new", "code"), SDF_DEFECTS)
def test_defect_in_sdf_is_reported_without_other_exceptions(sdf, old, new, code):
    text = sdf.read_text()
    assert old in text
    sdf.write_text(text.replace(old, new, 1))
    codes = {finding.code for finding in read(sdf).findings if finding.is_error}
    assert code is None or code in codes


def test_numbers_that_overflow_in_composed_poses_are_reported(sdf):
    text = sdf.read_text().replace("0.0 0.0 0.0 0.0 0.0 0.0</pose>", "1.5e308 0 0 0 0 0</pose>")
    moved = '<model name="planar_2r"><pose>1.5e308 0 0 0 0 0</pose>'
    sdf.write_text(text.replace('<model name="planar_2r">', moved))
    assert "not-finite" in {finding.code for finding in read(sdf).findings}
