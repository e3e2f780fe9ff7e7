"""Number of bends of cables with friction."""

from __future__ import annotations

from dataclasses import replace

from addin_sdfusion.robot import Muscle, Robot
from addin_sdfusion.robot.model.muscle_laws import law_of


def bend_count(muscle: Muscle) -> int:
    """Return the number of bends with a friction state; 0 for a muscle without friction."""
    return len(muscle.bend_friction)


def stretch_count(muscle: Muscle) -> int:
    """Return the number of bends with a stretch state.

    All bends of a cable with distributed elasticity have one.
    """
    return bend_count(muscle) if law_of(muscle.model).stretches else 0


def has_cable_friction(robot: Robot) -> bool:
    """Return whether an active muscle has cable friction."""
    return any(bend_count(muscle) for muscle in robot.muscles)


def without_friction(robot: Robot) -> Robot:
    """Return a robot without friction of cables and joints."""
    muscles = [muscle.with_friction_scaled(0.0) for muscle in robot.muscles]
    joints = tuple(
        replace(joint, coordinates=tuple(replace(c, friction=0.0) for c in joint.coordinates))
        for joint in robot.joints
    )
    return replace(robot.with_muscles(muscles), joints=joints)
