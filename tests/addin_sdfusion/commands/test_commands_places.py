"""Tests of commands if components have several or ambiguous occurrences."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import pytest
from fake_fusion import Builder, designs
from fake_fusion.base import CLASSES
from fake_fusion.maths import translation
from support.designs.exported import Export, export, failing, press_export

from addin_sdfusion.exporting.export import export_robot
from addin_sdfusion.robot import Finding, Subject
from cardsflow_fmu.cad import read_design
from cardsflow_fmu.cli.main import main

DEFINE, CHECK, EXPORT = "cardsflowDefineMuscles", "cardsflowCheck", "cardsflowExport"


pytestmark = pytest.mark.usefixtures("addin")


def shown(fusion: Any, kind: str, name: str) -> list[Any]:
    """Return the entities that Check selects for a finding on an object."""
    from addin_sdfusion.commands.check.locate import entities_of
    from addin_sdfusion.commands.reading import read

    design = fusion.design
    return entities_of(design, read(design), Subject(kind, name))


def two_copies() -> Any:
    """Return two joined components 9 cm apart, with user points of the same name."""
    build = Builder("copies")
    paths = [build.place(n, translation((9.0 * k, 0, 0))) for k, n in enumerate(("one", "two"))]
    for k, path in enumerate(paths):
        build.box(path, (1.0, 1.0, 1.0))
        build.point(path, (0.0, 0.0, 1.0), "mine")
        build.rigid_group(f"EXPORT_{'ab'[k]}", [path])
    build.joint("EXPORT_j", "cylindrical", paths[1], paths[0], axis=(0.0, 1.0, 0.0))
    return build.done()


@pytest.mark.parametrize("same", ["the same", None])
def test_points_of_copies_with_equal_ids_are_distinguished(
    fusion: Any, monkeypatch: pytest.MonkeyPatch, same: str | None
) -> None:
    """Copies of a document have equal component ids; old documents may have none."""

    def reported(_: Any) -> str:
        if same is None:
            raise RuntimeError("2 : InternalValidationError")
        return same

    monkeypatch.setattr(CLASSES["adsk.fusion"]["Component"], "id", property(reported))
    two_copies()
    command = fusion.run_command(DEFINE)
    for occurrence in fusion.design.rootComponent.occurrences:
        point = occurrence.component.constructionPoints.itemByName("mine")
        command.pick("pick", point.createForAssemblyContext(occurrence))
    assert len(command.table("points")) == 3
    command.ok()
    assert command.failed == ""
    names = []
    for occurrence in fusion.design.rootComponent.occurrences:
        point = occurrence.component.constructionPoints.item(0)
        stored = json.loads(point.attributes.itemByName("CARDSFlow", "point").value)
        names.append((point.name, stored["occurrence"], stored["number"]))
    assert names == [("VP_motor0_EXPORT_a_0", "one:1", 0), ("VP_motor0_EXPORT_b_1", "two:1", 1)]


def test_a_coordinate_is_shown_by_its_joint(fusion: Any) -> None:
    two_copies()
    assert [e.name for e in shown(fusion, "coordinate", "j_slide")] == ["EXPORT_j"]
    assert [e.name for e in shown(fusion, "joint", "j")] == ["EXPORT_j"]
    assert shown(fusion, "joint", "j_2") == []


def test_a_mesh_body_is_shown(fusion: Any) -> None:
    designs.surface_and_mesh_bodies()
    (body,) = shown(fusion, "body", "lower:1/scan")
    assert body.name == "scan"
    assert body.assemblyContext.fullPathName == "lower:1"


def test_a_task_point_is_shown_in_its_occurrence(fusion: Any) -> None:
    """Its component has two occurrences."""
    build = Builder("hands")
    base = build.place("base", grounded=True)
    build.box(base, (1.0, 1.0, 1.0))
    left = build.place("hand", translation((-5.0, 0.0, 0.0)))
    build.box(left, (1.0, 1.0, 1.0))
    right = build.place(left[-1].component, translation((5.0, 0.0, 0.0)))
    build.point(left, (0.0, 0.0, 1.0), "EE_right")
    for name, path in (("base", base), ("left", left), ("right", right)):
        build.rigid_group(f"EXPORT_{name}", [path])
    build.done()
    (point,) = shown(fusion, "task_frame", "right")
    assert point.assemblyContext.fullPathName == "hand:2"


@pytest.mark.parametrize("name", ["a::b", "__x__"])
def test_errors_of_the_sdf_writer_are_reported_by_check(
    fusion: Any, tmp_path: Path, name: str
) -> None:
    """Previously Check found no error, but Export failed."""
    build = Builder("reserved")
    paths = designs.chain(build, ("base", name))
    build.point(paths[0], (1.0, 0.0, 5.0), "EE_base")
    build.done()
    command = fusion.run_command(CHECK)
    rows = command.table("findings")[1:]
    assert ["error", f"link {name}"] in [row[:2] for row in rows]
    command.cancel()
    command = fusion.run_command(EXPORT)
    fusion.world.folder_answers.append(str(tmp_path / "robot"))
    command.press("browse")
    assert not command.is_valid()
    command.cancel()


def test_a_message_is_shown_even_if_logging_fails(
    fusion: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from addin_sdfusion.commands.export import entry

    fail = failing(OSError("the disk is full"))
    designs.two_link_arm()
    monkeypatch.setattr(entry, "export_robot", fail)
    monkeypatch.setattr(CLASSES["adsk.core"]["Application"], "log", fail)
    assert "the disk is full" in press_export(fusion, tmp_path / "robot").failed


def test_the_shown_command_line_is_valid_in_the_shell(fusion: Any, tmp_path: Path) -> None:
    designs.two_link_arm()
    folder = tmp_path / "Bob's(new)"
    press_export(fusion, folder)
    commands = shown_commands(fusion)
    assert commands == [["init", str(folder), "-o", str(folder)], ["run", str(folder)]]
    options = ["-o", str(tmp_path / "results"), "--set", "run.duration=0.1"]
    for words in (commands[0], [*commands[1], *options]):
        assert main(words) == 0
    press_export(fusion, folder)
    assert shown_commands(fusion) == [["run", str(folder)]]


def shown_commands(fusion: Any) -> list[list[str]]:
    """Return the words of the commands in the last message."""
    lines = fusion.messages[-1].splitlines()
    return [shlex.split(line)[1:] for line in lines if line.startswith("    cardsflow ")]


@pytest.mark.slow
def test_every_step_of_an_export_can_be_cancelled(fusion: Any, tmp_path: Path) -> None:
    """A cancelled export leaves no files, at any step."""
    designs.component_twice()
    steps = 0
    while True:
        fusion.world.cancel_progress_after = None
        command = fusion.run_command(EXPORT)
        fusion.world.folder_answers.append(str(tmp_path / "robot"))
        command.press("browse")
        fusion.world.cancel_progress_after = steps
        command.ok()
        if "cancelled" not in fusion.messages[-1]:
            break
        assert list(tmp_path.iterdir()) == []
        steps += 1
    assert steps > 10
    assert (tmp_path / "robot/model.sdf").is_file()
    assert [path.name for path in tmp_path.iterdir()] == ["robot"]


def test_a_saved_snapshot_results_in_the_same_export(fusion: Any, tmp_path: Path) -> None:
    """The saved file can be read by `cardsflow import-cad`."""
    design = designs.two_link_arm()
    before = fusion.full_fingerprint()
    command = fusion.run_command(CHECK)
    file = tmp_path / "report" / "arm.json"
    command.press("save")  # the file dialog is cancelled
    fusion.world.file_answers.append(str(file))
    command.press("save")
    assert str(file) in command["detail"].text
    assert all(record.hidden for record in fusion.world.progress)
    for wrong, text in ((tmp_path, "cannot be written"), (file, "Nothing was saved")):
        fusion.world.file_answers.append(str(wrong))
        fusion.world.cancel_progress_after = 0 if wrong == file else None
        command.press("save")
        assert text in command["detail"].text
    command.cancel()
    assert fusion.full_fingerprint() == before
    assert fusion.messages == []
    export_robot(read_design(file), tmp_path / "a/arm")
    made = export(design, tmp_path / "b/arm")
    assert Export(tmp_path / "a/arm", made.robot, ()).contents() == made.contents()


def test_define_muscles_reads_no_masses_and_no_meshes(
    fusion: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both are slow in Fusion."""
    slow = failing(AssertionError())
    designs.two_link_arm()
    for cls in ("BRepBody", "Occurrence", "Component"):
        monkeypatch.setattr(CLASSES["adsk.fusion"][cls], "getPhysicalProperties", slow)
    monkeypatch.setattr(CLASSES["adsk.fusion"]["TriangleMeshCalculator"], "calculate", slow)
    command = fusion.run_command(DEFINE)
    assert len(command.table("points")) > 1
    command.cancel()
    assert fusion.messages == []


def test_findings_of_sdf_are_not_repeated(fusion: Any) -> None:
    from addin_sdfusion.building.build_robot import check_design
    from addin_sdfusion.fusion.design import read_design

    found: list[Finding] = check_design(read_design(designs.name_clash(), meshes=False))
    codes = [f.code for f in found if f.is_error]
    assert codes == ["name-clash"]
