"""Tests that points and wrap surfaces survive edits of the design, or are reported as not found."""

from __future__ import annotations

import json
from typing import Any

import pytest
from fake_fusion import Builder
from fake_fusion.maths import rotation, translation
from support.designs.exported import read_design

from addin_sdfusion.building.build_robot import link_of
from addin_sdfusion.muscles.design_table import read_table
from addin_sdfusion.muscles.table import MuscleTable

DEFINE = "cardsflowDefineMuscles"
FAR = translation((30.0, 0.0, 0.0))

pytestmark = pytest.mark.usefixtures("addin")


def draw(*, referenced: bool = False) -> Builder:
    """Draw a torso and a component `arm` with two occurrences, each with a cylinder."""
    build = Builder("robot")
    torso = build.place("torso", grounded=True)
    build.box(torso, (2.0, 2.0, 2.0))
    component = build.component("arm v3" if referenced else "arm", referenced=referenced)
    paths = [build.place(component, translation((9.0 * k, 0, 0))) for k in (1, 2)]
    build.box(paths[0], (1.0, 1.0, 6.0))
    build.cylinder(paths[0], 0.5, 3.0)
    for k, path in enumerate(paths):
        build.joint(f"joint{k}", "revolute", path, torso, axis=(0.0, 1.0, 0.0))
    build.done()
    return build


def occurrence(fusion: Any, path: str) -> Any:
    return fusion.design.rootComponent.occurrences.itemByName(path)


def define(fusion: Any, *paths: str) -> None:
    """Pick a vertex of the torso and one of each occurrence."""
    command = fusion.run_command(DEFINE)
    for number, path in enumerate(("torso:1", *paths)):
        command.pick("pick", occurrence(fusion, path).bRepBodies[0].vertices[number])
    command.ok()
    assert command.failed == ""


def read(fusion: Any) -> tuple[MuscleTable, list[str]]:
    """Return the muscle table and the codes of all findings on points."""
    snapshot = read_design(fusion.design, meshes=False, masses=None)
    table, findings = read_table(snapshot, link_of(snapshot))
    codes = [f.code for f in (*snapshot.findings, *findings)]
    return table, sorted({code for code in codes if code not in ("not-read", "same-name")})


def places(table: MuscleTable) -> list[tuple[int, str, bool]]:
    """Return number, occurrence and whether it is not found, of each via point."""
    return [(p.number, p.occurrence, bool(p.lost)) for p in table.points]


def press_ok(fusion: Any) -> None:
    command = fusion.run_command(DEFINE)
    command.ok()
    assert command.failed == ""


@pytest.mark.parametrize("referenced", [False, True])
def test_a_component_used_twice_is_renamed(fusion: Any, referenced: bool) -> None:
    draw(referenced=referenced)
    name = "arm v3" if referenced else "arm"
    define(fusion, f"{name}:2")
    fusion.designer.rename(f"{name}:1", "elbow")
    table, codes = read(fusion)
    assert places(table) == [(0, "torso:1", False), (1, "elbow:2", False)]
    assert codes == []


@pytest.mark.parametrize("version", [4, None])
def test_an_external_reference_is_updated(fusion: Any, version: int | None) -> None:
    draw(referenced=True)
    define(fusion, "arm v3:2", "arm v3:1")
    fusion.designer.get_latest("arm v3:1", version)
    name = "arm" if version is None else f"arm v{version}"
    table, codes = read(fusion)
    assert [p.occurrence for p in table.points] == ["torso:1", f"{name}:2", f"{name}:1"]
    assert codes == []
    assert [p.link for p in table.points] == ["torso", "arm_2", "arm"] or version is not None


def test_an_unresolved_reference_keeps_its_points(fusion: Any) -> None:
    """OK used to erase them, also after the reference was found again."""
    draw(referenced=True)
    define(fusion, "arm v3:2", "arm v3:1")
    before, _ = read(fusion)
    fusion.designer.resolve("arm v3:2", False)
    table, codes = read(fusion)
    assert [lost for _, _, lost in places(table)] == [False, True, False]
    assert "lost-point" in codes
    command = fusion.run_command(DEFINE)
    assert "not found" in command.table("points")[2][2]
    command.ok()
    press_ok(fusion)
    fusion.designer.resolve("arm v3:2")
    after, codes = read(fusion)
    assert [p.use for p in after.points] == [p.use for p in before.points]
    for p, q in zip(after.points, before.points, strict=True):
        assert p.position == pytest.approx(q.position, abs=1e-15)
    assert codes == []


