"""Tests of reading joints: a naive reader fails each test."""

from __future__ import annotations

import math
import random
from typing import Any

import fake_fusion
import numpy as np
import pytest
from fake_fusion import Builder, designs
from fake_fusion.base import CLASSES
from fake_fusion.maths import rotation, translation
from fake_fusion.model.data import transform
from hypothesis import given
from hypothesis import strategies as st
from support.designs.drawn import at, drawn_joints, random_design

from addin_sdfusion.snapshot import DesignSnapshot, JointSnapshot

with fake_fusion.modules():
    from addin_sdfusion.fusion.design import read_design

API = CLASSES["adsk.fusion"]
TRANSFORMS = ("Joint.geometryOneTransform", "Joint.geometryTwoTransform")
SEEDS = st.integers(0, 2**32)
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def read(design: Any) -> DesignSnapshot:
    return read_design(design, meshes=False, masses=None)


def by_name(design: Any) -> dict[str, JointSnapshot]:
    return {joint.name: joint for joint in read(design).joints}


def hinged(build: Builder, **more: Any) -> JointSnapshot:
    """Return a joint between two parts of a nested, rotated assembly."""
    order = random.Random(1)
    whole = build.place("whole", designs.random_motion(order))
    one = build.place("one", designs.random_motion(order), above=whole)
    two = build.place("two", designs.random_motion(order), above=whole)
    kind = more.pop("kind", "revolute")
    build.joint("joint", kind, one, two, T=designs.random_motion(order), inside=whole, **more)
    design = build.done()
    (joint,) = read(design).joints
    return joint


# Position -------------------------------------------------------------------------------------


@pytest.mark.slow
@given(SEEDS)
def test_older_fusion_without_transforms(seed: int) -> None:
    """Only the geometry is available, including joint origins."""
    with fake_fusion.install() as fake:
        design = random_design(random.Random(seed))
        fake.without(*TRANSFORMS, "AsBuiltJoint.transform")
        fake.without("Joint.offsetX", "Joint.offsetY")
        found = read(design).joints
        for (_, name), (path, data, T_one, T_two, _axes) in drawn_joints(design).items():
            one = "+".join(o.name for o in (*path, *data.one))
            (joint,) = (j for j in found if j.one == one and j.name.startswith(name))
            if joint.as_built or joint.kind == "inferred":
                continue
            assert joint.origin_one == pytest.approx(at(T_one, (0, 0, 0)), abs=1e-9)
            assert joint.origin_two == pytest.approx(at(T_two, (0, 0, 0)), abs=1e-9)
            assert joint.problem == ""


def test_geometry_is_null_unless_read_through_a_proxy(fusion: Any) -> None:
    fusion.without(*TRANSFORMS)
    design = designs.nested_rotated()
    native = design._data.root.occurrences[0].component.joints
    assert native  # native joints exist
    for joint in read(design).joints:
        assert joint.origin_one is not None
        assert joint.origin_one == pytest.approx(joint.origin_two, abs=1e-12)


