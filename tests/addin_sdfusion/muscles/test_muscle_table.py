from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addin_sdfusion.muscles.attributes import (
    muscles_text,
    point_text,
    read_point,
    read_settings,
    read_wrap,
    settings_text,
    wrap_text,
)
from addin_sdfusion.muscles.csv_reader import COLUMNS, read_csv
from addin_sdfusion.muscles.csv_writer import csv_text
from addin_sdfusion.muscles.design_table import read_table
from addin_sdfusion.muscles.merge import merge
from addin_sdfusion.muscles.mirror import Plane, mirror_muscle, other_side
from addin_sdfusion.muscles.path import path_of
from addin_sdfusion.muscles.rows import PointRow, WrapRow, by_name
from addin_sdfusion.muscles.stored import stored_muscles, stored_point, stored_surface
from addin_sdfusion.muscles.table import MuscleTable
from addin_sdfusion.robot.errors import InputError
from addin_sdfusion.robot.finding import Finding
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import (
    DesignSnapshot,
    MuscleSnapshot,
    PointSnapshot,
    PointUse,
    SurfaceSnapshot,
    SurfaceUse,
    WrapUse,
)

# Reading a design


def point(name: str, use: PointUse | None = None, **more: Any) -> PointSnapshot:
    place = {"occurrence": "a:1", "position": (0.0, 0.0, 0.0), "entity": name} | more
    return PointSnapshot(name, use=use, **place)


def design(*points: PointSnapshot, **more: Any) -> DesignSnapshot:
    return DesignSnapshot("robot", points=points, **more)


def codes(findings: list[Finding]) -> list[str]:
    return [finding.code for finding in findings]


def test_old_designs_are_read_in_numeric_order() -> None:
    names = [f"VP_motor{m}_EXPORT_a_0_{k}" for m in (10, 2) for k in (10, 2, 9)]
    table, findings = read_table(design(*map(point, names)))
    assert [row.name for row in table.rows] == ["motor2", "motor10"]
    assert [p.number for p in table.points_of("motor2")] == [2, 9, 10]
    assert {p.link for p in table.points} == {"a_0"}
    assert {(row.f_min, row.f_max) for row in table.rows} == {(10.0, 80.0)}
    assert codes(findings) == ["default-forces"] * 2 + ["missing-number"] * 2
    assert not any(finding.is_error for finding in findings)


def test_copied_points_are_an_error() -> None:
    names = ["VP_motor0_EXPORT_a_0", "VP_motor0_EXPORT_a_0 (1)"]
    table, findings = read_table(design(*map(point, names)))
    assert len(table.points) == 2
    copied = next(f for f in findings if f.code == "copied-point")
    assert copied.is_error
    assert names[1] in copied.message
    assert "duplicate-number" in codes(findings)


def test_an_attribute_takes_precedence_over_the_name() -> None:
    attribute = PointUse("via", "arm", "biceps", 4)
    table, findings = read_table(design(point("VP_motor0_EXPORT_hand_9", attribute)))
    (row,) = table.points
    assert (row.muscle, row.number, row.link) == ("biceps", 4, "arm")
    assert codes(findings) == ["default-forces"]


def test_points_of_all_roles() -> None:
    task = PointUse("task", "hand", name="tip", axes=("x", "z"))
    marker = PointUse("marker", "hand", name="led")
    table, findings = read_table(
        design(
            point("p", task),
            point("q", marker),
            point("EE_hand"),
            point("EE_hand (1)"),
            point("VM_arm"),
            point("COM_arm"),
            point("VP_wrong"),
            point("Origin"),
        )
    )
    assert [(t.name, t.link, t.axes) for t in table.tasks] == [
        ("hand", "hand", ("x", "y", "z")),
        ("hand_1", "hand", ("x", "y", "z")),
        ("tip", "hand", ("x", "z")),
    ]
    assert [(m.name, m.link) for m in table.markers] == [("arm", "arm"), ("led", "hand")]
    assert codes(findings) == ["bad-point-name"]


