"""Variables of muscles with tension laws: commands, tensions, states; see `ports`."""

from __future__ import annotations

from collections.abc import Sequence

from addin_sdfusion.robot import Muscle, Robot
from addin_sdfusion.robot.model.tension_laws import law_of, states_of
from sim_dart.muscles.friction import bends

from .port import Causality, Port, Variability, muscle_signals, signal_names

FORCE, COMMAND, TENSION, FAR_TENSION = "f", "u", "tension", "far_tension"

ENERGIES = {
    "energy.kinetic": ("J", "Kinetic energy of the robot"),
    "energy.potential": ("J", "Energy of its weight and of its joints' springs"),
    "work.muscles": ("J", "Work of the muscles since the start"),
    "work.outside": ("J", "Work of motors, and of loads from outside, since the start"),
    "work.damping": ("J", "Work of the joints' damping since the start"),
    "work.friction": ("J", "Work of cables' friction since the start"),
    **{f"momentum.{axis}": ("N.s", f"Momentum of the robot along {axis}") for axis in "xyz"},
    **{
        f"angular_momentum.{axis}": ("N.m.s", f"Momentum of the robot about the world's {axis}")
        for axis in "xyz"
    },
}
"""Energies, work and momenta of a plant, with units."""


def is_modelled(muscle: Muscle) -> bool:
    """Whether its tension follows from a law, instead of being what is commanded."""
    return law_of(muscle.model).kind != "ideal"


def is_driven(muscle: Muscle) -> bool:
    """Whether it is modelled and not passive: it takes a command in the unit of its law."""
    return is_modelled(muscle) and law_of(muscle.model).command is not None


def ideal_muscles(robot: Robot) -> list[int]:
    """Indices of the muscles whose command is their tension."""
    return [k for k, muscle in enumerate(robot.muscles) if not is_modelled(muscle)]


def modelled_muscles(robot: Robot) -> list[int]:
    """Indices of the muscles that have a law."""
    return [k for k, muscle in enumerate(robot.muscles) if is_modelled(muscle)]


def driven_muscles(robot: Robot) -> list[int]:
    """Indices of the muscles that have a law with a command."""
    return [k for k, muscle in enumerate(robot.muscles) if is_driven(muscle)]


def commanded_muscles(robot: Robot) -> list[int]:
    """Indices of the muscles that the plant's commands are for, in their order."""
    return [*ideal_muscles(robot), *driven_muscles(robot)]


def tension_signals(robot: Robot) -> list[str]:
    """The actual tension of every muscle, in the order of f.

    `tension.<muscle>` where a law makes it, `f.<muscle>` where it is what is commanded.
    """
    forces, tensions = muscle_signals(FORCE, robot), muscle_signals(TENSION, robot)
    rows = zip(robot.muscles, forces, tensions, strict=True)
    return [tension if is_modelled(muscle) else force for muscle, force, tension in rows]


def command_signals(robot: Robot) -> list[str]:
    """`u.<muscle>` of every muscle that takes one."""
    names = muscle_signals(COMMAND, robot)
    return [names[k] for k in driven_muscles(robot)]


def plain(unit: str) -> str:
    """The unit as ports have it: none for a number."""
    return "" if unit == "1" else unit


def state_order(robot: Robot) -> list[int]:
    """Index among the muscles' states, muscle after muscle, of each port.

    Ports of one kind stand together: all activations, then all fibre lengths.
    """
    kinds = [state.name for muscle in robot.muscles for state in states_of(muscle.model)]
    first = {kind: kinds.index(kind) for kind in kinds}
    return sorted(range(len(kinds)), key=lambda k: (first[kinds[k]], k))


def state_ports(robot: Robot, causality: Causality) -> list[Port]:
    """A port a state of a muscle, such as `activation.biceps`, in `state_order`."""
    names = [signal.removeprefix(FORCE) for signal in muscle_signals(FORCE, robot)]
    ports = [
        Port(
            f"{state.name}{name}",
            plain(state.unit),
            causality,
            "continuous",
            f"{_words(state.name)} of muscle {muscle.name}",
        )
        for name, muscle in zip(names, robot.muscles, strict=True)
        for state in states_of(muscle.model)
    ]
    return [ports[k] for k in state_order(robot)]


def command_ports(
    robot: Robot, causality: Causality, variability: Variability, starts: Sequence[float] = ()
) -> list[Port]:
    """`u.<muscle>` of every muscle that takes one.

    Args:
        robot: The robot.
        causality: Of the ports.
        variability: Of the ports.
        starts: The command of every muscle before it is given, shape (m,); 0 where it is empty.
    """
    ports = []
    for name, k in zip(command_signals(robot), driven_muscles(robot), strict=True):
        muscle = robot.muscles[k]
        command = law_of(muscle.model).command
        assert command is not None
        what = f"{_words(command.name)} of muscle {muscle.name}"
        start = float(starts[k]) if len(starts) else 0.0
        ports.append(Port(name, plain(command.unit), causality, variability, what, start))
    return ports


def tension_ports(robot: Robot) -> list[Port]:
    """`tension.<muscle>` of every muscle that has a law, as outputs."""
    muscles = [robot.muscles[k] for k in modelled_muscles(robot)]
    names = signal_names(TENSION, [muscle.name for muscle in muscles])
    return [
        Port(name, "N", "output", "continuous", f"Tension of muscle {muscle.name}")
        for name, muscle in zip(names, muscles, strict=True)
    ]


def rubbing_muscles(robot: Robot) -> list[int]:
    """Indices of the muscles whose cables have friction in bends."""
    return [k for k, muscle in enumerate(robot.muscles) if bends(muscle)]


def far_tension_ports(robot: Robot) -> list[Port]:
    """`far_tension.<muscle>` of every muscle with friction, as outputs."""
    muscles = [robot.muscles[k] for k in rubbing_muscles(robot)]
    names = signal_names(FAR_TENSION, [muscle.name for muscle in muscles])
    what = "Tension that friction leaves at the last via point of muscle"
    return [
        Port(name, "N", "output", "continuous", f"{what} {muscle.name}")
        for name, muscle in zip(names, muscles, strict=True)
    ]


def energy_ports() -> list[Port]:
    """Energies, work and momenta of a plant, as outputs."""
    return [
        Port(name, unit, "output", "continuous", what) for name, (unit, what) in ENERGIES.items()
    ]


def _words(name: str) -> str:
    return name.replace("_", " ").capitalize()
