"""Parameters, commands and states of the muscle law of a muscle.

`laws` defines all laws; `sim_dart/csrc/laws/<law>.c` contains the equations.
"""

from __future__ import annotations

from ..errors import InputError
from .laws import MUSCLE_LAWS
from .laws.law import Command, LawState, MuscleLawDefinition, evaluate
from .muscle import CableModel, Muscle

PRESETS: dict[str, CableModel] = {
    name: CableModel(law.kind, values)
    for law in MUSCLE_LAWS.values()
    for name, values in law.presets.items()
}
"""Published parameter sets, by name."""


def law_of(model: CableModel) -> MuscleLawDefinition:
    """Return the simulated muscle law: `ideal` for CASPR's cables that are not simulated."""
    if model.custom is not None:
        custom = model.custom
        command = None if custom.command is None else Command(*custom.command)
        source = f"{custom.file}:{custom.name}"
        return MuscleLawDefinition("custom", "a custom law", source, command=command)
    return MUSCLE_LAWS.get(model.kind, MUSCLE_LAWS["ideal"])


def law_parameters(model: CableModel) -> dict[str, float]:
    """Return all parameters of a muscle law, including defaults, in the C core's order.

    Args:
        model: A model without errors; see `check`.

    Raises:
        InputError: A parameter without a default is not specified.
    """
    specified = dict(model.parameters)
    values = {}
    for parameter in law_of(model).parameters:
        value = specified.get(parameter.name, parameter.default)
        if value is None:
            raise InputError(f"{model.kind}: parameter {parameter.name!r} is missing")
        values[parameter.name] = value
    return values


def muscle_parameters(muscle: Muscle) -> dict[str, float]:
    """Return all parameters of a muscle's law, including the contribution of its pulley.

    A pulley of radius R turns r / R times as far as a drum of radius r. It adds J (r / R)^2 to the
    drum's inertia and Tc r / R to its dry friction.

    Args:
        muscle: A muscle without errors; see `check`.
    """
    values = law_parameters(muscle.model)
    if muscle.pulley is not None and law_of(muscle.model).has_drum:
        ratio = values["drum_radius"] / muscle.pulley.radius[0]
        values["drum_inertia"] += muscle.pulley.number("inertia") * ratio**2
        values["dry_friction"] += muscle.pulley.number("bearing_friction") * ratio
    return values


def command_range(model: CableModel) -> tuple[float, float]:
    """Return minimum and maximum of a muscle's command; (0, 0) for a passive muscle."""
    command = law_of(model).command
    return (0.0, 0.0) if command is None else range_of(command, model)


def range_of(signal: Command | LawState, model: CableModel) -> tuple[float, float]:
    """Return minimum and maximum of the command or a state of a muscle with these parameters."""
    values = law_parameters(model)
    low, high = (
        evaluate(limit, values) if isinstance(limit, str) else limit
        for limit in (signal.low, signal.high)
    )
    return low, high


def states_of(model: CableModel) -> tuple[LawState, ...]:
    """Return the states of a muscle with these parameters, in order."""
    law = law_of(model)
    if not law.states:
        return ()
    values = law_parameters(model)
    return tuple(state for state in law.states if not state.where or evaluate(state.where, values))
