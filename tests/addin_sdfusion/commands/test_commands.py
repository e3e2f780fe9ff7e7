"""Tests of the commands in the fake Fusion, from the view of the user."""

from __future__ import annotations

import json
from typing import Any

import fake_fusion
import numpy as np
import pytest
from fake_fusion import Builder, designs
from fake_fusion.driver import Rejected
from fake_fusion.maths import point, rotation, translation
from hypothesis import given
from hypothesis import strategies as st
from support.designs.exported import failing
from support.designs.user import User, build_arm

IDS = ("cardsflowDefineMuscles", "cardsflowCheck", "cardsflowExport")
DEFINE, CHECK, EXPORT = IDS


def state(fusion: Any) -> tuple[Any, Any]:
    """Return the state of the user interface."""
    ui = fusion.app.userInterface
    definitions = [ui.commandDefinitions.item(i).id for i in range(ui.commandDefinitions.count)]
    panels = [
        (panel.id, [panel.controls.item(i).id for i in range(panel.controls.count)])
        for panel in (ui.allToolbarPanels.item(i) for i in range(ui.allToolbarPanels.count))
    ]
    return definitions, panels


def done(command: Any) -> None:
    """Press OK and check that no error occurs."""
    command.ok()
    assert command.failed == ""


def position(entity: Any) -> np.ndarray:
    """Return the position of the point of an entity in the root frame, in [cm]."""
    from fake_fusion.model.points import position_of

    return position_of(entity)


# Start and stop of the add-in


def test_stop_removes_everything_that_start_added(fusion: Any) -> None:
    before = state(fusion)
    with fake_fusion.modules():
        from addin_sdfusion import addin_sdfusion

        for _ in range(2):
            addin_sdfusion.run(None)
            addin_sdfusion.run(None)
            definitions, panels = state(fusion)
            assert set(IDS) <= set(definitions)
            assert dict(panels)["SolidScriptsAddinsPanel"][-3:] == list(IDS)
            addin_sdfusion.stop(None)
            addin_sdfusion.stop(None)
            assert state(fusion) == before
    assert fusion.messages == []


def test_the_buttons_are_promoted(fusion: Any, addin: Any) -> None:
    panel = fusion.app.userInterface.allToolbarPanels.itemById("SolidScriptsAddinsPanel")
    for name in IDS:
        control = panel.controls.itemById(name)
        assert control.isPromoted
        assert control.isPromotedByDefault
        assert len(control.commandDefinition.tooltip) > 20


@pytest.mark.parametrize("name", IDS)
def test_without_a_design_there_is_a_message(fusion: Any, addin: Any, name: str) -> None:
    fusion.run_command(name)
    designs.single_cube()
    fusion.world.in_design = False  # a product of another workspace
    fusion.run_command(name)
    assert len(fusion.messages) == 2
    assert all("Open a design" in text for text in fusion.messages)


def test_stop_while_a_dialog_is_open(fusion: Any, addin: Any, user: User) -> None:
    before = fusion.full_fingerprint()
    command = user.define(user.vertex())
    addin.stop(None)
    assert not command.is_open
    assert fusion.full_fingerprint() == before


def test_another_command_does_not_confirm_the_dialog(fusion: Any, user: User) -> None:
    before = fusion.full_fingerprint()
    command = user.define(user.vertex())
    fusion.run_command(CHECK)
    assert not command.is_open
    assert fusion.full_fingerprint() == before


# Define muscles


