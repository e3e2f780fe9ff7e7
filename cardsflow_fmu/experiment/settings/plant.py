"""Settings of [plant] and [start]: the simulated robot and its initial state."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import (
    AS_WHOLE,
    FromZero,
    Listed,
    Positive,
    Table,
    setting,
)
from sim_dart.plant.settings import MAX_SUBSTEPS, Engine, Rule


class PlantSettings(Table):
    """The simulated robot."""

    step: Positive = setting(
        "integration step, in s; run.step is a multiple of it (default: run.step)", None
    )
    mass_scale: tuple[Positive, ...] = named_setting(
        "link", "factor on the masses of the plant; the controller uses the unscaled masses", 1.0
    )
    friction_scale: tuple[FromZero, ...] = named_setting(
        "muscle",
        "factor on the cable friction of the plant; the controller uses the unscaled one",
        1.0,
    )
    tension_scale: tuple[FromZero, ...] = named_setting(
        "muscle",
        "factor on the tensions of the plant; the controller uses the unscaled ones; requires the "
        "engine core",
        1.0,
    )
    break_time: tuple[FromZero, ...] = named_setting(
        "muscle",
        "time at which the cable breaks, in s; 0: never; requires the engine core",
        0.0,
    )
    integrator: Rule = setting("integrator; rk4 requires the engine core", "euler")
    engine: Engine = setting(
        "implementation of the dynamics; auto: core without contacts, else dart", "auto"
    )
    substeps: Annotated[int, Field(ge=1, le=MAX_SUBSTEPS), AS_WHOLE] = setting(
        "integrator steps per plant.step, with constant commands", 1
    )
    energy: bool = setting("provide energies, work and momenta as outputs", False)
    wrenches: Annotated[tuple[str, ...], Listed] = setting(
        "links with external forces and torques as inputs", ()
    )


class StartSettings(Table):
    """Initial state (default: the first point of the reference)."""

    q: tuple[float, ...] = named_setting("coordinate", "joint positions, in rad or m", None)
    qd: tuple[float, ...] = named_setting("coordinate", "joint velocities, in rad/s or m/s", 0.0)
    y: tuple[float, ...] = named_setting(
        "task coordinate",
        "task coordinates, in m or rad; inverse kinematics finds the pose",
        None,
    )
    seed: tuple[float, ...] = named_setting(
        "coordinate", "initial guess of the inverse kinematics, in rad or m", None
    )
