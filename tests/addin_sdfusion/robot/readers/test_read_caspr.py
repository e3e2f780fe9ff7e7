from __future__ import annotations

import math
import re
import shutil
from pathlib import Path

import pytest

from addin_sdfusion.robot import WORLD, UnknownNameError, read_robot, revolute
from addin_sdfusion.robot.formats.read import read

EXAMPLE = Path(__file__).parents[4] / "examples/planar_2r/robot"


@pytest.fixture
def planar(shared):
    return shared / "robots/caspr/Example_2R_planar_XZ/Example_2R_planar_XZ_bodies.xml"


@pytest.fixture
def arm(shared):
    return read_robot(shared / "robots/caspr/RoboyLeftArm")


def points(muscle):
    return [(point.link, pytest.approx(point.position)) for point in muscle.via_points]


def test_planar_arm_has_two_links_that_rotate_about_y(planar):
    robot = read_robot(planar)
    assert robot.name == "Example_2R_planar_XZ"
    assert [link.name for link in robot.links] == ["R_Y 1", "R_Y 2"]
    assert [joint.name for joint in robot.joints] == ["joint_1", "joint_2"]
    assert [joint.motions for joint in robot.joints] == [revolute((0, 1, 0))] * 2
    assert [joint.parent for joint in robot.joints] == [WORLD, "R_Y 1"]
    assert robot.joints[1].T_parent_joint.position == (0, 0, 1)
    assert [(c.name, c.lower, c.upper, c.unit) for c in robot.coordinates] == [
        ("joint_1", -3.1416, 3.1416, "rad"),
        ("joint_2", -3.1416, 3.1416, "rad"),
    ]
    for link in robot.links:
        assert (link.inertia.mass, link.inertia.com, link.end) == (0.1, (0, 0, 0.5), (0, 0, 1))
        assert (link.inertia.ixx, link.inertia.iyy, link.inertia.izz) == (0.083333, 0, 0.083333)


def test_points_relative_to_centre_of_mass_are_moved_to_link_frame(planar):
    robot = read_robot(planar)
    assert [muscle.name for muscle in robot.muscles] == [f"cable {i}" for i in (1, 2, 3, 4)]
    assert points(robot.muscles[1]) == [(WORLD, (1.5, 0, 0)), ("R_Y 2", (0.1, 0, 0.8))]
    assert {(m.f_min, m.f_max) for m in robot.muscles} == {(10, 100)}


def test_all_cable_sets_are_read_and_any_can_be_active(planar):
    assert [group.name for group in read_robot(planar).cable_sets] == [
        "basic",
        "basic_multi_segment",
    ]
    robot = read_robot(planar, cable_set="basic_multi_segment")
    assert points(robot.muscles[0]) == [
        (WORLD, (0.5, 0, 0)),
        ("R_Y 1", (0.25, 0, 0.8)),
        ("R_Y 2", (0.15, 0, 0.6)),
    ]


def test_unknown_cable_set_lists_known_ones(planar):
    with pytest.raises(UnknownNameError, match=r"_cables.xml: no cable set 'basik'.*'basic'"):
        read_robot(planar, cable_set="basik")


def test_first_operational_space_is_active_without_default(planar):
    (frame,) = read_robot(planar).task_frames
    assert (frame.name, frame.link, frame.position) == ("test1", "R_Y 2", (0, 0, 1))
    assert frame.axes == ("x", "z")


def test_only_zero_inertia_about_the_axis_is_reported(planar):
    reading = read(planar)
    assert {(f.severity, f.code) for f in reading.findings} == {
        ("warning", "zero-inertia-about-axis")
    }
    assert [f.line for f in reading.findings] == [6, 26]
    assert [file.name.removeprefix("Example_2R_planar_XZ_") for file in reading.files] == [
        "bodies.xml",
        "cables.xml",
        "operational_spaces.xml",
    ]


def test_axes_are_normalised_and_keep_their_direction(arm):
    given = [
        (0.05101, -0.9984, 0.02231),
        (-0.9157, -0.03784, 0.4001),
        (-0.3986, -0.04084, -0.9162),
        (0.9171, -0.01288, -0.3984),
    ]
    for joint, axis in zip(arm.joints, given, strict=True):
        assert math.hypot(*joint.motions[0].axis) == pytest.approx(1, abs=1e-15)
        assert joint.motions[0].axis == pytest.approx(axis, abs=1e-4)