def test_points_are_picked_in_order(fusion: Any, user: User) -> None:
    mine = fusion.fingerprint()
    everything = fusion.full_fingerprint()
    entities = [user.vertex(3), user.circle(), user.sketch_point(), user.face("Sphere"),
                user.face("Torus")]  # fmt: skip
    places = [position(entity) for entity in entities]
    command = user.define(*entities)
    rows = command.table("points")
    assert rows[0] == ["No.", "Link", "x, y, z [mm]"]
    assert [row[:2] for row in rows[1:]] == [["0", "torso"]] + [
        [str(k), "arm"] for k in range(1, 5)
    ]
    assert len(fusion.world.undo_steps) == 0
    done(command)
    names = [f"VP_motor0_EXPORT_{'arm' if k else 'torso'}_{k}" for k in range(5)]
    points = user.points()
    for name, place in zip(names, places, strict=True):
        assert points[name] == pytest.approx(place, abs=1e-9)
    assert user.attribute(names[1])["muscle"] == "motor0"
    assert len(fusion.world.undo_steps) == 1
    assert fusion.fingerprint() == mine
    fusion.undo()
    assert fusion.full_fingerprint() == everything


def test_opening_again_shows_the_same_table(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(3), user.circle(), user.own_point())
    command.set("muscle_name", "biceps")
    command.set("f_max", 123.0)
    command.set("color", "#00FF00")
    command.set("model", "passive_spring")
    command.set(command.cell("parameters", 1, 1).id, "12.5")
    table = command.table("points")
    command.ok()
    after = fusion.full_fingerprint()
    command = user.define()
    assert command.table("points") == table
    assert command["muscle_name"].value == "biceps"
    assert command["f_max"].value == 123.0
    assert command["color"].value == "#00ff00"
    assert [row[:2] for row in command.table("parameters")[1:]] == [["K", "12.5"], ["l0", ""]]
    command.ok()
    assert fusion.full_fingerprint() == after
    assert "VP_motor0_EXPORT_arm_2" in user.points()


def test_a_point_of_the_user_is_used_and_its_name_is_restored(fusion: Any, user: User) -> None:
    place = position(user.own_point())
    command = user.define(user.vertex(0), user.own_point())
    command.ok()
    points = user.points()
    assert "my own point" not in points
    assert points["VP_motor0_EXPORT_arm_1"] == pytest.approx(place)
    command = user.define()
    command.press("delete_muscle")
    done(command)
    assert user.points().keys() == {"my own point"}


def test_cancel_and_previews_change_nothing(fusion: Any, user: User) -> None:
    before = fusion.full_fingerprint()
    command = user.define(*user.vertices(3))
    assert user.root.customGraphicsGroups.count == 1
    group = user.root.customGraphicsGroups.item(0)
    assert group.count == 4  # a line and three numbers
    command.cancel()
    assert user.root.customGraphicsGroups.count == 0
    assert fusion.full_fingerprint() == before
    assert len(fusion.world.undo_steps) == 0


def test_the_table_is_edited(fusion: Any, user: User) -> None:
    command = user.define(*user.vertices(4))
    shown = [row[2] for row in command.table("points")[1:]]

    def order() -> list[int]:
        return [shown.index(row[2]) for row in command.table("points")[1:]]

    command.row("points", 1)
    command.press("down")
    assert order() == [1, 0, 2, 3]
    assert command["points"].selectedRow == 2
    command.press("up")
    assert order() == [0, 1, 2, 3]
    command.row("points", 3)
    command.press("delete")
    assert order() == [0, 1, 3]
    command.row("points", 1)
    command.press("duplicate")
    assert order() == [0, 0, 1, 3]
    command.row("points", 4)
    command.press("insert")
    command.pick("pick", user.vertex(2))
    assert order() == [0, 0, 1, 2, 3]
    command.press("insert")
    command.pick("pick", user.vertex(2))
    assert order() == [0, 0, 1, 2, 3, 2]
    command.row("points", 0)
    command.press("delete")
    assert "Select a point" in command["status"].text
    command.ok()
    assert [int(name.rsplit("_", 1)[1]) for name in sorted(user.points()) if "VP" in name] == [
        0, 1, 2, 3, 4, 5,
    ]  # fmt: skip


