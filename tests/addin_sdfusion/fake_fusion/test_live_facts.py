"""Tests that the default behaviour of the fake agrees with observations in real Fusion."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest
from fake_fusion import Builder, designs
from fake_fusion.control import Fake
from fake_fusion.maths import point, rotation, translation

Y, Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def cells(matrix: Any) -> np.ndarray:
    return np.array(matrix.asArray()).reshape(4, 4)


def xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def two_legs(**more: Any) -> tuple[Any, Any, Any]:
    """Return the proxies of a leg with a joint that is inserted twice."""
    build = Builder()
    order = random.Random(3)
    first = build.place("leg", designs.random_motion(order))
    foot = build.place("foot", designs.random_motion(order), above=first)
    build.place(first[-1].component, rotation(math.pi / 2, Y) @ translation((1.0, 2.0, 3.0)))
    T = designs.random_motion(order)
    build.joint("ankle", "revolute", foot, first, T=T, inside=first, values=(0.123,), **more)
    root = build.done().rootComponent
    leg = root.occurrences[0].component
    native = (leg.asBuiltJoints if more.get("as_built") else leg.joints)[0]
    one, two = (native.createForAssemblyContext(o) for o in root.occurrences)
    return native, one, two


def test_all_occurrences_fail_with_one_unresolved_reference(fusion: Fake) -> None:
    build = Builder()
    arm = build.place("arm")
    build.unresolved("gone", above=arm)
    root = build.done().rootComponent
    with pytest.raises(RuntimeError, match="InternalValidationError : occ"):
        _ = root.allOccurrences
    (seen,) = root.occurrences
    (gone,) = seen.childOccurrences
    assert gone.fullPathName == "arm:1+gone:1"
    with pytest.raises(RuntimeError, match="InternalValidationError"):
        _ = gone.component


def test_transforms_of_as_built_joints_are_in_the_component_frame(fusion: Fake) -> None:
    native, one, two = two_legs(as_built=True)
    assert cells(one.transform).tolist() == cells(two.transform).tolist()
    assert cells(two.transform).tolist() == cells(native.transform).tolist()
    T = cells(two.assemblyContext.transform2) @ cells(two.transform)
    assert xyz(two.jointMotion.rotationAxisVector) == pytest.approx(T[:3, 2])


@pytest.mark.parametrize("as_built", [False, True])
def test_geometry_is_of_the_first_occurrence_with_axes_of_the_component(
    fusion: Fake, as_built: bool
) -> None:
    _, one, two = two_legs(as_built=as_built)
    placed = [j.geometry if as_built else j.geometryOrOriginTwo for j in (one, two)]
    T = cells(one.assemblyContext.transform2)
    own = one.transform if as_built else one.geometryTwoTransform
    for geometry in placed:
        assert xyz(geometry.origin) == pytest.approx((T @ cells(own))[:3, 3])
        assert xyz(geometry.primaryAxisVector) == pytest.approx(cells(own)[:3, 2])


def test_joint_origins_without_context_are_of_the_first_occurrence(fusion: Fake) -> None:
    _, _, two = two_legs(by_origins=True)
    leg, data = two.assemblyContext, two._data
    lost = two.geometryOrOriginTwo
    assert lost.assemblyContext is None
    found = lost.createForAssemblyContext(leg)
    T = cells(leg.transform2)
    assert xyz(found.geometry.origin) == pytest.approx((T @ data.T_two)[:3, 3])
    assert xyz(found.primaryAxisVector) == pytest.approx(data.T_two[:3, 2])
    assert xyz(lost.geometry.origin) != pytest.approx((T @ data.T_two)[:3, 3])


def test_health_is_available_in_the_timeline(fusion: Fake) -> None:
    build = Builder()
    one, two = build.place("one"), build.place("two")
    build.joint("j", "revolute", one, two, as_built=True, health=2, problem="lost")
    group = build.rigid_group("g", [one, two])
    group.health, group.problem = 1, "old"
    root = build.done().rootComponent
    for entity, state, text in (
        (root.asBuiltJoints[0], 2, "lost"),
        (root.rigidGroups[0], 1, "old"),
    ):
        with pytest.raises(AttributeError, match="healthState"):
            _ = entity.healthState
        health = entity.timelineObject
        assert (health.healthState, health.errorOrWarningMessage) == (state, text)


def test_stale_groups_have_no_name(fusion: Fake) -> None:
    build = Builder()
    build.rigid_group("g", [build.place("one")], stale=True)
    (group,) = build.done().rootComponent.rigidGroups
    assert list(group.occurrences) == []
    with pytest.raises(RuntimeError, match="InternalValidationError"):
        _ = group.name


def test_angles_after_dragging_are_rounded(fusion: Fake) -> None:
    _, exact, _ = two_legs()
    _, dragged, _ = two_legs(dragged=True)
    assert exact.jointMotion.rotationValue == 0.123
    assert dragged.jointMotion.rotationValue == math.radians(7.0)


def test_a_slider_moves_one_along_its_direction(fusion: Fake) -> None:
    build = Builder()
    two = build.place("two", designs.random_motion(random.Random(1)))
    T = designs.random_motion(random.Random(2))
    build.joint("j", "slider", build.place("one"), two, T=T, values=(2.5,))
    (joint,) = build.done().rootComponent.joints
    one, zero = (cells(t)[:3, 3] for t in (joint.geometryOneTransform, joint.geometryTwoTransform))
    along = np.array(xyz(joint.jointMotion.slideDirectionVector))
    assert one - zero == pytest.approx(2.5 * along)
    assert joint.jointMotion.slideValue == 2.5


def test_points_by_coordinates_need_the_edit_of_a_base_feature(fusion: Fake) -> None:
    design = designs.no_groups()
    root = design.rootComponent
    with fusion.transaction():
        feature = root.features.baseFeatures.add()
        assert feature.timelineObject is not None
        assert design.designType == 1
        feature.startEdit()
        assert design.designType == 0
        with pytest.raises(RuntimeError, match="hidden"):
            _ = feature.timelineObject
        request = root.constructionPoints.createInput()
        request.setByPoint(point((1.0, 2.0, 3.0)))
        request.targetBaseOrFormFeature = feature
        made = root.constructionPoints.add(request)
        with pytest.raises(RuntimeError, match="named"):
            made.name = "too early"
        feature.finishEdit()
        feature.constructionPoints.item(0).name = "now"
    assert design.designType == 1


def test_an_edit_reverts_positions_that_are_not_captured(fusion: Fake) -> None:
    build = Builder()
    arm = build.place("arm")
    build.box(arm, (1.0, 1.0, 1.0))
    build.move(arm, translation((0.0, 0.0, 5.0)))
    design = build.done()
    assert design.snapshots.hasPendingSnapshot
    (occurrence,) = design.rootComponent.occurrences
    assert cells(occurrence.transform2)[2, 3] == 5.0
    with fusion.transaction():
        points = occurrence.component.constructionPoints
        request = points.createInput()
        request.setByPoint(occurrence.component.bRepBodies[0].vertices[0])
        points.add(request)
    assert cells(occurrence.transform2)[2, 3] == 0.0
    assert not design.snapshots.hasPendingSnapshot


def test_collections_are_never_none(fusion: Fake) -> None:
    design = designs.two_link_arm()
    for attribute in design.findAttributes("CARDSFlow", ""):
        assert attribute.otherParents is not None
        assert attribute.otherParents.count == 0
    panels = fusion.app.userInterface.allToolbarPanels
    assert type(panels).__name__ == "ToolbarPanelList"


def test_the_first_component_is_grounded_automatically(fusion: Fake) -> None:
    build = Builder()
    first = build.place("first")
    build.place("second")
    build.place("within", above=first)
    root = build.done().rootComponent
    one, two = root.occurrences
    assert (one.isGrounded, one.isGroundToParent) == (False, True)
    assert (two.isGrounded, two.isGroundToParent) == (False, False)
    (within,) = one.childOccurrences
    assert not within.isGroundToParent
    with fusion.transaction():
        two.isGrounded = True
    assert not two.isGroundToParent


def test_everything_in_an_assembly_design_is_external(fusion: Fake) -> None:
    build = Builder(intent="assembly")
    build.place("inner", above=build.place("outer"))
    root = build.done().rootComponent
    (outer,) = root.occurrences
    (inner,) = outer.childOccurrences
    for occurrence in (outer, inner):
        assert occurrence.isReferencedComponent
        assert occurrence.component.parentDesign != root.parentDesign
