"""FMU variables of a robot: name, unit, causality, start value.

All names of variables in FMUs, wiring, CSV headers and legends are defined in this package. The
value reference of a port is its index in the table of its model.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.trajectory import Space

from .controller_parameters import bound_ports, gain_ports
from .groups import Groups
from .muscles import (
    FAR_TENSION,
    TENSION,
    command_ports,
    energy_ports,
    friction_muscles,
    ideal_muscles,
    modelled_muscles,
    nominal_force,
    state_ports,
    tension_ports,
)
from .port import (
    Causality,
    Port,
    Variability,
    coordinate_signals,
    count_port,
    effort,
    force_unit,
    identifier,
    load_signals,
    motor_signals,
    muscle_ports,
    muscle_signals,
    nominal_of,
    signal_names,
    task_names,
    task_signals,
    task_units,
    time_port,
)
from .reaction import reached_port, reaction_groups, speed_port
from .world import world_ports, wrench_ports, wrench_signals

if TYPE_CHECKING:
    from sim_dart.scene import Scene

__all__ = [
    "FALLBACK",
    "LATE",
    "LIMITS_DROPPED",
    "SOLVE_TIME",
    "TORQUE",
    "WORKER_TIMEOUT",
    "Causality",
    "Port",
    "Variability",
    "controller_groups",
    "coordinate_ports",
    "coordinate_signals",
    "external_load_signals",
    "force_unit",
    "identifier",
    "load_signals",
    "motor_signals",
    "muscle_signals",
    "plant_groups",
    "reference_groups",
    "signal_names",
    "slack_signals",
    "task_names",
    "task_signals",
    "task_units",
]

LIMITS_DROPPED = "limits_dropped"
FALLBACK = "fallback"
LATE = "late"
TORQUE = "tau"
"""Prefix of the commands of joint motors."""

SOLVE_TIME = "solve_time"
"""Computation time of a tick. It differs between runs and is not part of result tables."""


WORKER_TIMEOUT = time_port(
    "worker_timeout", "Longest duration of a call if the model runs in a worker process", 60.0
)
"""Parameter of the C library; models do not use it."""


def external_load_signals(robot: Robot, wrenched: Sequence[str]) -> list[str]:
    """Return the inputs for external forces on end-effector points and wrenches on links."""
    return [*load_signals(robot), *wrench_signals(wrenched)]


def coordinate_ports(
    prefix: str,
    per: str,
    quantity: str,
    robot: Robot,
    causality: Causality,
    variability: Variability,
    start: Sequence[float] | None = None,
) -> list[Port]:
    """Return one port per coordinate. Its unit is the unit of the coordinate, followed by `per`.

    Positions have the joint limits as range. Without `start`, start values are those next to 0.
    """
    ports = []
    for j, (name, c) in enumerate(
        zip(coordinate_signals(prefix, robot), robot.coordinates, strict=True)
    ):
        low, high = (-math.inf, math.inf) if per else (c.lower, c.upper)
        value = start[j] if start else min(max(0.0, low), high)
        description, unit = f"{quantity} of {c.name}", c.unit + per
        port = Port(name, unit, causality, variability, description, value, lower=low, upper=high)
        ports.append(replace(port, nominal=nominal_of(unit)))
    return ports


def _force_ports(
    robot: Robot, causality: Causality, variability: Variability, starts: Sequence[float] = ()
) -> list[Port]:
    """Return `f.<muscle>` of every muscle. Start values are 0 if `starts` is empty."""
    muscles = range(len(robot.muscles))
    ports = muscle_ports("f", "N", "Force of muscle", robot, causality, muscles, variability)
    starts = starts or [0.0] * len(robot.muscles)
    return [
        replace(port, start=start, lower=0.0, upper=m.f_max, nominal=nominal_force(m))
        for port, m, start in zip(ports, robot.muscles, starts, strict=True)
    ]


def _torque_ports(robot: Robot, causality: Causality, variability: Variability) -> list[Port]:
    """Return `tau.<coordinate>` of every motor."""
    rows = zip(motor_signals(TORQUE, robot), robot.motors, strict=True)
    return [
        Port(
            *(name, force_unit(c), causality, variability, description),
            lower=c.tau_min,
            upper=c.tau_max,
            nominal=largest if 0.0 < largest < math.inf else 1.0,
        )
        for name, c in rows
        for description in [f"{effort(c)} of the motor of {c.name}"]
        for largest in [max(-c.tau_min, c.tau_max)]
    ]


def _task_ports(
    prefix: str, per: str, quantity: str, robot: Robot, causality: Causality
) -> list[Port]:
    """Return one port per task coordinate. Its unit is followed by `per`."""
    return [
        Port(
            *(name, unit + per, causality, "continuous", f"{quantity} {name[len(prefix) + 1 :]}"),
            nominal=nominal_of(unit + per),
        )
        for name, unit in zip(task_signals(prefix, robot), task_units(robot), strict=True)
    ]


def _load_ports(robot: Robot, causality: Causality) -> list[Port]:
    return [
        Port(name, "N", causality, "continuous", f"External force on {name[2:-3]}, world axes")
        for name in load_signals(robot)
    ]


def plant_groups(
    robot: Robot,
    q: Sequence[float],
    qd: Sequence[float],
    step: float,
    *,
    forces: Sequence[float] = (),
    commands: Sequence[float] = (),
    energy: bool = False,
    wrenches: Sequence[str] = (),
    scene: Scene | None = None,
    has_tensions: bool = False,
) -> Groups:
    """Return the variables of the plant.

    Inputs are commands and external loads; outputs include positions, velocities and lengths. The
    command of an ideal cable is its force. Muscles with a muscle law have a command in the unit of
    the law, and tension and states as outputs. The command of a joint motor is its torque.

    Args:
        q: Start positions, in [rad] or [m].
        qd: Start velocities, in [rad/s] or [m/s].
        step: Internal step, in [s].
        forces: Start forces of ideal cables, one per muscle, in [N]; 0 if empty.
        commands: Start commands of the muscles, if one has a muscle law.
        energy: Whether energies, work and momenta are outputs.
        wrenches: Names of links with external forces and torques.
        scene: Surroundings of the robot, or None.
        has_tensions: Whether tensions of muscles without a muscle law are outputs.
    """
    muscles = range(len(robot.muscles))
    measured = muscles if has_tensions else modelled_muscles(robot)
    far = "Tension at the last via point, after cable friction, of muscle"
    pulls = _force_ports(robot, "input", "continuous", forces)
    driven = command_ports(robot, "input", "continuous", commands)
    return {
        "commands": [*(pulls[k] for k in ideal_muscles(robot)), *driven],
        "torques": _torque_ports(robot, "input", "continuous"),
        "loads": _load_ports(robot, "input"),
        "wrenches": wrench_ports(wrenches, "input"),
        "q": coordinate_ports("q", "", "Position", robot, "output", "continuous"),
        "qd": coordinate_ports("qd", "/s", "Velocity", robot, "output", "continuous"),
        "lengths": [
            replace(port, lower=0.0, nominal=nominal_of("m"))
            for port in muscle_ports("l", "m", "Path length of muscle", robot, "output", muscles)
        ],
        "tasks": _task_ports("y", "", "Task coordinate", robot, "output"),
        "tensions": tension_ports(TENSION, "Tension of muscle", robot, measured),
        "far_tensions": tension_ports(FAR_TENSION, far, robot, friction_muscles(robot)),
        "states": state_ports(robot, "output"),
        "energies": energy_ports() if energy else [],
        "world": world_ports(scene),
        "q_start": coordinate_ports(
            "q_start", "", "Start position", robot, "parameter", "fixed", q
        ),
        "qd_start": coordinate_ports(
            "qd_start", "/s", "Start velocity", robot, "parameter", "fixed", qd
        ),
        "step": [time_port("step", "Internal step of the plant", step)],
        "worker_timeout": [WORKER_TIMEOUT],
        "derivatives": [],  # see `continuous`
        "indicators": [],
    }


def reference_groups(
    robot: Robot, space: Space, *, with_loads: bool = False, has_speed: bool = False
) -> Groups:
    """Return the variables of a reference: desired positions, velocities, accelerations.

    Args:
        space: Whether it is in joint or operational space.
        with_loads: Whether external loads are also outputs.
        has_speed: Whether its speed is an input, and its time an output.
    """
    return {
        "speed": [speed_port("input")] if has_speed else [],
        "reference": _reference_ports(robot, space, "output"),
        "loads": _load_ports(robot, "output") if with_loads else [],
        "reached": [reached_port("output")] if has_speed else [],
        "worker_timeout": [WORKER_TIMEOUT],
    }


def _reference_ports(robot: Robot, space: Space, causality: Causality) -> list[Port]:
    rows = (("_d", "", "position"), ("d_d", "/s", "velocity"), ("dd_d", "/s2", "acceleration"))
    ports: list[Port] = []
    for ending, per, quantity in rows:
        if space == "joint":
            prefix = f"q{ending}"
            ports += coordinate_ports(
                prefix, per, f"Desired {quantity}", robot, causality, "continuous"
            )
        else:
            ports += _task_ports(f"y{ending}", per, f"Desired {quantity}", robot, causality)
    return ports


def controller_groups(
    robot: Robot,
    space: Space,
    kp: Sequence[float],
    kd: Sequence[float],
    period: float,
    *,
    torque_gains: bool = False,
    is_predictive: bool = False,
    estimate: Mapping[str, Sequence[Port]] = MappingProxyType({}),
    bounded: Sequence[int] = (),
) -> Groups:
    """Return the variables of a controller.

    Inputs are state, reference and external loads; outputs are forces and diagnostics. For muscles
    with a muscle law, the states are also inputs, the forces are desired tensions, and the commands
    are additional outputs. Motor torques and their limits follow the muscle forces and their
    limits.

    Args:
        space: Whether the reference is in joint or operational space.
        kp: Position gains of the coordinates or task coordinates that track the reference.
        kd: Velocity gains of the same coordinates.
        period: Time between two ticks, in [s].
        torque_gains: Whether the gains are torques per error instead of accelerations per error.
        is_predictive: Whether the law is model predictive control, which reports fallbacks.
        estimate: Additional inputs from an estimator.
        bounded: Muscles whose loss the controller reacts to.
    """
    infeasible = "No forces within the limits produce the required torque"
    undecided = "The solver found no forces, although they may exist"
    return {
        "q": coordinate_ports("q", "", "Position", robot, "input", "continuous"),
        "qd": coordinate_ports("qd", "/s", "Velocity", robot, "input", "continuous"),
        "reference": _reference_ports(robot, space, "input"),
        "loads": _load_ports(robot, "input"),
        "states": state_ports(robot, "input"),
        "estimated_loads": estimate.get("estimated_loads", []),
        "valid": estimate.get("valid", []),
        **reaction_groups(robot, bounded),
        "forces": [
            *_force_ports(robot, "output", "discrete"),
            *_torque_ports(robot, "output", "discrete"),
        ],
        "commands": command_ports(robot, "output", "discrete"),
        "slack": _slack_ports(robot, space),
        "report": [
            count_port("at_bound", "Number of muscles and motors at a limit"),
            Port(SOLVE_TIME, "s", "output", "discrete", "Computation time of the tick", lower=0.0),
            Port("infeasible", "", "output", "discrete", infeasible, boolean=True),
            Port("not_converged", "", "output", "discrete", undecided, boolean=True),
            *_limit_ports(space),
            *(_predictive_ports() if is_predictive else []),
        ],
        **gain_ports(robot, space, kp, kd, torque_gains),
        **bound_ports(robot),
        "period": [time_port("period", "Time between two ticks", period)],
        "worker_timeout": [WORKER_TIMEOUT],
    }


def _limit_ports(space: Space) -> list[Port]:
    description = "No forces within the limits keep the joint limits"
    dropped = Port(LIMITS_DROPPED, "", "output", "discrete", description, boolean=True)
    return [] if space == "joint" else [dropped]


def _predictive_ports() -> list[Port]:
    description = "No predicted motion was found; the computed torque determines the forces"
    return [
        Port(FALLBACK, "", "output", "discrete", description, boolean=True),
        count_port("iterations", "Number of solver iterations"),
        Port(LATE, "", "output", "discrete", "The deadline ended the iterations", boolean=True),
    ]


def slack_signals(robot: Robot, space: Space) -> dict[str, str]:
    """Return the slack signals with units: joint torque, or task acceleration."""
    if space == "joint":
        names = coordinate_signals("slack", robot)
        return {name: force_unit(c) for name, c in zip(names, robot.coordinates, strict=True)}
    return {
        name: f"{unit}/s2"
        for name, unit in zip(task_signals("slack", robot), task_units(robot), strict=True)
    }


def _slack_ports(robot: Robot, space: Space) -> list[Port]:
    quantity = "Torque or force shortfall of" if space == "joint" else "Acceleration shortfall of"
    return [
        Port(name, unit, "output", "discrete", f"{quantity} {name.removeprefix('slack.')}")
        for name, unit in slack_signals(robot, space).items()
    ]