def test_arm_has_its_limits_masses_and_positions(arm):
    assert [(c.initial, c.lower, c.upper) for c in arm.coordinates] == [
        (1.2, 1.2, 1.7),
        (0, -3.142, 3.142),
        (0, -0.5, 0.5),
        (-0.5, -1.57, 0),
    ]
    assert [link.inertia.mass for link in arm.links] == [0.001, 0.001, 1, 1]
    assert arm.link("lower_arm_left").inertia.com == (-0.03277, 0.004782, -0.1547)
    assert arm.joints[0].T_parent_joint.position == (0.2926, 0.007368, 0.5479)
    assert arm.joints[3].T_parent_joint.position == (-0.1399, -0.01744, -0.277)


def test_arm_has_its_cables_in_file_order(arm):
    names = [f"motor{i}" for i in (*range(9), 10, 9)]
    assert [muscle.name for muscle in arm.muscles] == names
    assert {(m.f_min, m.f_max) for m in arm.muscles} == {(10, 5000)}
    assert points(arm.muscle("motor4")) == [
        (WORLD, (0.3034, 7.361e-16, 0.5961)),
        ("upper_arm_left", (0.06348 - 0.05912, 0.005441 - 0.006673, 0.1036 - 0.1688)),
    ]
    assert points(arm.muscle("motor9"))[1] == (
        "lower_arm_left",
        (0.0406 - 0.03277, 0.03544 + 0.004782, 0.1295 - 0.1547),
    )


def test_arm_has_its_stick_tip(arm):
    (frame,) = arm.task_frames
    assert (frame.link, frame.position) == ("lower_arm_left", (-0.15492, -0.254225, -0.386772))
    assert frame.axes == ("x", "y", "z")


def edited(tmp_path, ending, old, new):
    folder = tmp_path / "robot"
    shutil.copytree(EXAMPLE, folder)
    file = folder / f"planar_2r_{ending}.xml"
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    return folder


def test_inertia_about_the_joint_is_moved_to_the_centre_of_mass(tmp_path):
    old = '"com">\n          <Ixx>0.083333</Ixx>\n          <Iyy>0.0</Iyy>'
    new = '"joint">\n          <Ixx>0.108333</Ixx>\n          <Iyy>0.025</Iyy>'
    inertia = read_robot(edited(tmp_path, "bodies", old, new)).links[0].inertia
    moments = (inertia.ixx, inertia.iyy, inertia.izz)
    assert moments == pytest.approx((0.083333, 0.0, 0.083333), abs=1e-15)
    assert (inertia.ixy, inertia.ixz, inertia.iyz) == (0, 0, 0)


def test_points_on_the_base_are_absolute_for_any_reference(tmp_path):
    folder = edited(
        tmp_path, "cables", 'attachment_reference="joint"', 'attachment_reference="com"'
    )
    first, second = read_robot(folder).muscles[0].via_points
    assert first.position == (0.5, 0.0, 0.0)
    assert second.position == (0.1, 0.0, 1.3)


@pytest.mark.parametrize(
    ("type_", "kind", "axis"),
    [
        ('"R_X"', "revolute", (1, 0, 0)),
        ('"R_Z"', "revolute", (0, 0, 1)),
        ('"R_AXIS" axis="0 3 4"', "revolute", (0, 0.6, 0.8)),
        ('"P_X"', "prismatic", (1, 0, 0)),
        ('"P_AXIS" axis="0 0 -2"', "prismatic", (0, 0, -1)),
    ],
)
def test_joint_types_have_their_axes_and_units(tmp_path, type_, kind, axis):
    joint = read_robot(edited(tmp_path, "bodies", '"R_Y"', type_)).joints[0]
    assert (joint.type, joint.motions[0].axis) == (kind, axis)
    assert joint.coordinates[0].unit == ("m" if kind == "prismatic" else "rad")


