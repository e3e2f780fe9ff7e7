"""Tests of ten problems that users of other exporters have reported, by number."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_fusion import Builder, designs
from fake_fusion.maths import rotation, translation
from support.designs.exported import Export, export, findings_of, press_export, read_design, running

from addin_sdfusion.building.build_robot import link_of
from addin_sdfusion.robot.errors import RobotError
from addin_sdfusion.robot.formats.read import read_robot


def positions(made: Export) -> dict[str, Any]:
    """Return the positions of the joints of an export on their parents."""
    return {joint.name: joint.T_parent_joint.position for joint in made.robot.joints}


def test_1_as_built_joints_are_joints(fusion: Any, tmp_path: Path) -> None:
    """Reported as: 'only base_link'."""
    robot = export(designs.as_built_only(), tmp_path / "robot").robot
    assert [joint.name for joint in robot.joints][1:] == ["upper_joint", "lower_joint", "lid_joint"]
    assert [c.name for c in robot.coordinates] == ["upper_joint", "lower_joint"]


def test_2_rigid_groups_are_links(fusion: Any, tmp_path: Path) -> None:
    """Nested parts belong to the group of their nearest ancestor."""
    made = export(designs.rigid_groups(), tmp_path / "robot")
    assert [link.name for link in made.robot.links] == ["base", "upper", "lower"]
    steel = 7.85e-3
    motor, bracket, screw = np.pi * 4.0 * 5.0, 6.0, np.pi * 0.09 * 2.0
    masses = [link.inertia.mass for link in made.robot.links]
    expected = [60.0 + motor, 60.0 + bracket + screw, 60.0]
    np.testing.assert_allclose(masses, [steel * volume for volume in expected], rtol=1e-9)


@pytest.mark.parametrize("seed", [11, 12])
def test_3_nested_and_rotated_occurrences_keep_their_poses(
    fusion: Any, tmp_path: Path, seed: int
) -> None:
    """Reported as: joints and meshes at wrong positions. The fake contains the true poses."""
    design = designs.nested_rotated(seed)
    made = export(design, tmp_path / "robot")
    placed = made.meshes_in_world()
    root = design.rootComponent
    for occurrence in root.allOccurrences:
        for i in range(occurrence.bRepBodies.count):
            box = occurrence.bRepBodies.item(i).boundingBox
            corners = np.array([box.minPoint.asArray(), box.maxPoint.asArray()]) / 100.0
            np.testing.assert_allclose(placed[occurrence.component.name].bounds, corners, atol=1e-5)


def boxes_of_links(design: Any) -> dict[str, Any]:
    """Return the bounding boxes of visible solids by link, in [m], from the bodies of the fake."""
    links = link_of(read_design(design, meshes=False, masses=None))
    found: dict[str, list[Any]] = {}
    for occurrence in design.rootComponent.allOccurrences:
        link = links.get(occurrence.fullPathName)
        for i in range(occurrence.bRepBodies.count):
            body = occurrence.bRepBodies.item(i)
            if link and body.isVisible and body.isSolid:
                box = body.boundingBox
                found.setdefault(link, []).append([box.minPoint.asArray(), box.maxPoint.asArray()])
    return {
        link: np.array([np.min(boxes, axis=(0, 1)), np.max(boxes, axis=(0, 1))]) / 100.0
        for link, boxes in found.items()
    }


@pytest.mark.parametrize("root_body", [False, True])
def test_4_joints_to_the_root_and_the_ground(fusion: Any, tmp_path: Path, root_body: bool) -> None:
    """Reported as: 'NoneType' object has no attribute 'component'."""
    made = export(designs.joint_to_root(root_body=root_body), tmp_path / "robot")
    (joint,) = [joint for joint in made.robot.joints if joint.name == "root_joint"]
    assert joint.child == "upper"
    assert joint.parent == "world"


def test_5_joint_origins_are_read(fusion: Any, tmp_path: Path) -> None:
    """Joint origins of Fusion have no attribute `origin`."""
    made = export(designs.joint_origins(), tmp_path / "robot")
    assert {joint.name for joint in made.robot.joints} >= {"upper_joint", "lower_joint"}
    np.testing.assert_allclose(positions(made)["lower_joint"], (0.0, 0.0, 0.1), atol=1e-12)


def test_6_inertias_of_several_bodies_small_parts_and_overridden_masses(
    fusion: Any, tmp_path: Path
) -> None:
    """Reported as: no parallel-axis theorem; rounding to 0; masses set by the user ignored."""
    shape = export(designs.l_shape(), tmp_path / "a").robot.link("lower").inertia
    boxes = [(60.0, (2.0, 3.0, 10.0), (0.0, 5.0)), (36.0, (6.0, 3.0, 2.0), (4.0, 1.0))]
    masses = np.array([7.85e-3 * volume for volume, _, _ in boxes])
    com = masses @ np.array([place for _, _, place in boxes]) / masses.sum()
    iyy = sum(
        m * ((x * x + z * z) / 12.0 + (px - com[0]) ** 2 + (pz - com[1]) ** 2)
        for m, (_, (x, _, z), (px, pz)) in zip(masses, boxes, strict=True)
    )
    assert shape.mass == pytest.approx(masses.sum(), rel=1e-9)
    assert shape.com[0] == pytest.approx(0.01 * com[0], rel=1e-9)
    assert shape.matrix[1][1] == pytest.approx(1e-4 * iyy, rel=1e-9)
    small = export(designs.small_parts(), tmp_path / "b").robot.link("lower").inertia
    mass = 1.2e-3 * 0.024
    assert small.mass == pytest.approx(mass, rel=1e-9)
    assert small.matrix[2][2] == pytest.approx(mass / 12.0 * 13e-6, rel=1e-9)
    reported = export(designs.overridden_mass(2.5), tmp_path / "c").robot.link("upper").inertia
    assert reported.mass == pytest.approx(2.5, rel=1e-9)


def test_7_lengths_are_metres_everywhere(fusion: Any, tmp_path: Path) -> None:
    """Reported as: meshes a thousand times too large; sliders in cm."""
    build = Builder("slider", units="ft")
    base = build.place("base", grounded=True)
    cart = build.place("cart", translation((0.0, 0.0, 50.0)))
    for path in (base, cart):
        build.box(path, (20.0, 20.0, 20.0))
    build.joint("slide", "slider", cart, base, (0.0, 0.0, 50.0), (1.0, 0.0, 0.0),
                limits=((-25.0, 40.0),))  # fmt: skip
    made = export(build.done(), tmp_path / "robot")
    (coordinate,) = made.robot.coordinates
    assert (coordinate.lower, coordinate.upper) == (-0.25, 0.4)
    np.testing.assert_allclose(positions(made)["slide"], (0.0, 0.0, 0.5), atol=1e-12)
    for mesh in made.meshes_in_world().values():
        np.testing.assert_allclose(mesh.extents, 0.2, rtol=1e-6)


def test_8_copies_of_a_component_have_separate_meshes(fusion: Any, tmp_path: Path) -> None:
    """Reported as: the meshes of one copy overwrote the meshes of the other."""
    made = export(designs.component_twice(), tmp_path / "robot")
    paths = [mesh.uri for link in made.robot.links for mesh in link.meshes]
    assert len(paths) == len(set(paths)) == 6
    placed = made.meshes_in_world()
    np.testing.assert_allclose(placed["left"].centroid, (-0.04, 0.0, 0.04), atol=1e-7)
    np.testing.assert_allclose(placed["right"].centroid, (0.04, 0.0, 0.04), atol=1e-7)
    (muscle,) = made.robot.muscles
    assert [via.link for via in muscle.via_points] == ["palm", "left"]


def test_9_loops_are_reported_and_closed_and_constraints_are_tolerated(
    fusion: Any, tmp_path: Path
) -> None:
    """Reported as: two parents without a message; allJoints raised InternalValidationError."""
    design = designs.closed_loop()
    (loop,) = [f for f in findings_of(design) if f.code == "closed-loop"]
    assert all(repr(name) in loop.message for name in "abcd")
    cut = export(design, tmp_path / "a", cut_joints=("d",)).robot
    assert {joint.name for joint in cut.joints} >= {"a", "b", "c"}
    assert [loop.name for loop in cut.loops] == ["d"]
    made = export(designs.assembly_constraints(), tmp_path / "b")
    assert "assembly-constraints" in made.codes
    assert {joint.name for joint in made.robot.joints} >= {"upper_joint", "lower_joint"}


def test_10_collisions_are_selectable_with_unique_names(fusion: Any, tmp_path: Path) -> None:
    """Reported as: no choice of collisions, and two collisions with the same name."""
    design = designs.l_shape()
    for choice in ("none", "mesh", "convex_hull"):
        made = export(design, tmp_path / choice, collision=choice)
        roles = [mesh.role for mesh in made.robot.link("lower").meshes]
        assert ("collision" in roles) == (choice != "none")
        names = [line for line in made.sdf.splitlines() if "<collision name=" in line]
        per_link = made.sdf.split("<link name=")[1:]
        for text in per_link:
            own = [line for line in text.splitlines() if "<collision name=" in line]
            assert len(own) == len(set(own))
        assert bool(names) == (choice != "none")


def test_names_of_any_script_are_exported(fusion: Any, tmp_path: Path) -> None:
    """In addition to the ten: unicode names stopped the export."""
    design = designs.unicode_names()
    with running():
        press_export(fusion, tmp_path / "робот 1")
    robot = read_robot(tmp_path / "робот 1")
    assert [link.name for link in robot.links] == ["основа", "上臂", 'ell"bow <&>']
    assert robot.name == "Schülter – 肩"
    assert design.rootComponent.occurrences.count == 3


REFUSED = {
    "inferred_joint": "unsupported-joint",
    "suppressed_and_broken": "broken-joint",
    "occurrence_in_two_groups": "occurrence-in-two-groups",
    "disconnected": "link-not-connected",
    "surface_and_mesh_bodies": "link-without-mass",
    "no_material": "link-without-mass",
    "name_clash": "name-clash",
    "duplicate_names": "copied-point",
    "case_differences": "unknown-link",
    "unexported_link": "unknown-link",
}


@pytest.mark.cases(19)
@pytest.mark.slow
@pytest.mark.parametrize("name", designs.FEATURES)
def test_reported_designs_are_exported_or_rejected_with_a_reason(
    fusion: Any, tmp_path: Path, name: str
) -> None:
    """In addition to the ten: broken messages without advice."""
    design = designs.FEATURES[name]()
    findings = findings_of(design)
    assert all("\n" not in str(f) and "Traceback" not in str(f) for f in findings)
    if name in REFUSED:
        assert REFUSED[name] in {f.code for f in findings if f.is_error}
        with pytest.raises(RobotError):
            export(design, tmp_path / name)
        return
    made = export(design, tmp_path / name)
    boxes = boxes_of_links(design)
    placed = made.meshes_in_world()
    for link in placed.keys() & boxes.keys():
        np.testing.assert_allclose(placed[link].bounds, boxes[link], atol=1e-4)


def test_rotated_copy_keeps_its_rotation(fusion: Any, tmp_path: Path) -> None:
    """In addition to the ten: a bar with two occurrences, one of them rotated by 90°."""
    build = Builder("bars")
    one = build.place("bar", grounded=True)
    build.box(one, (10.0, 1.0, 2.0))
    two = build.place(one[-1].component, translation((0, 0, 9)) @ rotation(np.pi / 2, (0, 0, 1)))
    build.joint("pivot", "revolute", two, one, (0.0, 0.0, 4.0), (0.0, 0.0, 1.0))
    made = export(build.done(), tmp_path / "robot", collision="none")
    extents = sorted(tuple(np.round(m.extents, 6)) for m in made.meshes_in_world().values())
    assert extents == [(0.01, 0.1, 0.02), (0.1, 0.01, 0.02)]