def test_a_point_with_several_occurrences_is_read_on_its_link() -> None:
    attribute = PointUse("via", "right", "m", 0)
    places = [
        point("p", attribute, occurrence=path, position=(x, 0.0, 0.0))
        for path, x in (("arm:1", 1.0), ("arm:2", 2.0))
    ]
    link_of = {"arm:1": "left", "arm:2": "right"}
    table, _ = read_table(design(*places), link_of)
    assert [p.position[0] for p in table.points] == [2.0]
    table, _ = read_table(design(*places))
    assert [p.position[0] for p in table.points] == [1.0]
    meant = replace(attribute, occurrence="arm:1")
    table, _ = read_table(design(*(replace(p, use=meant) for p in places)), link_of)
    assert [p.position[0] for p in table.points] == [1.0]


def test_a_point_without_link_belongs_to_the_link_of_its_component() -> None:
    use = PointUse("via", muscle="m")
    places = [
        point(str(k), replace(use, number=k), occurrence=o) for k, o in enumerate(("a:1", ""))
    ]
    table, _ = read_table(design(*places), {"a:1": "arm"})
    assert [p.link for p in table.points] == ["arm", "world"]
    (row,) = read_table(design(places[0]))[0].points
    assert row.link == "a:1"  # not a link: the finding contains the component


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "{}", '{"role": "eye", "link": "a"}',
             '{"role": "via", "link": "a", "what": 1}', '{"role": "via", "link": 1}', "[" * 9999]
)  # fmt: skip
def test_broken_attributes_are_findings(text: str) -> None:
    findings: list[Finding] = []
    assert stored_point({"point": text}, "p", findings) is None
    assert stored_point({"point": text}, "p", findings) is None  # another occurrence: reported once
    assert codes(findings) == ["bad-attribute"]
    assert "'p'" in findings[0].message


@pytest.mark.parametrize(
    "text", ["{", "{}", "[1]", '[{"name": "m", "color": "red"}]', '[{"f_min": 1}]',
             '[{"name": "m", "parameters": {"K": "x"}}]', '[{"name": "m", "parameters": 1}]',
             '[{"name": "m", "parameters": {"K": NaN}}]', '[{"name": "m", "model": "magic"}]']
)  # fmt: skip
def test_a_broken_list_of_muscles_is_a_finding(text: str) -> None:
    findings: list[Finding] = []
    assert stored_muscles({"muscles": text}, "robot", findings) == ()
    assert codes(findings) == ["bad-attribute"]


def stored(text: str) -> tuple[MuscleSnapshot, ...]:
    findings: list[Finding] = []
    muscles = stored_muscles({"muscles": text}, "robot", findings)
    assert not findings
    return muscles


def test_the_list_of_muscles_defines_order_and_forces() -> None:
    rows = (MuscleSnapshot("z", f_max=math.inf), MuscleSnapshot("a", "#00ff00", 1.0, 2.0))
    attribute = PointUse("via", "arm", "m", 0)
    table, findings = read_table(design(point("p", attribute), muscles=stored(muscles_text(rows))))
    assert table.rows[:2] == rows
    assert table.rows[2].name == "m"
    table, findings = read_table(design(muscles=stored(muscles_text(rows)) * 2))
    assert table.rows == rows
    assert codes(findings) == ["duplicate-muscle"] * 2


def test_wrap_surfaces_and_their_findings() -> None:
    points = [point(str(k), PointUse("via", "arm", "m", k)) for k in (3, 4)]
    good = SurfaceUse("w", "arm", (WrapUse("m", 3, 1, 2),))
    bad = SurfaceUse("w", "arm", (WrapUse("m", 4), WrapUse("n", 0)))
    surfaces = [
        SurfaceSnapshot("a:1", "cylinder", 0.01, (1.0, 2.0, 3.0), (1.0, 0.0, 0.0), 0.2, str(i),
                        attribute)
        for i, attribute in enumerate((good, bad))
    ]  # fmt: skip
    surfaces.append(replace(surfaces[0], entity="2", use=None))
    found: list[Finding] = []
    assert stored_surface({"wrap": "?"}, "a:1", found) is None
    assert codes(found) == ["bad-attribute"]
    table, findings = read_table(design(*points, surfaces=tuple(surfaces)))
    assert table.wraps_of("m")[0][1] == WrapUse("m", 3, 1, 2)
    assert table.wraps[0].face.length == 0.2
    assert sorted(codes(findings)) == sorted(
        ["default-forces", "bad-wrap", "bad-wrap", "duplicate-wrap"]
    )