def test_joint_origin_has_its_offset(fusion: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """JointOrigin.geometry excludes the offsets, which older versions store separately."""
    from fake_fusion.base import new

    design = designs.joint_origins()
    fusion.without(*TRANSFORMS)
    expected = by_name(design)
    along_x = property(lambda _: new(API["ModelParameter"], value=2.0))
    monkeypatch.setattr(API["JointOrigin"], "offsetX", along_x, raising=False)
    for name, joint in by_name(design).items():
        before = expected[name].origin_two
        assert before is not None
        assert joint.origin_two == pytest.approx(np.add(before, (0.02, 0.0, 0.0)))


def test_separated_joint_sides_are_a_warning(fusion: Any) -> None:
    build = Builder()
    paths = designs.chain(build)
    paths[2][-1].T = paths[2][-1].T @ translation((0.0, 0.5, 0.0))
    snapshot = read(build.done())
    (finding,) = (f for f in snapshot.findings if f.code == "joint-apart")
    assert finding.subject == ("joint", "lower_joint")
    assert "5 mm apart" in finding.message


def test_offsets_and_slides_are_not_reported_as_gap(fusion: Any) -> None:
    assert not read(designs.joint_with_offset()).findings
    assert not read(designs.every_joint_type()).findings
    joint = by_name(designs.joint_with_offset())["lower_joint"]
    assert joint.origin_one is not None
    assert joint.origin_two is not None
    assert math.dist(joint.origin_one, joint.origin_two) == pytest.approx(0.03)


# Components -----------------------------------------------------------------------------------


def test_joint_to_the_root(fusion: Any) -> None:
    joint = by_name(designs.joint_to_root())["root_joint"]
    assert (joint.one, joint.two) == ("upper:1", "")
    assert joint.motions[0].value == pytest.approx(0.2)


def test_joint_to_its_parent_component(fusion: Any) -> None:
    """A null occurrence is the sub-assembly, not the root."""
    build = Builder()
    arm = build.place("arm", translation((1.0, 0.0, 0.0)))
    hand = build.place("hand", above=arm)
    build.joint("wrist", "revolute", hand, arm, inside=arm)
    joint = by_name(build.done())["wrist"]
    assert (joint.one, joint.two) == ("arm:1+hand:1", "arm:1")


def test_joint_in_a_component_with_two_occurrences(fusion: Any) -> None:
    build = Builder()
    left = build.place("leg", translation((5.0, 0.0, 0.0)))
    foot = build.place("foot", above=left)
    T = translation((-5.0, 0.0, 0.0)) @ rotation(math.pi / 2, Z)
    build.place(left[-1].component, T)
    build.joint("ankle", "revolute", foot, left, (0.0, 0.0, 1.0), X, inside=left)
    snapshot = read(build.done())
    first, second = snapshot.joints
    assert (first.name, second.name) == ("ankle", "ankle_2")
    assert (first.one, second.one) == ("leg:1+foot:1", "leg:2+foot:1")
    assert first.origin_one == pytest.approx((0.05, 0.0, 0.01))
    assert second.origin_one == pytest.approx((-0.05, 0.0, 0.01))
    assert second.motions[0].axis == pytest.approx(Y, abs=1e-15)
    (finding,) = snapshot.findings
    assert finding.code == "same-name"
    assert "leg:2" in finding.message


def test_joints_with_equal_names_in_different_components(fusion: Any) -> None:
    build = Builder()
    arm, leg = build.place("arm"), build.place("leg")
    hand, foot = build.place("hand", above=arm), build.place("foot", above=leg)
    build.joint("Rev1", "revolute", hand, arm, inside=arm)
    build.joint("Rev1", "revolute", foot, leg, inside=leg)
    build.joint("Rev1_2", "revolute", leg, arm)
    build.joint("Rev1_2", "rigid", leg, arm, as_built=True)
    found = {joint.name: joint.one for joint in read(build.done()).joints}
    assert found.pop("Rev1") == "arm:1+hand:1"
    assert found.pop("Rev1_3") == "leg:1+foot:1"
    assert found.keys() == {"Rev1_2", "Rev1_2_2"}


def test_assembly_constraints_do_not_hide_joints(fusion: Any) -> None:
    design = designs.assembly_constraints()
    with pytest.raises(RuntimeError, match="InternalValidationError"):
        _ = design.rootComponent.allJoints
    snapshot = read(design)
    assert len(snapshot.joints) == 2
    assert [f.code for f in snapshot.findings] == ["assembly-constraints"]
    fusion.without("Component.assemblyConstraints")
    assert len(read(design).joints) == 2


# Motions ------------------------------------------------------------------------------------


@pytest.mark.parametrize("as_built", [False, True])
@pytest.mark.parametrize("vectors", ["fixed", "carried"])
def test_every_joint_type_has_its_motions(fusion: Any, as_built: bool, vectors: Any) -> None:
    fusion.options.ball_vectors = vectors
    design = designs.every_joint_type(as_built=as_built)
    snapshot = read(design)
    assert not snapshot.findings
    found = {joint.kind: joint for joint in snapshot.joints}
    assert found.keys() == {
        *("rigid", "revolute", "slider", "cylindrical", "pin_slot", "planar", "ball")
    }
    roles = {kind: [(m.kind, m.role) for m in j.motions] for kind, j in found.items()}
    turn, slide = "rotation", "translation"
    assert roles == {
        "rigid": [],
        "revolute": [(turn, "")],
        "slider": [(slide, "")],
        "cylindrical": [(turn, "rotation"), (slide, "slide")],
        "pin_slot": [(slide, "slide"), (turn, "rotation")],
        "planar": [(slide, "primary_slide"), (slide, "secondary_slide"), (turn, "rotation")],
        "ball": [(turn, "pitch"), (turn, "yaw"), (turn, "roll")],
    }
    for (_, name), (_, data, T_one, T_two, axes) in drawn_joints(design).items():
        joint = next(j for j in snapshot.joints if j.name == name)
        for motion, freedom, axis in zip(joint.motions, data.freedoms, axes, strict=True):
            unit = 1.0 if motion.kind == "rotation" else 0.01
            assert motion.value == pytest.approx(unit * freedom.value, abs=1e-15)
            assert motion.lower == pytest.approx(unit * (freedom.value - 0.5), abs=1e-15)
            assert motion.upper == pytest.approx(unit * (freedom.value + 0.25), abs=1e-15)
            assert motion.axis == pytest.approx(axis, abs=1e-12)
        if as_built and joint.kind == "rigid":
            assert joint.origin_one is joint.origin_two is None
        else:
            assert joint.origin_two == pytest.approx(at(T_two, (0, 0, 0)), abs=1e-12)
        if as_built and any(m.kind == "translation" for m in joint.motions):
            assert joint.origin_one is None  # unknown
        elif joint.kind != "rigid":
            assert joint.origin_one == pytest.approx(at(T_one, (0, 0, 0)), abs=1e-12)


BALLS = [(0.3, -0.4, 0.5), (0.3, 0.0, 0.0), (0.0, 0.4, 0.0), (0.0, 0.0, 0.7), (0.3, 0.2, 0.0)]


@pytest.mark.parametrize("vectors", ["fixed", "carried"])
@pytest.mark.parametrize(
    ("custom", "values"),
    [*((False, v) for v in BALLS), *((True, v) for v in BALLS if v != (0.3, 0.0, 0.0))],
)
def test_ball_axes_are_fixed_to_two(fusion: Any, vectors: Any, custom: bool, values: Any) -> None:
    fusion.options.ball_vectors = vectors
    T = designs.random_motion(random.Random(4))
    R = rotation(0.6, (1.0, 1.0, 0.0))[:3, :3] if custom else np.eye(3)
    axes = [tuple(R @ np.array(axis)) for axis in (Z, X, Y)]
    build = Builder()
    one, two = build.place("one", designs.random_motion(random.Random(5))), build.place("two")
    build.joint("ball", "ball", one, two, T=T, values=values, axes=axes)
    snapshot = read(build.done())
    (joint,) = snapshot.joints
    assert not snapshot.findings
    for motion, axis in zip(joint.motions, axes, strict=True):
        assert motion.axis == pytest.approx(T[:3, :3] @ np.array(axis), abs=1e-12)


@pytest.mark.parametrize("vectors", ["fixed", "carried"])
def test_ball_axes_are_found_from_the_pose(fusion: Any, vectors: Any) -> None:
    """A custom yaw axis that is not perpendicular to the pitch axis."""
    fusion.options.ball_vectors = vectors
    yaw = tuple((np.array((1.0, 0.0, 0.5)) / math.sqrt(1.25)).tolist())
    build = Builder()
    one, two = build.place("one"), build.place("two")
    build.joint("b", "ball", one, two, values=(0.3, 0.4, 0.5), axes=(Z, yaw, Y))
    snapshot = read(build.done())
    assert not snapshot.findings
    for motion, axis in zip(snapshot.joints[0].motions, (Z, yaw, Y), strict=True):
        assert motion.axis == pytest.approx(axis, abs=1e-12)


def test_uncertain_ball_axes_are_reported(fusion: Any) -> None:
    R = rotation(0.6, (1.0, 1.0, 0.0))[:3, :3]
    build = Builder()
    axes = [tuple(R @ np.array(axis)) for axis in (Z, X, Y)]
    build.joint("b", "ball", build.place("one"), build.place("two"), values=(0.3, 0, 0), axes=axes)
    assert {f.code for f in read(build.done()).findings} == {"ball-axes-uncertain"}


@pytest.mark.parametrize("kind", ["revolute"])
def test_reversed_axis_is_corrected(
    fusion: Any, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A reversed sign of the value is detected from the two frames of the joint."""
    from fake_fusion.build import FREEDOMS

    values = [0.3 + 0.1 * k for k in range(len(FREEDOMS[kind]))]
    expected = hinged(Builder(), kind=kind, values=values)
    original = API["JointMotion"]._vector

    def reverse(motion: Any, role: str) -> Any:
        v = original(motion, role)
        v.scaleBy(-1.0)
        return v

    monkeypatch.setattr(API["JointMotion"], "_vector", reverse)
    found = hinged(Builder(), kind=kind, values=values)
    for motion, right in zip(found.motions, expected.motions, strict=True):
        assert motion.axis == pytest.approx(right.axis, abs=1e-12)


def test_flipped_joints_and_angles_reverse_nothing(fusion: Any) -> None:
    for more in ({"flipped": True}, {"angle": -0.6}, {"offsets": (0.0, 0.0, 1.0)}):
        build = Builder()
        joint = hinged(build, values=(0.3,), **more)
        path = build.root.occurrences[0]
        data = path.component.joints[0]
        T = path.T @ transform(data.two) @ data.T_two
        assert joint.motions[0].axis == pytest.approx(T[:3, 2], abs=1e-12)


def test_only_enabled_limits_are_read(fusion: Any) -> None:
    found = by_name(designs.limits())
    limits = [(m.lower, m.upper) for k in range(1, 6) for m in found[f"joint_{k}"].motions]
    assert limits == [(None, None), (-0.5, None), (None, 0.75), (-0.5, 0.75), (0.0, 0.0)]


def test_motion_links_are_couplings(fusion: Any) -> None:
    """A hand inserted twice: a knuckle follows with half the angle, a slide by a screw pitch."""
    build = Builder()
    hand = build.place("hand", designs.random_motion(random.Random(1)))
    build.place(hand[-1].component, designs.random_motion(random.Random(2)))
    parts = [build.place(f"part {k}", above=hand) for k in range(4)]
    first, second = (
        build.joint(f"knuckle {k}", "revolute", parts[k], hand, inside=hand, values=(value,))
        for k, value in enumerate((0.4, 0.3))
    )
    screw = build.joint("screw", "cylindrical", parts[2], hand, inside=hand, values=(0.0, 1.5))
    build.motion_link(first, second, values=(1.0, 0.5), reversed=True)
    build.motion_link(screw, motions=(3, 4), values=(2 * math.pi, 0.2))
    build.motion_link(second, first, suppressed=True)
    snapshot = read(build.done())
    found = {(c.follower, c.follower_role): c for c in snapshot.couplings}
    assert found.keys() == {
        *(("knuckle 1", ""), ("knuckle 1_2", ""), ("screw", "slide"), ("screw_2", "slide"))
    }
    for suffix in ("", "_2"):
        knuckle = found[f"knuckle 1{suffix}", ""]
        assert knuckle.leader == f"knuckle 0{suffix}"
        assert (knuckle.ratio, knuckle.offset) == pytest.approx((-0.5, 0.5))
        slide = found[f"screw{suffix}", "slide"]
        assert (slide.leader, slide.leader_role) == (f"screw{suffix}", "rotation")
        assert (slide.ratio, slide.offset) == pytest.approx((0.002 / (2 * math.pi), 0.015))
    assert {f.code for f in snapshot.findings} == {"same-name"}


# Problems ---------------------------------------------------------------------------


def test_suppressed_and_broken_joints_are_marked(fusion: Any) -> None:
    found = by_name(designs.suppressed_and_broken())
    assert found["upper_joint"].problem == ""
    assert found["lower_joint"].problem.startswith("Reference Failures")
    assert found["old"].suppressed
    assert found["old"].problem == ""
    assert not found["upper_joint"].suppressed


def test_transforms_of_broken_geometry_are_used(fusion: Any) -> None:
    joint = by_name(designs.suppressed_and_broken())["lower_joint"]
    assert joint.origin_one == pytest.approx((0.0, 0.0, 0.2))


def test_a_warning_of_fusion_is_a_finding_but_not_a_problem(fusion: Any) -> None:
    build = Builder()
    designs.chain(build)
    build.root.joints[0].health, build.root.joints[0].problem = 1, "out\nof date"
    build.root.joints[1].health = 4
    snapshot = read(build.done())
    assert [f.message for f in snapshot.findings] == [
        "joint 'upper_joint': Fusion warns: out of date"
    ]
    assert "timeline" in {j.name: j.problem for j in snapshot.joints}["lower_joint"]


def test_locked_joint_is_read_as_locked(fusion: Any) -> None:
    found = by_name(designs.locked_joint())
    assert found["lower_joint"].locked
    assert not found["upper_joint"].locked


def test_inferred_joint_has_components_but_no_motion(fusion: Any) -> None:
    joint = by_name(designs.inferred_joint())["lower_joint"]
    assert (joint.kind, joint.motions, joint.origin_one) == ("inferred", (), None)
    assert (joint.one, joint.two) == ("lower:1", "upper:1")


def test_unknown_joint_type_is_a_problem(fusion: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(API["JointMotion"], "jointType", property(lambda _: 12))
    assert all("12" in joint.problem for joint in read(designs.no_groups()).joints)


def test_joint_without_components_is_read_with_its_problem(fusion: Any) -> None:
    build = Builder()
    one = build.place("one")
    data = build.joint("j", "revolute", one, ())
    data.one = ()
    assert "both sides are the root component" in by_name(build.done())["j"].problem
