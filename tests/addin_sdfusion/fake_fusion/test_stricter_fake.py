"""Tests of the strict rules and of the designer's actions of the fake."""

from __future__ import annotations

from typing import Any

import pytest
from fake_fusion import Builder, designs
from fake_fusion.maths import translation


def test_names_of_occurrences_follow_their_component(fusion: Any) -> None:
    design = designs.component_twice()
    fusion.designer.rename("finger:1", "thumb")
    names = [o.fullPathName for o in design.rootComponent.occurrences]
    assert names == ["palm:1", "thumb:1", "thumb:2"]
    fusion.undo()
    assert design.rootComponent.occurrences[1].name == "finger:1"


def test_a_token_finds_the_same_occurrence(fusion: Any) -> None:
    design = designs.component_twice()
    occurrence = design.rootComponent.occurrences[2]
    token = occurrence.entityToken
    assert token != occurrence.entityToken
    fusion.designer.rename("finger:1", "thumb")
    assert design.findEntityByToken(token) == [occurrence]
    assert design.findEntityByToken("unknown") == []


def test_a_pasted_component_has_the_points_and_another_id(fusion: Any) -> None:
    design = designs.component_twice()
    path = fusion.designer.paste_new("finger:1", translation((0.0, 9.0, 0.0)))
    made = design.rootComponent.occurrences.itemByName(path).component
    old = design.rootComponent.occurrences.itemByName("finger:1").component
    assert made.id != old.id
    assert made.constructionPoints.count == old.constructionPoints.count == 1


def test_a_suppressed_occurrence_is_not_listed(fusion: Any) -> None:
    design = designs.component_twice()
    fusion.designer.suppress("finger:2")
    assert [o.name for o in design.rootComponent.allOccurrences] == ["palm:1", "finger:1"]
    fusion.undo()
    assert design.rootComponent.occurrences.count == 3


def test_the_root_component_has_no_opacity(fusion: Any) -> None:
    design = designs.component_twice()
    with fusion.transaction():
        with pytest.raises(RuntimeError, match="opacity"):
            design.rootComponent.opacity = 0.5
        design.rootComponent.occurrences[0].component.opacity = 0.5


def test_objects_of_an_edit_are_invalid_after_it(fusion: Any) -> None:
    import adsk.core

    build = Builder("points")
    build.place("part")
    root = build.done().rootComponent
    with fusion.transaction():
        feature = root.features.baseFeatures.add()
        feature.startEdit()
        new = root.constructionPoints.createInput()
        new.setByPoint(adsk.core.Point3D.create(1.0, 2.0, 3.0))
        new.targetBaseOrFormFeature = feature
        made = root.constructionPoints.add(new)
        assert made.isValid
        feature.finishEdit()
    assert not made.isValid
    assert feature.constructionPoints.item(0).isValid


def test_calls_are_counted(fusion: Any) -> None:
    design = designs.component_twice()
    _ = design.rootComponent, design.rootComponent
    assert fusion.world.calls["Design.rootComponent"] == 2


@pytest.mark.parametrize("after", ["invalid", "valid"])
def test_a_recomputation_makes_vertices_invalid(fusion: Any, after: Any) -> None:
    fusion.options.recomputed = after
    design = designs.component_twice()
    occurrence = design.rootComponent.occurrences[1]
    vertex = occurrence.bRepBodies[0].vertices[0]
    token, place = vertex.entityToken, vertex.geometry.asArray()
    fusion.designer.suppress("finger:2")
    assert vertex.isValid
    fusion.undo()
    assert vertex.isValid == (after == "valid")
    (found,) = design.findEntityByToken(token)
    assert found.geometry.asArray() == place
    assert occurrence.isValid


def test_an_undone_creation_makes_its_objects_invalid(fusion: Any) -> None:
    root = designs.component_twice().rootComponent
    with fusion.transaction():
        group = root.customGraphicsGroups.add()
    fusion.undo()
    assert not group.isValid
    fusion.designer.delete("finger:2")
    fusion.undo()
    assert root.occurrences[2].isValid


def test_a_configuration_suppresses_and_unsuppresses(fusion: Any) -> None:
    design = designs.component_twice()
    for hidden, shown in ((["finger:2"], ["palm:1", "finger:1"]), ([], 3 * [None])):
        fusion.designer.configure(*hidden)
        names = [o.name for o in design.rootComponent.occurrences]
        assert names == shown or len(names) == len(shown) == 3
    fusion.undo()
    assert design.rootComponent.occurrences.count == 2


def test_another_configuration_is_another_component(fusion: Any) -> None:
    build = Builder()
    held = build.component("arm", referenced=True)
    build.box(build.place(held), (1.0, 1.0, 1.0))
    root = build.done().rootComponent
    before = root.occurrences[0].component.id
    assert fusion.designer.switch_configuration("arm:1", "long") == "arm (long):1"
    assert root.occurrences[0].name == "arm (long):1"
    assert root.occurrences[0].component.id != before
    fusion.undo()
    assert root.occurrences[0].component.id == before
