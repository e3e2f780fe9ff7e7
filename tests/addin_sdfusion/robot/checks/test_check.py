from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from support.robots.random_robots import inertias, robots

from addin_sdfusion.robot import (
    WORLD,
    BasePulley,
    CableModel,
    CableSet,
    Coordinate,
    Inertia,
    Joint,
    Link,
    Mesh,
    Muscle,
    Pose,
    Robot,
    RobotError,
    TaskFrame,
    TaskSet,
    ViaPoint,
    Wrap,
    WrapSurface,
    check,
    prismatic,
    require_valid,
    revolute,
)
from addin_sdfusion.robot.checks.masses import density_matrix, positive_semidefinite

NAN = math.nan
SOLID = Inertia(1.0, (0.0, 0.0, 0.5), 0.1, 0.1, 0.1)


def hinge(name, parent, child, **changes):
    values = {
        "motions": revolute((0.0, 1.0, 0.0)),
        "coordinates": (Coordinate(name, -1.0, 1.0),),
    }
    return Joint(name, parent, child, **{**values, **changes})


def cable(name="biceps", start=WORLD, end="arm", **changes):
    points = (ViaPoint(start, (0.3, 0.0, 0.0)), ViaPoint(end, (0.1, 0.0, 0.3)))
    return replace(Muscle(name, points, 1.0, 10.0), **changes)


ROBOT = Robot(
    "robot",
    (Link("arm", SOLID), Link("hand", SOLID)),
    (hinge("elbow", WORLD, "arm"), hinge("wrist", "arm", "hand")),
    (CableSet("a", (cable(),)), CableSet("b", (cable(), cable("triceps")))),
    "a",
    (TaskSet("tip", (TaskFrame("tip", "hand", (0.0, 0.0, 1.0)),)),),
    "tip",
)


def with_joint(**changes):
    return replace(ROBOT, joints=(ROBOT.joints[0], replace(ROBOT.joints[1], **changes)))


def with_coordinate(**changes):
    return with_joint(coordinates=(replace(Coordinate("wrist", -1.0, 1.0), **changes),))


def with_hand(**changes):
    hand = Link("hand", replace(SOLID, **changes))
    return replace(ROBOT, links=(ROBOT.links[0], hand))


def with_cable(**changes):
    return ROBOT.with_muscles([cable(**changes)])


def with_frame(**changes):
    frame = replace(ROBOT.task_frames[0], **changes)
    return replace(ROBOT, task_sets=(TaskSet("tip", (frame,)),))


def with_surfaces(*surfaces):
    return replace(ROBOT, wrap_surfaces=surfaces)


PULLEY = BasePulley("rotating", (("pulley_radius", (0.1,)), ("cable_entry_vector", (0, 0, 1))))


def pulley(**numbers):
    return BasePulley("rotating", (*PULLEY.parameters, *((k, (v,)) for k, v in numbers.items())))


def in_pulley():
    start, end = cable().via_points
    near = tuple(a + b for a, b in zip(start.position, (0.0, 0.05, 0.02), strict=True))
    return (start, replace(start, position=near), end)


def reaching():
    """Return the same robot with a via point on the arm."""
    start, near, _ = in_pulley()
    return (start, replace(near, link="arm"))


SCREW = BasePulley(
    "screw", (("pulley_radius", (0.1,)), ("cable_pulley_entry_vector", (0.0, 0.0, 1.0)))
)
BALL = WrapSurface("ball", "arm", "sphere", 0.1)
BALLS = (
    BALL,
    WrapSurface("near", "arm", "sphere", 0.1, Pose((0.15, 0.0, 0.0))),
    WrapSurface("far", "arm", "sphere", 0.1, Pose((3.0, 0.0, 0.0))),
    WrapSurface("base", WORLD, "sphere", 50.0, Pose((0.0, 0.0, 0.0))),
)


def over_balls(*wraps):
    return replace(with_cable(wraps=wraps), wrap_surfaces=BALLS)


MESH = Mesh("visual", "hand.stl", scale=(1.0, NAN, 1.0))


def twice(items):
    return (*items, items[-1])


