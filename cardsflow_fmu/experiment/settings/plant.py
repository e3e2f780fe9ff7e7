"""[plant] and [start]: the simulated robot, and its state at the start."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cardsflow_fmu.experiment.config.names import each
from cardsflow_fmu.experiment.config.table import (
    AS_WHOLE,
    FromZero,
    Listed,
    Positive,
    Table,
    setting,
)

Rule = Literal["euler", "rk4"]
"""The integrators of a plant."""

Engine = Literal["auto", "core", "dart"]
"""What computes a plant, or a controller's dynamics; see `sim_dart.plant.engine`."""

MOST_SUBSTEPS = 1_000_000
"""As `sim_dart.plant.plant` has it."""


class PlantSettings(Table):
    """The simulated robot."""

    step: Positive = setting("internal step, in s; run.step is a whole multiple of it", None)
    mass_scale: tuple[Positive, ...] = each(
        "link", "factor on masses that the controller does not know", 1.0
    )
    friction_scale: tuple[FromZero, ...] = each(
        "muscle", "factor on friction of cables that the controller does not know", 1.0
    )
    integrator: Rule = setting("rk4: of fourth order, with the engine core", "euler")
    engine: Engine = setting("auto: the core where there are no contacts", "auto")
    substeps: Annotated[int, Field(ge=1, le=MOST_SUBSTEPS), AS_WHOLE] = setting(
        "steps of the integrator in an internal step, with commands held", 1
    )
    energy: bool = setting("whether energies, work and momenta are outputs", False)
    wrenches: Annotated[tuple[str, ...], Listed] = setting(
        "links that take forces and torques from outside", ()
    )


class StartSettings(Table):
    """The state at the start; where it is silent, that of the reference."""

    q: tuple[float, ...] = each("coordinate", "joint positions, in rad or m", None)
    qd: tuple[float, ...] = each("coordinate", "joint velocities, in rad/s or m/s", 0.0)
    y: tuple[float, ...] = each(
        "task coordinate",
        "task coordinates, in m or rad: the pose is found by inverse kinematics",
        None,
    )
    seed: tuple[float, ...] = each(
        "coordinate", "where the inverse kinematics begin, in rad or m", None
    )
