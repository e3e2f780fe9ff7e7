"""Tests of the known defects of the original SDFusion, by number."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_fusion import Builder, designs
from fake_fusion.driver import Rejected
from fake_fusion.maths import rotation, translation
from support.designs.exported import (
    EXPORT,
    codes_of,
    export,
    findings_of,
    press_export,
    running,
)

import addin_sdfusion
from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.errors import RobotError
from addin_sdfusion.robot.formats.read import read_robot
from sim_dart import DartDynamics

ADDIN = Path(addin_sdfusion.__file__).parent


def same_robots(one: Robot, other: Robot, *, gravity: bool = True) -> None:
    """Check that two robots have the same dynamics."""
    a, b = DartDynamics(one), DartDynamics(other)
    rng = np.random.default_rng(1)
    for q in rng.uniform(-0.7, 0.7, (5, len(a.coordinate_names))):
        np.testing.assert_allclose(a.mass_matrix(q), b.mass_matrix(q), rtol=0, atol=1e-9)
        np.testing.assert_allclose(a.muscle_jacobian(q), b.muscle_jacobian(q), rtol=0, atol=1e-9)
        if gravity:
            np.testing.assert_allclose(a.gravity(q), b.gravity(q), rtol=0, atol=1e-9)


def test_1_caspr_bodies_describe_the_robot(fusion: Any, tmp_path: Path) -> None:
    """The export crashed at the first joint; masses, inertias, types and parents were wrong."""
    made = export(designs.two_link_arm(seed=4, nesting=2), tmp_path / "arm")
    (bodies,) = (made.folder / "caspr").glob("*_bodies.xml")
    caspr = read_robot(bodies)
    assert [link.name for link in caspr.links][-2:] == ["link_1", "link_2"]
    same_robots(caspr, made.robot)


def test_2_an_existing_folder_can_be_exported_to_again(fusion: Any, tmp_path: Path) -> None:
    """The second export crashed. Files of the user must be kept."""
    design = designs.two_link_arm()
    first = export(design, tmp_path / "arm").contents()
    (tmp_path / "arm/notes.txt").write_text("mine")
    second = export(design, tmp_path / "arm").contents()
    assert second.pop("notes.txt") == b"mine"
    assert {name: data for name, data in second.items() if "findings" not in name} == {
        name: data for name, data in first.items() if "findings" not in name
    }


@pytest.mark.parametrize("drawn", [designs.things_to_pick, designs.small_parts])
def test_3_the_design_is_unchanged(fusion: Any, tmp_path: Path, drawn: Any) -> None:
    """Sketches and small parts were deleted, and copies of components remained."""
    drawn()
    before = fusion.fingerprint(), fusion.design.rootComponent.sketches.count
    with running():
        press_export(fusion, tmp_path / "robot")
    assert (tmp_path / "robot/model.sdf").is_file()
    assert (fusion.fingerprint(), fusion.design.rootComponent.sketches.count) == before
    fusion.undo()
    assert fusion.world.undo_steps == []
    assert fusion.full_fingerprint()


def test_4_a_second_export_in_one_session_has_no_points_of_the_first(
    fusion: Any, tmp_path: Path
) -> None:
    """Via points were duplicated, also across documents."""
    many, few = designs.two_link_arm(), designs.many_numbers()
    with running():
        for folder, design in (("a", few), ("b", many), ("c", few)):
            fusion.activate(design)
            press_export(fusion, tmp_path / folder / "robot")
    assert len(read_robot(tmp_path / "b/robot").muscles) == 4
    (muscle,) = read_robot(tmp_path / "c/robot").muscles
    assert len(muscle.via_points) == 12
    files = [tmp_path / folder / "robot/cardsflow.xml" for folder in "ac"]
    assert files[0].read_bytes() == files[1].read_bytes()


@pytest.mark.slow
def test_5_every_setting_changes_the_files(fusion: Any, tmp_path: Path) -> None:
    """Check boxes were never read; the model was called '' and its meshes model:///meshes."""
    design = designs.two_link_arm()
    usual = export(design, tmp_path / "a/arm", up_axis="z")
    assert usual.robot.name == "planar_2r"
    assert "model://arm/meshes/" in usual.sdf or "meshes/visual/" in usual.sdf
    assert "model:///" not in usual.sdf
    choices: list[dict[str, Any]] = [
        {"name": "another"},
        {"visual": False},
        {"collision": "none"},
        {"collision": "mesh"},
        {"caspr": False},
        {"osim": False},
        {"up_axis": "y"},
        {"fixed_base": False},
        {"base": "link_2", "fixed_base": False},
    ]
    for k, choice in enumerate(choices):
        other = export(design, tmp_path / f"{k}/arm", **choice).contents()
        assert other != usual.contents(), choice
    with pytest.raises(RobotError, match="no link 'link_1'"):
        export(design, tmp_path / "c/arm", links="components", components=("base:1",))