ERRORS = {
    "duplicate-link": replace(ROBOT, links=twice(ROBOT.links)),
    "duplicate-joint": replace(ROBOT, joints=twice(ROBOT.joints)),
    "duplicate-coordinate": with_coordinate(name="elbow"),
    "duplicate-cable-set": replace(ROBOT, cable_sets=twice(ROBOT.cable_sets)),
    "duplicate-muscle": ROBOT.with_muscles([cable(), cable()]),
    "duplicate-task-set": replace(ROBOT, task_sets=twice(ROBOT.task_sets)),
    "duplicate-task-frame": replace(ROBOT, task_sets=(TaskSet("tip", twice(ROBOT.task_frames)),)),
    "bad-name": with_coordinate(name=" wrist"),
    "reserved-name": replace(ROBOT, links=(*ROBOT.links, Link(WORLD, SOLID))),
    "unknown-parent": with_joint(parent="amr"),
    "unknown-child": with_joint(child="hnad"),
    "two-parents": replace(ROBOT, joints=(*ROBOT.joints, hinge("extra", WORLD, "hand"))),
    "no-parent": replace(ROBOT, links=(*ROBOT.links, Link("loose", SOLID))),
    "closed-loop": replace(ROBOT, joints=(hinge("a", "hand", "arm"), hinge("b", "arm", "hand"))),
    "joint-order": replace(ROBOT, joints=ROBOT.joints[::-1]),
    "zero-axis": with_joint(motions=revolute((0.0, 0.0, 0.0))),
    "axis-not-unit": with_joint(motions=revolute((0.0, 1.01, 0.0))),
    "wrong-coordinates": with_joint(coordinates=()),
    "wrong-unit": with_coordinate(unit="m"),
    "limits-reversed": with_coordinate(lower=2.0),
    "motor-limits-reversed": with_coordinate(tau_min=2.0, tau_max=1.0),
    "motor-without-torque": with_coordinate(actuated=True, tau_min=0.0, tau_max=0.0),
    "negative-damping": with_coordinate(damping=-1.0),
    "negative-mass": with_hand(mass=-1.0),
    "inertia-not-psd": with_hand(ixy=1.0),
    "no-inertia-about-axis": with_hand(com=(0.0, 0.0, 0.0), iyy=0.0),
    "no-mass-along-axis": replace(
        with_hand(mass=0.0),
        joints=(
            ROBOT.joints[0],
            hinge(
                "wrist",
                "arm",
                "hand",
                motions=prismatic((0.0, 1.0, 0.0)),
                coordinates=(Coordinate("wrist", unit="m"),),
            ),
        ),
    ),
    "too-few-via-points": with_cable(via_points=cable().via_points[:1]),
    "unknown-via-link": with_cable(end="amr"),
    "zero-length-segment": with_cable(via_points=cable().via_points[:1] * 2),
    "negative-force": with_cable(f_min=-1.0),
    "force-limits-reversed": with_cable(f_min=11.0),
    "unknown-cable-set": replace(ROBOT, cable_set="c"),
    "unknown-task-set": replace(ROBOT, task_set="c"),
    "unknown-task-link": with_frame(link="hnad"),
    "empty-task-set": replace(ROBOT, task_sets=(TaskSet("tip", ()),)),
    "passive-cable-force": with_cable(model=CableModel("passive_spring")),
    "unknown-pulley-parameter": with_cable(pulley=pulley(inertai=1e-4)),
    "point-in-pulley": with_cable(via_points=in_pulley(), pulley=PULLEY),
    "pulley-without-winch": with_cable(pulley=pulley(inertia=1e-4)),
    "duplicate-wrap-surface": with_surfaces(BALL, BALL),
    "unknown-wrap-link": with_surfaces(replace(BALL, link="amr")),
    "unknown-wrap-shape": with_surfaces(replace(BALL, shape="bal")),
    "bad-wrap-side": over_balls(Wrap("ball", 0, side=10**20)),
    "bad-wrap-size": with_surfaces(replace(BALL, radius=0.0)),
    "unknown-wrap-surface": with_cable(wraps=(Wrap("ball", 0),)),
    "bad-wrap-segment": replace(with_cable(wraps=(Wrap("ball", 1),)), wrap_surfaces=(BALL,)),
    "bad-wrap-turns": over_balls(Wrap("ball", 0, turns=-1)),
    "bad-wrap-inside": over_balls(Wrap("ball", 0, 1, inside=True)),
    "too-many-wraps": over_balls(*[Wrap("ball", 0)] * 9),
    "bad-cable-friction": with_cable(friction=-0.1),
    "bad-pulley": with_cable(pulley=BasePulley("rotating", (("pulley_radius", (0.0,)),))),
}

