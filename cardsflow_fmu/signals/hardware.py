"""The table of hardware variables: the plant's, and diagnostics."""

from __future__ import annotations

from collections.abc import Sequence

from addin_sdfusion.robot import Robot

from .ports import Port, muscle_signals, plant_ports

MODES = {0: "starting", 1: "running", 2: "holding", 3: "stopped"}
"""What the hardware's output `mode` says."""


def hardware_ports(
    robot: Robot,
    q: Sequence[float],
    qd: Sequence[float],
    step: float,
    *,
    has_tensions: bool = True,
) -> list[Port]:
    """Ports of the hardware: the plant's, and diagnostics behind its outputs.

    Args:
        robot: The robot.
        q: Positions that it is to start at, in [rad] or [m].
        qd: Velocities there, in [rad/s] or [m/s].
        step: Internal step of a plant, in [s].
        has_tensions: Whether tensions are measured.
    """
    ports = plant_ports(robot, q, qd, step)
    first_parameter = [port.causality for port in ports].index("parameter")
    tensions = [
        Port(name, "N", "output", "continuous", f"Measured tension of muscle {muscle.name}")
        for name, muscle in zip(muscle_signals("tension", robot), robot.muscles, strict=True)
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
    return [*ports[:first_parameter], *tensions, *diagnostics, *ports[first_parameter:]]
