"""Tests of reading a design: structure, names and order; the design is not changed."""

from __future__ import annotations

import math
import os
import random
from collections import Counter
from typing import Any

import fake_fusion
import numpy as np
import pytest
from fake_fusion import Builder, designs
from fake_fusion.maths import rotation, translation
from fake_fusion.model.data import paths_below
from hypothesis import given
from hypothesis import strategies as st
from support.designs.drawn import at, drawn_joints, places, random_design, tensor

from addin_sdfusion.progress import Cancelled
from addin_sdfusion.robot.errors import InputError
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import DesignSnapshot, PointUse
from addin_sdfusion.snapshot_file import read_snapshot, write_snapshot

with fake_fusion.modules():
    from addin_sdfusion.fusion.design import read_design

SEEDS = st.integers(0, 2**32)
DESIGNS = int(os.environ.get("CARDSFLOW_DESIGNS", "30"))


def codes(snapshot: DesignSnapshot) -> Counter[str]:
    return Counter(finding.code for finding in snapshot.findings)


# Structure -----------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", designs.FEATURES)
def test_every_feature_is_read_and_unchanged(fusion: Any, name: str, tmp_path: Any) -> None:
    design = designs.FEATURES[name]()
    before = fusion.full_fingerprint()
    snapshot = read_design(design)
    assert fusion.full_fingerprint() == before
    assert not fusion.world.undo_steps
    assert not fusion.messages
    assert not any(finding.is_error for finding in snapshot.findings)
    assert read_design(design) == snapshot
    assert read_snapshot(write_snapshot(snapshot, tmp_path / "s.json")) == snapshot


def test_occurrences_have_their_poses(fusion: Any) -> None:
    snapshot = read_design(designs.nested_rotated(), meshes=False)
    parents = {o.path: o.parent for o in snapshot.occurrences}
    assert parents == {
        "arm assembly:1": "",
        "arm assembly:1+base:1": "arm assembly:1",
        "arm assembly:1+forearm assembly:1": "arm assembly:1",
        "arm assembly:1+forearm assembly:1+lower:1": "arm assembly:1+forearm assembly:1",
        "arm assembly:1+forearm assembly:1+upper:1": "arm assembly:1+forearm assembly:1",
    }
    assert [o.component for o in snapshot.occurrences][1] == "base"


def test_plus_in_a_name_is_not_a_path_separator(fusion: Any) -> None:
    build = Builder()
    whole = build.place("a+b")
    build.place("c", above=whole)
    parents = {o.path: o.parent for o in read_design(build.done()).occurrences}
    assert parents == {"a+b:1": "", "a+b:1+c:1": "a+b:1"}


def test_two_occurrences_with_one_path_are_an_error(fusion: Any) -> None:
    build = Builder()
    build.place("b", above=build.place("a"))
    build.place("a:1+b")
    snapshot = read_design(build.done())
    assert codes(snapshot) == {"same-path": 1}
    assert len({o.path for o in snapshot.occurrences}) == len(snapshot.occurrences) == 2


def test_flags_of_occurrences_are_read(fusion: Any) -> None:
    build = Builder()
    build.place("pinned", grounded=True)
    build.place("to parent", ground_to_parent=True)
    build.place("hidden", visible=False)
    build.place(build.component("elsewhere", referenced=True))
    design = build.done()
    found = {o.component: o for o in read_design(design).occurrences}
    assert found["pinned"].grounded
    assert found["to parent"].ground_to_parent
    assert not found["to parent"].grounded
    assert not found["hidden"].is_fixed
    assert not found["hidden"].visible
    assert found["elsewhere"].referenced
    assert not found["pinned"].referenced
    fusion.without("Occurrence.isGroundToParent")
    older = {o.component: o for o in read_design(design).occurrences}
    assert older["pinned"].grounded
    assert not older["to parent"].is_fixed


@pytest.mark.parametrize("intent", ["part", "assembly", "hybrid"])
def test_intent_is_read_if_available(fusion: Any, intent: str) -> None:
    design = Builder(intent=intent).done()
    assert read_design(design).intent == intent
    fusion.without("Design.designIntent")
    assert read_design(design).intent == "unknown"


def test_name_is_without_the_version(fusion: Any) -> None:
    assert read_design(Builder("arm v12").done()).name == "arm"
    assert read_design(Builder("arm v").done()).name == "arm v"
    assert read_design(Builder("v2").done()).name == "v2"