WARNINGS = {
    "zero-inertia-about-axis": with_hand(iyy=0.0),
    "inertia-triangle": with_hand(iyy=0.3),
    "lengths-in-millimetres": with_hand(ixx=500.0, iyy=500.0, izz=500.0),
    "no-moment-arm": with_cable(start="arm"),
    "no-force-limit": with_cable(f_max=math.inf),
    "point-reaches-pulley": with_cable(via_points=reaching(), pulley=PULLEY),
    "idle-cable-friction": with_cable(
        via_points=(
            ViaPoint(WORLD, (0.1, 0.0, 0.0), friction=0.1),
            ViaPoint("hand", (0.1, 0.0, 0.5)),
        )
    ),
    "initial-outside-limits": with_coordinate(initial=2.0),
    "no-motor-limit": with_coordinate(actuated=True, tau_min=-5.0),
    "zero-limits": with_coordinate(lower=0.0, upper=0.0),
    "limits-in-degrees": with_coordinate(lower=0.0, upper=140.0),
    "no-muscles": replace(ROBOT, cable_set=""),
    "cable-model-not-simulated": with_cable(model=CableModel("linear_spring", (("K", 10.0),))),
    "winch-travel-left-out": with_cable(pulley=SCREW),
    "via-point-inside-wrap": over_balls(Wrap("base", 0)),
    "wrap-ends-left": replace(
        with_cable(wraps=(Wrap("ball", 0, inside=True),)),
        wrap_surfaces=(replace(BALL, shape="cylinder", length=0.1),),
    ),
    "wraps-overlap": over_balls(Wrap("ball", 0), Wrap("near", 0)),
    "wrap-side-left": over_balls(Wrap("ball", 0, 1), Wrap("far", 0)),
}

NOT_FINITE = {
    "gravity": replace(ROBOT, gravity=(0.0, 0.0, NAN)),
    "mass": with_hand(mass=NAN),
    "infinite mass": with_hand(mass=math.inf),
    "inertia": with_hand(ixz=NAN),
    "centre of mass": with_hand(com=(NAN, 0.0, 0.0)),
    "end": replace(ROBOT, links=(ROBOT.links[0], Link("hand", SOLID, (NAN, 0.0, 0.0)))),
    "axis": with_joint(motions=revolute((NAN, 0.0, 0.0))),
    "pose": with_joint(T_parent_joint=Pose((NAN, 0.0, 0.0))),
    "angles": with_joint(T_child_joint=Pose(rpy=(math.inf, 0.0, 0.0))),
    "initial": with_coordinate(initial=NAN),
    "damping": with_coordinate(damping=math.inf),
    "limit": with_coordinate(lower=NAN),
    "both limits infinite": with_coordinate(lower=math.inf, upper=math.inf),
    "force": with_cable(f_min=NAN),
    "upper force": with_cable(f_max=NAN),
    "friction": with_cable(friction=NAN),
    "friction of a point": with_cable(
        via_points=(ViaPoint(WORLD, (1, 0, 0)), ViaPoint("arm", (0, 0, 1), friction=NAN))
    ),
    "via point": with_cable(via_points=(ViaPoint(WORLD, (NAN, 0, 0)), ViaPoint("arm", (0, 0, 0)))),
    "task frame": with_frame(position=(0.0, NAN, 0.0)),
    "cable": with_cable(model=CableModel("linear_spring", (("K", NAN),))),
    "pulley": with_cable(pulley=BasePulley("rotating", (("pulley_radius", (NAN,)),))),
    "wrap surface": with_surfaces(replace(BALL, radius=NAN)),
    "wrap length": with_surfaces(replace(BALL, length=NAN)),
    "mesh": replace(ROBOT, links=(ROBOT.links[0], Link("hand", SOLID, meshes=(MESH,)))),
}


def codes(robot, severity):
    return {finding.code for finding in check(robot) if finding.severity == severity}


def test_base_robot_of_the_tables_has_no_findings():
    assert check(ROBOT) == []