def test_reordering_moves_names_and_numbers(fusion: Any, user: User) -> None:
    command = user.define(*user.vertices(3))
    command.ok()
    before = user.points()
    command = user.define()
    command.row("points", 1)
    command.press("down")
    command.ok()
    after = user.points()
    assert after.keys() == before.keys()
    name = "VP_motor0_EXPORT_torso_{}".format
    assert after[name(0)] == pytest.approx(before[name(1)])
    assert after[name(1)] == pytest.approx(before[name(0)])
    assert user.attribute(name(1))["number"] == 1
    assert len(fusion.world.undo_steps) == 2


def test_another_link_by_drop_down(fusion: Any, user: User) -> None:
    command = user.define()
    command.set("link", "torso")
    command.pick("pick", user.circle())
    place = position(user.circle())
    assert command.table("points")[1][1] == "torso"
    done(command)
    torso = user.occurrence("torso").component
    assert torso.constructionPoints.itemByName("VP_motor0_EXPORT_torso_0") is not None
    assert user.points()["VP_motor0_EXPORT_torso_0"] == pytest.approx(place, abs=1e-6)
    command = user.define()
    command.set(command.cell("points", 1, 1).id, "arm")
    command.ok()
    assert user.points()["VP_motor0_EXPORT_arm_0"] == pytest.approx(place, abs=1e-6)
    assert torso.constructionPoints.count == 0


def test_muscles_are_added_and_chosen_by_name(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(0))
    command.set("muscle", "+ New muscle")
    command.pick("pick", user.vertex(1))
    assert command.items("muscle") == ["motor0", "motor1", "+ New muscle"]
    command.set("muscle_name", "motor0")
    assert "Muscle motor0 exists already" in command["status"].text
    command.set("muscle", "motor0")
    assert len(command.table("points")) == 2
    command.ok()
    rows = json.loads(fusion.design.attributes.itemByName("CARDSFlow", "muscles").value)
    assert [row["name"] for row in rows] == ["motor0", "motor1"]
    assert rows[0]["color"] != rows[1]["color"]


def test_reason_for_disabled_ok_is_shown(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(0))
    assert command.is_valid()
    command.set("f_min", 200.0)
    assert not command.is_valid()
    assert "OK is disabled" in command["status"].text
    with pytest.raises(Rejected):
        command.ok()
    command.set("f_max", 300.0)
    assert command.is_valid()
    command.set("color", "red")
    assert not command.is_valid()
    command.set("color", "#ff0000")
    command.set("model", "passive_spring")
    command.set(command.cell("parameters", 1, 1).id, "K")
    assert "'K' is not a number" in command["status"].text


def test_a_part_without_a_link_is_reported(fusion: Any, addin: Any) -> None:
    build = build_arm()
    loose = build.place("loose")
    build.box(loose, (1.0, 1.0, 1.0))
    command = fusion.run_command(DEFINE)
    command.pick("pick", User(fusion).body("loose").vertices.item(0))
    assert "does not belong to a link" in command["status"].text
    assert len(command.table("points")) == 1


def test_faces_of_referenced_components_are_rejected_and_points_are_stored(
    fusion: Any, addin: Any
) -> None:
    build = build_arm()
    linked = build.place(build.component("bolt", referenced=True))
    build.cylinder(linked, 1.0, 1.0)
    build.rigid_group("EXPORT_bolt", [linked])
    before = fusion.full_fingerprint()
    command = fusion.run_command(DEFINE)
    command.pick("wrap_pick", User(fusion).body("bolt").faces.item(0))
    text = command["status"].text
    assert "bolt:1" in text
    assert "another document" in text
    command.pick("pick", User(fusion).body("bolt").vertices.item(0))
    command.set("link", "bolt")
    command.pick("pick", User(fusion).vertex(0))
    done(command)
    assert linked[-1].component.points == []
    command = fusion.run_command(DEFINE)
    assert [row[1] for row in command.table("points")[1:]] == ["bolt", "bolt"]
    command.cancel()
    fusion.undo()
    assert fusion.full_fingerprint() == before


