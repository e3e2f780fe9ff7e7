"""Bends of cables with friction, as the C core counts them."""

from __future__ import annotations

from addin_sdfusion.robot import Muscle, Robot


def bends(muscle: Muscle) -> int:
    """How many bends a cable with friction has: via points but the ends, wraps, the pulley.

    Args:
        muscle: The muscle; one without friction has none.
    """
    pulleys = muscle.pulley is not None
    return len(muscle.via_points) - 2 + len(muscle.wraps) + pulleys if muscle.friction else 0


def rubs(robot: Robot) -> bool:
    """Whether friction changes the tension of any active muscle."""
    return any(bends(muscle) for muscle in robot.muscles)
