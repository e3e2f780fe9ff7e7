"""Variables of the detection of faults, and of the reaction of controllers to lost muscles."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from addin_sdfusion.robot import Robot

from .groups import Groups
from .port import Causality, Port, coordinate_signals, count_port, muscle_ports, muscle_signals

FAULTS = {
    0: "none",
    1: "broken",
    2: "jammed",
    3: "weak",
    4: "length_stuck",
    5: "length_bias",
    6: "length_scale",
    7: "length_swapped",
    8: "tension_stuck",
    9: "tension_dead",
    10: "encoder_stuck",
}
"""Kinds of faults: `enum fault_kind` of controllers/csrc/faults/faults.h."""

FAULT_GROUPS = (
    "commands",
    "muscle_faults",
    "length_faults",
    "tension_faults",
    "encoder_faults",
    "bounds",
    "fault_report",
)

DECISIONS = {
    0: "no fault",
    1: "continue",
    2: "slow down",
    3: "hold the pose",
    4: "stop the joints",
}
"""Meaning of the controller's output `reaction`."""

PARTS = {
    "fault": "muscle",
    "length_fault": "length sensor",
    "tension_fault": "tension sensor",
    "encoder_fault": "encoder",
}
"""Parts with faults, by the prefix of their outputs."""

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
    """Return the speed of the reference, relative to its nominal speed."""
    description = "Speed of the reference, relative to its nominal speed"
    return Port(SPEED, "", causality, "discrete", description, 1.0, lower=0.0, upper=1.0)


def reached_port(causality: Causality) -> Port:
    """Return the time of the reference, which is less than the time after it has slowed down."""
    return Port(REACHED, "s", causality, "continuous", "Time of the reference")


def reaction_groups(robot: Robot, muscles: Sequence[int]) -> Groups:
    """Return the variables of a controller that reacts to lost muscles.

    Args:
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


def _kinds(first: int, last: int) -> str:
    return "0 none, " + ", ".join(f"{k} {FAULTS[k]}" for k in range(first, last + 1))


def fault_groups(
    robot: Robot, muscles: Sequence[int], encoded: Sequence[int], *, has_faults: bool
) -> Groups:
    """Return the variables of the detection of faults.

    Args:
        muscles: Indices of the muscles with sensors.
        encoded: Coordinates with an encoder.
        has_faults: Whether faults are detected; otherwise all groups are empty.
    """
    if not has_faults:
        return dict.fromkeys(FAULT_GROUPS, ())

    def of_muscles(prefix: str, quantity: str, kinds: str) -> list[Port]:
        signals = muscle_signals(prefix, robot)
        return [
            count_port(signals[k], f"{quantity} {robot.muscles[k].name}: {kinds}", max(FAULTS))
            for k in muscles
        ]

    encoders = coordinate_signals("encoder_fault", robot)
    report = (
        ("fault_time", "s", "Time of the newest decision, from the start"),
        ("fault_statistic", "", "Log Bayes factor of the newest fault against no fault"),
        ("fault_threshold", "", "Half the squared normalised mean from which a sensor is suspect"),
        ("fault_confidence", "", "Probability of the newest fault among all hypotheses"),
        ("fault_value", "", "Factor, offset in m or stiffness in N/m of the newest fault"),
    )
    return {
        "commands": muscle_ports("f", "N", "Force command of muscle", robot, "input", muscles),
        "muscle_faults": of_muscles("fault", "Fault of muscle", _kinds(1, 3)),
        "length_faults": of_muscles("length_fault", "Fault of the length sensor of", _kinds(4, 7)),
        "tension_faults": of_muscles(
            "tension_fault", "Fault of the tension sensor of", _kinds(8, 9)
        ),
        "encoder_faults": [
            count_port(encoders[j], f"Fault of the encoder of {c.name}: {_kinds(10, 10)}", 10)
            for j, c in enumerate(robot.coordinates)
            if j in encoded
        ],
        "bounds": bound_signals(robot, muscles, "output"),
        "fault_report": [
            count_port("faults", "Number of parts with faults"),
            *(Port(name, unit, "output", "discrete", quantity) for name, unit, quantity in report),
        ],
    }
