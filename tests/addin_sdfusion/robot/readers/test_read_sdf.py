from __future__ import annotations

import math
from itertools import pairwise

import pytest

from addin_sdfusion.robot import IDENTITY, WORLD, UnknownNameError, read_robot
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.model.rotations import apply, compose, inverse, rotate, rotation

LINK = (
    '<link name="{name}">{pose}<inertial><mass>1</mass><inertia>'
    "<ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>"
)
MUSCLE = (
    '<myoMuscle name="{name}"><link name="base"><viaPoint type="FIXPOINT">1 0 0</viaPoint></link>'
    '<link name="arm"><viaPoint type="FIXPOINT">0 0 1</viaPoint></link></myoMuscle>'
)
AXIS = "<axis><xyz{attribute}>{xyz}</xyz>{more}</axis>"


def link(name, pose=""):
    return LINK.format(name=name, pose=pose)


def joint(xyz="0 0 1", pose="", attribute="", more="", type_="revolute"):
    axis = AXIS.format(xyz=xyz, attribute=attribute, more=more)
    return (
        f'<joint name="elbow" type="{type_}">{pose}<parent>base</parent><child>arm</child>'
        f"{axis}</joint>"
    )


def write(folder, *parts, version="1.7"):
    body = "\n".join(parts)
    text = f'<sdf version="{version}"><model name="robot">\n{body}\n</model></sdf>'
    (folder / "model.sdf").write_text(text)
    return folder


def zero_pose(robot):
    """Return the poses of the links at q = 0, by the definition of a joint."""
    poses = {WORLD: IDENTITY}
    for j in robot.joints:
        T_parent_child = compose(j.T_parent_joint, inverse(j.T_child_joint))
        poses[j.child] = compose(poses[j.parent], T_parent_child)
    return poses


def lengths(robot):
    """Return the muscle lengths at q = 0."""
    poses = zero_pose(robot)
    through = (
        [apply(poses[point.link], point.position) for point in muscle.via_points]
        for muscle in robot.muscles
    )
    return [sum(math.dist(a, b) for a, b in pairwise(points)) for points in through]


def world_joint(robot):
    """Return the position of the elbow at q = 0, and its axis."""
    elbow = robot.joint("elbow")
    pose = compose(zero_pose(robot)[elbow.parent], elbow.T_parent_joint)
    return (*pose.position, *rotate(rotation(pose.rpy), elbow.motions[0].axis))


def test_muscle_lengths_agree_with_caspr(shared):
    sdf = read_robot(shared / "robots/cardsflow/roboy_upper_body")
    caspr = read_robot(shared / "robots/caspr/RoboyUpperBody")
    assert len(sdf.coordinates) == len(caspr.coordinates) == 26
    assert len(sdf.muscles) == 38
    assert sorted(lengths(sdf)) == pytest.approx(sorted(lengths(caspr)), abs=2e-4)


BASE = link("base", "<pose>0 0 1 0 0 0.5</pose>")
TURNED = "<pose>1 2 3 0.1 0.2 0.3</pose>"
OFFSET = "<pose>0.1 0.2 0.3 -0.3 0.2 0.1</pose>"


def test_joint_pose_is_relative_to_its_child(tmp_path):
    robot = read_robot(write(tmp_path, BASE, link("arm", TURNED), joint("0 1 0", OFFSET)))
    R = rotation((0.1, 0.2, 0.3))
    x, y, z = rotate(R, (0.1, 0.2, 0.3))
    axis = rotate(R, rotate(rotation((-0.3, 0.2, 0.1)), (0, 1, 0)))
    assert world_joint(robot) == pytest.approx((1 + x, 2 + y, 3 + z, *axis))
    arm = zero_pose(robot)["arm"]
    assert (*arm.position, *arm.rpy) == pytest.approx((1, 2, 3, 0.1, 0.2, 0.3))


def test_model_pose_moves_the_whole_robot(tmp_path):
    robot = read_robot(write(tmp_path, "<pose>0 0 5 0 0 0</pose>", BASE, link("arm"), joint()))
    assert zero_pose(robot)["base"].position == (0, 0, 6)
    assert zero_pose(robot)["arm"].position == pytest.approx((0, 0, 5))


@pytest.mark.parametrize(
    "pose",
    [
        '<pose relative_to="base">{}</pose>',
        '<pose relative_to="mark">{}</pose>',
    ],
)
def test_poses_relative_to_other_frames_are_composed(tmp_path, pose):
    frame = '<frame name="mark" attached_to="base"/>'
    arm = link("arm", pose.format("1 0 0 0 0 0"))
    robot = read_robot(write(tmp_path, BASE, frame, arm, joint()))
    expected = (math.cos(0.5), math.sin(0.5), 1)
    assert zero_pose(robot)["arm"].position == pytest.approx(expected)


