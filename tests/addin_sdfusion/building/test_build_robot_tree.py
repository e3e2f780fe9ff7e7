"""Tests of trees of links: roots, parents, closed loops, names."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.designs.design_strategies import shuffled
from support.designs.small_designs import (
    DesignSnapshot,
    arm,
    body,
    box,
    group,
    part,
    revolute,
    rigid,
)

from addin_sdfusion.building.build_robot import BuiltRobot, build_robot, link_of
from addin_sdfusion.exporting.export import export_robot
from addin_sdfusion.robot import Robot, read_robot
from addin_sdfusion.robot.model.coupling import all_values
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import CouplingSnapshot, GroupSnapshot

NAMES = ("a", "b", "c", "d")


def design(*joints: Any, grounded: str = "", links: Any = NAMES, **more: Any) -> DesignSnapshot:
    """Return a design whose links are components at different positions."""
    given = {
        "occurrences": tuple(part(f"{n}:1", grounded=n in grounded) for n in links),
        "bodies": tuple(
            body(f"{n}:1", box((0.1, 0.2, 0.3), (0.0, 0.0, 0.4 * k))) for k, n in enumerate(links)
        ),
        "joints": joints,
        **more,
    }
    return DesignSnapshot("made", **given)


def joint(name: str, one: str, two: str, **more: Any) -> Any:
    return revolute(name, one and f"{one}:1", two and f"{two}:1", **more)


CHAIN = (joint("ab", "b", "a"), joint("bc", "c", "b"), joint("cd", "d", "c"))
LOOP = (*CHAIN, joint("da", "a", "d"))


def codes(made: BuiltRobot) -> list[str]:
    return [f.code for f in made.findings if f.code != "no-muscles"]


def tree(made: BuiltRobot) -> list[tuple[str, str, str]]:
    assert made.robot is not None, made.findings
    return [(j.name, j.parent, j.child) for j in made.robot.joints]


def fused(robot: Robot) -> list[str]:
    return [j.name for j in robot.joints if j.type == "fixed"]


def test_a_single_cube_without_groups_is_a_robot() -> None:
    made = build_robot(DesignSnapshot("cube v3", bodies=(body(""),)))
    assert tree(made) == [("world_base", "world", "base")]
    assert codes(made) == []


def test_the_grounded_link_is_the_base_for_any_joint_direction() -> None:
    made = build_robot(design(*CHAIN, grounded="c"))
    assert tree(made) == [
        ("world_c", "world", "c"),
        ("bc", "c", "b"),
        ("cd", "c", "d"),
        ("ab", "b", "a"),
    ]
    assert made.base == "c"
    assert codes(made) == []


def test_without_ground_the_base_is_the_link_that_is_not_a_child() -> None:
    made = build_robot(design(*CHAIN))
    assert made.base == "a"
    assert codes(made) == []


def test_a_joint_to_the_root_is_the_parent_joint_of_its_link() -> None:
    made = build_robot(design(*CHAIN, revolute("ground", "b:1", "")))
    assert tree(made)[0] == ("ground", "world", "b")
    assert codes(made) == []
    flipped = build_robot(design(*CHAIN, revolute("ground", "", "b:1")))
    assert tree(flipped) == tree(made)
    assert flipped.robot is not None
    assert made.robot is not None
    (one,), (two,) = (r.joints[0].motions for r in (made.robot, flipped.robot))
    assert [-x for x in one.axis] == list(two.axis)


def test_the_chosen_base_takes_precedence_and_ignored_grounds_are_reported() -> None:
    chosen = ExportSettings(base="d")
    made = build_robot(design(*CHAIN, grounded="a", settings=chosen))
    assert made.base == "d"
    assert codes(made) == ["ground-ignored"]
    unknown = build_robot(design(*CHAIN, settings=ExportSettings(base="D")))
    assert codes(unknown) == ["unknown-base"]
    assert "no link 'D' (known: a, b, c, d)" in unknown.findings[0].message


def test_two_grounded_links_of_one_tree_are_an_error() -> None:
    made = build_robot(design(*CHAIN, grounded="ad"))
    assert codes(made) == ["several-bases"]
    assert "'a', 'd'" in made.findings[0].message
    assert codes(build_robot(design(*CHAIN, grounded="ad", settings=ExportSettings(base="a")))) == [
        "ground-ignored"
    ]


def test_unconnected_grounded_links_are_each_fixed_to_the_world() -> None:
    made = build_robot(design(*CHAIN[:2], grounded="ad"))
    assert made.robot is not None
    assert fused(made.robot) == ["world_a", "world_d"]
    assert codes(made) == []
    floating = ExportSettings(fixed_base=False)
    assert codes(build_robot(design(*CHAIN[:2], grounded="ad", settings=floating))) == [
        "several-bases"
    ]
    chosen = ExportSettings(fixed_base=False, base="a")
    made = build_robot(design(*CHAIN[:2], grounded="ad", settings=chosen))
    assert made.robot is not None
    assert made.robot.joints[0].type == "free"
    assert fused(made.robot) == ["world_d"]


def test_two_roots_without_ground_are_an_error() -> None:
    made = build_robot(design(CHAIN[0], CHAIN[2]))
    assert codes(made) == ["several-bases"]
    assert "'a', 'c'" in made.findings[0].message


def test_unconnected_links_are_reported() -> None:
    made = build_robot(design(CHAIN[0], CHAIN[2], grounded="a"))
    assert codes(made) == ["link-not-connected"]
    assert "'c'" in made.findings[0].message
    assert "'d'" in made.findings[0].message


def test_a_closed_loop_names_its_joints_and_one_can_be_cut() -> None:
    snapshot = design(*LOOP, grounded="a")
    made = build_robot(snapshot)
    assert made.robot is not None
    assert codes(made) == ["closed-loop"]
    assert made.loops == (("ab", "bc", "cd", "da"),)
    for name in made.loops[0]:
        assert repr(name) in made.findings[0].message
        cut = build_robot(replace(snapshot, settings=ExportSettings(cut_joints=(name,))))
        assert codes(cut) == []
        assert cut.loops == made.loops
        assert len(tree(cut)) == 4
        assert name not in [j[0] for j in tree(cut)]
        assert cut.robot is not None
        assert [loop.name for loop in cut.robot.loops] == [name]


def test_two_loops_are_two_findings_without_other_joints() -> None:
    ends = ("e", "f")
    snapshot = design(
        *LOOP, joint("ac", "a", "c"), joint("ae", "e", "a"), joint("ef", "f", "e"),
        grounded="a", links=(*NAMES, *ends),
    )  # fmt: skip
    made = build_robot(snapshot)
    assert codes(made) == ["closed-loop"] * 2
    assert all("ae" not in loop and "ef" not in loop for loop in made.loops)


def test_a_loop_without_ground_has_no_base() -> None:
    assert codes(build_robot(design(*LOOP))) == ["no-base", "closed-loop"]


def test_an_unknown_joint_to_cut_is_reported() -> None:
    made = build_robot(design(*CHAIN, settings=ExportSettings(cut_joints=("EXPORT_bd",))))
    assert codes(made) == ["unknown-cut-joint"]


def test_a_cut_joint_may_be_broken() -> None:
    broken = replace(LOOP[3], problem="Lost")
    made = build_robot(design(*CHAIN, broken, settings=ExportSettings(cut_joints=("da",))))
    assert codes(made) == ["cut-joint"]


def test_redundant_rigid_joints_are_not_exported() -> None:
    made = build_robot(
        design(
            *CHAIN[:2],
            rigid("cd", "d:1", "c:1"),
            rigid("dc", "c:1", "d:1"),
            groups=(GroupSnapshot("Rigid Group1", ("c:1", "d:1")),),
            grounded="a",
        )
    )
    assert made.robot is not None
    assert fused(made.robot) == ["world_a", "cd"]
    assert codes(made) == []


def test_rigid_groups_hold_components_together() -> None:
    made = build_robot(
        design(*CHAIN[:1], groups=(GroupSnapshot("Group", ("d:1", "c:1", "b:1")),), grounded="a")
    )
    assert tree(made)[2:] == [("Group_c", "b", "c"), ("Group_d", "b", "d")]
    assert codes(made) == []


def test_joints_are_in_the_order_of_their_names() -> None:
    made = build_robot(
        design(*CHAIN[:1], groups=(GroupSnapshot("a group", ("a:1", "c:1")),), links=NAMES[:3])
    )
    assert [name for name, _, _ in tree(made)] == ["world_a", "a group", "ab"]


def test_a_joint_between_a_grounded_link_and_the_world_is_reported() -> None:
    made = build_robot(design(*CHAIN, revolute("ground", "a:1", ""), grounded="a"))
    assert codes(made) == ["joint-to-ground"]
    cut = ExportSettings(cut_joints=("ground",))
    assert codes(
        build_robot(design(*CHAIN, revolute("ground", "a:1", ""), grounded="a", settings=cut))
    ) == ["cut-joint"]
    rigidly = build_robot(design(*CHAIN, rigid("ground", "a:1", ""), grounded="a"))
    assert tree(rigidly)[0] == ("ground", "world", "a")
    assert codes(rigidly) == []


def test_a_floating_base_has_no_joint_to_the_world() -> None:
    floating = ExportSettings(fixed_base=False)
    made = build_robot(design(*CHAIN, revolute("ground", "b:1", ""), settings=floating))
    assert codes(made) == ["joint-to-ground"]
    assert tree(made)[0] == ("world_b", "world", "b")


def test_two_joints_to_the_world_are_a_loop() -> None:
    grounded = (revolute("g1", "a:1", ""), revolute("g2", "d:1", ""))
    for settings in (ExportSettings(), ExportSettings(base="a")):
        made = build_robot(design(*CHAIN, *grounded, settings=settings))
        assert codes(made) == ["closed-loop"]
        assert made.loops == (("ab", "bc", "cd", "g1", "g2"),)
        assert tree(made)[:2] == [("g1", "world", "a"), ("g2", "world", "d")]
    cut = build_robot(design(*CHAIN, *grounded, settings=ExportSettings(cut_joints=("g2",))))
    assert codes(cut) == []
    assert cut.robot is not None
    assert [(loop.parent, loop.child) for loop in cut.robot.loops] == [("world", "d")]


def test_the_bodies_of_the_root_are_a_grounded_link() -> None:
    root = body("", box((0.1, 0.1, 0.1)), name="Plate")
    snapshot = design(*CHAIN, revolute("ground", "a:1", ""))
    made = build_robot(replace(snapshot, bodies=(*snapshot.bodies, root)))
    assert tree(made)[:2] == [("world_base", "world", "base"), ("ground", "base", "a")]
    assert codes(made) == []


def test_a_grounded_component_without_link_is_the_world() -> None:
    snapshot = arm()
    table = part("table:1", grounded=True)
    made = build_robot(
        replace(
            snapshot,
            occurrences=(table, *(replace(o, grounded=False) for o in snapshot.occurrences)),
            joints=(*snapshot.joints, revolute("turntable", "base:1", "table:1")),
        )
    )
    assert tree(made)[0] == ("turntable", "world", "base")
    assert codes(made) == []


def test_a_fixed_joint_to_the_world_gets_an_unused_name() -> None:
    made = build_robot(design(joint("world_a", "b", "a"), links=("a", "b"), grounded="a"))
    assert [name for name, _, _ in tree(made)] == ["world_a_", "world_a"]


@pytest.mark.parametrize("groups", [True, False])
def test_children_of_a_link_component_belong_to_the_link(groups: bool) -> None:
    snapshot = arm()
    inner = (part("lower:1+hand:1", "lower:1"), part("lower:1+hand:1+nail:1", "lower:1+hand:1"))
    snapshot = replace(snapshot, occurrences=(*snapshot.occurrences, *inner))
    snapshot = snapshot if groups else replace(snapshot, groups=())
    assert link_of(snapshot)["lower:1+hand:1+nail:1"] == "lower"
    nested = replace(snapshot, groups=(*snapshot.groups, group("hand", "lower:1+hand:1")))
    if groups:
        assert link_of(nested)["lower:1+hand:1"] == "hand"
        assert link_of(nested)["lower:1+hand:1+nail:1"] == "hand"


def test_repeated_components_are_separate_links() -> None:
    paths = ("hand:1", "hand:1+finger:1", "hand:1+finger:2", "hand:2", "hand:2+finger:1")
    occurrences = tuple(part(p, p.rpartition("+")[0]) for p in paths)
    snapshot = DesignSnapshot(
        "hands", ExportSettings(components=paths, links="components"), occurrences
    )
    assert link_of(snapshot) == {
        "hand:1": "hand",
        "hand:1+finger:1": "hand_finger",
        "hand:1+finger:2": "finger_2",
        "hand:2": "hand_2",
        "hand:2+finger:1": "hand_2_finger",
    }


def test_chosen_components_are_paths_or_unique_names() -> None:
    paths = ("hand:1", "hand:1+finger:1", "hand:1+finger:2", "foot:1")
    occurrences = tuple(part(p, p.rpartition("+")[0]) for p in paths)

    def chosen(*texts: str) -> DesignSnapshot:
        return DesignSnapshot("robot", ExportSettings(components=texts), occurrences)

    expected = {"hand:1", "hand:1+finger:1", "hand:1+finger:2"}
    assert link_of(chosen("hand", "finger:2")).keys() == expected
    found = build_robot(chosen("finger", "foot")).findings
    (message,) = (f.message for f in found if f.code == "unknown-component")
    assert "'hand:1+finger:1', 'hand:1+finger:2' have this name; use a path" in message


def test_links_with_equal_names_are_reported() -> None:
    occurrences = (part("a:2"), replace(part("b:1"), component="a_2"))
    snapshot = DesignSnapshot("two", occurrences=occurrences, bodies=(body("a:2"), body("b:1")))
    assert "duplicate-link" in codes(build_robot(snapshot))


def test_only_the_chosen_components_are_links() -> None:
    expected = ExportSettings(links="components", components=("a:1", "b:1"))
    made = build_robot(design(*CHAIN, settings=expected))
    assert [name for name, _, _ in tree(made)] == ["world_a", "ab"]
    assert codes(made) == ["joint-outside-links", "body-in-no-link", "body-in-no-link"]


def test_names_of_the_design_are_unchanged() -> None:
    snapshot = arm(
        groups=(group("base"), group("Oberarm (links) <é>", "upper:1"), group("a_0", "lower:1")),
        joints=(
            revolute("EXPORT_Schulter & co", "upper:1", "base:1"),
            revolute("関節 1", "lower:1", "upper:1", origin_one=(0.4, 0, 0), origin_two=None),
        ),
        points=(),
        muscles=(),
    )
    made = build_robot(snapshot)
    assert [name for name, _, _ in tree(made)] == ["world_base", "Schulter & co", "関節 1"]
    assert made.robot is not None
    assert {link.name for link in made.robot.links} == {"base", "Oberarm (links) <é>", "a_0"}


@pytest.mark.slow
@given(st.integers(0, 10_000), st.sampled_from(["", "a", "ad", "bc"]), st.booleans(), st.booleans())
def test_findings_do_not_depend_on_the_order_of_creation(
    seed: int, grounded: str, loop: bool, fixed: bool
) -> None:
    joints = (*(LOOP if loop else CHAIN), joint("ac", "a", "c"), revolute("g", "b:1", ""))
    snapshot = design(
        *joints,
        grounded=grounded,
        groups=(GroupSnapshot("Group", ("d:1", "b:1")),),
        settings=ExportSettings(fixed_base=fixed),
    )
    assert build_robot(shuffled(snapshot, seed)) == build_robot(snapshot)


def test_joints_have_damping_friction_spring_and_effort_of_the_design() -> None:
    """The values also apply to a joint that is exported in reverse direction."""
    how = {"damping": 0.3, "friction": 0.2, "stiffness": 5.0, "rest": 0.1, "effort": 7.0}
    for ends in (("upper:1", "base:1"), ("base:1", "upper:1")):
        shoulder = revolute("shoulder", *ends)
        turns = replace(shoulder.motions[0], **how)
        design = arm(joints=(replace(shoulder, motions=(turns,)), arm().joints[1]))
        robot = build_robot(design).robot
        assert robot is not None
        made, elbow = robot.coordinates
        assert (made.damping, made.friction, made.stiffness, made.rest) == (0.3, 0.2, 5.0, 0.1)
        assert (made.tau_min, made.tau_max) == (-7.0, 7.0)
        assert (elbow.damping, elbow.tau_max) == (0.0, float("inf"))


def test_a_coupling_relates_the_coordinates(tmp_path: Path) -> None:
    """The arm has one independent coordinate, q_elbow = 2 q_shoulder + 0.1, also in its file."""
    design = arm(couplings=(CouplingSnapshot("elbow", "shoulder", 2.0, 0.1),))
    export_robot(design, tmp_path / "arm")
    for robot in (build_robot(design).robot, read_robot(tmp_path / "arm")):
        assert robot is not None
        assert [c.name for c in robot.coordinates] == ["shoulder"]
        assert all_values(robot, {"shoulder": 0.3}) == pytest.approx(
            {"shoulder": 0.3, "elbow": 0.7}
        )


@pytest.mark.parametrize("jointed", [False, True])
def test_automatic_grounding_has_low_precedence(jointed: bool) -> None:
    """The first component is b; the user has grounded a, or joined it to the root."""
    first, *others = design(CHAIN[0], links=("b", "a"), grounded="" if jointed else "a").occurrences
    more = [joint("wrist", "a", "")] if jointed else []
    occurrences = (replace(first, ground_to_parent=True), *others)
    made = build_robot(design(CHAIN[0], *more, links=("b", "a"), occurrences=occurrences))
    assert codes(made) == ["ground-ignored"]
    assert tree(made)[-1] == ("ab", "a", "b")
    alone = build_robot(
        design(CHAIN[0], links=("b", "a"), occurrences=(occurrences[0], part("a:1")))
    )
    assert codes(alone) == []
    assert alone.base == "b"
