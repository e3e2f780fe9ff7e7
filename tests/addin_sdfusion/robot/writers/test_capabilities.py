"""Each format reports each unsupported feature, and reports it only if the robot has it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
from support.robots.driven import leg
from support.robots.every_field import robot_of_every_field
from support.robots.loops import four_bar, with_loop
from support.robots.one_link import cable, one_link
from support.robots.random_robots import random_tree
from support.robots.robots import planar_2r

from addin_sdfusion.robot import (
    WORLD,
    BasePulley,
    CableModel,
    CableSet,
    Coordinate,
    CoordinateTerm,
    Inertia,
    Joint,
    LimitForce,
    Link,
    LoopJoint,
    Mesh,
    Motion,
    Muscle,
    PiecewiseLinear,
    PointCondition,
    PointMotion,
    Polynomial,
    Robot,
    Shape,
    TaskFrame,
    TaskSet,
    Term,
    ViaPoint,
    Wrap,
    WrapSurface,
    revolute,
)
from addin_sdfusion.robot.formats import features
from addin_sdfusion.robot.formats.capability import Capabilities, Row
from addin_sdfusion.robot.formats.cardsflow.capabilities import CARDSFLOW
from addin_sdfusion.robot.formats.caspr.capabilities import CASPR
from addin_sdfusion.robot.formats.mjcf.capabilities import MJCF, mesh_rows
from addin_sdfusion.robot.formats.opensim.capabilities import OPENSIM
from addin_sdfusion.robot.formats.sdf.capabilities import SDF
from addin_sdfusion.robot.formats.urdf.capabilities import URDF, URDF_WITHOUT_EXTRAS
from addin_sdfusion.robot.model.robot import MARKERS

FORMATS = (SDF, URDF, CASPR, CARDSFLOW, OPENSIM, MJCF)

CURVE = PiecewiseLinear((0.0, 1.0, 2.0), (0.0, 1.0, 0.0))
LINE = Polynomial((0.0, 2.0))
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
STRAIGHT = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)


def named(name: str) -> Robot:
    """Return a robot whose link has this name."""
    robot = one_link()
    joint = replace(robot.joints[0], child=name)
    return replace(robot, links=(replace(robot.links[0], name=name),), joints=(joint,))


def with_muscle(**fields: object) -> Robot:
    return one_link(muscles=[replace(cable(*STRAIGHT), **fields)])


def driven(*motions: Motion, **coordinate: object) -> Robot:
    """Return a joint of these motions, all driven by one coordinate."""
    return one_link(motions=motions, **coordinate)


def two_motions() -> Robot:
    """Return a joint with a rotation and a translation, one of them with a motor."""
    motions = Motion("rotation", X), Motion("translation", X, coordinate=1)
    robot = one_link(motions=motions, actuated=True)
    joint = robot.joints[0]
    coordinates = (*joint.coordinates, Coordinate("s", unit="m"))
    return replace(robot, joints=(replace(joint, coordinates=coordinates),))


def following(*terms: Term) -> Robot:
    """Return a coordinate that is coupled to two others."""
    inertia = Inertia(1.0, (0.0, 0.0, 0.0), 1.0, 1.0, 1.0)
    links = tuple(Link(name, inertia) for name in "abc")
    parents = (WORLD, "a", "b")
    coordinates = (Coordinate("p"), Coordinate("q"), Coordinate("r", coupling=terms))
    joints = (
        Joint(c.name, parent, link.name, revolute(Z), (c,))
        for c, parent, link in zip(coordinates, parents, links, strict=True)
    )
    return Robot("r", links, tuple(joints))


def chain(length: int) -> Robot:
    inertia = Inertia(1.0, (0.0, 0.0, 0.0), 1.0, 1.0, 1.0)
    links = tuple(Link(f"l{k}", inertia) for k in range(length))
    joints = tuple(
        Joint(f"j{k}", f"l{k - 1}" if k else WORLD, f"l{k}", revolute(Z), (Coordinate(f"q{k}"),))
        for k in range(length)
    )
    return Robot("r", links, joints)


def fixed_with_the_name_of_a_coordinate() -> Robot:
    robot = one_link()
    links = (*robot.links, Link("b", Inertia(1.0)))
    return replace(robot, links=links, joints=(*robot.joints, Joint("q", "a", "b")))


@cache
def examples() -> tuple[Robot, ...]:
    """Return robots that each have a feature that some others do not have."""
    alone = Muscle("m", terms=(CoordinateTerm("q", 0.1),), via_points=())
    screw = BasePulley("screw", (("pulley_radius", (0.1,)), ("other", (1.0,))))
    damped = (("fibre_damping", 0.1), ("elastic_tendon", 1.0))
    lengths = (("optimal_fibre_length", 0.1), ("tendon_slack_length", 0.1))
    force = (("max_isometric_force", 100.0),)
    hill = CableModel("hill_degroote2016", (*force, *lengths, *damped))
    meshes = (Mesh("visual", "\a.stl"), Mesh("collision", "here.stl"))
    pulley = BasePulley("rotating", (("pulley_radius", (0.1,)),))
    away = ViaPoint("a", (0.0, 0.0, 1.0)), ViaPoint(WORLD, (0.0, 1.0, 0.0))
    ball = WrapSurface("ball", WORLD, "sphere", 0.5)
    turned = cable((-1.0, 0.1, 0.0), (1.0, 0.1, 0.0), wraps=(Wrap("ball", 0, 1, 1),))
    inside = cable((-1.0, 0.1, 0.0), (0.2, 0.3, 0.0), wraps=(Wrap("ball", 0, 1),))
    moving = ViaPoint(WORLD, (0.0, 1.0, 0.0), moves=(PointMotion(X, "q", LINE, -1.0, 1.0),))
    turn = TaskFrame("turn", "a", (0.0, 0.0, 1.0), ("beta",))
    robot = one_link()
    return (
        robot,
        planar_2r(),
        leg(),
        random_tree(0),
        random_tree(2),
        robot_of_every_field(1),
        robot_of_every_field(4),
        named("j"),
        named("a::b"),
        named("a  b"),
        replace(robot, links=(replace(robot.links[0], meshes=meshes),)),
        one_link(upper=1e17),
        one_link(tau_max=1e17),
        one_link(limit_force=LimitForce(-1.0, 1.0, 2.0, 2.0, inertia=0.1)),
        one_link(Inertia(1.0, (0.0, 0.0, 0.0), 0.1, 0.1, 0.3)),
        one_link(Inertia(0.0)),
        one_link(lower=0.5, upper=1.0),
        one_link(lower=0.5, upper=0.5),
        one_link(lower=0.5),
        one_link(actuated=True, tau_min=1.0, tau_max=1.0),
        four_bar(),
        with_loop(four_bar(), type="ball", axes=()),
        with_loop(four_bar(), type="planar", axes=(Y,)),
        with_muscle(model=CableModel("ideal", (("colour", 1.0),))),
        with_muscle(model=CableModel("linear_spring")),
        with_muscle(model=hill),
        with_muscle(pulley=screw),
        with_muscle(f_min=1.0, f_max=1.0),
        with_muscle(pulley=pulley, via_points=away),
        with_muscle(via_points=(moving, away[0])),
        one_link(muscles=[turned], surfaces=[ball]),
        one_link(muscles=[inside], surfaces=[ball]),
        replace(robot, task_sets=(TaskSet("t", (turn,)),), task_set="t"),
        replace(robot, gravity=(0.0, 0.0, 0.0)),
        two_motions(),
        one_link(muscles=[alone]),
        replace(robot, cable_sets=(CableSet("my set", ()),), cable_set="my set"),
        replace(robot, cable_sets=(), cable_set=""),
        following(Term("p", LINE), Term("q", LINE)),
        following(Term("p", CURVE), Term("q", CURVE)),
        following(Term("p", LINE), Term("p", LINE)),
        following(Term("p", CURVE)),
        driven(*(Motion("rotation", axis) for axis in (X, Y, Z))),
        driven(Motion("rotation", X), Motion("translation", X), Motion("rotation", Y)),
        driven(Motion("rotation", X, function=CURVE)),
        chain(481),
        fixed_with_the_name_of_a_coordinate(),
    )


BARE, CABLE = one_link(), with_muscle()
BALL = WrapSurface("ball", WORLD, "sphere", 0.5)
ROUND = cable((-1.0, 0.1, 0.0), (1.0, 0.1, 0.0))
STRAIGHT_PAST = one_link(muscles=[ROUND], surfaces=[BALL])
WRAPPED = one_link(muscles=[replace(ROUND, wraps=(Wrap("ball", 0),))], surfaces=[BALL])
SPRING = CableModel("linear_spring", (("K", 1.0),))
MOVES = (PointMotion(X, "q", LINE, -1.0, 1.0),)


def with_link(**fields: object) -> Robot:
    return replace(BARE, links=(replace(BARE.links[0], **fields),))


def with_point(**fields: object) -> Robot:
    return with_muscle(via_points=(ViaPoint(WORLD, STRAIGHT[0]), ViaPoint("a", X, **fields)))


def with_rule(rule: str) -> Robot:
    wraps = (Wrap("ball", 0, rule=rule),)
    return one_link(muscles=[replace(ROUND, wraps=wraps)], surfaces=[BALL])


def with_tasks(*frames: TaskFrame, more: tuple[TaskSet, ...] = ()) -> Robot:
    return replace(BARE, task_sets=(TaskSet(MARKERS, frames), *more), task_set=MARKERS)


TIP = TaskFrame("tip", "a", X)
ALONE = {
    "COLLISIONS": (BARE, with_link(shapes=(Shape("sphere", (0.1,)),))),
    "MESHES": (BARE, with_link(meshes=(Mesh("visual", "a.stl"),))),
    "LINK_ENDS": (BARE, with_link(end=X)),
    "GRAVITIES": (BARE, replace(BARE, gravity=(0.0, 0.0, -1.0))),
    "INITIAL_VALUES": (BARE, one_link(initial=0.1)),
    "LIMITS": (BARE, one_link(lower=-1.0, upper=1.0)),
    "DAMPING": (BARE, one_link(damping=0.1)),
    "SPRINGS": (BARE, one_link(stiffness=1.0)),
    "FRICTION": (BARE, one_link(friction=0.1)),
    "ARMATURES": (BARE, one_link(armature=0.1)),
    "LIMIT_FORCES": (BARE, one_link(limit_force=LimitForce(-1.0, 1.0, 2.0, 2.0))),
    "MOTORS": (BARE, one_link(actuated=True)),
    "MOTOR_BOUNDS": (
        one_link(actuated=True),
        one_link(actuated=True, tau_min=-1.0, tau_max=2.0),
    ),
    "VELOCITY_LIMITS": (BARE, one_link(max_velocity=2.0)),
    "LOOPS": (BARE, replace(BARE, loops=(LoopJoint("loop", WORLD, "a", "universal", (X, Y)),))),
    "MUSCLE_LAWS": (CABLE, with_muscle(model=SPRING)),
    "IDEAL_PARAMETERS": (CABLE, with_muscle(model=CableModel("ideal", (("colour", 1.0),)))),
    "CABLE_FRICTION": (CABLE, with_muscle(friction=0.1)),
    "CONDITIONS": (with_point(), with_point(when=PointCondition("q", -1.0, 1.0))),
    "MOVING_POINTS": (with_point(), with_point(moves=MOVES)),
    "TERMS": (CABLE, with_muscle(terms=(CoordinateTerm("q", 0.1),))),
    "WRAP_SURFACES": (one_link(muscles=[ROUND]), STRAIGHT_PAST),
    "WRAPS": (STRAIGHT_PAST, WRAPPED),
    "OPENSIM_WRAPS": (WRAPPED, with_rule("opensim")),
    "MUJOCO_WRAPS": (WRAPPED, with_rule("mujoco")),
    "CABLE_SETS": (BARE, replace(BARE, cable_sets=(*BARE.cable_sets, CableSet("b", ())))),
    "TASK_FRAMES": (BARE, with_tasks(TIP)),
    "TASK_SETS": (with_tasks(TIP), with_tasks(TIP, more=(TaskSet("b", (TIP,)),))),
}
"""Features by their names in `features`: a robot without the feature, and one with it."""
ALSO = {
    "WRAPS": ["points that may move inside wrap surfaces"],
    "OPENSIM_WRAPS": [features.WRAPS.name, features.WRAP_SURFACES.name],
    "MUJOCO_WRAPS": [features.WRAPS.name, features.WRAP_SURFACES.name],
}
"""Features that a robot with the feature also has."""


def rows() -> list[tuple[Capabilities, Row]]:
    tables = (
        *FORMATS,
        replace(MJCF, rows=mesh_rows({"here.stl": "here.stl"})),
        URDF_WITHOUT_EXTRAS,
    )
    return [(table, row) for table in tables for row in table.rows if row.code]


@pytest.mark.parametrize("table", FORMATS, ids=[table.title for table in FORMATS])
def test_table_contains_all_features(table: Capabilities) -> None:
    known = {feature.name for row in table.rows for feature in row.features}
    if table is MJCF:
        known |= {feature.name for row in mesh_rows({}) for feature in row.features}
    assert {feature.name for feature in features.CATALOGUE} - known == set()


@pytest.mark.parametrize(
    ("table", "row"),
    rows(),
    ids=[f"{table.title}-{row.code}-{row.features[0].name}" for table, row in rows()],
)
def test_row_reports_only_robots_with_the_feature(table: Capabilities, row: Row) -> None:
    found = [list(row.findings(robot, table.title)) for robot in examples()]
    assert any(found)
    assert not all(found) or row.code == "links-left-out"  # reported for all robots
    for finding in (finding for one in found for finding in one):
        assert (finding.code, finding.is_error) == (row.code, row.treatment == "rejected")
        assert finding.message.startswith(finding.subject.kind.replace("_", " "))
        assert "\n" not in finding.message
        assert "{" not in finding.message


@pytest.mark.parametrize("name", ALONE)
@pytest.mark.parametrize("table", FORMATS, ids=[table.title for table in FORMATS])
def test_single_feature_causes_only_findings_of_its_rows(table: Capabilities, name: str) -> None:
    feature, (without, having) = getattr(features, name), ALONE[name]
    names = {feature.name, *ALSO.get(name, ())}
    own = [row for row in table.rows if names & {known.name for known in row.features}]
    before, after = set(table.losses(without)), set(table.losses(having))
    reported = {f for row in own for f in row.findings(having, table.title)} - before
    assert after - before == reported
    its = [row for row in own if feature in row.features]
    if any(row.code and not row.only for row in its):
        assert reported
    if all(row.treatment == "kept" for row in own):
        assert not reported


@pytest.mark.parametrize("table", FORMATS, ids=[table.title for table in FORMATS])
def test_all_losses_have_a_code_and_a_message(table: Capabilities) -> None:
    lost = [row for row in table.rows if row.treatment in ("changed", "rejected")]
    assert lost
    assert all(row.code and row.message for row in lost)
    assert not any(row.code for row in table.rows if row.treatment == "kept")
