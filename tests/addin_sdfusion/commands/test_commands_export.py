"""Tests of Check and Export in the fake Fusion, from the view of the user."""

from __future__ import annotations

import html
import json
from pathlib import Path
from typing import Any

import pytest
from fake_fusion import Builder, designs
from fake_fusion.driver import Rejected
from support.designs.exported import failing
from support.process_output import files_of

from addin_sdfusion.robot.formats.read import read_robot

CHECK, EXPORT = "cardsflowCheck", "cardsflowExport"


pytestmark = pytest.mark.usefixtures("addin")


def export_to(fusion: Any, folder: Path) -> Any:
    """Return the dialog with a chosen folder."""
    command = fusion.run_command(EXPORT)
    fusion.world.folder_answers.append(str(folder))
    command.press("browse")
    return command


def bad_design() -> Any:
    """Return a design with a muscle on an unknown link and a body outside groups."""
    build = Builder("bad")
    base = build.place("base", grounded=True)
    build.box(base, (1.0, 1.0, 1.0))
    arm = build.place("arm")
    build.box(arm, (1.0, 1.0, 1.0))
    build.rigid_group("EXPORT_base", [base])
    build.rigid_group("EXPORT_arm", [arm])
    build.joint("EXPORT_elbow", "revolute", one=arm, two=base, origin=(0, 0, 1), axis=(0, 1, 0))
    build.point(arm, (0.0, 0.0, 1.0), "VP_motor0_EXPORT_leg_0")
    build.point(base, (0.0, 0.0, 2.0), "VP_motor0_EXPORT_base_1")
    return build.done()


# Check


def test_check_of_a_valid_design(fusion: Any) -> None:
    designs.two_link_arm()
    before = fusion.full_fingerprint()
    command = fusion.run_command(CHECK)
    assert command["summary"].text == "No problems found: the robot can be exported."
    assert command.table("findings")[0][1] == "Object"
    command.press("again")
    with pytest.raises(Rejected):
        command.ok()
    command.cancel()
    assert fusion.full_fingerprint() == before
    assert fusion.messages == []


def test_check_lists_all_findings_and_shows_their_objects(fusion: Any) -> None:
    bad_design()
    before = fusion.full_fingerprint()
    command = fusion.run_command(CHECK)
    rows = command.table("findings")[1:]
    assert "error" in command["summary"].text
    severities = [row[0] for row in rows]
    assert severities == sorted(severities)
    assert any("leg" in row[2] or "leg" in row[1] for row in rows)
    shown = 0
    for i in range(len(rows)):
        command.press(command.cell("findings", i + 1, 0).id)
        assert rows[i][1] in command["detail"].text
        assert rows[i][2] in command["detail"].text  # the text is complete
        shown += command["shown"].selectionCount
    assert (
        fusion.app.userInterface.activeSelections.count == 0
    )  # it must be empty while a command runs
    assert shown > 0
    command.cancel()
    assert fusion.full_fingerprint() == before
    assert len(fusion.world.undo_steps) == 0


