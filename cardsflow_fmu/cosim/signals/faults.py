"""Variables of the detection of faults in an estimator."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from addin_sdfusion.robot import Robot

from .estimation import measured_muscles
from .groups import Groups
from .port import Port, coordinate_signals, count_port, muscle_signals

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

GROUPS = (
    "commands",
    "muscle_faults",
    "length_faults",
    "tension_faults",
    "encoder_faults",
    "bounds",
    "fault_report",
)


def _kinds(first: int, last: int) -> str:
    return "0 none, " + ", ".join(f"{k} {FAULTS[k]}" for k in range(first, last + 1))


def fault_groups(robot: Robot, encoded: Sequence[int], *, has_faults: bool) -> Groups:
    """Return the variables of the detection of faults.

    Args:
        robot: The robot.
        encoded: Coordinates with an encoder.
        has_faults: Whether faults are detected; otherwise all groups are empty.
    """
    if not has_faults:
        return dict.fromkeys(GROUPS, ())
    muscles = measured_muscles(robot)
    names = [robot.muscles[k].name for k in muscles]

    def of_muscles(prefix: str, what: str, kinds: str) -> list[Port]:
        signals = muscle_signals(prefix, robot)
        return [
            count_port(signals[k], f"{what} {name}: {kinds}", max(FAULTS))
            for k, name in zip(muscles, names, strict=True)
        ]

    forces, bounds = muscle_signals("f", robot), muscle_signals("bound", robot)
    encoders = coordinate_signals("encoder_fault", robot)
    report = (
        ("fault_time", "s", "Time of the newest decision, from the start"),
        ("fault_statistic", "", "Log Bayes factor of the newest fault against no fault"),
        ("fault_threshold", "", "Half the squared normalised mean from which a sensor is suspect"),
        ("fault_confidence", "", "Probability of the newest fault among all hypotheses"),
        ("fault_value", "", "Factor, offset in m or stiffness in N/m of the newest fault"),
    )
    return {
        "commands": [
            Port(forces[k], "N", "input", "continuous", f"Force command of muscle {name}")
            for k, name in zip(muscles, names, strict=True)
        ],
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
        "bounds": [
            Port(
                *(bounds[k], "N", "output", "discrete"),
                f"Largest force that muscle {name} can produce",
                min(robot.muscles[k].f_max, sys.float_info.max),
                lower=0.0,
            )
            for k, name in zip(muscles, names, strict=True)
        ],
        "fault_report": [
            count_port("faults", "Number of parts with faults"),
            *(Port(name, unit, "output", "discrete", what) for name, unit, what in report),
        ],
    }