def test_huge_numbers_do_not_take_long() -> None:
    points = [point(str(k), PointUse("via", "arm", "m", k)) for k in (0, 10**15)]
    _, findings = read_table(design(*points))
    assert "1, 2, 3, 4, 5, ..." in findings[-1].message


def test_attributes_are_read_back_unchanged() -> None:
    attribute = PointUse("task", "a", name="n", axes=("x",), occurrence="a:1", made=True)
    assert read_point(point_text(attribute)) == attribute
    assert json.loads(point_text(attribute)).keys() >= {"role", "muscle", "number", "link", "name"}
    wrap = SurfaceUse("w", "a", (WrapUse("m", 1, -1, 2), WrapUse("n", 0)), "a:1")
    assert read_wrap(wrap_text(wrap)) == wrap
    rows = (MuscleSnapshot("ü", "#ff0000", 1.0, math.inf, "linear_spring", {"K": 1e-9}),)
    assert stored(muscles_text(rows)) == rows
    settings = ExportSettings("n", cut_joints=("a", "b"), up_axis="y")
    assert read_settings(settings_text(settings)) == settings
    with pytest.raises(InputError):
        read_settings("[]")


# Edits


names = st.text(
    st.characters(categories=("Lu", "Ll", "Nd", "Pd", "Po", "Sc"), exclude_characters="\x00"),
    min_size=1,
    max_size=6,
)
numbers = st.floats(allow_nan=False, allow_infinity=False)
positions = st.tuples(numbers, numbers, numbers)
rows = st.builds(
    MuscleSnapshot,
    names,
    st.from_regex(r"#[0-9a-f]{6}", fullmatch=True),
    numbers,
    st.one_of(numbers, st.just(math.inf)),
    st.sampled_from(["ideal", "linear_spring", "vsd_flexure"]),
    st.dictionaries(st.from_regex(r"[A-Za-z_0-9]{1,5}", fullmatch=True), numbers, max_size=3),
)


def via(muscle: str, number: int, link: str, position: Any, entity: str = "") -> PointRow:
    return PointRow("via", link, muscle, number, position=position, entity=entity)


@st.composite
def tables(draw: st.DrawFn) -> MuscleTable:
    table = MuscleTable(tuple(draw(st.lists(rows, max_size=3, unique_by=lambda r: r.name))))
    for row in table.rows:
        for k in range(draw(st.integers(0, 4))):
            place = via(row.name, k, draw(names), draw(positions), f"{row.name}/{k}")
            table = table.insert_point(place)
    axes = st.sampled_from([("x", "y", "z"), ("alpha",)])
    tasks, markers = (
        st.builds(PointRow, st.just(role), names, name=names, axes=axes_, position=positions)
        for role, axes_ in (("task", axes), ("marker", st.just(())))
    )
    others = st.lists(st.one_of(tasks, markers), max_size=4, unique_by=lambda r: (r.role, r.name))
    return replace(table, others=by_name(draw(others)))


SPHERE = SurfaceSnapshot("", "sphere", 0.1, (0.0, 0.0, 0.0))


def muscle(count: int = 4, wraps: tuple[WrapUse, ...] = (), first: int = 0) -> MuscleTable:
    points = tuple(via("m", first + k, "arm", (float(k), 0.0, 0.0), f"e{k}") for k in range(count))
    wrap = WrapRow("w", "arm", wraps, face=SPHERE)
    return MuscleTable((MuscleSnapshot("m"),), points, wraps=(wrap,))


def entities(table: MuscleTable) -> list[str]:
    return [p.entity for p in table.points_of("m")]


def after(table: MuscleTable) -> list[int]:
    return [use.after for use in table.wraps[0].muscles]