def test_attributes_and_settings_are_read(fusion: Any) -> None:
    build = Builder()
    build.design.attributes["CARDSFlow", "settings"] = '{"name": "robo", "quality": "high"}'
    build.design.attributes["CARDSFlow", "muscles"] = "[]"
    build.design.attributes["Somebody", "muscles"] = "theirs"
    snapshot = read_design(build.done())
    assert snapshot.settings.name == "robo"
    assert snapshot.settings.quality == "high"
    assert snapshot.muscles == ()
    assert snapshot.source.program == "Fusion"


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"quality": "superb"}', '{"colour": 1}', "[" * 9999]
)
def test_bad_settings_become_the_default(fusion: Any, text: str) -> None:
    build = Builder()
    build.design.attributes["CARDSFlow", "settings"] = text
    snapshot = read_design(build.done())
    assert snapshot.settings == ExportSettings()
    assert codes(snapshot) == {"bad-settings": 1}


def test_group_members_are_paths_from_the_root(fusion: Any) -> None:
    build = Builder()
    arm = build.place("arm", translation((1.0, 2.0, 3.0)))
    hand = build.place("hand", above=arm)
    finger = build.place("finger", above=hand)
    build.rigid_group("EXPORT_hand", [hand, finger], inside=arm)
    build.rigid_group("old", [arm], suppressed=True)
    groups = {g.name: g for g in read_design(build.done()).groups}
    assert groups["EXPORT_hand"].occurrences == ("arm:1+hand:1", "arm:1+hand:1+finger:1")
    assert groups["old"].suppressed
    assert not groups["EXPORT_hand"].suppressed


def test_group_of_a_component_with_two_occurrences(fusion: Any) -> None:
    build = Builder()
    left = build.place("leg")
    foot = build.place("foot", above=left)
    build.place(left[-1].component, translation((9.0, 0.0, 0.0)))
    build.rigid_group("EXPORT_foot", [foot], inside=left)
    snapshot = read_design(build.done())
    assert {g.name: g.occurrences for g in snapshot.groups} == {
        "EXPORT_foot": ("leg:1+foot:1",),
        "EXPORT_foot_2": ("leg:2+foot:1",),
    }
    assert codes(snapshot) == {"same-name": 1}


# Points ------------------------------------------------------------------------------------------


def test_points_are_read_by_name_or_attribute_in_every_occurrence(fusion: Any) -> None:
    build = Builder()
    arm = build.place("arm", rotation(0.5, (1.0, 0.0, 0.0)))
    left = build.place("hand", translation((1.0, 0.0, 0.0)), above=arm)
    T = translation((-1.0, 0.0, 0.0)) @ rotation(1.0, (0.0, 1.0, 0.0))
    right = build.place(left[-1].component, T, above=arm)
    build.point(left, (1.0, 2.0, 3.0), "VP_motor0_EXPORT_hand_0")
    build.point(left, (0.0, 0.0, 1.0), "mine")
    build.point(left, (0.0, 0.0, 2.0), "named", {"point": '{"role": "task"}'})
    build.point((), (4.0, 5.0, 6.0), "COM_arm", problem="its vertex is gone")
    for name in ("EE_x", "VM_y"):
        build.point(arm, (0.0, 0.0, 0.0), name)
    found = read_design(build.done()).points
    assert Counter(p.name for p in found) == {
        "VP_motor0_EXPORT_hand_0": 2,
        "named": 2,
        "COM_arm": 1,
        "EE_x": 1,
        "VM_y": 1,
    }
    via = {p.occurrence: p for p in found if p.name.startswith("VP_")}
    assert set(via) == {"arm:1+hand:1", "arm:1+hand:2"}
    for path, text in ((left, "arm:1+hand:1"), (right, "arm:1+hand:2")):
        T = path[0].T @ path[1].T
        assert via[text].position == pytest.approx(at(T, (1.0, 2.0, 3.0)), abs=1e-15)
    assert len({p.entity for p in via.values()}) == 1
    assert len({p.entity for p in found}) == 5
    assert [p.problem for p in found if p.problem] == ["its vertex is gone"]
    assert {p.use for p in found if p.name == "named"} == {PointUse("task")}


def test_points_with_equal_names_are_different_entities(fusion: Any) -> None:
    build = Builder()
    build.point((), (2.0, 0.0, 0.0), "EE_x", exact_name=True)
    build.point((), (1.0, 0.0, 0.0), "EE_x", exact_name=True)
    found = read_design(build.done()).points
    assert len({p.entity for p in found}) == 2


