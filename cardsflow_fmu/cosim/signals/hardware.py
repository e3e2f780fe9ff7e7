"""Variables of the hardware: variables of the plant, and diagnostics."""

from __future__ import annotations

from collections.abc import Sequence

from addin_sdfusion.robot import Robot

from .groups import Groups
from .muscles import nominal_force
from .port import count_port
from .ports import Port, force_unit, motor_signals, muscle_signals, plant_groups

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
    tensions = [
        Port(name, "N", "output", "continuous", description, nominal=nominal_force(muscle))
        for name, muscle in zip(muscle_signals("tension", robot), robot.muscles, strict=True)
        for description in [f"Measured tension of muscle {muscle.name}"]
        if has_tensions
    ]
    tensions += [
        Port(
            name, force_unit(c), "output", "continuous", f"Measured torque of the motor of {c.name}"
        )
        for name, c in zip(motor_signals(MEASURED_TORQUE, robot), robot.motors, strict=True)
        if has_tensions
    ]
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
            groups |= {"measured_tensions": tensions, "diagnostics": diagnostics}
        groups[name] = ports
    return groups