def test_a_muscle_may_pass_through_a_surface(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(0), user.circle())
    command.pick("wrap_pick", user.face("Cylinder"))
    command.press("use_add")
    command.set(command.cell("wrap_uses", 1, 3).id, 2)
    command.set(command.cell("wrap_uses", 1, 2).id, "Inside")
    assert command.table("wrap_uses")[-1][2] == "Inside"
    done(command)
    attribute = user.face("Cylinder").attributes.itemByName("CARDSFlow", "wrap")
    (use,) = json.loads(attribute.value)["muscles"]
    assert (use["side"], use["turns"], use["inside"]) == (0, 0, True)


def test_wrap_surfaces_task_points_and_markers(fusion: Any, user: User) -> None:
    mine = fusion.fingerprint()
    command = user.define(user.vertex(0), user.circle())
    command.pick("wrap_pick", user.face("Cylinder"))
    command.pick("wrap_pick", user.face("Sphere"))
    assert command.items("wrap") == ["arm_cylinder", "arm_sphere"]
    command.set("wrap_name", "elbow")
    command.press("use_add")
    command.set(command.cell("wrap_uses", 1, 2).id, "Turning +")
    command.set(command.cell("wrap_uses", 1, 3).id, 1)
    command.pick("other_pick", user.vertex(4))
    command.set("other_role", "Marker")
    command.pick("other_pick", user.circle())
    command.set(command.cell("others", 1, 1).id, "tip")
    table = [command.table(name) for name in ("wrap_uses", "others")]
    done(command)
    assert {"EE_torso", "VM_arm"} <= user.points().keys()
    attribute = user.face("Sphere").attributes.itemByName("CARDSFlow", "wrap")
    stored = json.loads(attribute.value)
    assert stored["name"] == "elbow"
    assert stored["muscles"] == [{"muscle": "motor0", "after": 0, "side": 1, "turns": 1}]
    assert fusion.fingerprint() == mine
    command = user.define()
    command.set("wrap", "elbow")
    assert [command.table(name) for name in ("wrap_uses", "others")] == table
    command.press("wrap_delete")
    command.row("others", 1)
    command.press("other_delete")
    done(command)
    assert user.face("Sphere").attributes.itemByName("CARDSFlow", "wrap") is None
    assert user.face("Cylinder").attributes.itemByName("CARDSFlow", "wrap") is not None
    assert "EE_torso" not in user.points()


def test_old_designs_and_duplicates(fusion: Any, addin: Any) -> None:
    build = build_arm()
    arm = next(iter(build.design.root.occurrences))
    for k in (10, 2, 0):
        build.point((arm,), (float(k), 0.0, 0.0), f"VP_motor3_EXPORT_torso_{k}")
    user = User(fusion)
    command = user.define()
    assert "10 to 80 N" in command["status"].text
    xs = [row[2] for row in command.table("points")[1:]]
    assert [x.split(",")[0] for x in xs] == ["10.0", "30.0", "110.0"]
    command.ok()
    names = {name for name in user.points() if name.startswith("VP")}
    assert names == {f"VP_motor3_EXPORT_torso_{k}" for k in range(3)}
    command = user.define()
    command.row("points", 1)
    command.press("delete")
    command.ok()
    assert sum(name.startswith("VP") for name in user.points()) == 2
    assert "Unused VP_motor3_EXPORT_torso_0" in user.points()
    assert len(user.define().table("points")) == 3


# Mirror and CSV


def mirrored_design() -> Any:
    build = Builder("sides")
    torso = build.place("torso", grounded=True)
    build.box(torso, (2.0, 2.0, 2.0))
    for side, x in (("l", 5.0), ("r", -5.0)):
        arm = build.place(
            f"arm_{side}", rotation(0.3 * x, (1.0, 1.0, 0.0)) @ translation((x, 0, 0))
        )
        build.box(arm, (1.0, 1.0, 1.0))
        build.rigid_group(f"EXPORT_arm_{side}", [arm])
    build.rigid_group("EXPORT_torso", [torso])
    build.done()
    return build


