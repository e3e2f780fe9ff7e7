"""Tests of reading damaged designs: unreadable objects become findings, others are read."""

from __future__ import annotations

import random
from typing import Any

import fake_fusion
import pytest
from fake_fusion import Builder, designs
from fake_fusion.base import CLASSES
from fake_fusion.maths import point, translation
from fake_fusion.model.entity import occurrence
from hypothesis import given
from hypothesis import strategies as st

from addin_sdfusion.snapshot import DesignSnapshot
from addin_sdfusion.snapshot_file import snapshot_text

with fake_fusion.modules():
    from addin_sdfusion.fusion.design import read_design

API = {**CLASSES["adsk.core"], **CLASSES["adsk.fusion"]}
FAILURE = "2 : InternalValidationError : Utils::getObjectPath"


def failing(monkeypatch: pytest.MonkeyPatch, where: str, only: str = "") -> None:
    """Make a member of the API fail, optionally only for the entity with a given name."""
    name, member = where.split(".")
    original = getattr(API[name], member)
    is_property = isinstance(original, property)

    def fail(self: Any, *arguments: Any) -> Any:
        if not only or getattr(getattr(self, "_data", None), "name", "") == only:
            raise RuntimeError(FAILURE)
        return original.fget(self) if is_property else original(self, *arguments)

    monkeypatch.setattr(API[name], member, property(fail) if is_property else fail)


def messages(snapshot: DesignSnapshot) -> list[str]:
    return [finding.message for finding in snapshot.findings]


MEMBERS = [
    "Design.rootComponent",
    "Component.id",
    "Component.name",
    "Occurrence.transform2",
    "Occurrence.component",
    "Occurrence.childOccurrences",
    "Occurrence.fullPathName",
    "Occurrence.isVisible",
    "Occurrence.isGrounded",
    "Occurrence.isReferencedComponent",
    "Occurrence.getPhysicalProperties",
    "Component.occurrences",
    "Component.bRepBodies",
    "Component.meshBodies",
    "Component.constructionPoints",
    "Component.joints",
    "Component.asBuiltJoints",
    "Component.rigidGroups",
    "Component.assemblyConstraints",
    "BRepBody.isSolid",
    "BRepBody.name",
    "BRepBody.material",
    "BRepBody.isVisible",
    "BRepBody.meshManager",
    "BRepBody.getPhysicalProperties",
    "BRepBody.createForAssemblyContext",
    "PhysicalProperties.centerOfMass",
    "PhysicalProperties.getPrincipalMomentsOfInertia",
    "TriangleMeshCalculator.calculate",
    "ConstructionPoint.geometry",
    "ConstructionPoint.attributes",
    "ConstructionPoint.healthState",
    "ConstructionPoint.createForAssemblyContext",
    "Joint.name",
    "Joint.occurrenceOne",
    "Joint.jointMotion",
    "Joint.geometryOrOriginOne",
    "Joint.geometryOneTransform",
    "Joint.isSuppressed",
    "Joint.healthState",
    "Joint.errorOrWarningMessage",
    "Joint.isLocked",
    "Joint.offset",
    "Joint.angle",
    "Joint.isFlipped",
    "Joint.createForAssemblyContext",
    "AsBuiltJoint.geometry",
    "AsBuiltJoint.transform",
    "RevoluteJointMotion.rotationAxisVector",
    "RevoluteJointMotion.rotationLimits",
    "JointLimits.isMinimumValueEnabled",
    "JointOrigin.geometry",
    "RigidGroup.occurrences",
    "RigidGroup.isSuppressed",
    "Design.findAttributes",
    "Design.attributes",
    "Design.designIntent",
    "Attribute.parent",
    "BRepFace.geometry",
    "BRepFace.body",
    "BRepFace.edges",
    "BRepBody.parentComponent",
    "BRepBody.nativeObject",
]