def test_only_a_deleted_row_is_deleted(fusion: Any) -> None:
    draw(referenced=True)
    define(fusion, "arm v3:2", "arm v3:1")
    fusion.designer.resolve("arm v3:2", False)
    command = fusion.run_command(DEFINE)
    command.row("points", 2)
    command.press("delete")
    command.ok()
    fusion.designer.resolve("arm v3:2")
    table, codes = read(fusion)
    assert places(table) == [(0, "torso:1", False), (1, "arm v3:1", False)]
    assert codes == []


def test_a_point_of_a_suppressed_component_is_kept_in_order(fusion: Any) -> None:
    draw()
    fusion.designer.delete("arm:2")
    define(fusion, "arm:1", "torso:1")
    before, _ = read(fusion)
    fusion.designer.suppress("arm:1")
    command = fusion.run_command(DEFINE)
    command.row("points", 1)
    command.press("delete")
    command.ok()
    assert command.failed == ""
    fusion.designer.suppress("arm:1", False)
    table, codes = read(fusion)
    assert places(table) == [(0, "arm:1", False), (1, "torso:1", False)]
    assert table.points[0].position == before.points[1].position
    assert codes == []


@pytest.mark.parametrize("survive", [True, False])
def test_a_moved_part_keeps_its_points(fusion: Any, survive: bool) -> None:
    fusion.options.tokens_survive = survive
    draw()
    fusion.designer.delete("arm:2")
    define(fusion, "arm:1")
    fusion.designer.move("arm:1", "torso:1")
    table, codes = read(fusion)
    assert places(table) == [(0, "torso:1", False), (1, "torso:1+arm:1", False)]
    assert codes == ["moved-point"]
    press_ok(fusion)
    assert read(fusion)[1] == []


def test_the_other_instance_is_never_used(fusion: Any) -> None:
    draw()
    define(fusion, "arm:2")
    fusion.designer.delete("arm:2")
    table, codes = read(fusion)
    assert [lost for _, _, lost in places(table)] == [False, True]
    assert codes == ["lost-point"]


def test_a_link_follows_its_part(fusion: Any) -> None:
    """A rigid group that is created later contains the points of its parts."""
    draw()
    define(fusion, "arm:2")
    fusion.designer.group("EXPORT_body", "torso:1")
    fusion.designer.group("EXPORT_forearm", "arm:2")
    table, codes = read(fusion)
    assert [p.link for p in table.points] == ["body", "forearm"]
    assert codes == []


def test_a_replaced_link_repairs_all_points(fusion: Any) -> None:
    build = draw()
    torso = build.root.occurrences[0].component
    for number in range(2):
        record = {"role": "via", "muscle": "m", "number": number, "link": "trunk"}
        build.point(torso, (number, 0.0, 0.0), f"p{number}", {"point": json.dumps(record)})
    command = fusion.run_command(DEFINE)
    assert not command.is_valid()
    assert command.items("old_link") == ["trunk"]
    command.press("replace_link")
    command.ok()
    table, codes = read(fusion)
    assert [p.link for p in table.points] == ["torso", "torso"]
    assert codes == ["default-forces"] or codes == []


def test_points_of_a_pasted_component_are_not_used(fusion: Any) -> None:
    draw()
    define(fusion, "arm:2")
    fusion.designer.paste_new("arm:2", FAR)
    table, codes = read(fusion)
    assert places(table) == [(0, "torso:1", False), (1, "arm:2", False)]
    assert codes == ["copied-point"]


def test_a_wrap_surface_stays_on_its_instance(fusion: Any) -> None:
    draw()
    define(fusion, "arm:2")
    command = fusion.run_command(DEFINE)
    faces = occurrence(fusion, "arm:2").bRepBodies[1].faces
    command.pick("wrap_pick", next(f for f in faces if type(f.geometry).__name__ == "Cylinder"))
    command.press("use_add")
    command.ok()
    assert command.failed == ""
    fusion.designer.rename("arm:1", "elbow")
    table, codes = read(fusion)
    assert [(w.occurrence, w.lost) for w in table.wraps] == [("elbow:2", "")]
    assert codes == []


def test_a_wrap_surface_of_a_suppressed_component_is_kept(fusion: Any) -> None:
    draw()
    fusion.designer.delete("arm:2")
    define(fusion, "arm:1", "torso:1")
    command = fusion.run_command(DEFINE)
    faces = occurrence(fusion, "arm:1").bRepBodies[1].faces
    command.pick("wrap_pick", next(f for f in faces if type(f.geometry).__name__ == "Cylinder"))
    command.press("use_add")
    command.ok()
    fusion.designer.suppress("arm:1")
    table, codes = read(fusion)
    assert [bool(w.lost) for w in table.wraps] == [True]
    assert codes == ["lost-face", "lost-point"]
    command = fusion.run_command(DEFINE)
    command.set("muscle_name", "biceps")
    command.ok()
    assert command.failed == ""
    fusion.designer.suppress("arm:1", False)
    table, codes = read(fusion)
    assert [use.muscle for w in table.wraps for use in w.muscles] == ["biceps"]
    assert codes == []


