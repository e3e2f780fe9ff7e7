from __future__ import annotations

import math
from dataclasses import replace

import pytest
from support.robots.robots import planar_2r

from addin_sdfusion.robot import (
    WORLD,
    BasePulley,
    CableModel,
    CableSet,
    InputError,
    Mesh,
    Pose,
    RobotError,
    TaskFrame,
    TaskSet,
    Trajectory,
    TrajectoryPoint,
    Wrap,
    WrapSurface,
    caspr_losses,
    prismatic,
    read_robot,
    revolute,
    write_caspr,
)

ROBOT = planar_2r()


def with_joint(**changes):
    return replace(ROBOT, joints=(ROBOT.joints[0], replace(ROBOT.joints[1], **changes)))


def with_coordinate(**changes):
    return with_joint(coordinates=(replace(ROBOT.coordinates[1], **changes),))


def with_muscle(**changes):
    return ROBOT.with_muscles([replace(ROBOT.muscles[0], **changes), *ROBOT.muscles[1:]])


def with_frames(*frames):
    return replace(ROBOT, task_sets=(TaskSet("tip", frames),))


def two_motions(first, second):
    a, b = ROBOT.coordinates
    return with_joint(
        motions=(*revolute((1, 0, 0)), replace(revolute((0, 1, 0))[0], coordinate=1)),
        coordinates=(replace(a, name="a", actuated=first), replace(b, actuated=second)),
    )


SLIDE = (*revolute((0.0, 1.0, 0.0)), replace(prismatic((0.0, 0.0, 1.0))[0], coordinate=1))
SCREW = with_joint(
    motions=SLIDE,
    coordinates=(ROBOT.coordinates[1], replace(ROBOT.coordinates[1], name="slide", unit="m")),
)
HALF = BasePulley(
    "screw", (("pulley_radius", (0.1,)), ("cable_pulley_entry_vector", (0.0, 0.0, 1.0)))
)

ERRORS = {
    "caspr-gravity": replace(ROBOT, gravity=(0.0, 0.0, 0.0)),
    "caspr-fixed-joint": with_joint(motions=(), coordinates=()),
    "caspr-joint-type": SCREW,
    "caspr-turned-frame": with_joint(T_parent_joint=Pose(rpy=(0.1, 0.0, 0.0))),
    "caspr-link-frame": with_joint(T_child_joint=Pose((0.1, 0.0, 0.0))),
    "caspr-mixed-actuation": two_motions(True, False),
    "caspr-cable-property": with_muscle(model=CableModel("linear_spring")),
    "caspr-pulley-property": with_muscle(pulley=HALF),
}

BALL = WrapSurface("ball", "link_1", "sphere", 0.1)
TURN = TaskFrame("turn", "link_1", (0.0, 0.0, 1.0), ("beta",))
MESHED = replace(ROBOT.links[0], meshes=(Mesh("visual", "link.stl"),))

WARNINGS = {
    "caspr-joint-names": with_joint(name="elbow"),
    "caspr-damping": with_coordinate(damping=1.0),
    "caspr-motor-bounds": with_coordinate(tau_max=1.0),
    "caspr-meshes": replace(ROBOT, links=(MESHED, ROBOT.links[1])),
    "caspr-infinite-force": with_muscle(f_max=math.inf),
    "caspr-cable-property": with_muscle(model=CableModel("ideal", (("colour", 1.0),))),
    "caspr-one-item-a-link": with_frames(
        TaskFrame("a", "link_2", axes=("x",)), TaskFrame("b", "link_2", axes=("z",))
    ),
    "caspr-orientation-point": with_frames(TURN),
    "caspr-id": replace(ROBOT, cable_sets=(CableSet("my set", ROBOT.muscles),), cable_set="my set"),
}


def reported(robot, trajectories=()):
    return [(f.severity, f.code) for f in caspr_losses(robot, trajectories)]


def test_example_has_no_losses():
    assert caspr_losses(ROBOT) == []