# Order and motion --------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("block", range(DESIGNS // 10))
def test_poses_of_random_designs_are_products_of_relative_poses(block: int) -> None:
    """A valid design has only findings on duplicate names."""
    for seed in range(10 * block, 10 * block + 10):
        with fake_fusion.install() as fake:
            order = random.Random(seed)
            design = random_design(order)
            fake.options.mesh_frame = order.choice(("context", "component"))
            fake.options.nested_native_geometry = order.choice(("null", "local"))
            fake.options.ball_vectors = order.choice(("fixed", "carried"))
            fake.options.joint_transforms = order.choice(("context", "component"))
            before = fake.full_fingerprint()
            snapshot = read_design(design)
            assert fake.full_fingerprint() == before
            _compare_parts(design, snapshot)
            _compare_joints(design, snapshot)
            lost = [p for p in paths_below(design._data.root) if p[-1].unresolved]
            stale = any(g.stale for c in design._data.components for g in c.groups)
            assert set(codes(snapshot)) <= {
                "same-name",
                *(["not-read"] if lost else []),
                *(["stale-group"] if stale else []),
            }
            assert not any(f.is_error for f in snapshot.findings)


def _compare_parts(design: Any, snapshot: DesignSnapshot) -> None:
    bodies = {(b.occurrence, b.name): b for b in snapshot.bodies}
    points = {(p.occurrence, p.name): p for p in snapshot.points}
    for text, _, component, T in places(design):
        for data in component.bodies:
            mass = data.mass()
            found = bodies.pop((text, data.name))
            assert found.mass is not None
            assert found.mesh is not None
            assert found.mass.mass == pytest.approx(mass.mass, rel=1e-12)
            assert found.mass.com == pytest.approx(at(T, mass.com), abs=1e-12)
            R = T[:3, :3]
            assert tensor(found.mass) == pytest.approx(1e-4 * R @ mass.inertia @ R.T, abs=1e-11)
            nodes = np.array(found.mesh.nodes).reshape(-1, 3)
            drawn, triangles = data.shape.mesh(24)
            assert nodes == pytest.approx(np.array([at(T, p) for p in drawn]), abs=1e-12)
            assert found.mesh.triangles.tolist() == triangles.ravel().tolist()
        for data in component.points:
            place = points.pop((text, data.name))
            assert place.position == pytest.approx(at(T, data.position), abs=1e-12)
    assert not bodies
    assert not points


def _compare_joints(design: Any, snapshot: DesignSnapshot) -> None:
    expected = drawn_joints(design)
    assert len(snapshot.joints) == len(expected)
    for (_, name), (path, data, T_one, T_two, axes) in expected.items():
        paths = ["+".join(o.name for o in (*path, *side)) for side in (data.one, data.two)]
        (joint,) = (
            j for j in snapshot.joints if (j.one, j.two) == tuple(paths) and j.name.startswith(name)
        )
        assert joint.problem == ""
        assert joint.as_built == (data.kind == "as-built")
        if joint.kind == "inferred":
            continue
        if joint.as_built:
            rigid = joint.kind == "rigid"
            assert (joint.origin_two is None) == rigid
            if not rigid:
                assert joint.origin_two == pytest.approx(at(T_two, (0, 0, 0)), abs=1e-9)
        else:
            assert joint.origin_one == pytest.approx(at(T_one, (0, 0, 0)), abs=1e-9)
            assert joint.origin_two == pytest.approx(at(T_two, (0, 0, 0)), abs=1e-9)
        for motion, axis, freedom in zip(joint.motions, axes, data.freedoms, strict=True):
            unit = 1.0 if motion.kind == "rotation" else 0.01
            assert motion.axis == pytest.approx(axis, abs=1e-9)
            grid = math.radians(0.05) if data.dragged and freedom.turns else 0.0
            assert motion.value == pytest.approx(unit * freedom.value, abs=1e-15 + grid)
            assert motion.lower == pytest.approx(unit * freedom.limits.minimum)
            assert motion.upper is None