def test_set_with_unknown_cables_is_omitted_or_an_error_if_active(tmp_path):
    folder = edited(tmp_path, "cables", '"basic">\n    <cable_ideal', '"basic">\n    <cable_odd')
    file = folder / "planar_2r_cables.xml"
    text = file.read_text().replace("</cable_ideal>", "</cable_odd>", 1)
    file.write_text(text.replace('default_cable_set="basic"', 'default_cable_set="basic_2018_07"'))
    reading = read(folder)
    (finding,) = [f for f in reading.findings if f.code == "unsupported-cable"]
    assert (finding.severity, finding.subject) == ("warning", ("cable_set", "basic"))
    assert (finding.file, finding.line) == (file, 5)
    assert "basic" not in [group.name for group in reading.robot.cable_sets]
    reading = read(folder, cable_set="basic")
    assert reading.robot is None
    (finding,) = [f for f in reading.findings if f.is_error]
    assert finding.code == "unsupported-cable"
    assert "; choose another cable set: 'basic_multi_segment', " in finding.message


def test_cables_and_operational_spaces_are_optional(tmp_path):
    shutil.copy(EXAMPLE / "planar_2r_bodies.xml", tmp_path)
    reading = read(tmp_path)
    assert reading.robot.muscles == reading.robot.task_frames == ()
    assert "no-muscles" in {finding.code for finding in reading.findings}
    assert reading.files == (tmp_path / "planar_2r_bodies.xml",)


def with_items(tmp_path, items):
    """Return the example with these items on its second link in its operational space."""
    old = (EXAMPLE / "planar_2r_operational_spaces.xml").read_text()
    start, end = old.index("<position"), old.index("</operational_set>")
    return edited(tmp_path, "operational_spaces", old[start:end], items)


def item(tag, letters, name="hand"):
    return (
        f'<{tag} name="{name}"><link>2</link><offset>0 0 1</offset>'
        f'<axes active_axes="{letters}"/></{tag}>'
    )


def test_unknown_operational_items_are_omitted_with_a_warning(tmp_path):
    folder = with_items(tmp_path, '<twist name="turn"/>\n' + item("position", "zx"))
    reading = read(folder)
    assert [(f.name, f.axes) for f in reading.robot.task_frames] == [("hand", ("z", "x"))]
    assert "unsupported-task" in {finding.code for finding in reading.findings}


@pytest.mark.parametrize(
    ("tag", "letters", "frames"),
    [
        ("orientation_euler_xyz", "abg", [("hand", 0, ("alpha", "beta", "gamma"))]),
        ("orientation_euler_xyz", "ga", [("hand", 0, ("gamma", "alpha"))]),
        ("pose_euler_xyz", "xzb", [("hand", 1, ("x", "z")), ("hand_orientation", 0, ("beta",))]),
        ("pose_euler_xyz", "y", [("hand", 1, ("y",))]),
        ("pose_euler_xyz", "a", [("hand", 0, ("alpha",))]),
    ],
)
def test_orientations_and_poses_become_task_frames(tmp_path, tag, letters, frames):
    reading = read(with_items(tmp_path, item(tag, letters)))
    assert ("pose-angles" in {f.code for f in reading.findings}) == (len(frames) == 2)
    robot = reading.robot
    assert [(f.name, f.position[2], f.axes) for f in robot.task_frames] == frames
    assert {f.link for f in robot.task_frames} == {"link_2"}


@pytest.mark.parametrize(
    ("tag", "letters", "severity", "code"),
    [
        ("position", "xa", "error", "bad-task-axes"),
        ("position", "xx", "error", "bad-task-axes"),
        ("position", "", "error", "bad-task-axes"),
        ("orientation_euler_xyz", "x", "error", "bad-task-axes"),
        ("pose_euler_xyz", "q" * 1000, "error", "bad-task-axes"),
        ("pose_euler_xyz", "ax", "warning", "task-order"),
    ],
)
def test_invalid_axes_are_reported_with_their_line(tmp_path, tag, letters, severity, code):
    reading = read(with_items(tmp_path, "\n" + item(tag, letters)))
    reported = [(f.severity, f.code, f.line) for f in reading.findings if "task" in f.code]
    assert reported == [(severity, code, 6)]
    assert all(len(str(f)) < 400 for f in reading.findings)


