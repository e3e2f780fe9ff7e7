"""Settings of [motion.cost]."""

from __future__ import annotations

from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import FromZero, Table, setting


class MotionCostSettings(Table):
    """Cost of the motion: weights of integrals over time, and of the duration."""

    forces: tuple[FromZero, ...] = named_setting(
        "actuator",
        "weight of the squared muscle forces and motor torques (default: 1 without other costs)",
        0.0,
    )
    force_rates: tuple[FromZero, ...] = named_setting(
        "actuator", "weight of the squared rates of the forces and torques", 0.0
    )
    speeds: tuple[FromZero, ...] = named_setting(
        "coordinate", "weight of the squared joint velocities", 0.0
    )
    commands: tuple[FromZero, ...] = named_setting(
        "actuator",
        'weight of the squared commands, with `muscles = "laws"` (default: 1 without other costs)',
        0.0,
    )
    activations: tuple[FromZero, ...] = named_setting(
        "muscle", 'weight of the squared activations, with `muscles = "laws"`', 0.0
    )
    time: FromZero = setting("weight of the duration", 0.0)