@pytest.mark.parametrize("where", ["point", "kept", "muscle"])
def test_records_of_a_newer_version_are_kept(fusion: Any, where: str) -> None:
    build = draw(referenced=True)
    define(fusion, "arm v3:2")
    owner, name = build.design.attributes, {"kept": "points", "muscle": "muscles"}.get(where, "")
    if where == "point":
        owner, name = build.root.occurrences[0].component.points[0].attributes, "point"
    plain = json.loads(owner["CARDSFlow", name])
    record = {"point": lambda: plain, "kept": lambda: plain[0]["use"], "muscle": lambda: plain[0]}
    newer = {"version": 9, "pulley": {"radius": 2}}
    record[where]().update(newer)
    owner["CARDSFlow", name] = json.dumps(plain)
    table, codes = read(fusion)
    assert (len(table.points), codes[0]) == (2, "bad-attribute")
    press_ok(fusion)
    kept = json.loads(owner["CARDSFlow", name])
    found = {"point": lambda: [kept], "kept": lambda: [k["use"] for k in kept]}
    records = found.get(where, lambda: kept)()
    assert any(newer.items() <= entry.items() for entry in records)


def test_records_that_cannot_be_read_are_kept(fusion: Any) -> None:
    build = draw(referenced=True)
    define(fusion, "arm v3:2", "arm v3:1")
    owner = build.design.attributes
    points, muscles = (json.loads(owner["CARDSFlow", key]) for key in ("points", "muscles"))
    points[0]["position"] = "?"
    muscles.append({"name": "other", "model": 7})
    owner["CARDSFlow", "points"] = json.dumps(points)
    owner["CARDSFlow", "muscles"] = json.dumps(muscles)
    table, codes = read(fusion)
    assert [lost for _, _, lost in places(table)] == [False, True, False]
    assert codes == ["bad-attribute", "lost-point"]
    press_ok(fusion)
    stored = {key: json.loads(owner["CARDSFlow", key]) for key in ("points", "muscles")}
    assert points[0] in stored["points"]
    assert muscles[-1] in stored["muscles"]


def test_a_damaged_list_is_kept_as_text(fusion: Any) -> None:
    build = draw()
    define(fusion, "arm:2")
    build.design.attributes["CARDSFlow", "muscles"] = "[{"
    press_ok(fusion)
    assert build.design.attributes["CARDSFlow", "muscles_unread"] == "[{"


def test_names_of_the_first_sdfusion_are_read_and_converted(fusion: Any) -> None:
    """Points without attributes: their names specify muscle, link and number."""
    build = draw()
    torso, arm = (build.root.occurrences[k].component for k in (0, 2))
    build.point(torso, (1.0, 0.0, 0.0), "VP_motor0_EXPORT_torso_0")
    build.point(arm, (1.0, 0.0, 0.0), "VP_motor0_EXPORT_arm_2_1")
    before, _ = read(fusion)
    assert places(before) == [(0, "torso:1", False), (1, "arm:2", False)]
    press_ok(fusion)
    fusion.designer.rename("arm:1", "elbow")
    table, codes = read(fusion)
    assert [p.position for p in table.points] == [p.position for p in before.points]
    assert places(table) == [(0, "torso:1", False), (1, "elbow:2", False)]
    assert codes == []


@pytest.mark.parametrize("hidden", [False, True])
def test_another_occurrence_with_the_same_number_is_reported(
    fusion: Any, addin: Any, hidden: bool
) -> None:
    """A pasted occurrence gets the number of one that has another configuration now."""
    draw(referenced=True)
    define(fusion, "arm v3:2")
    path = fusion.designer.switch_configuration("arm v3:2", "long")
    if hidden:  # its token finds nothing
        fusion.designer.suppress(path)
    assert fusion.designer.paste("arm v3:1", translation((9.0, 0.0, 0.0))) == "arm v3:2"
    snapshot = read_design(fusion.design, meshes=False, masses=None)
    found = [p for p in snapshot.points if p.use and p.use.number == 1]
    assert [bool(p.lost) for p in found] == [not hidden]
    texts = [p.lost for p in found] + [f.message for f in snapshot.findings]
    assert any(f"another occurrence{',' if hidden else ' now'}" in text for text in texts)


