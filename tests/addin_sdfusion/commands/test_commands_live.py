"""Commands in designs of the kinds that running Fusion was seen to have."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_fusion import Builder, designs
from fake_fusion.base import CLASSES
from fake_fusion.maths import translation
from support.designs.exported import press_export

DEFINE, CHECK, EXPORT = "cardsflowDefineMuscles", "cardsflowCheck", "cardsflowExport"

pytestmark = pytest.mark.usefixtures("addin")


def arm(**more: Any) -> Builder:
    """Two links, and a joint between them."""
    build = Builder("arm", **more)
    designs.chain(build, ("base", "upper"))
    build.done()
    return build


def imported(fusion: Any, file: Path, lines: list[str]) -> Any:
    """The open dialog of Define muscles with a table read from a file."""
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


def test_four_hundred_points_take_one_edit_of_each_component(fusion: Any, tmp_path: Path) -> None:
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


def test_what_was_moved_is_captured_first(fusion: Any) -> None:
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


def test_stale_groups_and_motion_links_block_nothing(fusion: Any, tmp_path: Path) -> None:
    build = arm()
    for _ in range(3):
        build.rigid_group("old", [], stale=True)
    build.motion_link()
    build.tangent()
    command = fusion.run_command(CHECK)
    texts = [str(row) for row in command.table("findings")]
    assert sum("components are gone" in text for text in texts) == 1
    assert any("motion links" in text for text in texts)
    assert any("tangent" in text for text in texts)
    assert "no errors" in command["summary"].text
    command.cancel()
    press_export(fusion, tmp_path / "robot")
    assert (tmp_path / "robot").is_dir()


def test_an_as_built_joint_that_is_broken_is_an_error(fusion: Any) -> None:
    build = arm()
    one, two = ((o,) for o in build.root.occurrences)
    build.joint("weld", "rigid", one, two, as_built=True, health=2, problem="its parts are lost")
    command = fusion.run_command(CHECK)
    (row,) = [r for r in command.table("findings") if "its parts are lost" in str(r)]
    assert row[0] == "error"


def test_a_row_is_not_deleted_while_one_of_its_cells_tells_of_a_change(fusion: Any) -> None:
    """A wrap that is led through its surface has no turns: another cell of the row changes."""
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


def test_an_export_weighs_everything_once_and_says_so(
    fusion: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arm()
    weighed: list[tuple[str, int]] = []
    for name in ("BRepBody", "Occurrence"):
        original = CLASSES["adsk.fusion"][name].getPhysicalProperties

        def counted(owner: Any, accuracy: int, original: Any = original) -> Any:
            weighed.append((repr(owner), accuracy))
            return original(owner, accuracy)

        monkeypatch.setattr(CLASSES["adsk.fusion"][name], "getPhysicalProperties", counted)
    press_export(fusion, tmp_path / "robot")
    assert (tmp_path / "robot").is_dir()
    assert len(weighed) == len(set(weighed)) == 4
    assert {accuracy for _, accuracy in weighed} == {2}
    assert fusion.world.progress[0].hidden
    assert fusion.world.progress[0].title == "Export"