@pytest.mark.parametrize(
    ("version", "attribute", "more"),
    [
        ("1.4", "", ""),
        ("1.6", "", "<use_parent_model_frame>1</use_parent_model_frame>"),
        ("1.7", ' expressed_in="__model__"', ""),
        ("1.7", ' expressed_in="level"', ""),
    ],
)
def test_axis_can_be_expressed_in_another_frame(tmp_path, version, attribute, more):
    turned = joint("0 1 0", OFFSET, attribute, more)
    level = '<frame name="level"/>' if "level" in attribute else ""
    folder = write(tmp_path, BASE, link("arm", TURNED), level, turned, version=version)
    assert world_joint(read_robot(folder))[3:] == pytest.approx((0, 1, 0))


def test_rotated_inertial_frame_rotates_the_inertia(tmp_path):
    quarter = math.pi / 2
    text = link("arm").replace("<mass>", f"<pose>1 2 3 0 0 {quarter!r}</pose><mass>")
    text = text.replace("<ixx>1<", "<ixx>0.7<").replace("<iyy>1<", "<iyy>0.6<")
    robot = read_robot(write(tmp_path, link("base"), text, joint()))
    inertia = robot.link("arm").inertia
    assert inertia.com == (1, 2, 3)
    assert (inertia.ixx, inertia.iyy, inertia.izz) == pytest.approx((0.6, 0.7, 1.0))


@pytest.mark.parametrize(
    ("limit", "expected"),
    [
        ("", (-math.inf, math.inf)),
        ("<limit><lower>-1e16</lower><upper>1e16</upper></limit>", (-math.inf, math.inf)),
        ("<limit><lower>-inf</lower><upper>inf</upper></limit>", (-math.inf, math.inf)),
        ("<limit><lower>-1</lower></limit>", (-1, math.inf)),
        ("<limit><lower>-1</lower><upper>2</upper></limit>", (-1, 2)),
    ],
)
def test_missing_or_huge_limits_are_infinite(tmp_path, limit, expected):
    robot = read_robot(write(tmp_path, link("base"), link("arm"), joint(more=limit)))
    assert (robot.coordinates[0].lower, robot.coordinates[0].upper) == expected


def test_damping_and_joint_type_are_read(tmp_path):
    more = "<dynamics><damping>0.5</damping></dynamics>"
    slider = joint(more=more, type_="prismatic")
    robot = read_robot(write(tmp_path, link("base"), link("arm"), slider))
    assert (robot.coordinates[0].damping, robot.coordinates[0].unit) == (0.5, "m")


def test_root_link_is_fixed_to_the_world_with_a_warning(tmp_path):
    reading = read(write(tmp_path, BASE, link("arm"), joint()))
    first = reading.robot.joints[0]
    assert (first.type, first.parent, first.child) == ("fixed", WORLD, "base")
    assert (*first.T_parent_joint.position, *first.T_parent_joint.rpy) == (0, 0, 1, 0, 0, 0.5)
    (finding,) = [f for f in reading.findings if f.code == "welded-root"]
    assert (finding.severity, finding.line) == ("warning", 2)


def test_joints_are_sorted_parents_first_in_file_order(shared):
    robot = read_robot(shared / "robots/cardsflow/msj_platform")
    assert [coordinate.name for coordinate in robot.coordinates] == [
        "sphere_axis0",
        "sphere_axis1",
        "sphere_axis2",
    ]


def plugin(*children):
    return f'<plugin filename="x.so" name="x">{"".join(children)}</plugin>'


def muscle_names(folder, **options):
    return [muscle.name for muscle in read_robot(folder, **options).muscles]


def test_muscles_are_read_from_named_sets_then_cardsflow_xml_then_plugin(tmp_path):
    parts = [link("base"), link("arm"), joint()]
    bare = MUSCLE.format(name="in_plugin")
    write(tmp_path, *parts, plugin(bare))
    assert muscle_names(tmp_path) == ["in_plugin"]
    beside = tmp_path / "cardsflow.xml"
    beside.write_text(f"<cardsflow>{MUSCLE.format(name='beside')}</cardsflow>")
    assert muscle_names(tmp_path) == ["beside"]
    assert read(tmp_path).files == (tmp_path / "model.sdf", beside)
    sets = (
        f'<cable_set id="{name}" active="{active}">{MUSCLE.format(name=name)}</cable_set>'
        for name, active in (("one", "false"), ("two", "true"))
    )
    write(tmp_path, *parts, plugin(*sets, bare))
    assert muscle_names(tmp_path) == ["two"]
    assert muscle_names(tmp_path, cable_set="one") == ["one"]
    with pytest.raises(UnknownNameError, match=r"model.sdf: no cable set 'three'"):
        read_robot(tmp_path, cable_set="three")


def test_end_effectors_become_task_frames(shared):
    robot = read_robot(shared / "robots/cardsflow/test_robot")
    assert robot.task_frames
    assert all(frame.axes == ("x", "y", "z") for frame in robot.task_frames)