@pytest.mark.parametrize("code", ERRORS)
def test_defect_is_reported_as_error(code):
    assert code in codes(ERRORS[code], "error")


@pytest.mark.parametrize("code", WARNINGS)
def test_doubtful_value_is_reported_as_warning(code):
    assert codes(WARNINGS[code], "warning") == {code}
    assert codes(WARNINGS[code], "error") == set()


@pytest.mark.parametrize("place", NOT_FINITE)
def test_nan_and_infinite_numbers_are_reported(place):
    assert "not-finite" in codes(NOT_FINITE[place], "error")


@pytest.mark.parametrize(
    "axes", [(), ("x", "x"), ("w",), ("x", "alpha"), ("alpha", "alpha"), ("beta", "w")]
)
def test_task_axes_must_be_lengths_or_angles_without_repetition(axes):
    assert codes(with_frame(axes=axes), "error") == {"bad-task-axes"}


def test_all_findings_are_reported_with_errors_first():
    robot = replace(with_hand(mass=-1.0, ixy=1.0), cable_set="c", task_set="d")
    findings = check(robot)
    assert [finding.is_error for finding in findings] == sorted(
        (finding.is_error for finding in findings), reverse=True
    )
    expected = {"negative-mass", "inertia-not-psd", "unknown-cable-set", "unknown-task-set"}
    assert expected <= {finding.code for finding in findings}


def test_muscles_of_all_cable_sets_are_checked_and_named_with_their_set():
    broken = CableSet("b", (cable(f_min=-1.0),))
    (finding,) = check(replace(ROBOT, cable_sets=(ROBOT.cable_sets[0], broken)))
    assert finding.subject == ("muscle", "b/biceps")


def test_pulley_in_millimetres_is_reported_as_warning():
    (finding,) = check(
        with_cable(
            pulley=BasePulley("rotating", (("pulley_radius", (30.0,)), PULLEY.parameters[1]))
        )
    )
    assert (finding.severity, finding.code) == ("error", "bad-pulley")
    assert "30.0 m" in finding.message


def test_unsimulated_cables_are_reported_only_for_active_muscles():
    odd = cable(model=CableModel("vsd_flexure"), pulley=SCREW)
    robot = replace(ROBOT, cable_sets=(ROBOT.cable_sets[0], CableSet("b", (odd,))))
    assert check(robot) == []
    active = [(f.code, f.subject) for f in check(robot.with_cable_set("b"))]
    expected = ("cable-model-not-simulated", "winch-travel-left-out")
    assert active == [(code, ("muscle", "biceps")) for code in expected]


def test_massless_link_with_fixed_massive_link_has_no_findings():
    flange = replace(ROBOT.joints[1], name="flange", motions=(), coordinates=())
    light = Link("arm", Inertia(0.0))
    robot = replace(ROBOT, links=(light, ROBOT.links[1]), joints=(ROBOT.joints[0], flange))
    assert codes(robot, "error") == set()
    point = Link("hand", Inertia(1.0))  # a point mass on the axis
    assert "no-inertia-about-axis" in codes(replace(robot, links=(light, point)), "error")


def test_robot_without_mass_is_only_valid_for_lengths():
    robot = replace(ROBOT, links=tuple(Link(link.name, Inertia(0.0)) for link in ROBOT.links))
    assert codes(robot, "error") == set()
    assert "no-masses" in codes(robot, "warning")


def test_unknown_name_suggests_nearest_name():
    messages = [finding.message for finding in check(with_joint(parent="amr"))]
    assert any("did you mean 'arm'?" in message for message in messages)


def test_require_valid_raises_with_all_findings_or_returns_robot():
    assert require_valid(ROBOT) is ROBOT
    with pytest.raises(RobotError, match=r"mass -1\.0 is negative") as caught:
        require_valid(with_hand(mass=-1.0))
    assert caught.value.findings


@given(inertias())
def test_mass_properties_from_density_pass_both_inertia_checks(inertia):
    assert positive_semidefinite(inertia.matrix)
    assert positive_semidefinite(density_matrix(inertia.matrix))


@pytest.mark.slow
@given(robots())
def test_random_trees_have_no_findings(robot):
    assert [finding for finding in check(robot) if finding.is_error] == []