def test_6_numbers_in_names_are_compared_as_numbers(fusion: Any, tmp_path: Path) -> None:
    """`10` came before `2`; links like `a_0` were read wrongly; `(1)` became a number."""
    (muscle,) = export(designs.many_numbers(), tmp_path / "a").robot.muscles
    heights = [via.position[2] for via in muscle.via_points if via.link == "base"]
    assert heights == sorted(heights)
    assert [via.link for via in muscle.via_points] == ["base"] * 6 + ["upper"] * 6
    odd = export(designs.odd_link_names(), tmp_path / "b").robot
    for muscle in odd.muscles:
        assert [via.link for via in muscle.via_points] == ["a_0", "a_0_1", "2b"]
    renamed = [f for f in findings_of(designs.duplicate_names()) if f.code == "copied-point"]
    assert [f.is_error for f in renamed] == [True]
    assert "VP_motor0_EXPORT_upper_1 (1)" in str(renamed[0])


def test_7_nested_points_and_bodies_have_correct_positions(fusion: Any, tmp_path: Path) -> None:
    """Points, joints and bodies in sub-components were read in the frames of their components."""
    flat = export(designs.two_link_arm(), tmp_path / "a").robot
    nested = export(designs.two_link_arm(nesting=3, seed=2), tmp_path / "b").robot
    same_robots(nested, flat)
    ends = [{tuple(np.round(t.position, 9)) for t in r.task_frames} for r in (nested, flat)]
    assert ends[0] == ends[1]


@pytest.mark.slow
def test_8_all_kinds_of_joint_references_are_read(fusion: Any, tmp_path: Path) -> None:
    """The export crashed or ignored the joints."""
    plain = export(designs.two_link_arm(), tmp_path / "a").robot
    for k, how in enumerate(("by_origins", "as_built")):
        same_robots(export(designs.two_link_arm(**{how: True}), tmp_path / f"{k}").robot, plain)
    rooted = export(designs.joint_to_root(), tmp_path / "b").robot
    assert [j.name for j in rooted.joints] == ["root_joint", "lower_joint"]
    assert "unsupported-joint" in codes_of(designs.inferred_joint())


def test_9_only_enabled_limits_are_exported(fusion: Any, tmp_path: Path) -> None:
    """Disabled limits became 0 .. 0, which locked the joint."""
    robot = export(designs.limits(), tmp_path / "robot").robot
    found = {c.name: (c.lower, c.upper) for c in robot.coordinates}
    free = float("inf")
    assert found["joint_1"] == (-free, free)
    assert found["joint_2"] == (-0.5, free)
    assert found["joint_3"] == (-free, 0.75)
    assert found["joint_4"] == (-0.5, 0.75)
    assert robot.joint("joint_5").motions == ()  # 0 .. 0 in the design: fixed


@pytest.mark.parametrize("drawn", [designs.unexported_link, designs.case_differences])
def test_10_points_on_unknown_links_are_reported(fusion: Any, tmp_path: Path, drawn: Any) -> None:
    """The export failed with 'No constructor defined'."""
    design = drawn()
    (tmp_path / "robot").mkdir()
    with pytest.raises(RobotError) as caught:
        export(design, tmp_path / "robot")
    wrong = [f for f in caught.value.findings if f.code == "unknown-link"]
    assert wrong
    assert all(f.subject.name == "motor0" and "no link '" in f.message for f in wrong)
    assert list((tmp_path / "robot").iterdir()) == []


@pytest.mark.parametrize("drawn", [designs.no_groups, designs.single_cube])
def test_11_designs_without_rigid_groups_are_exported(
    fusion: Any, tmp_path: Path, drawn: Any
) -> None:
    """The progress dialog had the range 0 to 0, which Fusion rejects."""
    drawn()
    with running():
        command = press_export(fusion, tmp_path / "robot")
    assert command.failed == ""
    assert fusion.world.progress
    assert all(record.maximum > record.minimum for record in fusion.world.progress)
    assert read_robot(tmp_path / "robot").links