def test_points_are_inserted_moved_duplicated_and_deleted() -> None:
    table = muscle(3, first=1)
    new = via("m", -1, "arm", (9.0, 0.0, 0.0), "new")
    assert entities(table.insert_point(new)) == ["e0", "e1", "e2", "new"]
    assert entities(table.insert_point(new, 0)) == ["new", "e0", "e1", "e2"]
    assert entities(table.move_point("m", 0, 1)) == ["e1", "e0", "e2"]
    assert entities(table.move_point("m", 0, -1)) == ["e0", "e1", "e2"]
    assert entities(table.move_point("m", 2, 5)) == ["e0", "e1", "e2"]
    assert entities(table.duplicate_point("m", 0)) == ["e0", "e0", "e1", "e2"]
    assert entities(table.delete_point("m", 0)) == ["e1", "e2"]
    for edited in (
        table.insert_point(new, 0),
        table.move_point("m", 0, 1),
        table.delete_point("m", 0),
    ):
        count = len(edited.points)
        assert [p.number for p in edited.points] == list(range(1, count + 1))


@pytest.mark.slow
@given(st.integers(2, 6), st.data())
def test_wrap_surfaces_stay_after_their_point(count: int, data: st.DataObject) -> None:
    index = data.draw(st.integers(0, count - 1))
    use = data.draw(st.integers(0, max(count - 2, 0)))
    table = muscle(count, (WrapUse("m", use), WrapUse("other", 7)))
    new = via("m", -1, "arm", (9.0, 0.0, 0.0), "new")
    inserted = table.insert_point(new, index)
    assert entities(inserted)[after(inserted)[0]] == f"e{use}"
    deleted = table.delete_point("m", index)
    if count > 2:
        assert 0 <= after(deleted)[0] < count - 2
        if index > use and use < count - 2:
            assert entities(deleted)[after(deleted)[0]] == f"e{use}"
    assert after(inserted)[1] == after(deleted)[1] == 7


@pytest.mark.slow
@given(tables())
def test_numbers_are_consecutive(table: MuscleTable) -> None:
    table = table.renumber()
    for row in table.rows:
        assert [p.number for p in table.points_of(row.name)] == list(
            range(len(table.points_of(row.name)))
        )
    assert table.renumber() == table


def test_muscles_are_renamed_and_deleted_with_their_wraps() -> None:
    table = muscle(2, (WrapUse("m", 0),))
    renamed = table.rename_muscle("m", "n")
    assert renamed.row("m") is None
    assert len(renamed.points_of("n")) == 2
    assert renamed.wraps[0].muscles[0].muscle == "n"
    assert table.delete_muscle("m") == MuscleTable(wraps=(replace(table.wraps[0], muscles=()),))
    assert muscle().new_muscle_name() == "motor0"


def test_a_created_point_moved_to_another_link_is_created_again() -> None:
    table = muscle(2)
    made = replace(table.points[0], made=True).on_link("hand")
    assert (made.link, made.entity) == ("hand", "")
    kept = table.points[1].on_link("hand")
    assert (kept.link, kept.entity) == ("hand", "e1")


# Mirror


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("arm_l", "arm_r"), ("l_arm", "r_arm"), ("upper_arm_left", "upper_arm_right"),
        ("left-arm", "right-arm"), ("LEFT_ARM", "RIGHT_ARM"), ("LeftArm", "RightArm"),
        ("armLeft", "armRight"), ("armL", "armR"), ("LArm", "RArm"), ("Arm_L", "Arm_R"),
        ("hand.l", "hand.r"), ("left", "right"),
    ],
)  # fmt: skip
def test_left_and_right_are_exchanged(name: str, other: str) -> None:
    assert other_side(name) == other
    assert other_side(other) == name


@pytest.mark.parametrize("name", ["torso", "roll", "lower_arm", "wheel", "Lever", "ankle", "l", ""])
def test_names_without_a_side(name: str) -> None:
    assert other_side(name) is None


