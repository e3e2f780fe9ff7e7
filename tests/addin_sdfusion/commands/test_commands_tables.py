"""Tests of the tables of Define muscles and of the clipboard."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest
from support.designs.user import User

RED, BLUE = "#d62728", "#1f77b4"


def test_all_muscles_are_in_one_table(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(3), user.circle())
    command.set("muscle", "+ New muscle")
    command.pick("pick", user.own_point())
    command.set(command.cell("all", 1, 0).id, "biceps")
    for text in ("7", "7.", "7.5"):
        command.set(command.cell("all", 1, 1).id, text)
        assert command.cell("all", 1, 1).value == text
    command.set(command.cell("all", 2, 2).id, "many")
    assert "'many' is not a number" in command["status"].text
    command.set(command.cell("all", 2, 3).id, "elastic_cable")
    rows = command.table("all")[1:]
    assert [row[:4] for row in rows] == [
        ["biceps", "7.5", "80", "ideal"],
        ["motor1", "10", "80", "elastic_cable"],
    ]
    command.ok()
    stored = json.loads(fusion.design.attributes.itemByName("CARDSFlow", "muscles").value)
    assert [(m["name"], m["f_min"], m["model"]) for m in stored] == [
        ("biceps", 7.5, "ideal"),
        ("motor1", 10.0, "elastic_cable"),
    ]


def test_typed_coordinates_move_a_point(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(3), user.circle())
    x, y, _ = command.table("points")[1][2].split(", ")
    command.set(command.cell("points", 1, 2).id, f"{x}, {y}")
    assert "must be x, y, z in mm" in command["status"].text
    command.set(command.cell("points", 1, 2).id, f"{x}; {y}; 123,5")
    command.ok()
    (name,) = [n for n in user.points() if n.endswith("_0")]
    place = user.points()[name]
    assert place[2] == pytest.approx(12.35, abs=1e-9)  # in cm
    assert len(fusion.world.undo_steps) == 1


PROGRAM = "import pathlib, sys; f = pathlib.Path({!r}); {}"
TAKE, GIVE = "f.write_bytes(sys.stdin.buffer.read())", "sys.stdout.buffer.write(f.read_bytes())"


def test_points_are_copied_to_and_pasted_from_a_spreadsheet(
    fusion: Any, user: User, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from addin_sdfusion.commands import clipboard

    command = user.define(user.vertex(3), user.circle())
    command.press("copy")
    assert "clipboard is not available" in command["status"].text
    file = tmp_path / "clipboard"
    programs = [(sys.executable, "-c", PROGRAM.format(str(file), w)) for w in (TAKE, GIVE)]
    monkeypatch.setitem(clipboard.PROGRAMS, sys.platform, tuple(programs))
    command.set("muscle_name", "bizeps_rückwärts")
    command.press("copy")
    text = file.read_text(encoding="utf-8")
    assert text.splitlines()[1].split("\t")[1] == "bizeps_rückwärts"
    file.write_text(text.replace("bizeps_rückwärts", "trizeps"), encoding="utf-8")
    command.press("paste")
    assert "1 muscles with 2 points" in command["status"].text
    assert [row[0] for row in command.table("all")[1:]] == ["bizeps_rückwärts", "trizeps"]
    file.write_text("nonsense", encoding="utf-8")
    command.press("paste")
    assert "was not imported" in command["status"].text
    command.cancel()


def test_a_colour_is_chosen_by_name(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(3))
    command.set("palette", "Green")
    assert command["color"].value == "#2ca02c"
    command.set("color", "#123456")
    assert command.chosen("palette") == ["Custom"]
    command.set("palette", "Custom")
    assert command["color"].value == "#123456"
    command.cancel()


def test_edits_are_undone_and_redone_in_the_dialog(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(3), user.circle())
    shown = [command.table("points")]
    for text in ("b", "bi", "biceps"):
        command.set("muscle_name", text)  # one step
    command.row("points", 2)
    command.press("delete")
    shown.append(command.table("points"))
    command.press("delete_muscle")
    assert command.items("muscle") == ["+ New muscle"]
    command.press("undo")
    assert command.table("points") == shown[1]
    assert command["muscle_name"].value == "biceps"
    command.press("undo")
    assert command.table("points") == shown[0]
    command.press("undo")
    assert command["muscle_name"].value == "motor0"
    command.press("redo")
    command.press("redo")
    assert command["muscle_name"].value == "biceps"
    assert command.table("points") == shown[1]
    command.press("undo")
    command.pick("pick", user.own_point())  # an edit discards the undone edits
    command.press("redo")
    assert "Nothing can be redone" in command["status"].text
    for _ in range(4):
        command.press("undo")
    assert command.items("muscle") == ["+ New muscle"]
    command.press("undo")
    assert "Nothing can be undone" in command["status"].text
    command.ok()
    assert user.points().keys() == {"my own point"}


def test_buttons_have_a_text(fusion: Any, user: User) -> None:
    from addin_sdfusion.commands.define_muscles.dialog import DIALOG

    command = user.define()
    items = [child for top in DIALOG.inputs for child in (top, *top.children)]
    buttons = [item for item in items if item.kind == "button"]
    assert {item.id for item in buttons} >= {"undo", "redo", "wrap_delete"}
    for item in buttons:
        assert command[item.id].text == command[item.id].name == item.label


def test_a_tab_shows_muscles_while_a_joint_moves(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(3), user.circle())
    before = command.table("points")
    length = command["length"].text.split(", ")[1]
    command.tab("tab_motion")
    assert command.items("motion_joint") == ["shoulder"]
    (row,) = command.table("motion")[1:]
    assert row[0].endswith("</font> motor0")
    assert row[1:3] == [length, "+0.0"]
    seen = {row[3]}
    for percent in (0.0, 75.0, 100.0):
        command.set("motion_percent", percent)
        (row,) = command.table("motion")[1:]
        seen.add(row[3])
        color = RED if float(row[3]) > 0.0 else BLUE  # of the only muscle, thus the full colour
        assert row[0].startswith(f'<font color="{color}">')
        assert line_color(user) == color
        assert float(row[1].split()[0]) - float(length.split()[0]) == pytest.approx(
            float(row[2]), abs=0.11
        )
    assert len(seen) > 2
    assert command["motion_at"].text == "180.0° of -180.0° to 180.0°"
    assert command.table("points") == before
    command.tab("tab_muscles")
    assert line_color(user) not in (BLUE, "#bebebe")
    command.cancel()


def line_color(user: User) -> str:
    """Return the colour of the first line of the preview."""
    color = user.root.customGraphicsGroups.item(0).item(0).color.color
    return f"#{color.red:02x}{color.green:02x}{color.blue:02x}"


def test_arm_colors_depend_on_sign_and_size() -> None:
    from addin_sdfusion.muscles.motion import arm_color

    assert [arm_color(x, 2.0) for x in (2.0, -2.0, 0.0)] == [RED, BLUE, "#bebebe"]
    assert arm_color(0.0, 0.0) == "#bebebe"
    assert arm_color(1.0, 2.0) == "#ca7273"


def test_the_motion_tab_reports_that_no_joint_moves(fusion: Any, addin: Any) -> None:
    from fake_fusion import Builder

    Builder("empty").done()
    command = fusion.run_command("cardsflowDefineMuscles")
    command.tab("tab_motion")
    assert "the design has no components" in command["motion_at"].text
    command.cancel()


@pytest.mark.parametrize("count", [1, 2])
def test_wrap_surfaces_are_mirrored_with_their_muscle(fusion: Any, addin: Any, count: int) -> None:
    """The face of the other side is found by its place; several candidates are not used."""
    from fake_fusion import Builder
    from fake_fusion.maths import translation

    build = Builder("sides")
    torso = build.place("torso", grounded=True)
    build.box(torso, (2.0, 2.0, 2.0))
    for side, x in (("l", 5.0), ("r", -5.0)):
        arm = build.place(f"arm_{side}", translation((x, 0.0, 0.0)))
        build.box(arm, (1.0, 1.0, 1.0))
        build.cylinder(arm, 0.4, 3.0)
        if side == "r" and count == 2:
            build.cylinder(arm, 0.4, 3.0)
        build.rigid_group(f"EXPORT_arm_{side}", [arm])
    build.rigid_group("EXPORT_torso", [torso])
    build.done()
    user = User(fusion)
    command = user.define(user.vertex(0), user.body("arm_l").vertices.item(1))
    command.set("muscle_name", "biceps_l")
    command.pick("wrap_pick", User(fusion).body("arm_l", 1).faces.item(0))
    command.press("use_add")
    command.press("mirror")
    wraps = command.items("wrap")
    if count == 2:
        assert wraps == ["arm_l_cylinder"]
        assert "has no counterpart of surface 'arm_l_cylinder'" in command["status"].text
        command.cancel()
        return
    assert wraps == ["arm_l_cylinder", "arm_r_cylinder"]
    command.ok()
    face = user.body("arm_r", 1).faces.item(0)
    stored = json.loads(face.attributes.itemByName("CARDSFlow", "wrap").value)
    assert stored["name"] == "arm_r_cylinder"
    assert [use["muscle"] for use in stored["muscles"]] == ["biceps_r"]