def test_a_muscle_is_mirrored(fusion: Any, addin: Any) -> None:
    mirrored_design()
    user = User(fusion)
    mine = fusion.fingerprint()
    command = user.define(user.vertex(0), user.body("arm_l").vertices.item(1))
    command.set("muscle_name", "biceps_l")
    command.press("mirror")
    assert "biceps_r" in command.items("muscle")
    done(command)
    points = user.points()
    assert points["VP_motor1_EXPORT_arm_r_1"] == pytest.approx(
        points["VP_motor0_EXPORT_arm_l_1"] * (-1.0, 1.0, 1.0), abs=1e-6
    )
    arm = user.occurrence("arm_r").component
    assert arm.constructionPoints.itemByName("VP_motor1_EXPORT_arm_r_1") is not None
    assert fusion.fingerprint() == mine
    before = fusion.full_fingerprint()
    command = user.define()
    command.press("mirror")
    assert "exists already" in command["status"].text
    command.set("muscle", "biceps_r")
    command.press("delete_muscle")
    assert arm.features.baseFeatures.count == 1
    command.ok()
    assert arm.constructionPoints.count == 0
    assert arm.features.baseFeatures.count == 0
    fusion.undo()
    assert fusion.full_fingerprint() == before


def test_all_muscles_of_a_side_at_a_picked_plane(fusion: Any, addin: Any) -> None:
    mirrored_design()
    user = User(fusion)
    face = next(
        f
        for f in (user.body("torso").faces.item(i) for i in range(6))
        if abs(f.geometry.normal.x) == 1.0
    )
    x = face.geometry.origin.x
    command = user.define()
    for name in ("a_l", "b_l", "c_r"):
        command.set("muscle", "+ New muscle")
        command.set("muscle_name", name)
        command.pick("pick", user.body(f"arm{name[1:]}").vertices.item(0))
        command.pick("pick", user.vertex(0))
    command.set("plane", "A picked plane")
    command.press("mirror")
    assert "Pick a flat face" in command["status"].text
    command.pick("plane_pick", face)
    command.set("muscle", "a_l")
    command.set("mirror_all", True)
    command.press("mirror")
    assert "Mirrored: a_r, b_r." in command["status"].text
    assert command.items("muscle")[:-1] == ["a_l", "b_l", "c_r", "a_r", "b_r"]
    command.ok()
    points = user.points()
    left, right = (points[f"VP_motor{n}_EXPORT_arm_{s}_0"] for n, s in ((0, "l"), (3, "r")))
    assert right == pytest.approx([2 * x - left[0], left[1], left[2]], abs=1e-6)


def test_exported_csv_is_imported_unchanged(fusion: Any, user: User, tmp_path: Any) -> None:
    file = tmp_path / "muscles.csv"
    command = user.define(user.vertex(0), user.circle())
    fusion.world.file_answers.extend([None, str(file)])
    command.press("csv_export")
    assert not file.exists()
    command.press("csv_export")
    text = file.read_text(encoding="utf-8-sig")
    command.ok()
    before = fusion.full_fingerprint()
    command = user.define()
    fusion.world.file_answers.extend([str(file), str(tmp_path / "none.csv"), str(tmp_path)])
    command.press("csv_import")
    assert "1 muscles with 2 points" in command["status"].text
    command.press("csv_import")
    assert "cannot be read" in command["status"].text
    command.press("csv_import")
    assert "is a folder" in command["status"].text
    command.ok()
    assert fusion.full_fingerprint() == before
    file.write_text(text.replace("torso", "leg"), encoding="utf-8")
    command = user.define()
    fusion.world.file_answers.append(str(file))
    command.press("csv_import")
    assert "was not imported" in command["status"].text
    assert "line 2: no link 'leg'" in command["status"].text
    assert len(command.table("points")) == 3
    assert fusion.messages == []


# Failures