@pytest.mark.parametrize("axis", [(0.0, 1.0, 0.0), (1.0, 0.0, 0.0)])
def test_12_a_rotation_by_90_degrees_and_a_centre_of_mass_point(
    fusion: Any, tmp_path: Path, axis: Any
) -> None:
    """Division by the cosine of pitch; COM_ points moved the frame but not the inertia."""
    quarter = rotation(np.pi / 2, axis)
    turned = export(designs.two_link_arm(motion=quarter), tmp_path / "a").robot
    same_robots(turned, export(designs.two_link_arm(), tmp_path / "b").robot, gravity=False)
    named = export(designs.old_markers(), tmp_path / "c")
    assert "com-point-ignored" in named.codes
    inertia = named.robot.link("upper").inertia
    mass = 7.85e-3 * 60.0
    np.testing.assert_allclose(
        np.diag(inertia.matrix),
        mass / 12.0 * 1e-4 * np.array([3.0**2 + 100.0, 2.0**2 + 100.0, 13.0]),
        rtol=1e-9,
    )


@pytest.mark.slow
def test_12_no_thread_calls_the_api() -> None:
    """The API may be called only from the main thread."""
    for file in ADDIN.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                names = [node.module or ""]
            assert not {n.split(".")[0] for n in names} & {
                "threading",
                "_thread",
                "concurrent",
                "multiprocessing",
                "asyncio",
            }, file


def test_13_buttons_are_added_and_removed_and_use_the_active_document(
    fusion: Any, tmp_path: Path
) -> None:
    """There was no button and no stop(); the root component was read at import."""
    before = fusion.buttons()
    with running():
        assert len(fusion.buttons()) == len(before) + 3
        with pytest.raises(Rejected):
            fusion.run_command(EXPORT).ok()
        assert "Open a design first" in fusion.messages[-1]
        first, second = designs.two_link_arm(), designs.no_groups()
        for design, name in ((first, "first"), (second, "second")):
            fusion.activate(design)
            press_export(fusion, tmp_path / name)
    assert fusion.buttons() == before
    assert len(read_robot(tmp_path / "first").muscles) == 4
    assert read_robot(tmp_path / "second").name == "no groups"


@pytest.mark.parametrize("units", ["mm", "in", "m"])
def test_13_meshes_are_in_metres_for_any_unit(fusion: Any, tmp_path: Path, units: str) -> None:
    """Meshes were scaled by 0.001, which assumes designs in mm."""
    build = Builder("cube", units=units)
    build.box((), (20.0, 10.0, 30.0))
    made = export(build.done(), tmp_path / "robot")
    (mesh,) = made.meshes_in_world().values()
    np.testing.assert_allclose(mesh.extents, (0.2, 0.1, 0.3), rtol=1e-6)
    (inertia,) = [link.inertia for link in made.robot.links]
    assert inertia.mass == pytest.approx(47.1, rel=1e-9)
    assert "0.001 0.001 0.001" not in made.sdf


def test_14_the_sdf_file_is_up_to_date(fusion: Any, tmp_path: Path) -> None:
    """use_parent_model_frame; no effort, velocity or damping; the visual mesh as collision."""
    made = export(designs.two_link_arm(), tmp_path / "robot")
    assert '<sdf version="1.7">' in made.sdf
    assert "use_parent_model_frame" not in made.sdf
    for link in ("link_1", "link_2"):
        roles = [mesh.role for mesh in made.robot.link(link).meshes]
        assert sorted(roles) == ["collision", "visual"]
    assert "<collision name=" in made.sdf


@pytest.mark.parametrize(
    ("drawn", "code"),
    [
        (designs.name_clash, "name-clash"),
        (designs.no_material, "link-without-mass"),
    ],
)
def test_14_what_libsdformat_rejects_is_not_exported(
    fusion: Any, tmp_path: Path, drawn: Any, code: str
) -> None:
    """11 of 25 published models were rejected."""
    design = drawn()
    with pytest.raises(RobotError) as caught:
        export(design, tmp_path / "robot")
    assert [f.code for f in caught.value.findings if f.is_error].count(code) == 1
    assert not (tmp_path / "robot").exists()


def test_14_an_impossible_inertia_is_reported(fusion: Any) -> None:
    """Eight models violated the triangle inequality."""
    build = Builder("impossible")
    body = build.place("base", translation((0.0, 0.0, 1.0)), grounded=True)
    build.explicit(body, 1.0, inertia=np.diag([1.0, 1.0, 5.0]))
    assert "inertia-triangle" in codes_of(build.done())
