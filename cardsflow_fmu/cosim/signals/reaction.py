"""Variables of the reaction of controllers to lost muscles."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from addin_sdfusion.robot import Robot

from .groups import Groups
from .port import Causality, Port, count_port, muscle_signals

DECISIONS = {
    0: "no fault",
    1: "continue",
    2: "slow down",
    3: "hold the pose",
    4: "stop the joints",
}
"""Meaning of the controller's output `reaction`."""

BOUND = "bound"
"""Prefix of the largest forces that muscles can produce."""
REACTION, SPEED, REACHED, LOST = "reaction", "reference_speed", "reference_time", "lost_muscles"


def full_bounds(robot: Robot, muscles: Sequence[int]) -> list[float]:
    """Return the bounds of muscles without faults, in [N]."""
    return [min(robot.muscles[k].f_max, sys.float_info.max) for k in muscles]


def bound_signals(robot: Robot, muscles: Sequence[int], causality: Causality) -> list[Port]:
    """Return `bound.<muscle>` of muscles by their indices."""
    names = muscle_signals(BOUND, robot)
    return [
        Port(
            *(names[k], "N", causality, "discrete"),
            f"Largest force that muscle {robot.muscles[k].name} can produce",
            full,
            lower=0.0,
        )
        for k, full in zip(muscles, full_bounds(robot, muscles), strict=True)
    ]


def speed_port(causality: Causality) -> Port:
    """Return the speed of the reference relative to its own."""
    what = "Speed of the reference, relative to its own"
    return Port(SPEED, "", causality, "discrete", what, 1.0, lower=0.0, upper=1.0)


def reached_port(causality: Causality) -> Port:
    """Return the time of the reference, which is less than the time after it has slowed down."""
    return Port(REACHED, "s", causality, "continuous", "Time of the reference")


def reaction_groups(robot: Robot, muscles: Sequence[int]) -> Groups:
    """Return the variables of a controller that reacts to lost muscles.

    Args:
        robot: The robot.
        muscles: Indices of the muscles with a bound; empty without a reaction.
    """
    meaning = ", ".join(f"{number} {text}" for number, text in DECISIONS.items())
    return {
        "bounds": bound_signals(robot, muscles, "input"),
        "reached": [reached_port("input")] if muscles else [],
        "reaction": [
            speed_port("output"),
            count_port(REACTION, f"Reaction to lost muscles: {meaning}", max(DECISIONS)),
            count_port(LOST, "Number of lost muscles", len(muscles)),
        ]
        if muscles
        else [],
    }