def test_the_report_is_copied(fusion: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    from addin_sdfusion.commands import clipboard

    copied: list[str] = []
    monkeypatch.setattr(clipboard, "copy", copied.append)
    bad_design()
    command = fusion.run_command(CHECK)
    rows = command.table("findings")[1:]
    command.press("copy")
    assert "is copied" in command["detail"].text
    assert copied[0].startswith("bad in Fusion")
    for _, _, text in rows:
        assert html.unescape(text) in copied[0]
    command.cancel()


def test_commands_have_a_help_page_and_a_picture(fusion: Any) -> None:
    designs.two_link_arm()
    for name in (CHECK, EXPORT):
        definition = fusion.app.userInterface.commandDefinitions.itemById(name)
        assert Path(definition.toolClipFilename).is_file()
        command = fusion.run_command(name)
        assert Path(command.data.fields["helpFile"]).is_file()
        command.cancel()


@pytest.mark.parametrize("intent", ["part", "assembly"])
def test_kinds_of_designs_are_reported(fusion: Any, intent: str) -> None:
    build = Builder("kind", intent=intent)
    build.box((), (1.0, 1.0, 1.0))
    build.done()
    command = fusion.run_command(CHECK)
    assert f"{intent} design" in command["detail"].text
    command.cancel()
    command = fusion.run_command("cardsflowDefineMuscles")
    assert f"{intent} design" in command["status"].text
    command.cancel()
    assert fusion.messages == []


# Export


def test_an_export_and_the_message_after_it(fusion: Any, tmp_path: Path) -> None:
    designs.two_link_arm()
    mine = fusion.fingerprint()
    folder = tmp_path / "my robot"
    command = export_to(fusion, folder)
    assert command["folder"].value == str(folder)
    command.set("name", "arm")
    command.set("collision", "None")
    fusion.world.message_answers.clear()
    command.ok()
    assert command.failed == ""
    assert (folder / "model.sdf").is_file()
    assert f'cardsflow run "{folder}"' in fusion.messages[-1]
    assert str(folder) in fusion.messages[-1]
    assert "The files for CASPR and OpenSim do not contain everything" in fusion.messages[-1]
    assert " warnings. They are in" not in fusion.messages[-1]
    assert all(record.maximum > record.minimum for record in fusion.world.progress)
    assert all(record.hidden for record in fusion.world.progress)
    assert fusion.fingerprint() == mine
    assert len(fusion.world.undo_steps) == 1
    stored = json.loads(fusion.design.attributes.itemByName("CARDSFlow", "settings").value)
    assert stored["name"] == "arm"
    assert stored["collision"] == "none"


def test_exporting_twice_in_one_session_has_no_duplicates(fusion: Any, tmp_path: Path) -> None:
    designs.two_link_arm()
    folder = tmp_path / "robot"
    contents = []
    for _ in range(2):
        command = export_to(fusion, folder)
        command.ok()
        files = sorted(file for file in folder.rglob("*") if file.is_file())
        contents.append({file.relative_to(folder): file.read_bytes() for file in files})
    assert contents[0] == contents[1]
    assert contents[0]


def test_settings_are_stored(fusion: Any, tmp_path: Path) -> None:
    designs.two_link_arm()
    command = export_to(fusion, tmp_path / "robot")
    command.set("up_axis", "y")
    command.set("quality", "Low")
    command.set("osim", False)
    command.set("base", "base")
    command.ok()
    command = fusion.run_command(EXPORT)
    assert command.chosen("up_axis") == ["y"]
    assert command.chosen("quality") == ["Low"]
    assert command.chosen("base") == ["base"]
    assert command["osim"].value is False
    assert command["folder"].value == str(tmp_path / "robot")
    command.cancel()


def test_single_links_and_joints_have_settings(fusion: Any, tmp_path: Path) -> None:
    designs.two_link_arm()
    command = export_to(fusion, tmp_path / "robot")
    links = [row[0] for row in command.table("of_links")[1:]]
    joints = [row[0] for row in command.table("of_joints")[1:]]
    command.set(command.cell("of_links", links.index("link_2") + 1, 1).id, "Box")
    command.set(command.cell("of_links", links.index("link_2") + 1, 2).id, "0,75")
    command.set(command.cell("of_joints", joints.index("joint_2") + 1, 2).id, "0.5")
    command.set(command.cell("of_links", links.index("link_2") + 1, 3).id, "ulna")
    command.set(command.cell("of_joints", joints.index("joint_2") + 1, 4).id, "6")
    command.set(command.cell("of_joints", joints.index("joint_2") + 1, 5).id, "Reversed")
    command.set(command.cell("of_joints", joints.index("joint_2") + 1, 3).id, "much")
    assert "'much' is not a number" in command["status"].text
    command.ok()
    robot = read_robot(tmp_path / "robot")
    assert robot.link("ulna").inertia.mass == 0.75
    assert {shape.kind for shape in robot.link("ulna").shapes} == {"box"}
    (coordinate,) = robot.joint("joint_2").coordinates
    assert (coordinate.damping, coordinate.max_velocity) == (0.5, 6.0)
    assert robot.joint("joint_2").motions[0].axis == pytest.approx((0.0, -1.0, 0.0))
    command = fusion.run_command(EXPORT)
    assert command.table("of_links")[links.index("link_2") + 1][1:] == ["Box", "0.75", "ulna"]
    command.set(command.cell("of_links", links.index("link_2") + 1, 1).id, "Default")
    command.set(command.cell("of_links", links.index("link_2") + 1, 2).id, "")
    command.set(command.cell("of_links", links.index("link_2") + 1, 3).id, "")
    command.ok()
    stored = json.loads(fusion.design.attributes.itemByName("CARDSFlow", "settings").value)
    assert "of_links" not in stored


@pytest.mark.parametrize("text", ['{"version": 9, "name": "newer"}', "{"])
def test_settings_that_cannot_be_read_are_kept(fusion: Any, tmp_path: Path, text: str) -> None:
    designs.two_link_arm()
    stored = fusion.design.attributes
    fusion.design._data.attributes["CARDSFlow", "settings"] = text
    command = export_to(fusion, tmp_path / "robot")
    command.ok()
    assert command.failed == ""
    assert stored.itemByName("CARDSFlow", "settings_unread").value == text
    assert json.loads(stored.itemByName("CARDSFlow", "settings").value)["version"] == 2


def test_changes_since_the_last_export_are_shown(fusion: Any, tmp_path: Path) -> None:
    designs.two_link_arm()
    folder = tmp_path / "robot"
    command = export_to(fusion, folder)
    assert "Since the last export" not in command["status"].text
    command.ok()
    assert "previous export" not in fusion.messages[-1]
    export_to(fusion, folder).ok()
    assert ":\nnone" in fusion.messages[-1]
    command = export_to(fusion, folder)
    joints = [row[0] for row in command.table("of_joints")[1:]]
    command.set(command.cell("of_joints", joints.index("joint_2") + 1, 1).id, "3")
    links = [row[0] for row in command.table("of_links")[1:]]
    command.set(command.cell("of_links", links.index("link_2") + 1, 2).id, "2.5")
    for text in ("joint joint_2: values changed", "link link_2: 2.5 kg; before: 0.1 kg"):
        assert text in command["status"].text
    command.ok()
    assert "link link_2: 2.5 kg; before: 0.1 kg" in fusion.messages[-1]


def test_without_a_folder_ok_is_disabled(fusion: Any) -> None:
    designs.two_link_arm()
    command = fusion.run_command(EXPORT)
    assert "Choose the folder" in command["status"].text
    assert not command.is_valid()
    command.press("browse")  # the folder dialog is cancelled
    assert not command.is_valid()
    command.cancel()


def test_errors_disable_ok_and_contain_advice(fusion: Any, tmp_path: Path) -> None:
    bad_design()
    command = export_to(fusion, tmp_path / "robot")
    assert not command.is_valid()
    assert "leg" in command["status"].text
    with pytest.raises(Rejected):
        command.ok()
    command.cancel()
    assert not (tmp_path / "robot").exists()


def test_warnings_are_confirmed_once(fusion: Any, tmp_path: Path) -> None:
    designs.two_link_arm(attributes=False)  # without force limits
    before = fusion.fingerprint()
    command = export_to(fusion, tmp_path / "robot")
    fusion.world.message_answers.append(3)  # No
    command.ok()
    assert len(fusion.messages) == 1
    assert "10 to 80 N" in fusion.messages[0]
    assert not (tmp_path / "robot").exists()
    command = fusion.run_command(EXPORT)
    fusion.world.message_answers.append(2)  # Yes
    command.ok()
    assert len(fusion.messages) == 3
    assert (tmp_path / "robot/model.sdf").is_file()
    assert fusion.fingerprint() == before


def test_cancelling_keeps_the_old_export(fusion: Any, tmp_path: Path) -> None:
    designs.two_link_arm()
    folder = tmp_path / "robot"
    export_to(fusion, folder).ok()
    before = files_of(folder)
    command = export_to(fusion, folder)
    command.set("up_axis", "y")
    fusion.world.cancel_progress_after = 2
    command.ok()
    assert "cancelled" in fusion.messages[-1]
    assert files_of(folder) == before
    assert list(tmp_path.iterdir()) == [folder]
    assert fusion.world.progress[-1].hidden


def test_a_folder_that_cannot_be_written_is_reported(fusion: Any, tmp_path: Path) -> None:
    designs.two_link_arm()
    (tmp_path / "file").write_text("mine")
    export_to(fusion, tmp_path / "file").ok()
    assert str(tmp_path / "file") in fusion.messages[-1]
    assert "Traceback" not in fusion.messages[-1]
    assert (tmp_path / "file").read_text() == "mine"


def test_picked_components_become_links(fusion: Any, tmp_path: Path) -> None:
    designs.two_link_arm(groups=False)
    command = export_to(fusion, tmp_path / "robot")
    assert not command["components"].isVisible
    command.set("links", "Components")
    assert command["components"].isVisible
    root = fusion.design.rootComponent
    for i in range(root.occurrences.count):
        command.pick("components", root.occurrences.item(i))
    assert "pick again to remove" in command["status"].text
    command.ok()
    assert (tmp_path / "robot/model.sdf").is_file()


def test_a_failure_of_the_export_is_reported(fusion: Any, tmp_path: Path, monkeypatch: Any) -> None:
    from addin_sdfusion.commands.export import entry

    designs.two_link_arm()
    monkeypatch.setattr(entry, "export_robot", failing(OSError("the disk is full")))
    command = export_to(fusion, tmp_path / "robot")
    command.ok()
    assert "the disk is full" in command.failed
    assert "Traceback" not in command.failed
    assert any("Traceback" in text for text in fusion.log)


def test_unchecked_designs_are_not_exported(fusion: Any, tmp_path: Path, monkeypatch: Any) -> None:
    from addin_sdfusion.commands.export import entry

    designs.two_link_arm()
    command = export_to(fusion, tmp_path / "robot")
    monkeypatch.setattr(entry, "build_robot", failing(RuntimeError("no robot")))
    command.set("up_axis", "y")
    assert "no robot" in fusion.messages[-1]
    assert not command.is_valid()
    command.cancel()
    command = export_to(fusion, tmp_path / "robot")
    assert not command.is_valid()
    assert not any("Traceback" in text for text in fusion.messages)


def test_joints_of_loops_can_be_chosen_to_cut(fusion: Any, tmp_path: Path) -> None:
    build = Builder("loop")
    places = [build.place(name, grounded=name == "a") for name in "abc"]
    for place, name in zip(places, "abc", strict=True):
        build.box(place, (1.0, 1.0, 1.0))
        build.rigid_group(f"EXPORT_{name}", [place])
    for one, two in ((1, 0), (2, 1), (2, 0)):
        build.joint(f"EXPORT_j{one}{two}", "revolute", one=places[one], two=places[two],
                    origin=(one, two, 0), axis=(0, 0, 1))  # fmt: skip
    build.done()
    command = export_to(fusion, tmp_path / "robot")
    assert command.is_valid()
    assert set(command.items("cut_joints")) >= {"j21", "j20"}
    command.set("cut_joints", ["j20"])
    assert command.is_valid()
    assert command.chosen("cut_joints") == ["j20"]
    command.ok()
    assert [loop.name for loop in read_robot(tmp_path / "robot").loops] == ["j20"]