def test_a_failed_read_shows_a_message(fusion: Any, user: User, monkeypatch: Any) -> None:
    from addin_sdfusion.commands import reading

    error = RuntimeError("2 : InternalValidationError : joint")
    monkeypatch.setattr(reading, "read_design", failing(error))
    for name in IDS:
        fusion.run_command(name)
    assert len(fusion.messages) == 3
    assert all("InternalValidationError" in text for text in fusion.messages)
    assert not any("Traceback" in text for text in fusion.messages)
    assert any("Traceback" in text for text in fusion.log)


def test_failing_handlers_show_messages(fusion: Any, user: User, monkeypatch: Any) -> None:
    from addin_sdfusion.commands.define_muscles.model import muscles, points

    command = user.define(user.vertex(0))
    error = failing(ZeroDivisionError("division by zero"))
    monkeypatch.setattr(points, "pick_point", error)
    monkeypatch.setattr(points, "edit_point", error)
    monkeypatch.setattr(muscles, "choose", error)
    command.pick("pick", user.vertex(1))
    command.set("muscle", "+ New muscle")
    command.press("up")
    assert [("division by zero" in text) for text in fusion.messages] == [True] * 3
    assert not any("Traceback" in text for text in fusion.messages)
    command.cancel()


def test_a_failed_ok_reverts_everything(fusion: Any, user: User, monkeypatch: Any) -> None:
    from addin_sdfusion.commands.define_muscles.writing import writer

    before = fusion.full_fingerprint()
    command = user.define(user.vertex(0), user.vertex(1))

    error = RuntimeError("3 : the attribute is too long")
    monkeypatch.setattr(writer, "muscles_text", failing(error))
    command.ok()
    assert "the attribute is too long" in command.failed
    assert "Traceback" not in command.failed
    assert fusion.full_fingerprint() == before


def test_a_failed_preview_is_only_logged(fusion: Any, user: User, monkeypatch: Any) -> None:
    from addin_sdfusion.commands.define_muscles import entry

    monkeypatch.setattr(entry, "draw", failing(RuntimeError("no graphics")))
    command = user.define(user.vertex(0))
    assert fusion.messages == []
    assert any("no graphics" in text for text in fusion.log)
    command.ok()
    assert "VP_motor0_EXPORT_torso_0" in user.points()


def test_an_import_that_fails_is_reported(fusion: Any, monkeypatch: Any) -> None:
    with fake_fusion.modules():
        from addin_sdfusion import addin_sdfusion, commands

        monkeypatch.setattr(commands, "load", failing(ImportError("no command")))
        addin_sdfusion.run(None)
    assert len(fusion.messages) == 3
    assert "could not be started" in fusion.messages[0]


def test_another_document_while_a_dialog_is_open(fusion: Any, user: User) -> None:
    first = fusion.design
    command = user.define(user.vertex(0))
    command.ok()
    designs.single_cube()
    command = user.define()
    assert len(command.table("points")) == 1
    command.cancel()
    first.parentDocument.activate()
    command = user.define()
    assert len(command.table("points")) == 2


def test_without_new_members_of_the_api(fusion: Any, user: User) -> None:
    fusion.without("Design.designIntent", "SelectionCommandInput.isUseCurrentSelections")
    command = user.define(user.vertex(0))
    command.ok()
    assert "VP_motor0_EXPORT_torso_0" in user.points()
    assert fusion.messages == []


def test_text_is_not_replaced_while_typing(fusion: Any, user: User) -> None:
    """Fusion reports every letter; the text must not be replaced while the user types."""
    command = user.define(user.vertex(0))
    command.set("muscle", "+ New muscle")
    for text in ("m", "mo", "motor0", "motor0b"):
        command.set("muscle_name", text)
        assert command["muscle_name"].value == text
    command.set("model", "passive_spring")
    cell = command.cell("parameters", 1, 1).id
    for text in ("0", "0.", "0.50"):
        command.set(cell, text)
        assert command[cell].value == text
    command.pick("other_pick", user.vertex(2))
    cell = command.cell("others", 1, 1).id
    for text in ("t", "ti", "tip"):
        command.set(cell, text)  # the same input object
    command.pick("wrap_pick", user.face("Sphere"))
    command.pick("wrap_pick", user.face("Cylinder"))
    for text in ("", "arm_sphere", "arm_sphere2"):
        command.set("wrap_name", text)
    command.ok()
    assert user.attribute("EE_torso")["name"] == "tip"
    command = user.define()
    assert command.items("muscle") == ["motor0", "motor0b", "+ New muscle"]
    assert command.items("wrap") == ["arm_sphere", "arm_sphere2"]


