"""Collision shapes (boxes, spheres, cylinders) in the formats that support them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.random_robots import random_robot

from addin_sdfusion.robot import Pose, Robot, Shape, check, read_robot
from addin_sdfusion.robot.formats.convert import convert
from addin_sdfusion.robot.transforms.simplify import joint_frames

SHAPES = (
    Shape("box", (0.1, 0.2, 0.3), Pose((0.1, -0.2, 0.3), (0.4, -0.5, 0.6))),
    Shape("sphere", (0.05,), Pose((0.0, 0.25, 0.0))),
    Shape("cylinder", (0.02, 0.7), Pose((0.0, 0.0, 1.0), (0.0, 0.75, 0.0))),
    Shape("box", (1.0, 2.0, 3.0)),
)


def with_shapes(robot: Robot) -> Robot:
    first, *others = robot.links
    return replace(robot, links=(replace(first, shapes=SHAPES), *others))


@pytest.mark.parametrize("format_", ["sdf", "gazebo", "urdf", "mjcf"])
def test_shapes_are_restored(format_: str, tmp_path: Path) -> None:
    robot = with_shapes(random_robot(3))
    files = convert(robot, format_, tmp_path).files
    found = read_robot(files[0]).links[0].shapes
    # the frame of a link in URDF is the frame of its joint
    expected = (joint_frames(robot) if format_ == "urdf" else robot).links[0].shapes
    for shape, meant in zip(found, expected, strict=True):
        assert shape.kind == meant.kind
        np.testing.assert_allclose(shape.sizes, meant.sizes, rtol=1e-15)
        np.testing.assert_allclose(shape.pose.position, meant.pose.position, atol=1e-12)
        np.testing.assert_allclose(shape.pose.rpy, meant.pose.rpy, atol=1e-12)


@pytest.mark.parametrize(
    "shape", [Shape("box", (1.0, 2.0)), Shape("sphere", (0.0,)), Shape("cylinder", (1.0, -1.0))]
)
def test_shape_without_size_is_an_error_with_its_name(shape: Shape) -> None:
    robot = random_robot(1)
    first, *others = robot.links
    robot = replace(robot, links=(replace(first, shapes=(shape,)), *others))
    (finding,) = [f for f in check(robot) if f.code == "bad-size"]
    assert shape.kind in finding.message
    assert finding.subject.name == first.name