@given(positions.filter(lambda p: all(abs(v) < 1e3 for v in p)), st.integers(0, 2))
def test_mirroring_twice_is_the_identity(p: tuple[float, float, float], axis: int) -> None:
    normal = tuple(2.0 if i == axis else 0.0 for i in range(3))
    plane = Plane((0.5, -0.25, 1.0), normal)  # type: ignore[arg-type]
    image = plane.mirrored(p)
    assert plane.mirrored(image) == pytest.approx(p, abs=1e-9)
    assert image[axis] - plane.point[axis] == pytest.approx(plane.point[axis] - p[axis], abs=1e-9)


YZ = Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))


def biceps() -> MuscleTable:
    points = (
        via("biceps_l", 0, "torso", (0.1, 0.2, 0.3), "a"),
        via("biceps_l", 1, "arm_l", (0.4, 0.0, 0.0), "b"),
    )
    wraps = (
        WrapRow("elbow_l", "arm_l", (WrapUse("biceps_l", 0, 1),), face=SPHERE),
        WrapRow("elbow_r", "arm_r", face=SPHERE),
    )
    row = MuscleSnapshot("biceps_l", f_max=123.0)
    return MuscleTable((row,), points, wraps=wraps)


def test_a_muscle_is_mirrored() -> None:
    table, findings = mirror_muscle(biceps(), "biceps_l", YZ, {"torso", "arm_l", "arm_r"})
    assert findings == []
    assert [(p.link, p.position) for p in table.points_of("biceps_r")] == [
        ("torso", (-0.1, 0.2, 0.3)),
        ("arm_r", (-0.4, 0.0, 0.0)),
    ]
    assert table.row("biceps_r").f_max == 123.0  # type: ignore[union-attr]
    assert table.wraps[1].muscles == (WrapUse("biceps_r", 0, -1),)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("shape", ["cylinder", "sphere"])
def test_a_mirrored_muscle_passes_the_same_side_of_its_surface(shape: Any, sign: float) -> None:
    """Fusion may report either direction of an axis; the drawn path must be the mirror image."""
    for axis in ((0.0, 0.6, 0.8), (0.8, 0.0, 0.6)):
        z = (0.0, 0.0, 1.0) if shape == "sphere" else axis
        left = SurfaceSnapshot("l:1", shape, 0.05, (0.25, 0.1, 0.15), z, 0.5, "l")
        centre, other = YZ.mirrored(left.centre), YZ.mirrored_direction(z)
        other = z if shape == "sphere" else tuple(sign * v for v in other)
        right = replace(left, centre=centre, axis=other, entity="r")
        uses = (WrapUse("biceps_l", 0, 1, 1),)
        wraps = (
            WrapRow("elbow_l", "arm_l", uses, face=left),
            WrapRow("elbow_r", "arm_r", face=right),
        )
        table = replace(biceps(), wraps=wraps)
        table, _ = mirror_muscle(table, "biceps_l", YZ, {"torso", "arm_l", "arm_r"})
        image = [YZ.mirrored(p) for p in path_of(table, "biceps_l").points]
        assert len(image) > 60  # the path touches the surface
        assert np.array(path_of(table, "biceps_r").points) == pytest.approx(np.array(image))


def test_an_unknown_mirrored_link_is_a_finding_and_nothing_changes() -> None:
    table, findings = mirror_muscle(biceps(), "biceps_l", YZ, {"torso", "arm_l", "Arm_r"})
    assert table == biceps()
    assert codes(findings) == ["unknown-mirrored-link"]
    assert "did you mean 'Arm_r'" in findings[0].message


def test_a_muscle_of_the_other_side_is_replaced_on_request() -> None:
    links = {"torso", "arm_l", "arm_r"}
    table, _ = mirror_muscle(biceps(), "biceps_l", YZ, links)
    again, findings = mirror_muscle(table, "biceps_l", YZ, links)
    assert again == table
    assert codes(findings) == ["mirrored-muscle-exists"]
    again, findings = mirror_muscle(table, "biceps_l", YZ, links, replace_existing=True)
    assert again == table
    assert findings == []


