"""Bends of cables with friction, as the C core counts them."""

from __future__ import annotations

from addin_sdfusion.robot import Muscle, Robot
from addin_sdfusion.robot.model.muscle_laws import law_of


def bends(muscle: Muscle) -> int:
    """Return how many bends a cable has that states of friction belong to.

    Args:
        muscle: The muscle; one without friction has none.
    """
    return len(muscle.bend_friction)


def stretches(muscle: Muscle) -> int:
    """How many of them have a state of stretch besides: all of a cable that stretches all along."""
    return bends(muscle) if law_of(muscle.model).stretches else 0


def has_cable_friction(robot: Robot) -> bool:
    """Return whether friction changes the tension of any active muscle."""
    return any(bends(muscle) for muscle in robot.muscles)