@pytest.mark.parametrize("how", ["referenced", "suppressed", "found"])
def test_replacing_a_part_repairs_all_its_points(fusion: Any, how: str) -> None:
    """Points stay at the same place on the part, to 1e-9 cm; unrelated points do not change."""
    build = draw(referenced=how == "referenced")
    old, other = "arm v3" if how == "referenced" else "arm", "new arm"
    T = rotation(0.8, (1.0, 2.0, 3.0)) @ translation((4.0, 5.0, 6.0))
    path = build.place(other, T)
    build.box(path, (1.0, 1.0, 6.0))
    build.cylinder(path, 0.5, 3.0)
    build.done()
    arm, corners = occurrence(fusion, f"{old}:1"), (0, 3, 5)
    command = fusion.run_command(DEFINE)
    command.pick("pick", occurrence(fusion, "torso:1").bRepBodies[0].vertices[0])
    for corner in corners:
        command.pick("pick", arm.bRepBodies[0].vertices[corner])
    if how == "found":
        command.pick("wrap_pick", arm.bRepBodies[1].faces[0])
    command.ok()
    vertices = occurrence(fusion, f"{other}:1").bRepBodies[0].vertices
    expected = [[v / 100 for v in vertices[k].geometry.asArray()] for k in corners]
    fixed = read(fusion)[0].points[0]
    if how == "referenced":
        fusion.designer.resolve(f"{old}:1", False)
    elif how == "suppressed":
        fusion.designer.suppress(f"{old}:1")
        fusion.designer.delete(f"{old}:2")
    command = fusion.run_command(DEFINE)
    assert command.items("old_part") == [f"{old}:1", "torso:1"]
    command.set("old_part", f"{old}:1")
    command.set("new_part", f"{other}:1")
    command.press("replace_part")
    assert "3 points" in command["status"].text or how == "found"
    command.ok()
    assert command.failed == ""
    table, _ = read(fusion)
    assert table.points[0] == fixed
    assert places(table)[1:] == [(k, f"{other}:1", False) for k in (1, 2, 3)]
    for row, corner in zip(table.points[1:], expected, strict=True):
        assert row.position == pytest.approx(corner, abs=1e-11)
    assert [wrap.occurrence for wrap in table.wraps] == ([f"{other}:1"] if how == "found" else [])


def test_replacing_a_part_moves_points_of_the_parts_in_it(fusion: Any) -> None:
    """A second leg is placed; points on the foot of the first one move to its foot."""
    build = Builder("robot")
    leg, foot = build.component("leg"), build.component("foot")
    paths = [build.place(leg, translation((20.0 * k, 0.0, 0.0))) for k in (0, 1)]
    build.box(paths[0], (2.0, 2.0, 9.0))
    build.place(foot, translation((0.0, 0.0, -6.0)), above=paths[0])
    build.box(foot, (2.0, 4.0, 1.0))
    build.done()
    occurrences = {o.fullPathName: o for o in fusion.design.rootComponent.allOccurrences}
    command = fusion.run_command(DEFINE)
    for path in ("leg:1", "leg:1+foot:1"):
        command.pick("pick", occurrences[path].bRepBodies[0].vertices[2])
    assert command.items("old_part") == ["leg:1", "leg:1+foot:1"]
    before = [row[2] for row in command.table("points")[1:]]
    command.set("old_part", "leg:1")
    command.set("new_part", "leg:2")
    command.press("replace_part")
    assert command["status"].text.startswith("2 points and surfaces of leg:1 are moved to leg:2.")
    command.ok()
    assert command.failed == ""
    table, _ = read(fusion)
    assert [(p.occurrence, p.link) for p in table.points] == [
        ("leg:2", "leg_2"),
        ("leg:2+foot:1", "leg_2"),
    ]
    shown = [", ".join(f"{1000 * v:.1f}" for v in p.position) for p in table.points]
    x = [float(text.split(",")[0]) for text in (*before, *shown)]
    assert [b - a for a, b in zip(x[:2], x[2:], strict=True)] == pytest.approx([200.0, 200.0])


def test_replacing_a_part_needs_a_part_with_a_link(fusion: Any) -> None:
    build = draw()
    define(fusion, "arm:1")
    for path in ("torso:1", "arm:1"):
        fusion.designer.group(f"EXPORT_{path[:3]}", path)
    build.done()
    command = fusion.run_command(DEFINE)
    command.set("old_part", "arm:1")
    command.set("new_part", "arm:1")
    command.press("replace_part")
    assert "Choose the part to replace" in command["status"].text
    assert "arm:2" not in command.items("new_part")
