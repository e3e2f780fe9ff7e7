"""Muscles of robots as plain data: nothing is lost."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from addin_sdfusion.robot import (
    BasePulley,
    Branch,
    CoordinateTerm,
    InputError,
    Muscle,
    PointCondition,
    PointMotion,
    Polynomial,
    Robot,
    SimmSpline,
    ViaPoint,
    Wrap,
    read_robot,
)
from addin_sdfusion.robot.formats.muscle_table.document import MuscleDocument

EXAMPLES = Path(__file__).parents[4] / "examples"
ROBOTS = [
    *(f"{name}/robot" for name in ("bicycle", "cable_robot", "hill_arm", "planar_2r")),
    *("models/arm.xml", "models/leg.osim"),
]
RARE = Muscle(
    "rare",
    (
        ViaPoint("upper", (0.1, -0.0, 1e-17), friction=0.2),
        ViaPoint(
            "upper",
            (0.1, 0.2, 0.3),
            PointCondition("elbow", -0.5, 1.0, 0.1),
            (
                PointMotion((1.0, 0.0, 0.0), "elbow", Polynomial((0.0, 0.5)), high=2.0),
                PointMotion((0.0, 1.0, 0.0), "elbow", SimmSpline((0.0, 1.0), (2.0, 3.0))),
            ),
        ),
        ViaPoint("world", (0.0, 0.0, 1.0)),
        ViaPoint("world", (0.0, 0.0, 2.0)),
    ),
    pulley=BasePulley(
        "rotating", (("pulley_radius", (0.02,)), ("cable_entry_vector", (0.0, 0.0, 1.0)))
    ),
    wraps=(
        Wrap("a", 0, 0, 0, True),
        Wrap("a", 1, 1, 2, friction=0.5),
        Wrap("b", 1, rule="mujoco", side_point=ViaPoint("upper", (1.0, 2.0, 3.0))),
        Wrap("b", 2, rule="opensim", quadrant="-y", last_segment=3),
    ),
    branches=(Branch(0, 2.0), Branch(2, 3.0)),
    terms=(CoordinateTerm("elbow", 0.03),),
    friction=0.1,
    presliding=1e-3,
)


def _again(robot: Robot, empty: Robot) -> Robot:
    text = json.dumps(MuscleDocument.of(robot).to_plain(), allow_nan=False)
    return MuscleDocument.from_plain(json.loads(text)).apply_to(empty)


@pytest.mark.parametrize("path", ROBOTS)
def test_document_restores_the_muscles_of_examples(path: str) -> None:
    robot = read_robot(EXAMPLES / path)
    empty = replace(robot.with_muscles(()), wrap_surfaces=())
    assert _again(robot, empty) == robot


def test_document_holds_rare_properties() -> None:
    robot = read_robot(EXAMPLES / "hill_arm/robot").with_muscles([RARE])
    again = _again(robot, robot.with_muscles(()))
    assert again == robot
    assert repr(again.muscles[0].via_points[0].position) == "(0.1, -0.0, 1e-17)"


def test_document_creates_a_cable_set() -> None:
    robot = read_robot(EXAMPLES / "hill_arm/robot")
    bare = replace(robot, cable_sets=(), cable_set="", wrap_surfaces=())
    again = _again(robot, bare)
    assert again.muscles == robot.muscles
    assert again.cable_set == "muscles"


def test_document_keeps_surfaces_of_other_cable_sets() -> None:
    robot = read_robot(EXAMPLES / "hill_arm/robot")
    other = replace(robot, cable_sets=(*robot.cable_sets, replace(robot.cable_sets[0], name="b")))
    other = other.with_cable_set("b").with_muscles(())
    assert MuscleDocument().apply_to(other).wrap_surfaces == robot.wrap_surfaces


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"muscles": [{"law": "ideal"}]}, "key 'name' is missing"),
        ({"muscles": [{"name": "m", "law": "rubber"}]}, "must be one of ideal"),
        ({"muscles": [{"name": "m", "points": [{"link": "a", "position": [0, 1]}]}]}, "3 values"),
        ({"muscles": [{"name": "m", "options": "{"}]}, "options: must be a JSON object"),
        ({"muscles": [{"name": "m", "options": '{"mass": 1}'}]}, "unknown key 'mass'"),
        ({"wraps": 3}, "must hold a list"),
        ([], "must hold an object"),
    ],
)
def test_document_reports_invalid_data(change: object, message: str) -> None:
    robot = read_robot(EXAMPLES / "hill_arm/robot")
    with pytest.raises(InputError, match=message):
        MuscleDocument.from_plain(change).apply_to(robot)