def test_muscles_without_a_side_get_a_new_name() -> None:
    table = biceps().rename_muscle("biceps_l", "motor0")
    table, _ = mirror_muscle(table, "motor0", YZ, {"torso", "arm_l", "arm_r"})
    assert [row.name for row in table.rows] == ["motor0", "motor1"]
    table = biceps().rename_muscle("biceps_l", "neck")
    table, _ = mirror_muscle(table, "neck", YZ, {"torso", "arm_l", "arm_r"})
    assert [row.name for row in table.rows] == ["neck", "neck_mirrored"]


def test_a_surface_without_an_image_is_a_warning() -> None:
    table = biceps()
    table = replace(table, wraps=table.wraps[:1])
    table, findings = mirror_muscle(table, "biceps_l", YZ, {"torso", "arm_l", "arm_r"})
    assert codes(findings) == ["wrap-not-mirrored"]
    assert table.row("biceps_r") is not None
    _, findings = mirror_muscle(table, "nobody", YZ, ())
    assert codes(findings) == ["unknown-muscle"]


# CSV


@pytest.mark.slow
@given(tables())
def test_a_table_is_read_back_unchanged(table: MuscleTable) -> None:
    read, findings = read_csv(csv_text(table).encode())
    assert findings == []
    assert read == replace(table, points=tuple(replace(p, entity="") for p in table.points))


@pytest.mark.slow
@given(tables())
def test_importing_an_exported_table_changes_nothing(table: MuscleTable) -> None:
    read, _ = read_csv(csv_text(table).encode())
    again = merge(table, read)
    assert again.points == table.points
    assert again.rows == table.rows


GOOD = "name,number,link,x [m],y [m],z [m],f_max [N]\nm,0,arm,0.1,0.2,0.3,100\nm,1,hand,1,2,3,\n"


@pytest.mark.parametrize(
    "data",
    [
        GOOD.encode(),
        GOOD.encode("utf-8-sig"),
        GOOD.replace("\n", "\r\n").encode(),
        GOOD.encode("utf-16"),
        GOOD.replace(",", "\t").encode("utf-16"),
        GOOD.replace(",", ";").replace("0.1", "0,1").encode("utf-8-sig"),
        GOOD.replace(",", " ; ").encode(),
        GOOD.rstrip("\n").encode() + b"\n\n,,,,,,\n",
        GOOD.replace("[m]", "(m)").replace("name", "Name").encode(),
        GOOD.replace("name,number", "number,name")
        .replace("\nm,0,", "\n0,m,")
        .replace("\nm,1,", "\n1,m,")
        .encode(),
    ],
)  # fmt: skip
def test_files_of_spreadsheets_are_read(data: bytes) -> None:
    table, findings = read_csv(data, {"arm", "hand"})
    assert findings == []
    assert [(p.link, p.position) for p in table.points] == [
        ("arm", (0.1, 0.2, 0.3)),
        ("hand", (1.0, 2.0, 3.0)),
    ]
    assert table.rows[0].f_max == 100.0


def test_units_and_order_of_the_file() -> None:
    text = "name,link,x [mm],y [cm],z\nm,arm,1,1,1\nm,arm,2,2,2\nb,arm,3,3,3\n"
    table, findings = read_csv(text.encode())
    assert findings == []
    assert table.points[0].position == pytest.approx((0.001, 0.01, 1.0))
    assert [(p.muscle, p.number) for p in table.points] == [("m", 0), ("m", 1), ("b", 0)]


