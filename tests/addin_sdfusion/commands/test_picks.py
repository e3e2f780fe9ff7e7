"""Tests of picked points: anywhere on faces and edges, and with few clicks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from fake_fusion.maths import point
from fake_fusion.model.points import position_of
from support.designs.user import User, build_arm

CENTRE = {"Plane": 0.0, "Sphere": 1.5, "Cylinder": 1.0}
"""Distance of each face of the arm from the origin of its geometry, in [cm]."""


def on_face(face: Any) -> np.ndarray:
    """Return a position on a face of the arm that is not its centre, in the root frame, in [cm]."""
    shape = face.geometry
    axis = getattr(shape, "normal", None) or getattr(shape, "axis", None)
    normal = np.array(axis.asArray()) if axis else np.array([0.0, 0.0, 1.0])
    across = np.cross(normal, [1.0, 2.0, 3.0])
    across /= np.linalg.norm(across)
    radius = CENTRE[type(shape).__name__] or 0.4
    return np.array(shape.origin.asArray()) + radius * across


@pytest.mark.parametrize("parametric", [True, False])
def test_positions_on_faces_and_edges_are_exact(fusion: Any, addin: Any, parametric: bool) -> None:
    build_arm(parametric=parametric)
    user = User(fusion)
    edge = user.body("torso").edges.item(0)
    start, end = (np.array(p.asArray()) for p in (edge.geometry.startPoint, edge.geometry.endPoint))
    faces = [user.face("Plane"), user.face("Cylinder"), user.face("Sphere")]
    clicks = [(face, on_face(face)) for face in faces] + [(edge, 0.3 * start + 0.7 * end)]
    command = user.define()
    command.set("centres", False)
    for entity, place in clicks:
        command.pick("pick", entity, point(place))
    assert [row[1] for row in command.table("points")[1:]] == ["arm", "arm", "arm", "torso"]
    command.ok()
    assert command.failed == ""
    made = user.points()
    names = [f"VP_motor0_EXPORT_{'torso' if k == 3 else 'arm'}_{k}" for k in range(4)]
    for name, (_, place) in zip(names, clicks, strict=True):
        assert made[name] == pytest.approx(place, abs=1e-9)
    assert fusion.world.edit_scopes == (2 if parametric else 0)  # one for each component


def test_centres_are_used_unless_switched_off(fusion: Any, user: User) -> None:
    face, click = user.face("Sphere"), point(on_face(user.face("Sphere")))
    command = user.define()
    command.pick("pick", face, click)
    command.set("centres", False)
    command.pick("pick", face, click)
    command.pick("other_pick", face, click)
    command.ok()
    made, face = user.points(), user.face("Sphere")
    assert made["VP_motor0_EXPORT_arm_0"] == pytest.approx(position_of(face))
    assert made["VP_motor0_EXPORT_arm_1"] == pytest.approx(on_face(face))
    assert made["EE_arm"] == pytest.approx(on_face(face))


@pytest.mark.parametrize("kind", ["Plane", "Cylinder", "Sphere"])
def test_clicks_near_a_face_are_moved_onto_it_and_others_are_rejected(
    fusion: Any, user: User, kind: str
) -> None:
    """Fusion may report a position on a facet of the drawn face, or an unknown position."""
    place, shape = on_face(user.face(kind)), user.face(kind).geometry
    centre, is_flat = np.array(shape.origin.asArray()), kind == "Plane"
    outward = np.array(shape.normal.asArray()) if is_flat else place - centre
    outward /= np.linalg.norm(outward)
    command = user.define()
    command.set("centres", False)
    for wrong in (place + 0.6 * outward if is_flat else centre, (500.0, 0.0, 0.0)):
        command.pick("pick", user.face(kind), point(wrong))
        assert "position of the click on" in command["status"].text
    assert len(command.table("points")) == 1
    command.pick("pick", user.face(kind), point(place - 0.01 * outward))
    command.ok()
    assert user.points()["VP_motor0_EXPORT_arm_0"] == pytest.approx(place, abs=1e-9)


def test_a_position_on_a_part_of_another_document_is_stored(fusion: Any, addin: Any) -> None:
    build = build_arm()
    linked = build.place(build.component("bolt", referenced=True))
    build.box(linked, (2.0, 2.0, 2.0))
    build.rigid_group("EXPORT_bolt", [linked])
    user = User(fusion)
    face = user.body("bolt").faces.item(0)
    place = np.array(face.geometry.origin.asArray()) + np.array([0.0, 0.3, -0.2])
    command = user.define(user.vertex(0))
    command.pick("pick", face, point(place))
    shown = command.table("points")
    command.ok()
    command = user.define()
    assert command.table("points") == shown
    assert shown[2][2] == ", ".join(f"{10 * v:.1f}" for v in place)


def test_four_points_take_six_clicks_and_another_muscle_five(fusion: Any, user: User) -> None:
    command = user.define(*user.vertices(4))
    command.press("new_muscle")
    before = command.clicks
    assert before == 1 + 4 + 1
    for k in range(4):
        command.pick("pick", user.vertex(k + 4))
    assert command.clicks - before + 1 == 5  # with the button New muscle
    command.ok()
    assert command.failed == ""
    assert command.clicks == 11
    assert [row[0] for row in user.define().table("all")[1:]] == ["motor0", "motor1"]
    assert sum(name.startswith("VP_motor") for name in user.points()) == 8
