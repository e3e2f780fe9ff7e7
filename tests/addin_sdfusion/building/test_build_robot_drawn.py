"""Tests of robots built from designs in the fake Fusion, compared with the original robots."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest
from fake_fusion import Fake, designs
from support.robots.robots import planar_2r

from addin_sdfusion.building.build_robot import BuiltRobot, build_robot
from addin_sdfusion.robot import Robot
from sim_dart import DartDynamics


def built(design: Any) -> tuple[BuiltRobot, Robot]:
    from addin_sdfusion.fusion.design import read_design

    made = build_robot(read_design(design, meshes=False))
    assert made.robot is not None, made.findings
    return made, made.robot


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"seed": 3, "nesting": 2},
        {"groups": False, "seed": 1},
        {"as_built": True, "q": (0.3, -0.5)},
        {"by_origins": True, "q": (0.3, -0.5), "seed": 5, "nesting": 2},
        {"seed": 8, "nesting": 3, "q": (-1.2, 2.0)},
    ],
)
@pytest.mark.parametrize("moved", [False, True])
def test_a_drawing_of_the_example_arm_equals_the_example(
    fusion: Fake, how: Any, moved: bool
) -> None:
    motion = designs.random_motion(random.Random(4)) if moved else None
    _, robot = built(designs.two_link_arm(motion=motion, **how))
    drawn, written = DartDynamics(robot), DartDynamics(planar_2r())
    assert drawn.coordinate_names == written.coordinate_names
    assert drawn.muscle_names == written.muscle_names
    np.testing.assert_array_equal([drawn.f_min, drawn.f_max], [written.f_min, written.f_max])
    for q in ((0.0, 0.0), (0.4, -0.9), (-1.0, 2.0)):
        M, L = written.mass_matrix(q), written.muscle_jacobian(q)
        np.testing.assert_allclose(drawn.mass_matrix(q), M, rtol=0, atol=1e-12)
        np.testing.assert_allclose(drawn.muscle_jacobian(q), L, rtol=0, atol=1e-12)
        np.testing.assert_allclose(
            drawn.coriolis(q, (1, 2)), written.coriolis(q, (1, 2)), atol=1e-12
        )


@pytest.mark.parametrize("axes", ["fixed", "carried"])
def test_a_ball_joint_is_the_same_at_any_pose_and_equals_a_gimbal(fusion: Fake, axes: Any) -> None:
    fusion.options.ball_vectors = axes
    values = (0.3, -0.4, 0.5)
    _, turned = built(designs.shoulder_with_gimbal(values=values))
    _, home = built(designs.shoulder_with_gimbal(values=(0.0, 0.0, 0.0)))
    assert tuple(c.initial for c in turned.coordinates) == pytest.approx(values)
    assert turned.joint("shoulder").type == home.joint("shoulder").type == "ball"
    _, gimbal = built(designs.shoulder_with_gimbal(ball=False, values=(0.1, 0.2, -0.3)))
    a, b, c = (DartDynamics(robot) for robot in (turned, home, gimbal))
    for q in ((0.0, 0.0, 0.0), values, (-0.5, 0.7, 0.2)):
        np.testing.assert_allclose(a.mass_matrix(q), b.mass_matrix(q), atol=1e-12)
        np.testing.assert_allclose(a.muscle_jacobian(q), b.muscle_jacobian(q), atol=1e-12)
        np.testing.assert_allclose(a.muscle_lengths(q), c.muscle_lengths(q), atol=1e-12)
        np.testing.assert_allclose(a.muscle_jacobian(q), c.muscle_jacobian(q), atol=1e-12)


def test_a_cube_is_exported_as_a_robot(fusion: Fake) -> None:
    made, robot = built(designs.single_cube(2.0))
    assert [link.name for link in robot.links] == ["base"]
    assert robot.links[0].inertia.mass == pytest.approx(8e-3)
    assert [f.code for f in made.findings] == ["no-muscles"]


def test_a_body_without_material_is_reported_once(fusion: Fake) -> None:
    from addin_sdfusion.fusion.design import read_design

    made = build_robot(read_design(designs.no_material(), meshes=False))
    bodies = [f.subject.name for f in made.findings if f.subject.kind == "body"]
    assert len(bodies) == len(set(bodies)) == 1