HEAD = "role,name,number,link,x,y,z,color,f_min,f_max,model,parameters,axes\n"


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("via,m,0,arm,1,2,x,,,,,,", "bad-number"),
        ("via,m,0,arm,1,2,,,,,,,", "bad-number"),
        ("via,m,0,arm,1,2,nan,,,,,,", "bad-number"),
        ("via,m,0,arm,1,2,inf,,,,,,", "bad-number"),
        ("via,m,0,arm,1,2,1_0,,,,,,", "bad-number"),
        ("via,m,0,arm,1,2,1e999,,,,,,", "bad-number"),
        ("via,m,-1,arm,1,2,3,,,,,,", "bad-number"),
        ("via,m,1.5,arm,1,2,3,,,,,,", "bad-number"),
        ("via,m,99999999999,arm,1,2,3,,,,,,", "bad-number"),
        ("via,m,0,leg,1,2,3,,,,,,", "unknown-link"),
        ("via,m,0,,1,2,3,,,,,,", "missing-link"),
        ("via,,0,arm,1,2,3,,,,,,", "missing-name"),
        ("eye,m,0,arm,1,2,3,,,,,,", "bad-role"),
        ("via,m,0,arm,1,2,3,red,,,,,", "bad-color"),
        ("via,m,0,arm,1,2,3,,x,,,,", "bad-number"),
        ("via,m,0,arm,1,2,3,,,-inf,,,", "bad-number"),
        ("via,m,0,arm,1,2,3,,,,magic,,", "bad-model"),
        ("via,m,0,arm,1,2,3,,,,,K,", "bad-parameters"),
        ("via,m,0,arm,1,2,3,,,,,K=x,", "bad-parameters"),
        ("via,m,0,arm,1,2,3,,,,,=1,", "bad-parameters"),
        ("task,t,,arm,1,2,3,,,,,,w", "bad-axes"),
        ("via,m,0,arm,1,2,3,,,,,,,extra", "bad-line"),
        ("via,g,0,arm,1,2,3,,,,,,", "duplicate-number"),
        ("via,g,2,arm,1,2,3,,5,,,,", "contradiction"),
        ("task,t,,arm,1,2,3,,,,,,\ntask,t,,arm,1,2,3,,,,,,", "duplicate-name"),
        ("marker,t,,arm,1,2,3,,,,,,\nmarker,t,,arm,1,2,3,,,,,,", "duplicate-name"),
    ],
)
def test_invalid_lines_are_findings_with_line_numbers(line: str, code: str) -> None:
    good = "via,g,0,arm,1,2,3,,4,,,,\n"
    file = Path("muscles.csv")
    table, findings = read_csv(
        f"{HEAD}{good}\n{line}\n{good.replace('0', '1')}".encode(), {"arm"}, file
    )
    assert codes(findings) == [code]
    assert findings[0].is_error
    assert (findings[0].file, findings[0].line) == (file, 4 + line.count("\n"))
    assert {0, 1} <= {p.number for p in table.points_of("g")}


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"", "missing-column"),
        (b"\xff", "bad-encoding"),
        (b"\xff\xfea", "bad-encoding"),
        ("näme".encode("latin-1"), "bad-encoding"),
        (b"name,link,x,y\n", "missing-column"),
        (b"name,link,x [ft],y,z\n", "bad-unit"),
        (b'name,link,x,y,z\n"' + b"a" * 200_000, "bad-line"),
    ],
)
def test_bad_files_are_findings(data: bytes, code: str) -> None:
    table, findings = read_csv(data)
    assert codes(findings) == [code]
    assert table == MuscleTable()


@given(st.binary(max_size=200))
def test_any_bytes_are_read_without_an_exception(data: bytes) -> None:
    read_csv(data)
    read_csv(HEAD.encode() + data, {"arm"})


def test_unknown_columns_are_ignored_with_a_warning() -> None:
    table, findings = read_csv(b"name,link,x,y,z,note\nm,arm,1,2,3,hello\n")
    assert codes(findings) == ["unknown-column"]
    assert len(table.points) == 1
    assert COLUMNS[0] == "role"


def test_tables_of_robot_files_are_rejected() -> None:
    table, findings = read_csv(b"name,frame,link,x,y,z\nm,link,arm,1,2,3\n")
    assert codes(findings) == ["bad-frame"]
    assert table == MuscleTable()


def test_an_import_keeps_points_with_unchanged_positions() -> None:
    table = muscle(3)
    read, _ = read_csv(csv_text(table).replace("1.0,0.0,0.0", "1.5,0.0,0.0").encode())
    again = merge(table, read)
    assert entities(again) == ["e0", "", "e2"]
    assert again.points[1].position == (1.5, 0.0, 0.0)
    assert again.wraps == table.wraps
