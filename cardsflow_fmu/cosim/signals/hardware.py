"""Variables of the hardware: variables of the plant, and diagnostics."""

from __future__ import annotations

from collections.abc import Sequence

from addin_sdfusion.robot import Robot

from .groups import Groups
from .muscles import TENSION, tension_ports
from .port import Port, count_port, motor_ports
from .ports import plant_groups

MEASURED_TORQUE = "torque"
"""Prefix of measured motor torques; `tau` is the commanded torque."""

MODES = {0: "starting", 1: "running", 2: "holding", 3: "stopped"}
"""Meaning of the hardware's output `mode`."""


def hardware_groups(
    robot: Robot,
    q: Sequence[float],
    qd: Sequence[float],
    step: float,
    *,
    has_tensions: bool = True,
) -> Groups:
    """Return the variables of the hardware: variables of the plant, and diagnostics."""
    muscles, text = range(len(robot.muscles)), "Measured torque of the motor of"
    tensions: list[Port] = []
    if has_tensions:
        tensions += tension_ports(TENSION, "Measured tension of muscle", robot, muscles)
        tensions += motor_ports(MEASURED_TORQUE, text, robot, "output")
    modes = ", ".join(f"{number} {name}" for number, name in MODES.items())
    diagnostics = [
        Port("age", "s", "output", "continuous", "Time since the state was received"),
        count_port("missed", "Exchanges without a new state"),
        Port("round_trip_time", "s", "output", "continuous", "Time from a command to its answer"),
        Port("lateness", "s", "output", "continuous", "Lateness of the start of the step"),
        count_port("mode", f"State of the hardware: {modes}", max(MODES)),
        count_port("clamped", "Commands that the device clamped"),
    ]
    groups: dict[str, Sequence[Port]] = {}
    f_min = [muscle.f_min for muscle in robot.muscles]
    for name, ports in plant_groups(robot, q, qd, step, forces=f_min).items():
        if name == "q_start":  # the first parameter
            groups |= {
                "measured_tensions": tensions,
                "diagnostics": diagnostics,
            }
        groups[name] = ports
    return groups
