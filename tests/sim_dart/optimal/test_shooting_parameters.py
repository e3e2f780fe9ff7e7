"""Derivatives of intervals by parameters of the robot equal differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import CardsflowError, Inertia, Joint, Link, Robot, ViaPoint
from cardsflow_fmu import Experiment
from sim_dart.optimal.parameters import RobotFamily, RobotNumbers
from sim_dart.optimal.shooting import Shooting

H = 0.02


@pytest.fixture(scope="module")
def robot() -> Robot:
    return Experiment.load(EXAMPLES / "hill_arm").robot


def _with_point(robot: Robot, x: float) -> Robot:
    first, *others = robot.muscles
    start, *rest = first.via_points
    moved = ViaPoint(start.link, (x, *start.position[1:]))
    return robot.with_muscles([replace(first, via_points=(moved, *rest)), *others])


def _with_law(robot: Robot, name: str, value: float) -> Robot:
    first, *others = robot.muscles
    numbers = dict(first.model.parameters) | {name: value}
    model = replace(first.model, parameters=tuple(numbers.items()))
    return robot.with_muscles([replace(first, model=model), *others])


def _with_mass(robot: Robot, mass: float) -> Robot:
    *others, last = robot.links
    return replace(robot, links=(*others, replace(last, inertia=replace(last.inertia, mass=mass))))


def _with_spring(robot: Robot, stiffness: float, rest: float) -> Robot:
    *others, last = robot.joints
    spring = replace(last.coordinates[0], stiffness=stiffness, rest=rest)
    return replace(robot, joints=(*others, replace(last, coordinates=(spring,))))


def _check(shooting: Shooting, p: np.ndarray, scale: np.ndarray) -> None:
    rng, count = np.random.default_rng(0), 20
    x = rng.uniform(0.2, 0.8, (count, shooting.nx))
    u, h, e = rng.uniform(0.2, 0.8, (count, shooting.nu)), np.full(count, H), 1e-5
    found = shooting.run(x, u, h, parameters=p)
    assert found is not None
    assert found.D.shape == (count, shooting.nx, len(p))
    for k, step in enumerate(scale.tolist()):
        along = np.zeros(len(p))
        along[k] = e * step
        ends = [shooting.run(x, u, h, False, p + way * along) for way in (1.0, -1.0)]
        assert ends[0] is not None
        assert ends[1] is not None
        slope = (ends[0].ends - ends[1].ends) / (2.0 * e)
        assert abs(slope).max() > 1e-4  # the parameter has an effect
        np.testing.assert_allclose(found.D[:, :, k] * step, slope, rtol=1e-6, atol=1e-8)


def test_derivatives_by_parameters_match_differences(robot: Robot) -> None:
    """Attachment point, tendon slack length, mass, stiffness and rest of a joint spring."""
    slack = float(dict(robot.muscles[0].model.parameters)["tendon_slack_length"])
    nominal = np.array([robot.muscles[0].via_points[0].position[0], slack, 1.2, 3.0, 0.4])
    span = np.array([0.02, 0.01, 0.5, 2.0, 0.3])

    def robot_at(p: np.ndarray) -> Robot:
        x, length, mass, stiffness, rest = p.tolist()
        changed = _with_law(_with_point(robot, x), "tendon_slack_length", length)
        return _with_spring(_with_mass(changed, mass), stiffness, rest)

    family = RobotFamily(robot_at, nominal - span, nominal + span, nominal)
    shooting = Shooting(robot_at(nominal), 2, with_laws=True, family=family)
    _check(shooting, nominal + 0.3 * span, span)


def test_mass_of_a_link_that_is_merged_with_another_one(robot: Robot) -> None:
    """The centre of mass of both is not a linear function of it."""
    tool = Link("tool", Inertia(0.5, (0.0, 0.1, 0.2), 1e-3, 1e-3, 1e-3))
    joints = (*robot.joints, Joint("grip", robot.links[-1].name, "tool", (), ()))
    own = replace(robot, links=(*robot.links, tool), joints=joints)
    nominal, span = np.array([0.5]), np.array([0.3])
    family = RobotFamily(
        lambda p: _with_mass(own, float(p[0])), nominal - span, nominal + span, nominal
    )
    assert not RobotNumbers(family, lambda robot: robot).is_linear
    _check(Shooting(own, with_laws=True, family=family), nominal + 0.1, span)


def test_parameter_that_changes_the_structure_is_rejected(robot: Robot) -> None:
    one = np.array([1.0])

    def robot_at(p: np.ndarray) -> Robot:
        return robot if p[0] > 0.5 else robot.with_muscles(robot.muscles[1:])

    with pytest.raises(CardsflowError, match="must not change the number of parts"):
        RobotNumbers(RobotFamily(robot_at, 0.0 * one, 2.0 * one, one), lambda robot: robot)
