"""Tests of events that Fusion may send: of changed inputs, and while the add-in is busy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from fake_fusion import Builder, designs
from fake_fusion.driver import Rejected
from fake_fusion.maths import translation
from support.designs.user import DEFINE, User

EXPORT = "cardsflowExport"


def edit_muscles(user: User) -> Any:
    """Edit most kinds of inputs, and return the dialog."""
    command = user.fusion.run_command(DEFINE)
    command.set("muscle_name", "biceps")
    for entity in (user.vertex(0), user.circle(), user.sketch_point(), user.vertex(3)):
        command.pick("pick", entity)
    command.row("points", 2)
    command.press("up")
    command.set(command.cell("points", 1, 2).id, "1.23456, 2, 3")
    command.set("f_max", 70.0)
    command.set("model", "elastic_cable")
    command.set("muscle", "+ New muscle")
    command.pick("pick", user.own_point())
    command.pick("pick", user.vertex(5))
    command.set("muscle", "biceps")
    command.pick("wrap_pick", user.face("Cylinder"))
    command.press("use_add")
    command.set(command.cell("wrap_uses", 1, 2).id, "Turning +")
    command.set("other_role", "Marker")
    command.pick("other_pick", user.vertex(6))
    command.set(command.cell("all", 2, 1).id, "12")
    command.press("undo")
    command.press("redo")
    return command


def stored(fusion: Any) -> list[tuple[str, str]]:
    """Return the names and positions of all points, and the texts of the design."""
    from addin_sdfusion.muscles.attributes import without_tokens

    design = fusion.design
    points = {name: place.tolist() for name, place in User(fusion).points().items()}
    texts = [(a.name, without_tokens(a.value)) for a in design.attributes]
    faces = [without_tokens(a.value) for a in design.findAttributes("CARDSFlow", "wrap")]
    return [("points", repr(points)), *texts, ("faces", repr(faces))]


@pytest.mark.parametrize("recomputed", ["invalid", "valid"])
def test_events_of_own_changes_do_not_edit_muscles(
    fusion: Any, user: User, recomputed: Any
) -> None:
    """The stored muscles are the same whether Fusion sends such events never, at once or later."""
    fusion.options.recomputed = recomputed
    results = []
    for mode in ("never", "nested", "queued"):
        fusion.options.change_events = mode
        command = edit_muscles(user)
        status = command["status"].text
        command.ok()
        assert command.failed == ""
        results.append((status, stored(fusion)))
        fusion.undo()
        assert fusion.run_command(DEFINE).cancel() is None
    assert len(results[0][1]) > 2
    assert results[0] == results[1] == results[2]
    assert fusion.messages == fusion.log == []


def test_picked_faces_are_found_after_another_preview(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(0), user.sketch_point())
    command.pick("wrap_pick", user.face("Sphere"))
    command.press("use_add")
    command.pick("pick", user.vertex(1))
    command.ok()
    assert command.failed == ""
    (attribute,) = fusion.design.findAttributes("CARDSFlow", "wrap")
    assert type(attribute.parent.geometry).__name__ == "Sphere"
    again = fusion.run_command(DEFINE)
    again.set("wrap_name", "ball")
    again.ok()
    assert again.failed == ""
    assert again.data.gone


def test_a_command_started_while_it_reads_the_design_opens_once(fusion: Any, addin: Any) -> None:
    """A second click on the button is handled while the masses are calculated."""
    designs.two_link_arm()
    fusion.world.waiting.append(lambda: fusion.run_command(EXPORT))
    first = fusion.run_command(EXPORT)
    second = fusion.world.running
    assert not first.is_open
    assert second.is_open
    second.set("name", "robot")
    assert second["status"].text
    assert fusion.messages == []
    second.cancel()


@pytest.mark.parametrize("event", ["switch", "restart", "stop"])
def test_an_export_is_completed_despite_other_events(
    fusion: Any, addin: Any, tmp_path: Path, event: str
) -> None:
    """While meshes are written, another document is opened, or the command or add-in stopped."""
    events = {
        "switch": designs.single_cube,
        "restart": lambda: fusion.run_command(EXPORT),
        "stop": lambda: addin.stop({}),
    }
    found = []
    for name in ("calm", event):
        designs.two_link_arm(seed=3)
        command = fusion.run_command(EXPORT)
        command.set("folder", str(tmp_path / name / "robot"))
        if name != "calm":
            fusion.world.waiting.append(events[event])
        command.ok()
        assert not command.is_open
        assert not fusion.world.waiting
        assert "files were written" in fusion.messages[-1]
        files = sorted(f for f in (tmp_path / name).rglob("*") if f.is_file())
        found.append({f.relative_to(tmp_path / name).as_posix(): f.read_bytes() for f in files})
    calm, other = found
    assert calm.keys() == other.keys()
    for name, data in calm.items():
        assert data == other[name], name


def test_entities_inside_bodies_need_a_long_press(fusion: Any, addin: Any) -> None:
    build = Builder()
    case, motor = build.place("case"), build.place("motor")
    build.box(case, (4.0, 4.0, 4.0))
    build.box(motor, (1.0, 1.0, 1.0))
    beside = build.place("beside", translation((5.0, 0.0, 0.0)))
    build.box(beside, (1.0, 1.0, 1.0))
    root = build.done().rootComponent
    inside, free = (root.occurrences[k].bRepBodies[0].vertices[0] for k in (1, 2))
    command = fusion.run_command(DEFINE)
    with pytest.raises(Rejected, match="inside body"):
        command.pick("pick", inside)
    command.pick("pick", inside, through=True)
    command.pick("pick", free)
    with fusion.building():
        root.occurrences[0].component.opacity = 0.5
    command.pick("pick", inside)
    with fusion.building():
        beside[-1].light_bulb = False
    with pytest.raises(Rejected, match="hidden"):
        command.pick("pick", free)
    command.cancel()