OLD = (
    '<operational_spaces default_operational_set="old"><operational_set id="old">'
    + item("position", "xyz")
    + "</operational_set></operational_spaces></bodies_system>"
)


def test_operational_spaces_in_the_bodies_file_are_read_if_the_other_file_is_missing(tmp_path):
    folder = edited(tmp_path, "bodies", "</bodies_system>", OLD)
    reading = read(folder)
    assert reading.robot.task_set == "tip"
    messages = [f.message for f in reading.findings if f.code == "old-operational-spaces"]
    assert len(messages) == 1
    assert "ignored" in messages[0]
    (folder / "planar_2r_operational_spaces.xml").unlink()
    reading = read(folder)
    assert reading.robot.task_set == "old"
    assert "old-operational-spaces" in {finding.code for finding in reading.findings}


def test_older_bodies_files_are_read_with_a_warning(tmp_path):
    folder = edited(tmp_path, "bodies", ' q_min="-3.1416" q_max="3.1416"', "")
    file = folder / "planar_2r_bodies.xml"
    file.write_text(re.sub("</?bodies_system>|<!DOCTYPE[^>]*>", "", file.read_text()))
    reading = read(folder)
    first, second = reading.require().coordinates
    assert (first.lower, first.upper) == (-math.inf, math.inf)
    assert (second.lower, second.upper) == (-3.1416, 3.1416)
    old = [(f.severity, f.code, f.subject.name) for f in reading.findings]
    assert ("warning", "old-bodies", "planar_2r") in old
    assert ("warning", "no-limits", "joint_1") in old
    assert ("warning", "no-limits", "joint_2") not in old


SPRING = "<K>100</K><l0>0.5</l0>"
TORSION = "<K_cable>1e4</K_cable><num_torsion_springs>2</num_torsion_springs>"
TORSION += "<torsion_spring_stiffness>3</torsion_spring_stiffness>"
TORSION += "<torsion_spring_length>0.1</torsion_spring_length>"
FLEXURE = "<K_cable>3e9</K_cable>"
FLEXURE += "<vsd_force_deformation_relation>7 -8 9</vsd_force_deformation_relation>"
POLYNOMIAL = "<K_cable>4e4</K_cable><num_stiffness_polynomial_coeff>2"
POLYNOMIAL += "</num_stiffness_polynomial_coeff><stiffness_poly_coeff>5 6</stiffness_poly_coeff>"


def with_first_cable(tmp_path, tag, properties, first=""):
    """Return the example with another first cable, or another first attachment of it."""
    old = (EXAMPLE / "planar_2r_cables.xml").read_text()
    start, end = old.index("<cable_ideal"), old.index("</cable_ideal>")
    cable = old[start:end]
    new = cable.replace("<cable_ideal", f"<{tag}").replace("</properties>", "\n</properties>")
    new = new.replace("\n</properties>", f"\n{properties}</properties>")
    if tag == "cable_passive_linear_spring":
        new = new[: new.index("<force_min>")] + new[new.index("</force_max>") + 12 :]
    if first:
        new = new[: new.index("<attachment>")] + first + new[new.index("</attachment>") + 13 :]
    folder = edited(tmp_path, "cables", cable + "</cable_ideal>", f"{new}</{tag}>")
    return read(folder)


@pytest.mark.parametrize(
    ("tag", "properties", "kind", "values"),
    [
        ("cable_ideal", "<diameter>0.002</diameter>", "ideal", [0.002]),
        ("cable_ideal", "<force_error>-1</force_error>", "ideal", [-1]),
        ("cable_linear_spring", "<K>100</K><force_error>-1</force_error>", "linear_spring",
         [100, -1]),
        ("cable_linear_spring", "<K>100</K>", "linear_spring", [100]),
        ("cable_passive_linear_spring", SPRING, "passive_spring", [100, 0.5]),
        ("cable_vsd_torsion_spring", TORSION, "vsd_torsion", [1e4, 2, 3, 0.1]),
        ("cable_vsd_flexure_linear", FLEXURE, "vsd_flexure", [3e9, 7, -8, 9]),
        ("cable_vsd_polynomial", POLYNOMIAL, "vsd_polynomial", [4e4, 2, 5, 6]),
    ],
)  # fmt: skip
def test_all_cable_types_keep_their_properties(tmp_path, tag, properties, kind, values):
    reading = with_first_cable(tmp_path, tag, properties)
    model = reading.robot.muscles[0].model
    assert (model.kind, [value for _, value in model.parameters]) == (kind, values)
    expected: dict[str, set[str]] = {"passive_spring": set(), "ideal": set()}
    codes = {f.code for f in reading.findings if f.subject.kind == "muscle"}
    assert codes == expected.get(kind, {"cable-model-not-simulated"})


