"""Tests of commands in designs with properties that were observed in real Fusion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_fusion import Builder, designs
from fake_fusion.base import CLASSES
from fake_fusion.maths import translation
from fake_fusion.model.data import DesignData
from support.designs.exported import initial_poses, press_export

from addin_sdfusion.robot.formats.read import read_robot

DEFINE, CHECK, EXPORT = "cardsflowDefineMuscles", "cardsflowCheck", "cardsflowExport"

pytestmark = pytest.mark.usefixtures("addin")


def arm(**more: Any) -> Builder:
    """Return two links with a joint."""
    build = Builder("arm", **more)
    designs.chain(build, ("base", "upper"))
    build.done()
    return build


def imported(fusion: Any, file: Path, lines: list[str]) -> Any:
    """Return the open dialog of Define muscles after importing a file."""
    file.write_text("\n".join(["role,name,number,link,x [m],y [m],z [m]", *lines]))
    command = fusion.run_command(DEFINE)
    fusion.world.file_answers.append(str(file))
    command.press("csv_import")
    assert "muscles with" in command["status"].text
    return command


def test_every_dialog_opens_with_an_unresolved_reference(fusion: Any, tmp_path: Path) -> None:
    build = arm()
    build.unresolved("gone")
    command = fusion.run_command(DEFINE)
    for occurrence in list(fusion.design.rootComponent.occurrences)[:2]:
        command.pick("pick", occurrence.bRepBodies[0].vertices[0])
    command.ok()
    assert command.failed == ""
    command = fusion.run_command(CHECK)
    assert "no errors" in command["summary"].text
    assert any("gone:1" in str(row) for row in command.table("findings"))
    command.cancel()
    press_export(fusion, tmp_path / "robot")
    assert (tmp_path / "robot").is_dir()


@pytest.mark.slow
def test_four_hundred_points_need_one_edit_per_component(fusion: Any, tmp_path: Path) -> None:
    arm()
    before = fusion.full_fingerprint()
    lines = [
        f"via,m{k // 10},{k % 10},{('base', 'upper')[k % 2]},{0.001 * k!r},0.0,{0.002 * k!r}"
        for k in range(400)
    ]
    steps = len(fusion.world.undo_steps)
    command = imported(fusion, tmp_path / "muscles.csv", lines)
    command.ok()
    assert command.failed == ""
    assert fusion.world.edit_scopes == 2
    found = {}
    for occurrence in fusion.design.rootComponent.occurrences:
        for native in occurrence.component.constructionPoints:
            seen = native.createForAssemblyContext(occurrence).geometry
            found[native.name] = [seen.x, seen.y, seen.z]
    assert len(found) == 400
    for k in range(400):
        name = f"VP_motor{k // 10}_EXPORT_{('base', 'upper')[k % 2]}_{k % 10}"
        assert found[name] == pytest.approx([0.1 * k, 0.0, 0.2 * k], abs=1e-9)
    command = imported(fusion, tmp_path / "none.csv", [f"via,m{k},0,base,0,0,0" for k in range(40)])
    command.ok()
    assert len(fusion.world.undo_steps) == steps + 2
    fusion.undo()
    fusion.undo()
    assert fusion.full_fingerprint() == before


def test_moved_parts_must_be_captured_first(fusion: Any) -> None:
    build = arm()
    path = (build.root.occurrences[1],)
    build.move(path, translation((0.0, 0.0, 3.0)))
    fusion.run_command(DEFINE)
    assert fusion.world.running is None
    assert "Capture Position" in fusion.messages[-1]
    assert np.allclose(path[-1].T, translation((0.0, 0.0, 3.0)))
    with fusion.transaction():
        fusion.design.snapshots.add()
    fusion.run_command(DEFINE).cancel()


def test_stale_groups_and_tangents_do_not_prevent_the_export(fusion: Any, tmp_path: Path) -> None:
    build = arm()
    for _ in range(3):
        build.rigid_group("old", [], stale=True)
    build.tangent()
    command = fusion.run_command(CHECK)
    texts = [str(row) for row in command.table("findings")]
    assert sum("groups without components" in text for text in texts) == 1
    assert any("tangent" in text for text in texts)
    assert "no errors" in command["summary"].text
    command.cancel()
    press_export(fusion, tmp_path / "robot")
    assert (tmp_path / "robot").is_dir()


def test_a_broken_as_built_joint_is_an_error(fusion: Any) -> None:
    build = arm()
    one, two = ((o,) for o in build.root.occurrences)
    build.joint("weld", "rigid", one, two, as_built=True, health=2, problem="its parts are lost")
    command = fusion.run_command(CHECK)
    (row,) = [r for r in command.table("findings") if "its parts are lost" in str(r)]
    assert row[0] == "error"


def test_a_row_is_not_deleted_during_an_event_of_its_cells(fusion: Any) -> None:
    """A wrap inside its surface has no turns, so another cell of the row changes."""
    build = arm()
    build.cylinder((build.root.occurrences[0],), 1.0, 6.0)
    command = fusion.run_command(DEFINE)
    occurrences = list(fusion.design.rootComponent.occurrences)[:2]
    for occurrence in occurrences:
        command.pick("pick", occurrence.bRepBodies[0].vertices[0])
    faces = [f for body in occurrences[0].bRepBodies for f in body.faces]
    command.pick("wrap_pick", next(f for f in faces if type(f.geometry).__name__ == "Cylinder"))
    command.press("use_add")
    command.set(command.cell("wrap_uses", 1, 3).id, 2)
    command.set(command.cell("wrap_uses", 1, 2).id, "Inside")
    assert command.table("wrap_uses")[1][2:] == ["Inside", 0]
    assert fusion.messages == []
    command.ok()
    assert command.failed == ""


def test_an_export_calculates_masses_once_and_shows_the_progress(
    fusion: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arm()
    weighed: list[tuple[str, int]] = []
    for name in ("BRepBody", "Component", "Occurrence"):
        original = CLASSES["adsk.fusion"][name].getPhysicalProperties

        def counted(owner: Any, accuracy: int, original: Any = original) -> Any:
            weighed.append((repr(owner), accuracy))
            return original(owner, accuracy)

        monkeypatch.setattr(CLASSES["adsk.fusion"][name], "getPhysicalProperties", counted)
    press_export(fusion, tmp_path / "robot")
    assert (tmp_path / "robot").is_dir()
    assert len(weighed) == len(set(weighed)) == 2
    assert {accuracy for _, accuracy in weighed} == {3}
    assert fusion.world.progress[0].hidden
    assert fusion.world.progress[0].title == "Export"


def test_a_cancelled_mass_calculation_does_not_open_the_dialog(fusion: Any) -> None:
    arm()
    for command in ("cardsflowExport", "cardsflowCheck"):
        before = fusion.fingerprint()
        fusion.world.cancel_progress_after = 0
        opened = fusion.run_command(command)
        assert not opened.is_open
        assert fusion.world.progress[-1].hidden
        fusion.world.cancel_progress_after = None
        assert fusion.fingerprint() == before
        reopened = fusion.run_command(command)
        assert reopened.is_open
        reopened.cancel()


def inserted(build: Builder, name: str, muscles: str, first: int = 0) -> None:
    """Mark the parts, from index `first`, as parts of another document that lists muscles."""
    source = DesignData(name)
    source.attributes["CARDSFlow", "muscles"] = muscles
    for component in build.design.components[first + 1 :]:
        component.referenced, component.source = True, source


def via_points(folder: Path) -> dict[str, list[np.ndarray]]:
    """Return the exported via points in the world frame at the pose of the design, in [m]."""
    robot = read_robot(folder)
    poses = initial_poses(robot)
    return {
        m.name: [(poses[v.link] @ [*v.position, 1.0])[:3] for v in m.via_points]
        for m in robot.muscles
    }


def test_muscles_on_components_of_other_documents_are_stored_in_the_design(
    fusion: Any, tmp_path: Path
) -> None:
    """In an assembly design all components are external, and the root has no features."""
    build = arm(intent="assembly")
    inserted(build, "parts", "[]")
    before = fusion.full_fingerprint()
    occurrences = list(fusion.design.rootComponent.occurrences)

    def vertices() -> list[Any]:
        return [o.bRepBodies[0].vertices[k] for k, o in enumerate(occurrences)]

    command = fusion.run_command(DEFINE)
    for vertex in vertices():
        command.pick("pick", vertex)
    command.ok()
    assert command.failed == ""
    assert all(o.component.constructionPoints.count == 0 for o in occurrences)
    after = fusion.full_fingerprint()
    command = fusion.run_command(DEFINE)
    assert len(command.table("points")) == 3
    command.ok()
    assert fusion.full_fingerprint() == after  # no data is written again
    press_export(fusion, tmp_path / "robot")
    (found,) = via_points(tmp_path / "robot").values()
    for point, vertex in zip(found, vertices(), strict=True):
        place = vertex.geometry
        assert point == pytest.approx([0.01 * v for v in (place.x, place.y, place.z)], abs=1e-9)
    with fusion.building():  # the points move with their parts
        build.root.occurrences[1].T = translation((1.0, 2.0, 3.0)) @ build.root.occurrences[1].T
    command = fusion.run_command(DEFINE)
    seen = command.table("points")[2][2]
    command.cancel()
    place = vertices()[1].geometry
    assert seen == ", ".join(f"{10.0 * v:.1f}" for v in (place.x, place.y, place.z))
    fusion.undo()  # undoes the change of the export settings
    fusion.undo()
    with fusion.building():
        build.root.occurrences[1].T = translation((-1.0, -2.0, -3.0)) @ build.root.occurrences[1].T
    assert fusion.full_fingerprint() == before


def test_muscles_of_an_inserted_design_keep_their_forces(fusion: Any, tmp_path: Path) -> None:
    build = Builder("whole")
    paths = designs.chain(build, ("base", "upper"))
    designs.muscle(build, 0, [("base", paths[0]), ("upper", paths[1])])
    build.done()
    inserted(build, "arm", '[{"name": "motor0", "f_min": 3, "f_max": 77, "color": "#123456"}]', 1)
    command = fusion.run_command(CHECK)
    assert not any("force limits" in str(row) for row in command.table("findings"))
    command.cancel()
    press_export(fusion, tmp_path / "robot")
    (muscle,) = read_robot(tmp_path / "robot").muscles
    assert (muscle.name, muscle.f_min, muscle.f_max) == ("motor0", 3.0, 77.0)


def test_the_preview_is_visible_through_faces_and_shows_sides(fusion: Any) -> None:
    build = arm()
    build.cylinder((build.root.occurrences[0],), 1.0, 6.0)
    command = fusion.run_command(DEFINE)
    command.set("link", "world")
    for place in ((-3.0, 0.0, 0.0), (3.0, 0.0, 0.0)):
        build.sketch((), points=[place])
        sketch = fusion.design.rootComponent.sketches[-1]
        command.pick("pick", sketch.sketchPoints[0])
    command.set("link", "Link of the picked part")
    occurrence = fusion.design.rootComponent.occurrences[0]
    faces = [f for body in occurrence.bRepBodies for f in body.faces]
    face = next(f for f in faces if type(f.geometry).__name__ == "Cylinder")
    axis = face.geometry.axis.z
    command.pick("wrap_pick", face)
    command.press("use_add")
    for side, sign in (("Turning +", -1.0), ("Turning -", 1.0)):
        command.set(command.cell("wrap_uses", 1, 2).id, side)
        (group,) = fusion.design.rootComponent.customGraphicsGroups
        (line,) = [item for item in group if hasattr(item, "weight")]
        assert all(0.0 < item.color.opacity < 1.0 for item in group)  # visible through bodies
        across = np.reshape(line.coordinates.coordinates, (-1, 3))[1:-1, 1]
        assert len(across) > 5
        assert np.all(np.sign(across[np.abs(across) > 0.5]) == sign * axis)
        labels = [item for item in group if hasattr(item, "formattedText")]
        assert all(label.viewScale.pixelScale == 1.0 for label in labels)
        assert len(labels) == 2
    command.cancel()
