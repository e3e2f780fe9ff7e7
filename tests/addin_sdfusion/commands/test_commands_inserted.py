"""Tests of a design with a muscle that is inserted several times, once per leg."""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import pytest
from fake_fusion import Builder, designs
from fake_fusion.model.data import DesignData
from support.designs.drawn import at
from support.designs.exported import initial_poses, press_export, snapshot_of

from addin_sdfusion.building.build_robot import build_robot
from addin_sdfusion.exporting.export import export_robot
from addin_sdfusion.robot.formats.read import read_robot

DEFINE, CHECK = "cardsflowDefineMuscles", "cardsflowCheck"
MUSCLES = '[{"name": "calf", "f_min": 3, "f_max": 77, "color": "#123456"}]'
PLACES = {"shin": (0.0, 1.0, 2.0), "foot": (1.0, 1.0, 2.0)}
HEEL = (0.0, 0.0, -4.0)

pytestmark = pytest.mark.usefixtures("addin")


class Legs:
    """A torso and the design of a leg that is inserted several times.

    Attributes:
        build: The design.
        legs: Where the legs are.
    """

    def __init__(self, count: int) -> None:
        order = random.Random(4)
        self.build = build = Builder("robot")
        torso = build.place("torso", grounded=True)
        build.box(torso, (5.0, 5.0, 5.0))
        leg = build.place("leg", designs.random_motion(order))
        self._parts = {
            name: build.place(name, designs.random_motion(order), above=leg)
            for name in ("shin", "foot")
        }
        for number, (name, path) in enumerate(self._parts.items()):
            build.box(path, (1.0, 2.0, 3.0))
            use = {"role": "via", "link": name, "muscle": "calf"}
            text = json.dumps({**use, "number": number, "occurrence": f"{name}:1"})
            old = f"VP_motor0_EXPORT_{name}_{number}"
            build.point(path, PLACES[name], old, {"point": text})
        task = {"role": "task", "link": "foot", "name": "heel", "occurrence": "foot:1"}
        build.point(self._parts["foot"], HEEL, "EE_foot", {"point": json.dumps(task)})
        build.cylinder(self._parts["shin"], 0.5, 3.0)
        wrap = {"name": "shaft", "link": "shin", "occurrence": "shin:1"}
        uses = [{"muscle": "calf", "after": 0}]
        (face,) = (
            face
            for body in self._parts["shin"][-1].component.bodies
            for face in body.topology()[2]
            if face.geometry.kind == "cylinder"
        )
        face.attributes["CARDSFlow", "wrap"] = json.dumps({**wrap, "muscles": uses})
        build.joint("ankle", "revolute", self._parts["foot"], self._parts["shin"], inside=leg)
        self.legs = [leg]
        for _ in range(count - 1):
            self.legs.append(build.place(leg[-1].component, designs.random_motion(order)))
        for path in self.legs:
            build.joint("hip", "rigid", (*path, self._parts["shin"][-1]), torso)
        self.source = DesignData("leg")
        self.source.attributes["CARDSFlow", "muscles"] = MUSCLES
        for component in build.design.components[2:]:
            component.referenced, component.source = True, self.source
        self.design = build.done()

    @property
    def settings(self) -> dict[str, Any]:
        """Return the settings of the export: each part is a link."""
        names = (f"leg:{k + 1}+{part}:1" for k in range(len(self.legs)) for part in PLACES)
        return {"components": ("torso:1", *names), "links": "components"}

    def place(self, leg: int, part: str, position: tuple[float, ...]) -> Any:
        """Return the position of a point of a part in the world frame, in [m]."""
        return at(self.legs[leg][0].T @ self._parts[part][-1].T, position)


def test_every_leg_has_its_muscle(fusion: Any, tmp_path: Path) -> None:
    drawn = Legs(3)
    snapshot = snapshot_of(drawn.design, **drawn.settings)
    assert [m.name for m in snapshot.muscles] == ["calf", "calf_2", "calf_3"]
    assert {f.subject.name for f in snapshot.findings if f.code == "same-name"} >= {"calf"}
    built = build_robot(snapshot)
    assert [f.message for f in built.findings if f.is_error] == []
    export_robot(snapshot, tmp_path / "robot")
    robot = read_robot(tmp_path / "robot")
    poses = initial_poses(robot)
    assert len(robot.muscles) == 3
    for k, muscle in enumerate(robot.muscles):
        assert (muscle.f_min, muscle.f_max) == (3.0, 77.0)
        for via, (part, position) in zip(muscle.via_points, PLACES.items(), strict=True):
            found = (poses[via.link] @ [*via.position, 1.0])[:3]
            assert found == pytest.approx(drawn.place(k, part, position), abs=1e-9)
        (wrap,) = muscle.wraps
        surface = next(s for s in robot.wrap_surfaces if s.name == wrap.surface)
        found = (poses[surface.link] @ [*surface.pose.position, 1.0])[:3]
        assert found == pytest.approx(drawn.place(k, "shin", (0.0, 0.0, 0.0)), abs=1e-9)
    (tasks,) = robot.task_sets
    assert [t.name for t in tasks.frames] == ["heel", "heel_2", "heel_3"]
    for k, task in enumerate(tasks.frames):
        found = (poses[task.link] @ [*task.position, 1.0])[:3]
        assert found == pytest.approx(drawn.place(k, "foot", HEEL), abs=1e-9)


@pytest.mark.slow
def test_the_dialog_keeps_inserted_muscles_and_adds_new_ones(fusion: Any, tmp_path: Path) -> None:
    drawn = Legs(2)
    with fusion.building():
        drawn.build.design.attributes["CARDSFlow", "settings"] = json.dumps(drawn.settings)
    before = fusion.full_fingerprint()
    command = fusion.run_command(DEFINE)
    assert command.items("muscle")[:-1] == ["calf", "calf_2"]
    body = fusion.design.rootComponent.occurrences[0].bRepBodies[0]
    command.ok()
    assert command.failed == ""
    fusion.undo()
    assert fusion.full_fingerprint() == before
    command = fusion.run_command(DEFINE)
    command.set("muscle", "calf_2")
    command.set("f_max", 50.0)
    command.set("muscle", command.items("muscle")[-1])
    for vertex in body.vertices[:2]:
        command.pick("pick", vertex)
    command.ok()
    assert command.failed == ""
    command = fusion.run_command(DEFINE)
    assert command.items("muscle")[:-1] == ["calf", "calf_2", "motor0"]
    command.cancel()
    press_export(fusion, tmp_path / "robot")
    muscles = read_robot(tmp_path / "robot").muscles
    assert [(m.name, m.f_max) for m in muscles] == [
        ("calf", 77.0),
        ("calf_2", 50.0),
        ("motor0", 80.0),
    ]


def test_inserted_muscles_are_edited_only_in_their_design(fusion: Any) -> None:
    drawn = Legs(2)
    with fusion.building():
        drawn.build.design.attributes["CARDSFlow", "settings"] = json.dumps(drawn.settings)
    before = fusion.full_fingerprint()
    command = fusion.run_command(DEFINE)
    command.set("muscle", "calf_2")
    command.set("muscle_name", "other")
    command.ok()
    assert "another document" in command.failed
    assert fusion.full_fingerprint() == before
