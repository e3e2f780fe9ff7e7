"""The table of hardware variables: the plant's, and diagnostics."""

from __future__ import annotations

from collections.abc import Sequence

from addin_sdfusion.robot import Robot

from .groups import Groups
from .ports import Port, force_unit, motor_signals, muscle_signals, plant_groups

MEASURED_TORQUE = "torque"
"""What a motor at a joint makes, beside the `tau` that it is to make."""

MODES = {0: "starting", 1: "running", 2: "holding", 3: "stopped"}
"""What the hardware's output `mode` says."""


def hardware_groups(
    robot: Robot,
    q: Sequence[float],
    qd: Sequence[float],
    step: float,
    *,
    has_tensions: bool = True,
) -> Groups:
    """Variables of the hardware: the plant's, and diagnostics behind its outputs.

    Args:
        robot: The robot.
        q: Positions that it is to start at, in [rad] or [m].
        qd: Velocities there, in [rad/s] or [m/s].
        step: Internal step of a plant, in [s].
        has_tensions: Whether tensions, and torques of motors, are measured.
    """
    tensions = [
        Port(name, "N", "output", "continuous", f"Measured tension of muscle {muscle.name}")
        for name, muscle in zip(muscle_signals("tension", robot), robot.muscles, strict=True)
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
        Port("missed", "", "output", "discrete", "Exchanges that brought no new state"),
        Port("round_trip_time", "s", "output", "continuous", "From a command to its answer"),
        Port("lateness", "s", "output", "continuous", "How late the step began"),
        Port("mode", "", "output", "discrete", f"What the hardware does: {modes}"),
    ]
    groups: dict[str, Sequence[Port]] = {}
    f_min = [muscle.f_min for muscle in robot.muscles]
    for name, ports in plant_groups(robot, q, qd, step, forces=f_min).items():
        if name == "q_start":  # the first of the parameters
            groups |= {"measured_tensions": tensions, "diagnostics": diagnostics}
        groups[name] = ports
    return groups