def test_the_active_tab_receives_the_clicks(fusion: Any, user: User) -> None:
    command = user.define()
    for tab, name in (("tab_wraps", "wrap_pick"), ("tab_others", "other_pick")):
        command.tab(tab)
        assert command[name].hasFocus


def test_another_document_disables_ok(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(0))
    designs.single_cube()
    before = fusion.full_fingerprint()
    assert not command.is_valid()
    command.cancel()
    assert fusion.full_fingerprint() == before


def test_points_in_a_direct_design(fusion: Any, addin: Any) -> None:
    build_arm(parametric=False)
    user = User(fusion)
    places = [position(user.circle()), position(user.face("Torus"))]
    command = user.define(user.circle())
    command.set("link", "torso")
    command.pick("pick", user.face("Torus"))
    done(command)
    points = user.points()
    assert points["VP_motor0_EXPORT_arm_0"] == pytest.approx(places[0], abs=1e-6)
    assert points["VP_motor0_EXPORT_torso_1"] == pytest.approx(places[1], abs=1e-6)


STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("pick"), st.integers(0, 7)),
        st.tuples(
            st.sampled_from(["up", "down", "insert", "duplicate", "delete", "undo", "redo"]),
            st.integers(0, 5),
        ),
        st.tuples(st.just("own"), st.just(0)),
        st.tuples(st.just("face"), st.integers(0, 3)),
        st.tuples(st.just("part"), st.integers(0, 3)),
        st.tuples(st.just("muscle"), st.integers(0, 2)),
        st.tuples(st.just("ok"), st.just(0)),
    ),
    max_size=10,
)


@given(STEPS)
def test_any_sequence_of_edits_is_stored_and_undone(steps: list[tuple[str, int]]) -> None:
    with fake_fusion.install() as fusion:
        from addin_sdfusion import addin_sdfusion

        addin_sdfusion.run(None)
        build_arm()
        user = User(fusion)
        own = user.own_point()
        states = [fusion.full_fingerprint()]
        command = user.define()
        for what, number in [*steps, ("ok", 0)]:
            if what == "pick":
                command.pick("pick", user.vertex(number))
            elif what == "own":
                command.pick("pick", own)
            elif what == "face":
                face = user.face("Plane")
                place = np.array(face.geometry.origin.asArray())
                across = np.cross(face.geometry.normal.asArray(), (1.0, 0.0, 0.0))
                command.pick("pick", face, point(place + 0.1 * number * across))
            elif what == "part":
                for name in ("old_part", "new_part"):
                    items = command.items(name)
                    command.set(name, items[number % len(items)])
                command.press("replace_part")
            elif what == "muscle":
                names = command.items("muscle")
                command.set("muscle", names[number % len(names)])
            elif what == "ok":
                shown = tables_of(command)
                done(command)
                states.append(fusion.full_fingerprint())
                command = user.define()
                assert tables_of(command) == shown
            else:
                rows = len(command.table("points"))
                command.row("points", min(number, rows - 1))
                command.press(what)
        command.cancel()
        assert states[-1] == fusion.full_fingerprint()
        while fusion.world.undo_steps:
            fusion.undo()
        assert fusion.full_fingerprint() == states[0]
        assert fusion.messages == []
        addin_sdfusion.stop(None)


def tables_of(command: Any) -> dict[str, list[list[Any]]]:
    """Return the points of every muscle as shown in the dialog."""
    found = {}
    for name in command.items("muscle")[:-1]:
        command.set("muscle", name)
        found[name] = command.table("points")[1:]
    return found