def test_passive_spring_has_no_force_limits(tmp_path):
    muscle = with_first_cable(tmp_path, "cable_passive_linear_spring", SPRING).robot.muscles[0]
    assert (muscle.f_min, muscle.f_max) == (0.0, 0.0)
    assert dict(muscle.model.parameters) == {"K": 100.0, "l0": 0.5}


PULLEY = "<base_rotating_pulley><fixed_location>1 2 3</fixed_location><pulley_radius>0.04"
PULLEY += "</pulley_radius><cable_entry_vector>0 0 1</cable_entry_vector></base_rotating_pulley>"
SCREW = "<screw_base_rotating_pulley><constant_winch_point>1 2 3</constant_winch_point>"
SCREW += "<winch_vector>1 0 0</winch_vector><cable_pulley_entry_vector>0 0 1"
SCREW += "</cable_pulley_entry_vector><pulley_radius>0.04</pulley_radius><winch_radius>0.02"
SCREW += "</winch_radius><winch_groove_width>0.001</winch_groove_width>"
SCREW += "</screw_base_rotating_pulley>"


@pytest.mark.parametrize(("element", "kind"), [(PULLEY, "rotating"), (SCREW, "screw")])
def test_pulley_at_the_base_keeps_its_position(tmp_path, element, kind):
    reading = with_first_cable(tmp_path, "cable_ideal", "", element)
    muscle = reading.robot.muscles[0]
    assert points(muscle)[0] == (WORLD, (1, 2, 3))
    assert muscle.pulley.kind == kind
    assert dict(muscle.pulley.parameters)["pulley_radius"] == (0.04,)
    vectors = {"rotating": "cable_entry_vector", "screw": "cable_pulley_entry_vector"}
    assert dict(muscle.pulley.parameters)[vectors[kind]] == (0.0, 0.0, 1.0)
    assert muscle.pulley.entry_vector == (0.0, 0.0, 1.0)
    found = {f.code: f.message for f in reading.findings if f.subject.kind == "muscle"}
    assert found.keys() == ({"winch-travel-left-out"} if kind == "screw" else set())
    if kind == "screw":  # 1 mm per revolution of 2 pi 20 mm
        assert "0.00796 m per metre of cable" in found["winch-travel-left-out"]


@pytest.mark.parametrize(
    ("tag", "properties", "first", "severity", "code"),
    [
        ("muscle_hill_type", "", "", "error", "unsupported-cable"),
        ("pneumatic_artificial_muscle", "", "", "error", "unsupported-cable"),
        ("cable_ideal", "", "<hook/>", "error", "unsupported-cable"),
        ("cable_ideal", "", PULLEY * 2, "error", "misplaced-pulley"),
        ("cable_ideal", "<colour>1</colour>", "", "warning", "unknown-property"),
        ("cable_linear_spring", "", "", "error", "missing-element"),
        ("cable_linear_spring", "<K>stiff</K>", "", "error", "bad-number"),
        ("cable_vsd_flexure_linear", FLEXURE.replace("9</", "</"), "", "error", "bad-vector"),
    ],
)
def test_invalid_cable_is_reported(tmp_path, tag, properties, first, severity, code):
    reading = with_first_cable(tmp_path, tag, properties, first)
    found = [f for f in reading.findings if f.code == code]
    assert [f.severity for f in found] == [severity]
    assert found[0].file.name == "planar_2r_cables.xml"
    assert found[0].line >= 5
