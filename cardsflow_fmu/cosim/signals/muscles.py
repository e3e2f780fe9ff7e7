"""Variables of muscles with muscle laws: commands, tensions, states; see `ports`."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace

from addin_sdfusion.robot import Muscle, Robot
from addin_sdfusion.robot.model.muscle_laws import law_of, range_of, states_of
from sim_dart.muscles.friction import bend_count

from .groups import Groups
from .port import Causality, Port, Variability, muscle_ports, muscle_signals, nominal_of

FORCE, COMMAND, TENSION, FAR_TENSION = "f", "u", "tension", "far_tension"

ENERGIES = {
    "energy.kinetic": ("J", "Kinetic energy of the robot"),
    "energy.potential": ("J", "Potential energy of gravity and of joint springs"),
    "work.muscles": ("J", "Work of the muscles since the start"),
    "work.outside": ("J", "Work of motors and external loads since the start"),
    "work.damping": ("J", "Work of joint damping since the start"),
    "work.friction": ("J", "Work of cable friction since the start"),
    **{f"momentum.{axis}": ("N.s", f"Momentum of the robot along {axis}") for axis in "xyz"},
    **{
        f"angular_momentum.{axis}": (
            "N.m.s",
            f"Angular momentum of the robot about the world's {axis}",
        )
        for axis in "xyz"
    },
}
"""Energies, work and momenta of a plant, with units and descriptions."""


def is_modelled(muscle: Muscle) -> bool:
    """Return whether a muscle has a muscle law. The tension of other muscles is the command."""
    return law_of(muscle.model).kind != "ideal"


def is_driven(muscle: Muscle) -> bool:
    """Return whether a muscle has a muscle law with a command."""
    return is_modelled(muscle) and law_of(muscle.model).command is not None


def ideal_muscles(robot: Robot) -> list[int]:
    """Return the indices of the muscles whose command is their tension."""
    return [k for k, muscle in enumerate(robot.muscles) if not is_modelled(muscle)]


def modelled_muscles(robot: Robot) -> list[int]:
    """Return the indices of the muscles with a muscle law."""
    return [k for k, muscle in enumerate(robot.muscles) if is_modelled(muscle)]


def driven_muscles(robot: Robot) -> list[int]:
    """Return the indices of the muscles that have a muscle law with a command."""
    return [k for k, muscle in enumerate(robot.muscles) if is_driven(muscle)]


def commanded_muscles(robot: Robot) -> list[int]:
    """Return the index of the muscle of each command of the plant, in the order of the commands."""
    return [*ideal_muscles(robot), *driven_muscles(robot)]


def tension_signals(robot: Robot, names: Collection[str] = ()) -> list[str]:
    """Return the names of the signals with the actual tension of each muscle, in the order of f.

    They are `tension.<muscle>` for muscles with a muscle law, otherwise the command `f.<muscle>`.

    Args:
        names: Names of the signals of a run. If they contain `tension.<muscle>` of a muscle without
            a muscle law, this signal is used.
    """
    forces, tensions = muscle_signals(FORCE, robot), muscle_signals(TENSION, robot)
    return [
        tension if is_modelled(muscle) or tension in names else force
        for muscle, force, tension in zip(robot.muscles, forces, tensions, strict=True)
    ]


def command_signals(robot: Robot) -> list[str]:
    """Return `u.<muscle>` of every muscle with a command."""
    names = muscle_signals(COMMAND, robot)
    return [names[k] for k in driven_muscles(robot)]


def port_unit(unit: str) -> str:
    """Return the unit of a port, which is empty for a number without unit."""
    return "" if unit == "1" else unit


def state_order(robot: Robot) -> list[int]:
    """Return the index of each port's state in the states of the muscles.

    Ports are sorted by kind: all activations, then all fibre lengths.
    """
    kinds = [state.name for muscle in robot.muscles for state in states_of(muscle.model)]
    first = {kind: kinds.index(kind) for kind in kinds}
    return sorted(range(len(kinds)), key=lambda k: (first[kinds[k]], k))


def state_ports(robot: Robot, causality: Causality) -> list[Port]:
    """Return one port per muscle state, such as `activation.biceps`, in `state_order`."""
    names = [signal.removeprefix(FORCE) for signal in muscle_signals(FORCE, robot)]
    ports = [
        Port(
            f"{state.name}{name}",
            port_unit(state.unit),
            causality,
            "continuous",
            f"{_readable_name(state.name)} of muscle {muscle.name}",
            lower=low,
            upper=high,
            nominal=high if high < math.inf else nominal_of(state.unit),
        )
        for name, muscle in zip(names, robot.muscles, strict=True)
        for state in states_of(muscle.model)
        for low, high in [range_of(state, muscle.model)]
    ]
    return [ports[k] for k in state_order(robot)]


def command_ports(
    robot: Robot, causality: Causality, variability: Variability, starts: Sequence[float] = ()
) -> list[Port]:
    """Return the ports `u.<muscle>` of all muscles with a command."""
    ports = []
    for name, k in zip(command_signals(robot), driven_muscles(robot), strict=True):
        muscle = robot.muscles[k]
        command = law_of(muscle.model).command
        assert command is not None
        text = f"{_readable_name(command.name)} of muscle {muscle.name}"
        start = float(starts[k]) if len(starts) else 0.0
        unit, (low, high) = port_unit(command.unit), range_of(command, muscle.model)
        ports.append(Port(name, unit, causality, variability, text, start, lower=low, upper=high))
    return ports


def tension_ports(prefix: str, quantity: str, robot: Robot, muscles: Sequence[int]) -> list[Port]:
    """Return `muscle_ports` of tensions, which are outputs."""
    ports = muscle_ports(prefix, "N", quantity, robot, "output", muscles)
    return [
        replace(port, nominal=nominal_force(robot.muscles[k]))
        for k, port in zip(muscles, ports, strict=True)
    ]


def muscles_with_tension(robot: Robot, groups: Groups) -> list[int]:
    """Return the indices of the muscles whose tension is an output of a plant."""
    names = {port.name for port in groups["tensions"]}
    return [k for k, name in enumerate(muscle_signals(TENSION, robot)) if name in names]


def nominal_force(muscle: Muscle) -> float:
    """Return the nominal force of a muscle: its largest force, in [N], or 1 if unlimited."""
    return muscle.f_max if 0.0 < muscle.f_max < math.inf else 1.0


def friction_muscles(robot: Robot) -> list[int]:
    """Return the indices of the muscles with cable friction."""
    return [k for k, muscle in enumerate(robot.muscles) if bend_count(muscle)]


def energy_ports() -> list[Port]:
    """Return energies, work and momenta of a plant as outputs."""
    return [
        Port(name, unit, "output", "continuous", text) for name, (unit, text) in ENERGIES.items()
    ]


def _readable_name(name: str) -> str:
    return name.replace("_", " ").capitalize()