@pytest.mark.parametrize("code", ERRORS)
def test_unsupported_features_of_caspr_are_errors(code, tmp_path):
    assert ("error", code) in reported(ERRORS[code])
    with pytest.raises(RobotError, match=r"(?i)caspr"):
        write_caspr(ERRORS[code], tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("code", WARNINGS)
def test_omitted_features_are_warnings(code, tmp_path):
    assert reported(WARNINGS[code]) == [("warning", code)]
    write_caspr(WARNINGS[code], tmp_path)
    assert read_robot(tmp_path).name == ROBOT.name


def test_all_changed_names_are_listed():
    robot = replace(ROBOT, links=(replace(ROBOT.links[0], end=None), ROBOT.links[1]))
    coordinate = replace(ROBOT.coordinates[1], name="bend")
    elbow = replace(ROBOT.joints[1], name="elbow", coordinates=(coordinate,))
    robot = replace(robot, joints=(ROBOT.joints[0], elbow))
    assert [finding.message for finding in caspr_losses(robot)] == [
        "robot 'planar_2r': CASPR requires far ends of links, for drawing; 0 0 0 is written for "
        "'link_1'",
        "robot 'planar_2r': CASPR does not name joints and coordinates; 'elbow' becomes joint_2, "
        "'bend' becomes joint_2",
    ]


def test_wraps_are_omitted_and_cables_are_straight(tmp_path):
    robot = replace(with_muscle(wraps=(Wrap("ball", 0),)), wrap_surfaces=(BALL,))
    assert reported(robot) == [("warning", "caspr-wrap")] * 2
    write_caspr(robot, tmp_path)
    assert read_robot(tmp_path) == ROBOT


def test_findings_name_their_subject_in_one_line():
    for robot in (*ERRORS.values(), *WARNINGS.values()):
        for finding in caspr_losses(robot):
            assert finding.message.startswith(finding.subject.kind.replace("_", " "))
            assert "\n" not in str(finding)


def trajectory(name="t", size=2, spline="linear", space="joint", times=(0.0, 1.0)):
    still = (0.0,) * size
    count = {"linear": 1, "cubic": 2, "quintic": 3, "samples": 3}[spline]
    points = tuple(TrajectoryPoint(time, *(still,) * count) for time in times)
    return Trajectory(name, spline, points, 1.0, space)


@pytest.mark.parametrize(
    ("trajectories", "expected"),
    [
        ([trajectory()], []),
        ([trajectory(size=1)], [("error", "caspr-trajectory-size")]),
        ([trajectory(), trajectory()], [("error", "duplicate-trajectory")]),
        ([trajectory(), trajectory(space="operational")], [("error", "duplicate-trajectory")]),
        ([trajectory(" t")], [("error", "bad-name"), ("warning", "caspr-id")]),
        ([trajectory("1 t")], [("warning", "caspr-id")]),
        ([trajectory(size=3, space="operational")], [("warning", "caspr-trajectory-size")]),
        (
            [trajectory(spline="cubic", space="operational")],
            [("warning", "caspr-operational-spline")],
        ),
        ([trajectory(spline="samples", times=(0.0, 1.5))], [("error", "caspr-sample-times")]),
    ],
)
def test_trajectories_are_checked(trajectories, expected):
    assert reported(ROBOT, trajectories) == expected


def test_names_that_are_paths_are_rejected(tmp_path):
    for name in ("../robot", "", "a\\b"):
        with pytest.raises(InputError, match="file name"):
            write_caspr(ROBOT, tmp_path, name=name)


def test_doctype_path_leads_to_the_templates(tmp_path):
    folder = tmp_path / "models" / "CARDSFlow/planar_2r"
    for file in write_caspr(ROBOT, folder):
        path = file.read_text().split('SYSTEM "')[1].split('"')[0]
        assert (folder / path).resolve().parent == (tmp_path / "templates").resolve()


def test_written_xml_has_no_comments_and_single_spaces(tmp_path):
    via = tuple(replace(p, position=(1e-9, -0.0, 1e300)) for p in ROBOT.muscles[0].via_points)
    assert via[0].link == WORLD
    for file in write_caspr(with_muscle(via_points=via), tmp_path, trajectories=[trajectory()]):
        text = file.read_text()
        assert "<!--" not in text
        assert "<!DOCTYPE " in text
        assert not any("  " in line.strip() or "\t" in line for line in text.splitlines())
