"""Muscles of robots as plain data: nothing is lost."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from support.robots.rare_muscle import RARE

from addin_sdfusion.robot import InputError, Robot, read_robot
from addin_sdfusion.robot.formats.muscle_table.document import MuscleDocument

EXAMPLES = Path(__file__).parents[4] / "examples"


def _again(robot: Robot, empty: Robot) -> Robot:
    text = json.dumps(MuscleDocument.of(robot).to_plain(), allow_nan=False)
    return MuscleDocument.from_plain(json.loads(text)).apply_to(empty)


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
    assert again.cable_set == "cardsflow"


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