def with_everything() -> Any:
    build = Builder()
    paths = designs.chain(build, ("base", "a", "b"))
    part = build.place("part", translation((1.0, 2.0, 3.0)), above=paths[2])
    build.cylinder(part, 1.0, 2.0).topology()[2][0].attributes["CARDSFlow", "wrap"] = (
        '{"name": "w"}'
    )
    build.point(part, (1.0, 0.0, 0.0), "EE_b", {"point": '{"role": "task"}'})
    nut = build.place("nut", above=part)
    build.joint("turns", "revolute", nut, part, inside=part, as_built=True)
    build.joint("too", "revolute", nut, part, inside=part, by_origins=True)
    build.rigid_group("inner", [nut], inside=part)
    build.design.attributes["CARDSFlow", "muscles"] = "[]"
    build.constraint()
    return build.done()


@pytest.mark.cases(45)
@pytest.mark.slow
@pytest.mark.parametrize("where", MEMBERS)
def test_any_failing_member_does_not_stop_the_reader(
    fusion: Any, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    design = with_everything()
    before = fusion.full_fingerprint()
    failing(monkeypatch, where)
    log: list[str] = []
    snapshot = read_design(design, log=log.append)
    assert snapshot_text(snapshot)
    for text in messages(snapshot):
        assert "Traceback" not in text
        assert "\n" not in text
    logged = bool(log) and all("Traceback" in text for text in log)
    quiet = {  # members with other findings, or of newer versions only
        *("Component.assemblyConstraints", "Joint.geometryOrOriginOne", "Joint.isLocked"),
        *("Joint.geometryOneTransform", "Joint.offset", "Joint.angle", "AsBuiltJoint.geometry"),
        *("AsBuiltJoint.transform", "JointOrigin.geometry", "Design.designIntent"),
        *("ConstructionPoint.healthState", "Joint.healthState", "Joint.errorOrWarningMessage"),
    }
    assert logged == (where not in quiet)
    assert fusion.full_fingerprint() == before
    monkeypatch.undo()
    assert read_design(design, log=log.append).joints


@pytest.mark.slow
@given(st.sets(st.sampled_from(MEMBERS), min_size=1, max_size=6))
def test_several_failures_at_once(members: set[str]) -> None:
    with fake_fusion.install(), pytest.MonkeyPatch.context() as monkeypatch:
        design = with_everything()
        for where in sorted(members):
            failing(monkeypatch, where)
        assert snapshot_text(read_design(design, log=lambda _: None))


def test_only_the_object_that_fails_is_missing(
    fusion: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    build = Builder()
    paths = designs.chain(build)
    designs.muscle(build, 0, list(zip(("base", "upper", "lower"), paths, strict=True)))
    design = build.done()
    failing(monkeypatch, "ConstructionPoint.geometry", "VP_motor0_EXPORT_upper_1")
    snapshot = read_design(design)
    assert len(snapshot.points) == 2
    (finding,) = snapshot.findings
    assert finding.subject == ("point", "VP_motor0_EXPORT_upper_1")
    assert FAILURE in finding.message
    assert fusion.log  # Fusion's log contains the traceback
    assert "Traceback" in fusion.log[0]


def test_unreadable_joint_reports_its_problem(fusion: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    failing(monkeypatch, "Joint.jointMotion", "upper_joint")
    found = {joint.name: joint for joint in read_design(designs.no_groups()).joints}
    assert found["lower_joint"].problem == ""
    assert FAILURE in found["upper_joint"].problem
    assert "create the joint again" in found["upper_joint"].problem


def test_unreadable_item_does_not_hide_other_items(
    fusion: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = API["Joints"].item

    def item(joints: Any, index: int) -> Any:
        if index == 0:
            raise RuntimeError(FAILURE)
        return original(joints, index)

    def no_iterator(_: Any) -> Any:
        raise RuntimeError(FAILURE)

    monkeypatch.setattr(API["Joints"], "item", item)
    monkeypatch.setattr(API["Joints"], "__iter__", no_iterator)
    snapshot = read_design(designs.no_groups())
    assert [joint.name for joint in snapshot.joints] == ["lower_joint"]
    assert len(snapshot.findings) == 1


def test_missing_proxies_are_reported(fusion: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    design = with_everything()
    for cls in ("ConstructionPoint", "AsBuiltJoint", "Joint", "RigidGroup", "BRepBody"):
        monkeypatch.setattr(API[cls], "createForAssemblyContext", lambda *_: None)
    snapshot = read_design(design)
    assert {f.code for f in snapshot.findings} == {"not-read", "assembly-constraints"}
    assert len(snapshot.joints) == 2  # joints of the root


def test_points_reported_in_the_component_frame_are_transformed(
    fusion: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    design = designs.nested_rotated()
    expected = read_design(design, meshes=False).points
    native = property(lambda p: point(p._data.position))
    monkeypatch.setattr(API["ConstructionPoint"], "geometry", native)
    for found, right in zip(read_design(design, meshes=False).points, expected, strict=True):
        assert found.position == pytest.approx(right.position, abs=1e-12)


def test_paths_relative_to_the_sub_assembly_are_resolved(
    fusion: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Proxies of joints and groups return native occurrences."""
    design = designs.nested_rotated()
    expected = read_design(design, meshes=False)

    def end(side: str) -> property:
        return property(lambda joint: occurrence(getattr(joint._data, side)))

    monkeypatch.setattr(API["Joint"], "occurrenceOne", end("one"))
    monkeypatch.setattr(API["Joint"], "occurrenceTwo", end("two"))
    members = property(lambda group: [occurrence(m) for m in group._data.members])
    monkeypatch.setattr(API["RigidGroup"], "occurrences", members)
    found = read_design(design, meshes=False)
    assert [(j.one, j.two) for j in found.joints] == [(j.one, j.two) for j in expected.joints]
    assert found.groups == expected.groups


def test_unknown_group_members_are_reported(fusion: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    design = designs.rigid_groups()
    listed = API["RigidGroup"].occurrences.fget

    class Ghost:
        fullPathName = "ghost:1"  # noqa: N815

    members = property(lambda group: [*listed(group), Ghost()])
    monkeypatch.setattr(API["RigidGroup"], "occurrences", members)
    snapshot = read_design(design, meshes=False)
    assert {f.code for f in snapshot.findings} == {"unknown-member"}
    assert all("ghost:1" not in group.occurrences for group in snapshot.groups)


def test_mirrored_occurrence_is_an_error(fusion: Any) -> None:
    build = Builder()
    path = build.place("part")
    path[0].T[0, 0] = -1.0
    assert {f.code for f in read_design(build.done()).findings} == {"not-rigid"}


@pytest.mark.slow
def test_points_are_read_at_every_depth_of_nesting(fusion: Any) -> None:
    build = Builder()
    path: Any = ()
    for k in range(120):
        path = build.place(f"p{k}", translation((0.0, 0.0, 0.1)), above=path)
    build.point(path, (0.0, 0.0, 0.0), "EE_x")
    (point,) = read_design(build.done()).points
    assert point.position == pytest.approx((0.0, 0.0, 0.12))


def test_copies_of_a_document_with_equal_ids_are_distinguished(
    fusion: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Component.id is not unique if an assembly contains copies of external documents."""
    monkeypatch.setattr(API["Component"], "id", property(lambda _: "the same"))
    build = Builder()
    for k, name in enumerate(("first", "second")):
        path = build.place(name, translation((9.0 * k, 0.0, 0.0)))
        build.box(path, (1.0 + k, 1.0, 1.0), name="Body1")
        build.point(path, (0.0, 0.0, 0.0), "EE_x")
    snapshot = read_design(build.done())
    assert len({p.entity for p in snapshot.points}) == 2
    widths = [max(b.mesh.nodes[0::3]) - min(b.mesh.nodes[0::3]) for b in snapshot.bodies if b.mesh]
    assert widths == pytest.approx([0.01, 0.02])


def test_entities_of_components_without_id_are_distinguished(
    fusion: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    build = Builder()
    for name in ("first", "second"):
        build.point(build.place(name), (0.0, 0.0, 0.0), "EE_x")
    failing(monkeypatch, "Component.id")
    assert len({p.entity for p in read_design(build.done()).points}) == 2


def test_order_of_findings_is_independent_of_the_design(fusion: Any) -> None:
    texts = set()
    for seed in range(4):
        build = Builder("design")
        for k in range(6):
            path = build.place(f"part {k}")
            build.box(path, (1.0, 1.0, 1.0), density=0.0, material="")
        build.shuffle(random.Random(seed))
        texts.add(tuple(messages(read_design(build.done()))))
    assert len(texts) == 1
