"""Variables of a plant in continuous time: state derivatives and event indicators."""

from __future__ import annotations

import math

from addin_sdfusion.robot import Robot

from .groups import Groups
from .port import Port, coordinate_signals

_RATES = {"rad": "rad/s", "rad/s": "rad/s2", "m": "m/s", "m/s": "m/s2", "": "1/s", "J": "W"}
_SIDES = ("lower", "upper")


def state_signal(name: str) -> str | None:
    """Return the state of a derivative, or None for another variable."""
    return name[4:-1] if name.startswith("der(") else None


def continuous_groups(robot: Robot, groups: Groups) -> Groups:
    """Return the variables of a plant for model exchange.

    They are those of co-simulation, except settings of steps, with the derivatives of the states
    and with event indicators as local variables.
    """
    return {
        **groups,
        "step": [],
        "worker_timeout": [],
        "derivatives": [_derivative(state) for state in state_ports_of(groups)],
        "indicators": _indicators(robot),
    }


def state_ports_of(groups: Groups) -> list[Port]:
    """Return the continuous states of a plant: q, qd, states of muscles, and work with energies."""
    works = [port for port in groups["energies"] if port.name.startswith("work.")]
    return [*groups["q"], *groups["qd"], *groups["states"], *works]


def limited_sides(robot: Robot) -> list[tuple[int, int]]:
    """Return coordinate and side (0 lower, 1 upper) of each event indicator."""
    return [
        (j, side)
        for j, c in enumerate(robot.coordinates)
        for side, limit in enumerate((c.lower, c.upper))
        if math.isfinite(limit)
    ]


def _derivative(state: Port) -> Port:
    unit = _RATES.get(state.unit, f"{state.unit}/s")
    description = f"Derivative of {state.name}"
    return Port(f"der({state.name})", unit, "local", "continuous", description)


def _indicators(robot: Robot) -> list[Port]:
    description = "Distance from the {} limit, or force of the limit while it holds, of {}"
    return [
        Port(name, "", "local", "continuous", description.format(side, robot.coordinates[j].name))
        for j, index in limited_sides(robot)
        for side in [_SIDES[index]]
        for name in [coordinate_signals(f"event.{side}", robot)[j]]
    ]