@pytest.mark.slow
@given(SEEDS, SEEDS)
def test_order_of_creation_does_not_matter(seed: int, other: int) -> None:
    with fake_fusion.install():
        text = []
        for shuffled in (seed, other):
            build = Builder("design")
            order = random.Random(7)
            paths = designs.chain(build, ("base", "a", "b", "c10", "c9"))
            left = build.place("finger", above=paths[2])
            build.place(left[-1].component, translation((1.0, 2.0, 3.0)), above=paths[2])
            nail = build.place("nail", designs.random_motion(order), above=left)
            build.joint("hinge", "revolute", nail, left, inside=left)
            build.box(left, (1.0, 2.0, 3.0))
            build.sphere(left, 1.0)
            for k in range(12):
                build.point(paths[k % 3], (k, 0.0, 0.0), f"VP_motor{k}_EXPORT_a_{k}")
            build.rigid_group("EXPORT_finger", [left])
            build.shuffle(random.Random(shuffled))
            text.append(read_design(build.done(), masses=None))  # sums of masses differ by rounding
        assert text[0] == text[1]


@pytest.mark.slow
@given(SEEDS, SEEDS)
def test_frames_nesting_and_order_of_the_arm_do_not_matter(seed: int, moved: int) -> None:
    with fake_fusion.install():
        T = designs.random_motion(random.Random(moved))
        plain = read_design(designs.two_link_arm(), meshes=False)
        other = read_design(designs.two_link_arm(motion=T, seed=seed, nesting=3), meshes=False)
        points = {p.name: p.position for p in other.points}
        for point in plain.points:
            assert points[point.name] == pytest.approx(
                at(T, 100.0 * np.array(point.position)), abs=1e-10
            )
        joints = {j.name: j for j in other.joints}
        for joint in plain.joints:
            assert joint.origin_one is not None
            there = at(T, 100.0 * np.array(joint.origin_one))
            assert joints[joint.name].origin_one == pytest.approx(there, abs=1e-10)
            (motion,), (turned,) = joint.motions, joints[joint.name].motions
            assert turned.axis == pytest.approx(T[:3, :3] @ np.array(motion.axis), abs=1e-10)
            assert (turned.value, turned.lower) == (motion.value, motion.lower)


# Use ---------------------------------------------------------------------------------


@pytest.mark.parametrize("nothing", [None, "a design", 7])
def test_without_a_design_the_user_is_asked_to_open_one(fusion: Any, nothing: Any) -> None:
    with pytest.raises(InputError, match="open a design first"):
        read_design(nothing)


def test_application_is_read_as_its_open_design(fusion: Any) -> None:
    with pytest.raises(InputError, match="open a design first"):
        read_design(fusion.app)
    designs.no_groups()
    assert read_design(fusion.app).name == "no groups"


def test_progress_counts_to_its_end_and_may_cancel(fusion: Any) -> None:
    design = designs.l_shape()
    steps: list[tuple[int, int, str]] = []
    read_design(design, progress=lambda *step: steps.append(step))
    assert all(0 <= done <= whole for done, whole, _ in steps)
    assert [done for done, _, _ in steps] == list(range(len(steps)))
    assert len({whole for _, whole, _ in steps}) == 1
    assert len(steps) == steps[0][1] == 8  # root, three occurrences, four bodies
    assert "lower:1/foot" in [what for _, _, what in steps]

    def cancel(done: int, whole: int, what: str) -> None:
        if done == 3:
            raise Cancelled

    before = fusion.full_fingerprint()
    with pytest.raises(Cancelled):
        read_design(design, progress=cancel)
    assert fusion.full_fingerprint() == before


def test_masses_and_meshes_are_optional(fusion: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> Any:
        raise AssertionError("nobody asked for it")

    from fake_fusion.model import bodies, component

    for cls in (bodies.BRepBody, component.Occurrence):
        monkeypatch.setattr(cls, "getPhysicalProperties", refuse)
    monkeypatch.setattr(bodies.BRepBody, "meshManager", property(refuse))
    snapshot = read_design(designs.no_material(), meshes=False, masses=None)
    assert not snapshot.findings
    assert all(b.mass is None and b.mesh is None for b in snapshot.bodies)


@pytest.mark.slow
def test_large_design_is_read_completely(fusion: Any) -> None:
    design = designs.many_links(200, 400)
    snapshot = read_design(design, meshes=False)
    assert len(snapshot.points) == 400
    assert len(snapshot.joints) == 199


def test_stored_attributes_become_records(fusion: Any) -> None:
    snapshot = read_design(designs.two_link_arm(), meshes=False)
    assert snapshot.muscles
    assert all(p.use is not None for p in snapshot.points)
